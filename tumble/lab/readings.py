"""The numbers on the screen at the time shown: those of the coursework's screen, and the error table."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tumble.compare.run.status import Failure
from tumble.lab.pool import Contestant
from tumble.lab.throw import Throw
from tumble.scenarios.frames import Array
from tumble.scenarios.scene import Impulse

RUNNING = "running"


@dataclass(frozen=True)
class Reading:
    """One line of the coursework's screen: what it is, in which unit, and its numbers; none are not there yet."""

    name: str
    unit: str
    values: tuple[float, ...]


@dataclass(frozen=True)
class ErrorRow:
    """One contestant at the time shown, as a row of Table 4.1: one vertex, its error, and how far off.

    vertex: which; position and error [m], (3,); off_m: their distance, resolution_m: of the reference;
    status: why there is nothing to show, or what is wrong with what is shown; is_in_view: whether it is seen.
    """

    contestant: Contestant
    vertex: int | None
    position: Array | None
    error: Array | None
    off_m: float
    resolution_m: float
    status: str
    is_in_view: bool = True


def readings(
    mass: float, time: float, state: Array, vertices: Array, impulse: Impulse | None, hit: Array | None
) -> list[Reading]:
    """Return the coursework's screen: state (13,) and vertices [m], (n, 3), at a time [s], and the last impulse."""
    force = 0.0 if impulse is None else float(np.linalg.norm(impulse.value))
    direction = () if impulse is None else tuple((impulse.value / force).tolist())
    return [
        Reading("time", "s", (time,)),
        Reading("centre of mass", "m", tuple(state[0:3].tolist())),
        *(Reading(f"vertex {number}", "m", tuple(place.tolist())) for number, place in enumerate(vertices)),
        Reading("velocity", "m/s", tuple(state[7:10].tolist())),
        Reading("angular velocity", "rad/s", tuple(state[10:13].tolist())),
        Reading("hit point", "m", () if hit is None else tuple(hit.tolist())),
        Reading("impulse", "N s", () if impulse is None else (force,)),
        Reading("direction", "", direction),
        Reading("mass", "kg", (mass,)),
    ]


def error_rows(throw: Throw, frame: int, vertex: int | None) -> list[ErrorRow]:
    """Return each contestant's error at a frame, at one vertex or, for None, at the one where it is largest."""
    trajectories, answers = throw.trajectories(), dict(throw.answers)
    rows = []
    for contestant in throw.contestants:
        answer = answers.get(contestant)
        if contestant not in trajectories:
            status = str(answer) if isinstance(answer, Failure) else RUNNING
            rows.append(
                ErrorRow(
                    contestant=contestant,
                    vertex=None,
                    position=None,
                    error=None,
                    off_m=np.nan,
                    resolution_m=np.nan,
                    status=status,
                )
            )
            continue
        flight = trajectories[contestant]
        seen, true = flight.vertices[frame, 0], throw.true_vertices[frame]
        with np.errstate(over="ignore", invalid="ignore"):
            errors = seen - true
            off = np.linalg.norm(errors, axis=-1)
        lost = flight.diverged_at
        notes = f"diverged at {lost:.6g} s" if lost is not None else "; ".join(map(str, flight.notes))
        worst = int(np.argmax(np.where(np.isnan(off), -1.0, off))) if vertex is None else vertex
        limit = float(throw.true_limit[frame])
        rows.append(
            ErrorRow(
                contestant=contestant,
                vertex=worst,
                position=seen[worst],
                error=errors[worst],
                off_m=float(off[worst]),
                resolution_m=limit,
                status=notes,
            )
        )
    return rows


def errors_over_time(throw: Throw) -> tuple[Array, dict[Contestant, Array]]:
    """Return the instants [s] and each contestant's largest vertex error there [m], NaN where it is not known.

    An error below the truth's limit is shown as that limit.
    """
    curves = {}
    for contestant, flight in throw.trajectories().items():
        with np.errstate(over="ignore", invalid="ignore"):
            off = np.linalg.norm(flight.vertices[:, 0] - throw.true_vertices, axis=-1).max(axis=1)
        curves[contestant] = np.maximum(off, throw.true_limit)
    return throw.scene.rows, curves


def wrong(rows: Sequence[ErrorRow]) -> ErrorRow | None:
    """Return the row with the largest error, if any exceeds the resolution."""
    off = [row for row in rows if row.off_m > row.resolution_m]
    return max(off, key=lambda row: row.off_m, default=None)
