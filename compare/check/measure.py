"""Makes a record: every contestant on every scene, at the scene's own step and down a short ladder around it."""

import math
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from dataclasses import dataclass, replace
from itertools import chain

import numpy as np

from compare.check import order
from compare.check.energy import spin_energy
from compare.check.record import Record
from compare.check.schemas import CellRow, QuestionRow
from compare.check.times import time_rows
from compare.judge.errors import Run
from compare.run.flight import Trajectory, legs
from compare.run.participants import Participant
from compare.run.tasks import Task, run
from compare.run.truths import Answer, Truths
from compare.run.worker import Failure
from compare.tables.engines import engine_row
from compare.tables.runs import run_row
from scenarios.frames import Array
from scenarios.scene import Scene, frozen_array
from scenarios.truth import Truth

# One rounding of a number of size 1, up and down by turns.
NUDGE = 2.0**-53 * np.resize((1.0, -1.0, -1.0, 1.0, 1.0), 13)


@dataclass(frozen=True, eq=False)
class Flown:
    """One contestant on one scene: its run, the ladder around it, and what its roundings may come to [m]."""

    own: Run
    ladder: Sequence[Run]
    rounding_m: float | None


def measure(
    participants: Sequence[Participant],
    scenes: Sequence[Scene],
    asked: tuple[Sequence[str], Sequence[str]],
    command: str,
    timed: bool,
    tick: Callable[[str], object] = lambda what: None,
) -> Record:
    """Return the record of all participants on all scenes.

    asked: the words that scenes and contestants were asked for with; timed: whether run times are measured too, when
    all flights are over.  tick is told of every truth, cell and timed scene as it is done.
    Raises RayMissed where the true body is not in the way of a later ray.
    """
    with Truths(scenes, tick) as truths:
        tasks = [
            [task(scene, true, each, method) for each in participants for method in each.methods_for(scene)]
            for scene, true in zip(scenes, truths.futures, strict=True)
        ]
        found = iter(run(list(chain.from_iterable(tasks)), truths, tick=tick))
        answers = [future.result() for future in truths.futures]
    by_scene = [[next(found) for _ in own] for own in tasks]
    owns = [[flown.own for flown in cells] for cells in by_scene]
    times = (
        [time_rows(participants, scene, own, tick) for scene, own in zip(scenes, owns, strict=True)] if timed else []
    )
    return Record(
        tuple(asked[0]),
        tuple(asked[1]),
        command,
        tuple(question_row(scene, *answer) for scene, answer in zip(scenes, answers, strict=True)),
        tuple(map(engine_row, participants)),
        tuple(cell_row(flown) for cells in by_scene for flown in cells),
        tuple(chain.from_iterable(times)) if timed else None,
    )


def task(scene: Scene, true: Future[Answer], participant: Participant, method: str) -> Task[Flown]:
    """Return the task of one contestant on one scene."""
    key = scene.name, participant.title, method
    return Task(key, participant, lambda able: fly(able, scene, method, true.result().truth))


def fly(participant: Participant, scene: Scene, method: str, true: Truth | None) -> Flown:
    """Return one contestant's run, and a ladder around it where the method has an order to be read."""

    def at(dt: float) -> Run:
        return Run(scene, participant.title, method, dt, participant.fly(scene, method, dt), true)

    own = at(scene.step)
    if not order.readable(own):
        return Flown(own, (), None)
    other = participant.fly(replace(scene, start=nudged(scene.start)), method, scene.step)
    own_steps = participant.takes_own_steps(method)
    # Every step rounds once, this way or that: n of them come to the square root of n of one.
    rounded = len(legs(scene, scene.step)) if own_steps else own.flight.steps
    ladder = () if own_steps else order.ladder(own, at)
    return Flown(own, ladder, math.sqrt(rounded) * apart(own.flight, other))


def nudged(start: Array) -> Array:
    """Return states, (N, 13), moved by one rounding of the vector that each number belongs to."""
    parts = np.split(start, (3, 7, 10), axis=1)
    scales = [np.repeat(np.linalg.norm(part, axis=1, keepdims=True), part.shape[1], axis=1) for part in parts]
    return frozen_array(start + np.hstack(scales) * NUDGE)


def apart(one: Trajectory, other: Trajectory | Failure) -> float:
    """Return how far two flights are apart at most [m], without bound where the other is not one."""
    if isinstance(other, Failure) or other.diverged_at is not None:
        return math.inf
    return float(np.linalg.norm(one.vertices - other.vertices, axis=-1).max())


def question_row(scene: Scene, true: Truth | None, why_no_truth: str) -> QuestionRow:
    """Return the row of one scene."""
    limit, last = (None, (None,) * 3) if true is None else (float(true.limit.max()), true.vertices[-1, 0, -1].tolist())
    return QuestionRow(
        scene.name, scene.step, len(scene.times), why_no_truth or "exact", limit, order.reach(scene), *last
    )


def cell_row(flown: Flown) -> CellRow:
    """Return the row of one contestant on one scene."""
    row = run_row(flown.own)
    return CellRow(
        row.scene,
        row.engine,
        row.method,
        row.steps,
        row.status,
        row.why,
        row.max_error_m,
        row.rms_error_m,
        row.final_error_m,
        row.limit_m,
        flown.rounding_m,
        row.energy_drift,
        row.momentum_drift,
        row.angular_momentum_drift,
        *order.orders(flown.ladder),
        spin_energy(flown.own),
    )
