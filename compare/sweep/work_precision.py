"""Error against run time: every contestant down a ladder of steps or tolerances, then all of them against one clock.

Errors and times come from separate runs.  A fixed-step method's time is its steps times the cost of one; an adaptive
method, and one that takes a flight in one step, is timed by whole flights.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from tumble.compare.judge.cost import Timed, time_runs
from tumble.compare.judge.errors import Flown, Run
from tumble.compare.run.flight import legs
from tumble.compare.run.process.kept import Kept
from tumble.compare.run.progress import ProgressCallback, no_progress
from tumble.compare.run.running_engines import RunningEngine, truth_limit
from tumble.compare.run.status import Failure, Status
from tumble.compare.run.tasks import Task, run
from tumble.compare.run.timing.readings import USUAL, Sampling
from tumble.compare.run.truths import Truths, true_answer
from tumble.compare.sweep.longer_steps import COUNTS, at_all, longer_steps
from tumble.scenarios.scene import Scene
from tumble.scenarios.truth import NoTruth, Truth

YARDSTICK = "yardstick"
TOLERANCES = tuple(10.0 ** (-half / 2) for half in range(4, 29))
# A rung that gains less than this over three of its predecessors, which shrink the step by 2.8, is at its floor.
GAIN, OVER = 0.7, 3
# A scene and its truth by the step that it is judged for, None for that at its samples.
Judged = Mapping[float | None, tuple[Scene, Truth]]
ASYMPTOTIC = 1e-3  # of the body's size: an error above it may rise and fall before it is one of a small step


@dataclass(frozen=True)
class Effort:
    """How far a sweep goes.

    budget_s: native loop that one flight may take [s], by what its engine says that a step takes and not by a clock, so
    that the rungs are the same on a busy machine; tolerances: those of adaptive methods; sampling: of the times.
    """

    budget_s: float = 1.25
    tolerances: tuple[float, ...] = TOLERANCES
    sampling: Sampling = USUAL


FULL = Effort()
# Of a page: a third of the tolerances, ladders a twenty-fifth as long.
BRIEF = Effort(0.05, TOLERANCES[::3], Sampling(span_s=0.0, rounds=12, budget_s=2.0))


@dataclass(frozen=True, eq=False)
class Sweep:
    """All runs of one scene; those without a flight keep their reason and have no time.

    why_untimed: why contestants that flew could not be timed, by their names.
    """

    scene: Scene
    timed: tuple[Timed, ...]
    untimed: tuple[Run, ...]
    why_untimed: dict[str, str] = field(default_factory=dict)

    @property
    def runs(self) -> Iterator[Run]:
        """Every run, timed or not."""
        yield from (each.run for each in self.timed)
        yield from self.untimed


def sweep(
    running_engines: Sequence[RunningEngine],
    scene: Scene,
    on_progress: ProgressCallback = no_progress,
    effort: Effort = FULL,
    kept: Kept | None = None,
    enough_m: float = 0.0,
    beyond_samples: bool = False,
) -> Sweep:
    """Return one scene's error and time for every contestant and every rung of its ladder.

    kept: ladders that are done already, and where those are kept that get done.  Times are always taken anew: they are
    worth something only beside each other.
    enough_m: the error [m] that is asked for: a ladder ends where it is reached; beyond_samples: whether ladders of
    fixed steps begin above the distance of two samples; such steps are judged where they end.
    Raises NoTruth where there is nothing to measure errors against, RayMissed as compare does.
    """
    return against_the_clock(
        running_engines,
        scene,
        ladders(running_engines, scene, on_progress, effort, kept, enough_m, beyond_samples=beyond_samples),
        on_progress,
        effort,
    )


def ladders(
    running_engines: Sequence[RunningEngine],
    scene: Scene,
    on_progress: ProgressCallback = no_progress,
    effort: Effort = FULL,
    kept: Kept | None = None,
    enough_m: float = 0.0,
    truths: Truths | None = None,
    beyond_samples: bool = False,
) -> list[Run]:
    """Return every rung of every contestant's ladder, which no clock reads.

    truths: where that of the scene is asked for already; the other arguments, and what is raised: as of `sweep`.
    """
    longer = longer_steps(scene) if beyond_samples else {}
    answer = (
        truths.answer(scene) if truths else true_answer(at_all(scene, longer), limit_s=truth_limit(running_engines))
    )
    if answer.truth is None:
        raise NoTruth(f"{scene.name} has no truth to be held against: {answer.why}")
    asked = ((dt, seen, answer.at(seen).truth) for dt, seen in [(None, scene), *longer.items()])
    judged = {dt: (seen, true) for dt, seen, true in asked if true is not None}

    def task(running_engine: RunningEngine, method: str) -> Task[list[Flown]]:
        key = scene.name, running_engine.title, method
        return Task(key, running_engine, lambda able: climb(able, judged, method, effort, enough_m), list[Flown])

    def run_of(running_engine: RunningEngine, flown: Flown) -> Run:
        seen, true = where_judged(judged, running_engine, flown.method, flown.dt)
        return flown.run(seen, running_engine.title, true)

    tasks = [task(each, method) for each in running_engines for method in each.methods_for(scene)]
    found = run(tasks, on_progress=on_progress, kept=kept)
    return [run_of(one.running_engine, flown) for one, ladder in zip(tasks, found, strict=True) for flown in ladder]


def where_judged(judged: Judged, running_engine: RunningEngine, method: str, dt: float) -> tuple[Scene, Truth]:
    """Return the scene as one rung is run on it, and its truth: by its samples, or by the ends of longer steps."""
    return judged[None if running_engine.takes_own_steps(method) or dt not in judged else dt]


def against_the_clock(
    running_engines: Sequence[RunningEngine],
    scene: Scene,
    runs: Sequence[Run],
    on_progress: ProgressCallback = no_progress,
    effort: Effort = FULL,
) -> Sweep:
    """Return the sweep of one scene's ladders, all their times taken in the same rounds."""
    timed, why_untimed = time_runs(running_engines, scene, runs, effort.sampling)
    on_progress("timed")
    clocked = {id(each.run) for each in timed}
    return Sweep(
        scene=scene,
        timed=tuple(timed),
        untimed=tuple(one for one in runs if id(one) not in clocked),
        why_untimed=why_untimed,
    )


def climb(running_engine: RunningEngine, judged: Judged, method: str, effort: Effort, enough_m: float) -> list[Flown]:
    """Return the ladder of one method from its longest step to its floor, to what is enough, or the budget's end.

    judged: the scene by its samples, and by longer steps, each with its truth.
    """
    scene, _ = judged[None]
    longer = [] if running_engine.takes_own_steps(method) else [(method, dt) for dt in judged if dt is not None]
    ladder: list[Flown] = []
    runs: list[Run] = []
    for name, dt in (*longer, *rungs(running_engine, scene, method, effort.tolerances)):
        seen, true = where_judged(judged, running_engine, name, dt)
        answer = running_engine.fly(seen, name, dt, no_progress=True)
        ladder.append(Flown.of(running_engine, name, dt, answer))
        runs.append(ladder[-1].run(seen, running_engine.title, true))
        # An adaptive method's error falls by fits and starts, and its tolerances are few: they are all tried.
        if isinstance(answer, Failure) or (name == method and at_floor(runs)):
            break
        if over_budget(running_engine, name, answer.steps * len(scene.start), effort.budget_s):
            break
        if runs[-1].status is Status.OK and float(runs[-1].distances.max()) <= enough_m:
            break
    return ladder


def rungs(
    running_engine: RunningEngine, scene: Scene, method: str, tolerances: Sequence[float] = TOLERANCES
) -> Iterator[tuple[str, float]]:
    """Yield (method, dt [s]): tolerances of an adaptive method, one step for a whole one, else 2^k and 3 2^k steps."""
    bare = not isinstance(running_engine.info, Failure) and method in running_engine.info.adaptive
    if bare:
        yield from ((f"{method}@{tolerance:.3g}", scene.duration) for tolerance in tolerances)
    elif running_engine.takes_own_steps(method):
        yield method, scene.duration
    else:
        cuts = len(legs(scene, scene.duration))
        yield from ((method, scene.duration / (cuts * count)) for count in COUNTS)


def over_budget(running_engine: RunningEngine, method: str, steps: int, budget_s: float) -> bool:
    """Whether the next rung would take longer than a flight may; steps: those of all throws in this one."""
    info = running_engine.info
    return not isinstance(info, Failure) and 1.5 * steps * info.step_of(method) > 1e9 * budget_s


def at_floor(runs: Sequence[Run]) -> bool:
    """Whether smaller steps have stopped paying: the error is the truth's limit, or no longer falls."""
    errors = [float(run.distances.max()) for run in runs]
    limit = float(runs[-1].limits.max())
    if len(errors) > 1 and max(errors[-2:]) <= limit:
        return True
    size = runs[-1].scene.body.reach
    return len(errors) > OVER and max(errors[-OVER - 1 :]) < ASYMPTOTIC * size and errors[-1] > GAIN * errors[-OVER - 1]
