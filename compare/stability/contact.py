"""Stability above a rigid plane: a map of friction and angle, and the largest step that breaks no law of contact.

The map sets the body at rest on the face on which it starts, tilts gravity, and varies mu.  By Coulomb's law it holds
while tan(angle) <= mu, and slides or tips beyond.  The largest step needs no reference solution: nothing may pass the
plane, and no contact may add more energy than two steps of gravity do.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from tumble.compare.contact.directions import plane_axes, reaches_edge
from tumble.compare.contact.impacts import SHIFTS
from tumble.compare.contact.watched import Watched, gravity
from tumble.compare.judge import mechanics
from tumble.compare.judge.errors import Run, RunAnswer
from tumble.compare.run.flight import Trajectory
from tumble.compare.run.running_engines import RunningEngine
from tumble.compare.run.status import Failure
from tumble.compare.stability.schemas import CREEPS, GAINS, HOLDS, SLIDES, TIPS, TUNNELS, ContactMapRow, ContactStepRow
from tumble.compare.stability.trials import edge
from tumble.compare.tables.runs import contestant_columns, status_columns, step_columns
from tumble.scenarios.frames import Array, rotation_matrix
from tumble.scenarios.scene import Scene

# Friction over the scene's own, and tangents of the angle over friction: 1 is critical.
FRICTIONS = (0.25, 0.5, 1.0, 2.0)
TANGENTS = (0.5, 0.65, 0.8, 0.95, 0.99, 1.01, 1.05, 1.2, 1.5)
# How long a cell runs, in times in which the body falls by its own size; at least so many steps.
FALLS, LEAST_STEPS = 2.0, 64
# A uniform acceleration makes the last quarter 2.33 times as fast as the second, a creep 1.
ACCELERATES = 1.5
TIPPED_RAD = 0.02
# Steps that are tried: from a part of the scene's own, each twice the last, to a part of its duration.
FINEST, COARSEST, PRECISION = 0.5, 1 / 8, 0.02
# Where in a step the plane is met changes the outcome, and so each step stands for those near it.
NEARBY = (1.0, 0.95, 0.9)
SAMPLES = 200
# The gain in energy that shows, as a share of it.
SHOWS = 1e-3


@dataclass(frozen=True)
class ContactPiece:
    """The results of one contestant in one scene with a plane: the cells of its map, if any, and its step."""

    rows: tuple[ContactMapRow, ...]
    step: ContactStepRow


@dataclass(frozen=True, eq=False)
class Tilted:
    """A cell of a map: the scene, friction, angle [rad], and what Coulomb's law says."""

    scene: Scene
    friction: float
    angle: float
    verdict: str
    speed: float | None


def contact_piece(running_engine: RunningEngine, method: str, scene: Scene) -> ContactPiece:
    """Return the map and the largest step of one contestant in a scene with a plane."""
    step = largest_step(running_engine, method, scene)
    cells = tilted(scene) if step.status in ("ok", "flagged") else ()
    return ContactPiece(tuple(cell_row(running_engine, method, one) for one in cells), step)


def tilted(scene: Scene) -> Iterator[Tilted]:
    """Yield the cells of a scene's map; none where the body does not start on a face of its own."""
    plane, pull = scene.plane, float(np.linalg.norm(gravity(scene)))
    assert plane is not None
    if scene.body.radius is not None or scene.impulses or len(scene.start) > 1 or not pull or not plane.friction:
        return
    slope = reaches_edge(scene)
    if not slope or not scene.is_unforced or scene.start[0, 10:13].any():
        return
    start, down = scene.start.copy(), downhill(scene)
    start[0, 7:10] = 0.0
    took = max(FALLS * math.sqrt(scene.body.reach / pull), LEAST_STEPS * scene.step)
    times = scene.step * math.ceil(took / scene.step / 4) * np.arange(1.0, 5.0)
    for factor in FRICTIONS:
        mu = factor * plane.friction
        for ratio in TANGENTS:
            angle = math.atan(ratio * mu)
            turned = pull * (math.sin(angle) * down - math.cos(angle) * plane.normal)
            # Beyond an edge's tangent a body whose friction holds it, or brakes it as much, tips.
            tips = ratio * mu > slope and mu > slope
            said = HOLDS if ratio <= 1 and not tips else TIPS if tips else SLIDES
            faster = max(0.0, pull * (math.sin(angle) - mu * math.cos(angle)))
            yield Tilted(
                scene=replace(
                    scene,
                    plane=replace(plane, friction=mu),
                    gravity=turned,
                    start=start,
                    times=times,
                    duration=float(times[-1]),
                    written=None,
                ),
                friction=mu,
                angle=angle,
                verdict=said,
                speed=None if tips else faster * float(times[2] + times[3]) / 2,
            )


def downhill(scene: Scene) -> Array:
    """Return the direction in which a map tilts the plane, (3,): the first velocity's, else gravity's, along it."""
    assert scene.plane is not None
    normal = scene.plane.normal
    for vector in (scene.start[0, 7:10], gravity(scene)):
        along = vector - (vector @ normal) * normal
        if np.linalg.norm(along) > 1e-9 * np.linalg.norm(vector):
            return along / np.linalg.norm(along)
    return plane_axes(normal)[0]


def cell_row(running_engine: RunningEngine, method: str, one: Tilted) -> ContactMapRow:
    """Return the row of one cell."""
    run = run_of(running_engine, method, one.scene, one.scene.step)
    finite = not isinstance(run.answer, Failure) and run.answer.diverged_at is None
    verdict, speed = judged(Watched(one.scene, run.flight), one.scene.step) if finite else ("", None)
    return ContactMapRow(
        **contestant_columns(run),
        **step_columns(run),
        friction=one.friction,
        angle_rad=one.angle,
        critical_rad=math.atan(one.friction),
        **status_columns(run),
        verdict=verdict,
        true_verdict=one.verdict,
        speed_m_s=speed,
        true_speed_m_s=one.speed,
    )


def run_of(running_engine: RunningEngine, method: str, scene: Scene, dt: float) -> Run:
    """Return a run without a reference solution."""
    answer = running_engine.simulate(scene, method, dt)
    return RunAnswer.of(running_engine, method, dt, answer).run(scene, running_engine.title, None)


def judged(seen: Watched, dt: float) -> tuple[str, float]:
    """Return what a body on a tilted plane does, and its mean speed over the last quarter [m/s]."""
    ways = seen.along(np.diff(seen.states[:, 0:3], axis=0))
    speeds = np.linalg.norm(ways, axis=1) / np.diff(seen.times)
    axes = [rotation_matrix(state[3:7]).T @ seen.plane.normal for state in seen.states[[0, -1]]]
    took, last = float(seen.times[-1]), float(speeds[-1])
    # What a body falls within a step moves it by as much, over half the run.
    least = 2 * SHIFTS * dt * dt * float(np.linalg.norm(seen.pull)) / took
    if seen.through:
        return TUNNELS, last
    if np.linalg.norm(axes[0] - axes[1]) > TIPPED_RAD:
        return TIPS, last
    if last <= least:
        return HOLDS, last
    return SLIDES if last > ACCELERATES * speeds[1] else CREEPS, last


def largest_step(running_engine: RunningEngine, method: str, scene: Scene) -> ContactStepRow:
    """Return the largest step of one contestant."""
    first = run_of(running_engine, method, scene, scene.step)
    row = ContactStepRow(**contestant_columns(first), **status_columns(first))
    if isinstance(first.answer, Failure) or running_engine.takes_own_steps(method):
        return row
    ladder = [FINEST * scene.step]
    while 2 * ladder[-1] <= COARSEST * scene.duration:
        ladder.append(2 * ladder[-1])
    found = fault(running_engine, method, scene, ladder[0])
    speed = float(np.linalg.norm(first.flight.states[..., 7:10], axis=-1).max()) if found == "" else None
    row = replace(row, dt_from_s=ladder[0], dt_to_s=ladder[-1], max_speed_m_s=speed)
    if found:
        return replace(row, beyond=found)
    faults = {}

    def holds(dt: float) -> bool:
        if said := fault(running_engine, method, scene, dt):
            faults[dt] = said
        return not said

    for good, bad in pairwise(ladder):
        if not holds(bad):
            return replace(row, dt_max_s=edge(good, bad, holds, PRECISION), beyond=faults[min(faults)])
    return replace(row, dt_max_s=math.inf)


def fault(running_engine: RunningEngine, method: str, scene: Scene, dt: float) -> str:
    """Return what a run at a step [s], or at one of those near it, does that no contact can; empty if nothing."""
    for near in NEARBY:
        own = whole_steps(scene, near * dt)
        answer = running_engine.simulate(own, method, near * dt)
        if isinstance(answer, Failure):
            return answer.status.value
        if found := broken_law(own, answer, near * dt):
            return found
    return ""


def whole_steps(scene: Scene, dt: float) -> Scene:
    """Return a scene whose samples are whole steps of dt [s], so that none is cut."""
    steps = max(1, round(scene.duration / dt))
    times = dt * np.unique(np.linspace(1, steps, min(steps, SAMPLES)).astype(int))
    kept = tuple(each for each in scene.impulses if each.time < times[-1])
    return replace(scene, times=times, duration=float(times[-1]), impulses=kept, written=None)


def broken_law(scene: Scene, answer: Trajectory, dt: float) -> str:
    """Return which law a run breaks: TUNNELS, GAINS or diverged; empty if none."""
    if answer.diverged_at is not None:
        return "diverged"
    seen = Watched(scene, answer)
    if seen.through:
        return TUNNELS
    if not scene.is_unforced:  # their energy is not known here
        return ""
    pull, mass = gravity(scene), scene.body.mass
    energy = mechanics.energy(seen.states, scene.body, pull)
    potential = -mass * (seen.states[:, 0:3] @ pull)
    begun = np.concatenate(([False], seen.pushed & ~np.concatenate(([False], seen.pushed[:-1]))))
    starts = [0.0, *sorted({each.time for each in scene.impulses} - {0.0}), math.inf]
    for begins, ends in pairwise(starts):
        own = np.flatnonzero((seen.times >= begins) & (seen.times < ends))
        if not len(own):
            continue
        kinetic = np.maximum(energy[own[0]] - potential[own], 0.0)  # what the energy allows there
        # Two steps of gravity at every contact, at the greatest speed so far.
        speed = np.maximum.accumulate(np.sqrt(2 * kinetic / mass)) + np.linalg.norm(pull) * dt
        explained = SHIFTS * dt * mass * np.linalg.norm(pull) * speed * np.maximum(1, np.cumsum(begun[own]))
        if (energy[own] - energy[own[0]] > explained + SHOWS * kinetic.max()).any():
            return GAINS
    return ""
