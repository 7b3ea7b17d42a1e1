"""The numbers on the screen at the time shown: those of the coursework's screen, and the error table."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from tumble.compare.run.status import Failure
from tumble.lab.pool import Contestant
from tumble.lab.throw import Throw
from tumble.scenarios.frames import Array, rotation_matrix
from tumble.scenarios.scene import Impulse, Scene

RUNNING = "running"
# As `tumble.scenarios.wrench.wrench` returns it: forces and torques of states, (N, 13) -> (N, 6).
Wrench = Callable[[Array], Array]


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


def sensor_readings(
    scene: Scene, state: Array, point: Array | None, wrench: Wrench | None, *, at_impulse: bool
) -> list[Reading]:
    """Return what an accelerometer and a gyro at a point of the body, (3,), read in a state, (13,): nothing without it.

    point: principal axes [m]; wrench: of the scene's forces, None if not known yet.  The readings are along the axes of
    the scene file, which a sensor has without an orientation of its own.  At an impulse the accelerometer reads
    nothing: the specific force is not defined there.
    """
    force, spin = (), ()
    if point is not None:
        known = scene.is_free or wrench is not None
        f, w = felt(scene, state, point, wrench)
        force, spin = tuple(f.tolist()) if known and not at_impulse else (), tuple(w.tolist())
    return [Reading("accelerometer", "m/s2", force), Reading("gyro", "rad/s", spin)]


def felt(scene: Scene, state: Array, point: Array, wrench: Wrench | None) -> tuple[Array, Array]:
    """Return specific force F/m + alpha x r + w x (w x r) [m/s2] and w [rad/s], (3,), along the scene file's axes."""
    body, R = scene.body, rotation_matrix(state[3:7])
    force, torque = np.zeros((2, 3)) if wrench is None else np.split(wrench(state[np.newaxis])[0], 2)
    w = R.T @ state[10:13]
    alpha = (np.cross(body.moments * w, w) + R.T @ torque) / body.moments
    f = R.T @ force / body.mass + np.cross(alpha, point) + np.cross(w, np.cross(w, point))
    own = rotation_matrix(body.file_axes)
    return own.T @ f, own.T @ w


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
        # A method that says why its motion ends has not diverged.
        end = [] if lost is None else [f"{'no state from' if flight.notes else 'diverged at'} {lost:.6g} s"]
        notes = "; ".join([*map(str, flight.notes), *end])
        worst = int(np.argmax(np.where(np.isnan(off), -1.0, off))) if vertex is None else vertex
        limit = float(throw.true_limit[frame])
        rows.append(
            ErrorRow(
                contestant=contestant,
                vertex=worst,
                position=seen[worst] if np.isfinite(seen[worst]).all() else None,
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
