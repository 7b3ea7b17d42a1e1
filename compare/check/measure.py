"""Makes a record: every contestant on every scene, at the scene's own step and at a short sequence around it."""

import math
from collections.abc import Sequence
from concurrent.futures import Future
from dataclasses import asdict, dataclass, replace
from functools import partial
from itertools import chain

import numpy as np

from tumble.compare.check.record import Record
from tumble.compare.check.schemas import CELLS, EXACT, QUESTIONS, TIMES, CellRow, QuestionRow
from tumble.compare.check.times import time_rows
from tumble.compare.contact.rows import contact_rows
from tumble.compare.contact.schemas import CONTACT
from tumble.compare.contact.study import contacts
from tumble.compare.judge import ladder as order
from tumble.compare.judge.errors import Run, RunAnswer
from tumble.compare.judge.trend import spin_energy
from tumble.compare.run.execution import Parts
from tumble.compare.run.flight import Trajectory, legs
from tumble.compare.run.progress import ProgressCallback, no_progress
from tumble.compare.run.running_engines import RunningEngine, truth_limit
from tumble.compare.run.status import Failure
from tumble.compare.run.tasks import Task, run
from tumble.compare.run.truths import Answer, Truths, answered
from tumble.compare.tables.engines import engine_row
from tumble.compare.tables.frames import frame
from tumble.compare.tables.runs import run_row, vector_columns
from tumble.compare.tables.shared import ENGINES
from tumble.scenarios.frames import Array
from tumble.scenarios.scene import Scene, frozen_array
from tumble.scenarios.truth import Truth

# Signs of the roundings of a state, up and down in turn.
NUDGE = np.resize((1.0, -1.0, -1.0, 1.0, 1.0), 13)


@dataclass(frozen=True, eq=False)
class Cell:
    """One contestant on one scene: its run, the step-size sequence around it, and its rounding error [m].

    rounding_m: None if a perturbed run failed, so that it is unknown.
    """

    own: RunAnswer
    ladder: list[RunAnswer]
    rounding_m: float | None


def measure(
    running_engines: Sequence[RunningEngine],
    scenes: Sequence[Scene],
    words: tuple[Sequence[str], Sequence[str]],
    command: str,
    timed: bool,
    on_progress: ProgressCallback = no_progress,
) -> Record:
    """Return the record of all contestants on all scenes.

    words: for scenes and contestants on the command line; timed: whether run times are measured, after all other
    runs; on_progress: called for every reference solution and cell, and when all are timed.
    Raises RayMissed if the ray of a later impulse misses the true body.
    """
    landing, limit_s = [scene for scene in scenes if scene.plane], truth_limit(running_engines)
    with Parts() as part:
        with Truths(scenes, on_progress, limit_s=limit_s) as truths:
            tasks = [
                [task(scene, true, each, method) for each in running_engines for method in each.methods_for(scene)]
                for scene, true in zip(scenes, truths.futures, strict=True)
            ]
            cells = part(lambda: run(list(chain.from_iterable(tasks)), truths, on_progress=on_progress))
            answers = [future.result() for future in truths.futures] if cells is not None else []
        landed = part(lambda: contacts(running_engines, answered(landing, limit_s), on_progress=on_progress))
    found = iter(cells)
    rows, runs = [], []
    for scene, answer, own in zip(scenes, answers, tasks, strict=True):
        titled = [(one.running_engine.title, next(found)) for one in own]
        rows += [cell_row(scene, answer.truth, title, cell) for title, cell in titled]
        runs.append((scene, [cell.own.run(scene, title, answer.truth) for title, cell in titled]))
    times = [*time_rows(running_engines, runs)] if timed else []
    if timed:
        on_progress("timed")
    return Record(
        scenes=tuple(words[0]),
        contestants=tuple(words[1]),
        command=command,
        questions=frame(
            QUESTIONS, (question_row(scene, *answer) for scene, answer in zip(scenes, answers, strict=True))
        ),
        engines=frame(ENGINES, map(engine_row, running_engines)),
        cells=frame(CELLS, rows),
        times=frame(TIMES, times) if timed else None,
        contact=frame(CONTACT, (row for one in landed for row in contact_rows(one))) if landed else None,
    )


def task(scene: Scene, true: Future[Answer], running_engine: RunningEngine, method: str) -> Task[Cell]:
    """Return the task of one contestant on one scene."""
    key = scene.name, running_engine.title, method
    return Task(key, running_engine, partial(cell, scene=scene, method=method, answer=true))


def cell(running_engine: RunningEngine, scene: Scene, method: str, answer: Future[Answer]) -> Cell:
    """Return one contestant's run, and a step-size sequence around it if the method has an order to determine."""
    true = answer.result().truth

    def evaluated(dt: float, answer: Trajectory | Failure) -> Run:
        return RunAnswer.of(running_engine, method, dt, answer).run(scene, running_engine.title, true)

    def at(dt: float) -> Run:
        return evaluated(dt, running_engine.simulate(scene, method, dt, probe=True))

    own = at(scene.step)
    if not order.readable(own):
        return Cell(plain(own), [], None)
    other = running_engine.simulate(
        replace(scene, start=nudged(scene.start, running_engine.rounding)), method, scene.step
    )
    own_steps = running_engine.takes_own_steps(method)
    # Rounding errors of n steps add up as a random walk: sqrt(n) times that of one.
    rounded = len(legs(scene, scene.step)) if own_steps else own.flight.steps
    ladder = () if own_steps else order.ladder(own, at)
    apart_m = apart_m_of(own, evaluated(scene.step, other))
    return Cell(plain(own), [plain(each) for each in ladder], apart_m and math.sqrt(rounded) * apart_m)


def plain(run: Run) -> RunAnswer:
    """Return a run without its scene and truth."""
    return RunAnswer(method=run.method, dt=run.dt, answer=run.answer, tolerance=run.tolerance, rounding=run.rounding)


def nudged(start: Array, rounding: float) -> Array:
    """Return states, (N, 13), moved by one relative rounding of the vector that each number belongs to."""
    parts = np.split(start, (3, 7, 10), axis=1)
    scales = [np.repeat(np.linalg.norm(part, axis=1, keepdims=True), part.shape[1], axis=1) for part in parts]
    return frozen_array(start + np.hstack(scales) * rounding * NUDGE)


def apart_m_of(one: Run, other: Run) -> float | None:
    """Return the largest distance between two runs [m], None if the other did not finish."""
    if isinstance(other.answer, Failure) or other.answer.diverged_at is not None:
        return None
    return float(np.linalg.norm(one.flight.vertices - other.flight.vertices, axis=-1).max())


def question_row(scene: Scene, true: Truth | None, why_no_truth: str) -> QuestionRow:
    """Return the row of one scene; of a reference solution with a horizon, its part before that."""
    known = None if true is None else true.until_horizon()
    resolution = None if known is None else float(known.resolution.max())
    row = QuestionRow(
        scene=scene.name,
        step_s=scene.step,
        samples=len(scene.times),
        truth=why_no_truth or EXACT,
        resolution_m=resolution,
        size_m=scene.body.reach,
    )
    return row if known is None else replace(row, **vector_columns(known.vertices[-1, 0, -1], "x_m", "y_m", "z_m"))


def cell_row(scene: Scene, true: Truth | None, engine: str, cell: Cell) -> CellRow:
    """Return the row of one contestant on one scene."""
    own = cell.own.run(scene, engine, true)
    row = asdict(run_row(own))
    attitude_order, translation_order = order.orders([each.run(scene, engine, true) for each in cell.ladder])
    return CellRow(
        **{name: row[name] for name in CELLS.names if name in row},
        rounding_m=cell.rounding_m,
        attitude_order=attitude_order,
        translation_order=translation_order,
        spin_energy=spin_energy(own),
    )
