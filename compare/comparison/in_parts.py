"""Very many throws of a scene, in parts that are tasks: each gives the errors of its throws, added up, and is gone."""

import threading
from collections import OrderedDict
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise

from tumble.compare.judge.errors import RunAnswer
from tumble.compare.judge.spread import Spread, added, spread_of
from tumble.compare.run.digest import digest
from tumble.compare.run.execution import EXECUTION
from tumble.compare.run.progress import ProgressCallback, no_progress
from tumble.compare.run.running_engines import RunningEngine, truth_limit
from tumble.compare.run.status import Failure
from tumble.compare.run.tasks import Task, stream
from tumble.compare.run.truths import Answer, true_answer
from tumble.scenarios.ensemble import part_of, part_size, parts_in
from tumble.scenarios.scene import Scene, frozen_array
from tumble.scenarios.truth import Truth

# Throws that an engine has in its world at a time: some engines take the square of their number, and twice as long for
# 512.  A method with a step this fast [ns] has no world; it has more, as the question itself costs as much as many.
AT_A_TIME, SIDE_BY_SIDE, FAST_NS = 128, 4096, 100
# Parts whose reference solutions are held at a time: contestants share them.
SHARED = 4


class SharedAnswers:
    """Reference solutions of the last few parts, which contestants share: of one study, or of one Dask worker."""

    identity = "reference solutions"  # no result depends on which of them are here

    def __init__(self) -> None:
        self._futures: OrderedDict[tuple[str, int, float], Future[tuple[Scene, Answer]]] = OrderedDict()
        self._one_at_a_time = threading.Lock()

    def __reduce__(self) -> tuple[Callable[[], "SharedAnswers"], tuple[()]]:
        """Stay here: a task that is sent has those of its worker."""
        return of_this_worker, ()

    def of(self, running_engine: RunningEngine, scene: Scene, number: int, limit_s: float) -> tuple[Scene, Answer]:
        """Return a part and its reference solution, computed by who asks first.  Raises Halted, RayMissed."""
        key = digest(scene), number, limit_s
        with self._one_at_a_time:
            is_mine = key not in self._futures
            future = self._futures.setdefault(key, Future())
            while len(self._futures) > SHARED:
                self._futures.popitem(last=False)
        if is_mine:
            try:
                part = part_of(scene, number)
                future.set_result(
                    (part, true_answer(part, tell=lambda share: running_engine.refuse_halted(), limit_s=limit_s))
                )
            except BaseException as error:
                with self._one_at_a_time:
                    self._futures.pop(key, None)
                future.set_exception(error)
        return future.result()


def of_this_worker() -> SharedAnswers:
    """Return what the tasks of a Dask worker share."""
    from distributed import get_worker

    return vars(get_worker()).setdefault("tumble_answers", SharedAnswers())


@dataclass(frozen=True, eq=False)
class EnsembleRun:
    """One contestant in all throws of a scene.

    Parameters
    ----------
    running_engine : the engine
    method : of the engine
    dt : step [s]
    spread : the errors
    """

    running_engine: RunningEngine
    method: str
    dt: float
    spread: Spread

    @property
    def tolerance(self) -> float | None:
        """The tolerance under which the method chooses its steps, None of one that does not."""
        return self.running_engine.tolerance(self.method)

    @property
    def name(self) -> str:
        """ENGINE:METHOD."""
        return f"{self.running_engine.title}:{self.method}"


def contestants_of(running_engines: Sequence[RunningEngine], scene: Scene) -> list[tuple[RunningEngine, str]]:
    """Return who takes part in a scene that is run in parts: engines with their methods.

    Parameters
    ----------
    running_engines : with their methods
    scene : has an ensemble

    Returns
    -------
    pairs of an engine and a method
    """
    # Some methods are for many throws alone.
    several = part_of(scene, 0)
    return [(one, method) for one in running_engines for method in one.methods_for(several)]


def ensemble_runs(
    running_engines: Sequence[RunningEngine],
    scene: Scene,
    dt: float | None = None,
    on_progress: ProgressCallback = no_progress,
) -> list[EnsembleRun]:
    """Run all throws of a scene with every contestant, part by part.

    A contestant that fails in a part has no errors, and does not run the parts that follow.

    Parameters
    ----------
    running_engines : with their methods
    scene : has an ensemble
    dt : step [s]; None: the scene's own
    on_progress : called for every part of every contestant

    Returns
    -------
    one for each contestant

    Raises
    ------
    Incomplete : some parts are other shards'
    """
    pairs, limit_s = contestants_of(running_engines, scene), truth_limit(running_engines)
    found = {(engine.title, method): Spread(0) for engine, method in pairs}
    # All shards have the same tasks, whatever became of those of one.
    is_sharded = EXECUTION.get().shard is not None
    shared = SharedAnswers()

    def tasks() -> Iterator[Task[Spread]]:
        for number in range(parts_in(scene)):
            for engine, method in pairs:
                if is_sharded or not found[engine.title, method].has_failed:
                    yield _task(engine, method, scene, dt, number, limit_s, shared)

    for task, spread in stream(tasks(), on_progress):
        _, title, method, _ = task.key
        found[title, method] = added(found[title, method], spread)
    return [EnsembleRun(engine, method, dt or scene.step, found[engine.title, method]) for engine, method in pairs]


def _task(
    engine: RunningEngine,
    method: str,
    scene: Scene,
    dt: float | None,
    number: int,
    limit_s: float,
    shared: SharedAnswers,
) -> Task[Spread]:
    ask = partial(
        part_errors, scene=scene, method=method, dt=dt or scene.step, number=number, limit_s=limit_s, shared=shared
    )
    return Task((scene.name, engine.title, method, f"part {number}"), engine, ask)


def part_errors(
    running_engine: RunningEngine,
    scene: Scene,
    method: str,
    dt: float,
    number: int,
    limit_s: float,
    shared: SharedAnswers,
) -> Spread:
    """Return the errors of one contestant in one part; limit_s: of its reference solution [s]."""
    whole, answer = shared.of(running_engine, scene, number, limit_s)
    found, before = Spread(0), number * part_size(scene)
    pieces = max(1, len(whole.start) // at_a_time(running_engine, method))
    for first, last in pairwise(len(whole.start) * piece // pieces for piece in range(pieces + 1)):
        some = slice(first, last)
        piece = replace(whole, start=frozen_array(whole.start[some]))
        # One probe is enough to find an engine that looks its answers up.
        trajectory = running_engine.simulate(piece, method, dt, probe=before + first == 0)
        true = answer.truth and of_throws(answer.truth, some)
        one = RunAnswer.of(running_engine, method, dt, trajectory).run(piece, running_engine.title, true)
        found = added(found, spread_of(one, before + first))
        if found.has_failed:
            break
    return replace(found, throws=len(whole.start))


def at_a_time(running_engine: RunningEngine, method: str) -> int:
    """Return how many throws a method simulates at a time."""
    info = running_engine.info
    return AT_A_TIME if isinstance(info, Failure) or info.step_of(method) > FAST_NS else SIDE_BY_SIDE


def of_throws(truth: Truth, some: slice) -> Truth:
    """Return the reference solution of some of its throws."""
    arrays = {name: getattr(truth, name)[:, some] for name in ("states", "vertices", "bound", "input_error")}
    return replace(truth, contacts=truth.contacts[some], **arrays)
