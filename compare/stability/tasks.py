"""Every scene and every extreme case with every contestant, engines side by side.

One contestant in one scene is a piece, which is one task.
"""

from collections.abc import Callable, Sequence
from concurrent.futures import Future
from contextlib import nullcontext
from functools import partial

from tumble.compare.run.progress import ProgressCallback, no_progress
from tumble.compare.run.running_engines import RunningEngine, truth_limit
from tumble.compare.run.status import Failure
from tumble.compare.run.tasks import Key, Task, run
from tumble.compare.run.truths import Answer, Truths
from tumble.compare.stability.columns import FACTORS, ROWS, Question, columns
from tumble.compare.stability.contact import ContactPiece, contact_piece
from tumble.compare.stability.extremes import BUDGET_S, ExtremeRow, extreme
from tumble.compare.stability.trials import FULL, Effort, Piece, Trials
from tumble.scenarios.read import extremes
from tumble.scenarios.scene import Scene
from tumble.scenarios.truth import NoTruth

# Mapped if no scene is named.
STIFF = (
    "tether-undamped",
    "tether-critical",
    "tether-overdamped",
    "rod-stiff",
    "drag-stiff",
    "floor-stiff",
    "spin-fast",
)
Done = Piece | ExtremeRow | ContactPiece


def default_scenes() -> tuple[str, ...]:
    """Return the scenes of a study that names none.

    Returns
    -------
    names : the stiff scenes of the catalogue, and all extreme cases
    """
    return (*STIFF, *extremes())


def contestants(running_engine: RunningEngine, scene: Scene, few: bool = False) -> tuple[str, ...]:
    """Return the methods to run: those of the scene and, unless some were named, those on request.

    few: none on request, nor above a plane, where each engine says which methods have a use.
    """
    methods = running_engine.methods_for(scene)
    if few or scene.plane or running_engine.only_named or isinstance(running_engine.info, Failure):
        return methods
    return tuple(dict.fromkeys((*methods, *running_engine.info.on_request)))


def keys(
    running_engines: Sequence[RunningEngine], scenes: Sequence[Scene], cases: Sequence[Scene], few: bool = False
) -> list[Key]:
    """Return scene, engine and method of every piece, in the order of the tables."""
    return [
        (scene.name, running_engine.title, method)
        for scene in (*scenes, *cases)
        for running_engine in running_engines
        for method in contestants(running_engine, scene, few)
    ]


def stability(
    running_engines: Sequence[RunningEngine],
    scenes: Sequence[Scene],
    cases: Sequence[Scene],
    on_progress: ProgressCallback = no_progress,
    finished: Callable[[Key, Done], object] = lambda key, piece: None,
    factors: Sequence[float] = FACTORS,
    few: bool = False,
    effort: Effort = FULL,
    budget_s: float = BUDGET_S,
    truths: Truths | None = None,
) -> list[Done]:
    """Return every piece, in the order of `keys`.

    on_progress: called for every piece; finished: called with every piece, one at a time;
    factors: of the scenes' own parameter values; few: no method that runs only on request;
    effort: for each scene; budget_s: for each extreme case [s]; truths: computes the reference solutions; None: new
    ones.
    Raises BadScene for a scene in which nothing limits the step, RayMissed as compare does.
    """
    landing, scenes = ([scene for scene in scenes if bool(scene.plane) == has] for has in (True, False))
    own_columns = [columns(scene, factors) for scene in scenes]
    runs = [column.scene_of(ROWS) for own in own_columns for column in own]
    with nullcontext(truths) if truths else Truths([], limit_s=truth_limit(running_engines)) as working:
        true = iter(working.more([*runs, *cases]))
        questions = [
            Question(scene, own, [next(true) for _ in own]) for scene, own in zip(scenes, own_columns, strict=True)
        ]
        tasks: list[Task[Done]] = [
            Task((question.scene.name, each.title, method), each, partial(piece, method, question, effort))
            for question in questions
            for each in running_engines
            for method in contestants(each, question.scene, few)
        ]
        tasks += [
            Task((scene.name, each.title, method), each, partial(contact_task, method, scene))
            for scene in landing
            for each in running_engines
            for method in contestants(each, scene, few)
        ]
        tasks += [
            Task((case.name, each.title, method), each, partial(extreme_row, method, case, answer, budget_s))
            for case, answer in zip(cases, true, strict=True)
            for each in running_engines
            for method in contestants(each, case, few)
        ]
        return run(tasks, working, finished, on_progress)


def piece(method: str, question: Question, effort: Effort, running_engine: RunningEngine) -> Piece:
    """Return the map and limits of one contestant in one scene."""
    return Trials(running_engine, method, question, effort).piece()


def contact_task(method: str, scene: Scene, running_engine: RunningEngine) -> ContactPiece:
    """Return the results of one contestant in one scene with a plane."""
    return contact_piece(running_engine, method, scene)


def extreme_row(
    method: str, case: Scene, true: Future[Answer], budget_s: float, running_engine: RunningEngine
) -> ExtremeRow:
    """Return the result of one contestant in one extreme case."""
    found = true.result()
    if found.truth is None:
        raise NoTruth(f"{case.name} has no reference solution: {found.why}")
    return extreme(running_engine, method, case, found.truth, budget_s)
