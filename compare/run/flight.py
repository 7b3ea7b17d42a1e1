"""One run: one engine, one method, one step, from t = 0 to the end of the scene."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tumble.compare.engines.parts.soft_law import SoftLaw
from tumble.compare.run.engines.registry import Finding, built, findings
from tumble.compare.run.timing.timer import Steps, prepare
from tumble.scenarios.frames import Array, quaternion_product, vertices
from tumble.scenarios.impulse import RayMissed, jump
from tumble.scenarios.refusal import UserError
from tumble.scenarios.scene import Scene

# The other start of a probe differs by this share of the body's size, of a radian and of the velocities; a probe runs
# for at most this many steps.
ALTERED, PROBE_STEPS = 1e-4, 100
# One step more makes the mean of a run of 1e9, the most there may be, shorter by 1e-9; rounding moves it by 1e-15.
SAME_STEP = 1e-12


# Engine, scene, method and what to keep -> world.
WorldOf = Callable[[ModuleType, Scene, str, frozenset[str]], Any]


class BadStep(UserError):
    """A step that cannot be flown; the message is the one line for the user."""


@dataclass(frozen=True)
class Leg:
    """A stretch between two stops (samples, impulses, the end): n steps of dt [s] that end at `end` [s]."""

    n: int
    dt: float
    end: float


@dataclass(frozen=True, eq=False)
class Probe:
    """Two short runs of one throw: from the start that the scene has, and from one next to it.

    starts, ends: (2, 13); time: between them [s].
    """

    starts: Array
    ends: Array
    time: float


@dataclass(frozen=True, eq=False)
class Trajectory:
    """What an engine answered: R rows, one for t = 0 and one a sample, of N throws.

    After the state stopped being finite the rows are NaN.

    Parameters
    ----------
    times : instants of the rows [s], (R,)
    states : state of each throw in each row, (R, N, 13)
    vertices : positions of the n vertices [m], (R, N, n, 3), world axes
    steps : number of steps of the whole run
    wall_s : wall time of the engine's native loops [s]
    findings : findings of the engine's own audit
    remark : further remark of the engine; empty if there is none
    soft_law : law of its contact with the plane, of an engine that states one for soft contact
    probe : short runs from the scene's start and from a start next to it; None if not asked for
    cpu_s : CPU time of the native loops [s], of the process and of its children that have ended
    """

    times: Array
    states: Array
    vertices: Array
    steps: int
    wall_s: float
    findings: tuple[Finding, ...]
    remark: str = ""
    soft_law: SoftLaw | None = None
    probe: Probe | None = None
    cpu_s: float = 0.0

    def at(self, scene: Scene) -> "Trajectory":
        """Return the run with the rows of a scene alone, all of which it has."""
        rows = np.searchsorted(self.times, scene.rows)
        return replace(self, times=scene.rows, states=self.states[rows], vertices=self.vertices[rows])

    @property
    def notes(self) -> tuple[str, ...]:
        """The findings in words."""
        return tuple(found.text for found in self.findings)

    @property
    def diverged_at(self) -> float | None:
        """The first row's time at which the state is not finite [s], or None."""
        lost = ~np.isfinite(self.vertices).all(axis=(1, 2, 3)) | ~np.isfinite(self.states).all(axis=(1, 2))
        return float(self.times[np.argmax(lost)]) if lost.any() else None


def check_step(scene: Scene, dt: float | None) -> None:
    """Check that a step makes no more steps than a run may have.

    Parameters
    ----------
    scene : the scene
    dt : step [s]; None: the scene's own, which is not checked

    Raises
    ------
    BadStep : the step is too short for the scene
    """
    from tumble.scenarios.build import MOST_STEPS  # by the one who asks: who flies may have nothing but numpy

    if dt is not None and scene.duration / dt > MOST_STEPS:
        raise BadStep(f"--dt = {dt:g}: must be at least {scene.duration / MOST_STEPS:g} s for {scene.name}")


def legs(scene: Scene, dt: float) -> list[Leg]:
    """Cut the flight at samples and impulses; each leg gets ceil(leg / dt) equal steps, and dt itself where it divides.

    Whether dt divides is asked to the rounding of the two instants: 0.28 - 0.06 is 11 steps of 0.02, not 12.
    """
    stops = sorted({*scene.times.tolist(), *(impulse.time for impulse in scene.impulses), scene.duration} - {0.0})
    found = []
    for begin, end in zip([0.0, *stops], stops, strict=False):
        ratio = (end - begin) / dt
        whole = round(ratio)
        if whole and abs(ratio - whole) <= 4 * (math.ulp(end) / dt + math.ulp(ratio)):
            found.append(Leg(whole, dt, end))
        else:
            n = math.ceil(ratio)
            found.append(Leg(n, (end - begin) / n, end))
    return found


def takes_same_steps(scene: Scene, other: Scene, dt: float) -> bool:
    """Return whether a flight of the other scene, which has all samples of this one and more, takes the very steps.

    dt [s].  Where an interval is no multiple of dt its steps are shorter, and a part of it has steps of its own.
    """
    parts = iter(legs(other, dt))
    for leg in legs(scene, dt):
        left = leg.n
        while left > 0 and (part := next(parts, None)):
            if part.dt != leg.dt:
                return False
            left -= part.n
        if left:
            return False
    return True


def mean_step(duration: float, steps: int, dt: float) -> float:
    """Return the mean of the steps that a run took.

    Parameters
    ----------
    duration : duration of the run [s]
    steps : number of steps that it took
    dt : step that was asked for [s]

    Returns
    -------
    the mean step [s]; dt itself if the mean equals it but for rounding
    """
    taken = duration / steps
    return dt if math.isclose(taken, dt, rel_tol=SAME_STEP) else taken


def simulate(
    engine: ModuleType,
    scene: Scene,
    method: str,
    dt: float,
    keep: frozenset[str] = frozenset(),
    probe: bool = False,
    world_of: WorldOf = built,
) -> Trajectory:
    """Run the scene in one engine.

    dt [s]; keep: what of its OPTIONAL the engine is to build all the same; probe: whether to run briefly from another
    start as well, which finds an engine that looks its answers up; world_of: gives a world, as `built`.
    Raises whatever the engine raises, and ValueError where read or audit answers what the contract has not.
    """
    world = world_of(engine, scene, method, keep)
    audit = getattr(engine, "audit", lambda world: [])
    where = getattr(engine, "vertices", None)
    found: list[Finding] = []
    rows: dict[float, Array] = {}
    own: dict[float, Array] = {}  # of an engine that has vertices of its own

    def look(time: float, read: Any) -> Array:
        states = real(read)
        if states.shape != scene.start.shape:
            raise ValueError(f"read() returned shape {states.shape}, not {scene.start.shape}")
        rows[time] = states
        if where and (points := where(world, scene.body.points)) is not None:
            own[time] = real(points)
        return states

    engine.write(world, with_impulses(scene, 0.0, scene.start.copy(), found))
    states = look(0.0, engine.read(world))
    steps, taken = Steps(engine, world), 0
    for leg in legs(scene, dt):
        prepare(engine, world, leg.dt)
        states = look(leg.end, steps.make(leg.n, leg.dt))
        taken += leg.n
        if not np.isfinite(states).all():
            break
        if any(impulse.time == leg.end for impulse in scene.impulses):
            found += findings(audit(world))
            engine.write(world, with_impulses(scene, leg.end, states, found))
            look(leg.end, engine.read(world))
    found += findings(audit(world))

    lost, nowhere = np.full_like(states, np.nan), np.full((len(states), *scene.body.points.shape), np.nan)
    seen = np.array([rows.get(time, lost) for time in scene.rows])
    # All rows at once: for one body the calls would take longer than most engines' steps.
    points = np.array([own.get(time, nowhere) for time in scene.rows]) if own else vertices(seen, scene.body.points)
    return Trajectory(
        times=scene.rows,
        states=seen,
        vertices=points,
        steps=taken,
        wall_s=steps.wall_s,
        findings=tuple(dict.fromkeys(found)),
        remark=engine.remark(world) if hasattr(engine, "remark") else "",
        soft_law=engine.soft_law(world) if scene.plane is not None and hasattr(engine, "soft_law") else None,
        probe=run_probe(engine, scene, method, dt, keep, world_of) if probe else None,
        cpu_s=steps.cpu_s,
    )


def run_probe(
    engine: ModuleType,
    scene: Scene,
    method: str,
    dt: float,
    keep: frozenset[str] = frozenset(),
    world_of: WorldOf = built,
) -> Probe:
    """Return what the engine makes of the scene's start and of an altered one, on the first steps of dt [s].

    Each is given a world as a run is: who only counts the time is to begin at 0.
    """
    leg, size = legs(scene, dt)[0], scene.body.reach
    n, own = min(leg.n, PROBE_STEPS), with_impulses(scene, 0.0, scene.start.copy(), [])
    starts, ends = (own, altered(own, size)), []
    for states in starts:
        world = world_of(engine, scene, method, keep)
        prepare(engine, world, leg.dt)
        engine.write(world, states.copy())
        engine.advance(world, n, leg.dt)
        ends.append(real(engine.read(world))[0])
    return Probe(np.array([states[0] for states in starts]), np.array(ends), n * leg.dt)


def altered(states: Array, size: float) -> Array:
    """Return states, (N, 13), that are a little elsewhere, turned and swifter, for a body of that size [m]."""
    turn = np.concatenate(([1.0], ALTERED / 2 * np.array((0.48, 0.6, 0.64))))
    x, q, velocities = np.split(states, (3, 7), axis=1)
    q = quaternion_product(q, turn / np.linalg.norm(turn))
    return np.hstack((x + ALTERED * size * np.array((0.6, 0.64, 0.48)), q, velocities * (1 + ALTERED)))


def real(answer: ArrayLike) -> Array:
    """Return an engine's answer as an array of floats.  Raises ValueError where that would lose a part of it."""
    if np.iscomplexobj(answer):
        raise ValueError("it answered complex numbers")
    return np.array(answer, dtype=float)


def with_impulses(scene: Scene, time: float, states: Array, found: list[Finding]) -> Array:
    """Return the states after the impulses of one instant, in the order listed; a ray that misses applies none."""
    for number, impulse in enumerate(scene.impulses):
        if impulse.time == time:
            try:
                states = jump(impulse, states, scene.body)
            except RayMissed as missed:
                found.append(Finding("other", f"impulse {number} at t = {time:g} s not given: {missed}"))
    return states
