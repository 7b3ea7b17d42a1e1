"""Cases at the ends of what numbers can be, each written as a scene file and read as a user's would be.

Every one is a free flight with an exact truth; nobody can be held to more than its limit.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from compare.engines import OWN
from compare.judge.errors import Flown
from compare.judge.verdict import verdict
from compare.run.flight import Trajectory, legs
from compare.run.participants import Participant
from compare.run.worker import Failure
from compare.stability.schemas import ExtremeRow
from compare.tables.runs import boundless
from compare.tables.shared import worded
from scenarios.read import read_scene
from scenarios.scene import Scene
from scenarios.truth import Truth

BEST, FLOORS = f"{OWN}:exact", 10.0
BUDGET_S = 6.0  # of native loop in a flight
# Of an adaptive method such a share of the flight is flown to see whether all of it fits into the budget.
# The first time it may compile what it takes.
SHARE, LOOKS = 1 / 256, 2


@dataclass(frozen=True, eq=False)
class Case:
    """An extreme scene and the file it was read from."""

    scene: Scene
    text: str


def cases() -> list[Case]:
    """Return all extreme cases."""
    with TemporaryDirectory() as folder:
        found = []
        for name, text in texts():
            path = Path(folder, f"{name}.toml")
            path.write_text(text, encoding="utf-8")
            found.append(Case(read_scene(str(path)), text))
        return found


SPIN = (0.2, 0.9, -0.3)  # near the middle axis of a brick, so that it tumbles
ORIENTATION = (0.8, 0.2, -0.4, 0.4)
BRICK = {"shape": "box", "size": (0.4, 0.15, 0.1), "mass": 2.4, "orientation": ORIENTATION, "angular_velocity": SPIN}


def texts() -> Iterator[tuple[str, str]]:
    """Yield name and scene file of every case."""
    for power in range(2, 7):
        turning = {**BRICK, "angular_velocity": times(10.0**power, SPIN)}
        yield f"spin-1e{power}", scene_text(f"Spin of 1e{power} rad/s at an everyday step", 1.0, 1e-3, turning)
    for name, step, duration in (("1e-6", 1e-6, 0.01), ("1e-4", 1e-4, 1.0), ("1e-2", 1e-2, 10.0), ("1", 1.0, 64.0)):
        yield f"step-{name}", scene_text(f"Step of {name} s", duration, step, BRICK)
    for name, title, size in (
        ("needle", "Needle a thousand times as long as thick", (1.0, 1e-3, 1e-3)),
        ("plate", "Plate a thousand times as wide as thick", (1.0, 0.7, 1e-3)),
        ("micrometre", "Body of a micrometre", (4e-6, 1.5e-6, 1e-6)),
        ("thousand-km", "Body of a thousand kilometres", (1e6, 0.4e6, 0.25e6)),
    ):
        yield name, scene_text(title, 10.0, 1e-2, {**BRICK, "size": size})
    yield "inertia-1e6", scene_text("Moments of inertia a million to one", 10.0, 1e-2, rigid(1e-6, 1.0, 1.0))
    for power in (-9, 12):
        yield f"mass-1e{power}", scene_text(f"Mass of 1e{power} kg", 10.0, 1e-2, {**BRICK, "mass": 10.0**power})
    away = {**BRICK, "position": (1e7, -1e7, 1e7), "velocity": (1.0, 2.0, -0.5)}
    yield "far-1e7", scene_text("Ten thousand kilometres from the origin", 10.0, 1e-2, away)
    fast = {**BRICK, "angular_velocity": times(200 * math.pi, SPIN)}
    yield "turns-1e5", scene_text("A hundred thousand turns", 1000.0, 2e-3, fast)
    axis = {**BRICK, "orientation": (1.0, 0.0, 0.0, 0.0), "angular_velocity": (0.0, 3.0, 0.0)}
    yield "middle-axis", scene_text("Spin about exactly the middle axis", 10.0, 1e-2, axis)
    yield "separatrix", scene_text("A relative 1e-12 from the separatrix", 20.0, 1e-2, near_separatrix(1e-12))
    rest = {**BRICK, "angular_velocity": (0.0, 0.0, 0.0)}
    blow = {"value": (6e14, -6e14, 5e14), "vertex": 7}
    yield "impulse-1e15", scene_text("A blow of 1e15 N s", 1.0, 1e-3, rest, [blow])
    yield "no-impulse", scene_text("No impulse at all: a body at rest", 1.0, 1e-3, rest)
    centre = {"value": (3.0, -2.0, 1.0), "point_body": (0.0, 0.0, 0.0)}
    yield "impulse-centre", scene_text("A blow exactly through the centre", 1.0, 1e-3, rest, [centre])
    ten = [{"time": 0.5, "value": (1.0 - 0.2 * k, 0.3 * k - 1.0, 0.5), "vertex": k % 8} for k in range(10)]
    yield "ten-impulses", scene_text("Ten blows in one instant", 1.0, 1e-3, BRICK, ten)
    yield "steps-1e8", scene_text("A hundred million steps", 1e5, 1e-3, BRICK)
    tiny = {
        **BRICK,
        "position": (0.0, 5e-324, -0.0),
        "velocity": (1e-310, 0.0, -5e-324),
        "angular_velocity": (5e-324, 0.0, 1.0),
    }
    yield "denormal", scene_text("Denormal and zero components", 10.0, 1e-2, tiny)


def times(factor: float, vector: Sequence[float]) -> tuple[float, ...]:
    """Return a vector times a factor."""
    return tuple(factor * number for number in vector)


def rigid(a: float, b: float, c: float) -> dict:
    """Return a body of those moments [kg m2] that turns about all three axes, with points half a metre out."""
    inertia = ((a, 0.0, 0.0), (0.0, b, 0.0), (0.0, 0.0, c))
    points = ((0.5, 0.0, 0.0), (0.0, 0.5, 0.0), (0.0, 0.0, 0.5))
    return {"shape": "rigid", "mass": 1.0, "inertia": inertia, "points": points, "angular_velocity": (1.0, 2.0, 3.0)}


def near_separatrix(off: float) -> dict:
    """Return a body with moments 1, 2, 3 whose start is that share of its energy off the separatrix L2 = 2 T B.

    There A (B - A) w1^2 = C (C - B) w3^2, so with these moments w1^2 = 3 w3^2 (Landau and Lifshitz, Mechanics, 37).
    """
    turning = (math.sqrt(3.0) * (1.0 + off), 0.1, 1.0)
    return {**rigid(1.0, 2.0, 3.0), "angular_velocity": turning}


def scene_text(title: str, duration: float, step: float, body: dict, blows: Sequence[dict] = ()) -> str:
    """Return a scene file, looked at sixteen times."""
    top = {"title": title, "source": "tumble stability", "duration": duration, "samples": 16, "step": step}
    tables = [("", top), ("[body]\n", body), *(("[[impulse]]\n", blow) for blow in blows)]
    return "\n".join(
        head + "".join(f"{key} = {toml(value)}\n" for key, value in table.items()) for head, table in tables
    )


def toml(value: object) -> str:
    """Return a value as TOML writes it; floats with every digit."""
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, tuple):
        return f"[{', '.join(map(toml, value))}]"
    return repr(value)


def extreme(participant: Participant, method: str, case: Case, true: Truth, budget_s: float = BUDGET_S) -> ExtremeRow:
    """Return what one contestant makes of one case, in a native loop of at most budget_s [s]."""
    scene = case.scene
    answer = too_long(participant, method, scene, budget_s) or participant.fly(scene, method, scene.step)
    run = Flown.of(participant, method, scene.step, answer).run(scene, participant.title, true)
    said = verdict(run)
    key = scene.name, scene.title, participant.title, method, scene.step
    if isinstance(answer, Failure):
        return ExtremeRow(*key, None, worded(run.status)[0], said.word, None, None, None, None, said.why)
    worst = run.distances.max(axis=(1, 2))
    ratio = float(np.max(worst / run.limits.max(axis=1))) if np.isfinite(worst).all() else math.inf
    return ExtremeRow(
        *key,
        answer.steps,
        worded(run.status)[0],
        said.word,
        boundless(worst.max()),
        float(run.limits.max()),
        ratio,
        said.energy_ratio,
        "; ".join(dict.fromkeys(filter(None, (said.why, *run.notes)))),
    )


def too_long(participant: Participant, method: str, scene: Scene, budget_s: float) -> Failure | None:
    """Return that a flight would not fit into the budget, or None.

    Told from its steps and what its engine says that one takes; of an adaptive method, whose steps nobody counts, from
    the CPU time of a small share of it: no wall clock is asked, so that a busy machine has the same rows.
    """
    info = participant.info
    if isinstance(info, Failure) or method in info.whole:
        return None
    if participant.takes_own_steps(method):
        seconds = SHARE * scene.duration
        share = replace(scene, duration=seconds, times=np.array([seconds]))
        asked, needed = f"{scene.duration:g} s of flight", math.inf
        for _ in range(LOOKS):
            if needed <= budget_s:
                break
            first = participant.fly(share, method, scene.step)
            if not isinstance(first, Trajectory):
                return first
            needed = min(needed, first.cpu_s / SHARE)
    else:
        steps = sum(leg.n for leg in legs(scene, scene.step))
        asked, needed = f"{steps:.0e} steps", steps * info.step_of(method) / 1e9
    return Failure(f"timeout: {asked} would take {needed:.2g} s of {budget_s:g}") if needed > budget_s else None


def missed(rows: Sequence[ExtremeRow]) -> list[ExtremeRow]:
    """Return the rows in which our own best method is further off than FLOORS limits."""
    best = [row for row in rows if f"{row.engine}:{row.method}" == BEST]
    return [row for row in best if row.times_limit is None or not row.times_limit <= FLOORS]
