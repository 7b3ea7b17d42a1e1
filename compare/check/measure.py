"""Makes a record: every contestant on every scene, at the scene's own step and down a short ladder around it."""

import math
import os
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace
from itertools import chain

import numpy as np

from compare.check import order
from compare.check.energy import spin_energy
from compare.check.record import CellRow, QuestionRow, Record
from compare.check.times import time_rows
from compare.comparison.comparison import give_up, true_answer
from compare.comparison.results import engine_row
from compare.judge.errors import Run
from compare.run.flight import Trajectory, legs
from compare.run.participants import Participant
from compare.run.worker import Failure
from compare.sweep.sweep import is_own_pace
from compare.tables.rows import run_row, xyz
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
    stop = threading.Event()
    pending: list[Future] = []
    with (
        ThreadPoolExecutor(1) as oracle,
        ThreadPoolExecutor(max(1, min(len(participants), os.cpu_count() or 1))) as pool,
    ):
        pending += (truths := [oracle.submit(true_answer, scene, tick) for scene in scenes])
        pending += (flights := [pool.submit(fly_all, each, scenes, truths, tick, stop) for each in participants])
        try:
            found = [flight.result() for flight in flights]
        except BaseException:
            give_up(participants, stop, pending)
            raise
    by_scene = [[flown for own in found for flown in own[number]] for number in range(len(scenes))]
    owns = [[flown.own for flown in cells] for cells in by_scene]
    times = (
        [time_rows(participants, scene, own, tick) for scene, own in zip(scenes, owns, strict=True)] if timed else []
    )
    return Record(
        tuple(asked[0]),
        tuple(asked[1]),
        command,
        tuple(question_row(scene, *true.result()) for scene, true in zip(scenes, truths, strict=True)),
        tuple(map(engine_row, participants)),
        tuple(cell_row(flown) for cells in by_scene for flown in cells),
        tuple(chain.from_iterable(times)) if timed else None,
    )


def fly_all(
    participant: Participant,
    scenes: Sequence[Scene],
    truths: Sequence[Future[tuple[Truth | None, str]]],
    tick: Callable[[str], object],
    stop: threading.Event,
) -> list[list[Flown]]:
    """Return what one participant made of every scene, a list of its methods for each."""
    found: list[list[Flown]] = []
    for scene, true in zip(scenes, truths, strict=True):
        found.append([])
        for method in participant.methods_for(scene):
            if not stop.is_set():
                found[-1].append(fly(participant, scene, method, true.result()[0]))
                tick(f"{scene.name} {participant.title}:{method}")
    return found


def fly(participant: Participant, scene: Scene, method: str, true: Truth | None) -> Flown:
    """Return one contestant's run, and a ladder around it where the method has an order to be read."""

    def answer(scene: Scene, dt: float) -> Trajectory | Failure:
        return (
            participant.unsupported(scene) or participant.ensure_running() or participant.worker.fly(scene, method, dt)
        )

    def run(dt: float) -> Run:
        return Run(scene, participant.title, method, dt, answer(scene, dt), true)

    own = run(scene.step)
    if not order.readable(own):
        return Flown(own, (), None)
    other = answer(replace(scene, start=nudged(scene.start)), scene.step)
    own_pace = is_own_pace(participant, method)
    # Every step rounds once, this way or that: n of them come to the square root of n of one.
    rounded = len(legs(scene, scene.step)) if own_pace else own.flight.steps
    ladder = () if own_pace else order.ladder(own, run)
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
    limit, last = (None, (None,) * 3) if true is None else (float(true.limit.max()), xyz(true.vertices[-1, 0, -1]))
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
