"""Error against run time: every contestant over a sequence of steps or tolerances, then all timed together.

Errors and times come from separate runs.  The time of a fixed-step method is its number of steps times the cost of one;
adaptive methods, and those that take a whole run in one step, are timed by whole runs.
"""

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import pairwise

import numpy as np

from tumble.compare.judge.cost import Timed, time_runs
from tumble.compare.judge.errors import Run, RunAnswer
from tumble.compare.judge.orders import Level, order_between
from tumble.compare.run.engines.registry import STEP_NS
from tumble.compare.run.flight import Trajectory, legs
from tumble.compare.run.progress import ProgressCallback, no_progress
from tumble.compare.run.running_engines import RunningEngine, truth_limit
from tumble.compare.run.status import Failure, Status
from tumble.compare.run.tasks import Task, run
from tumble.compare.run.timing.readings import USUAL, Sampling
from tumble.compare.run.truths import Truths
from tumble.compare.sweep.longer_steps import COUNTS, longer_steps, with_all_samples
from tumble.compare.sweep.schemas import ObservableCostRow
from tumble.scenarios.scene import Scene
from tumble.scenarios.truth import NoTruth, Truth

YARDSTICK = "yardstick"
TOLERANCES = tuple(10.0 ** (-half / 2) for half in range(4, 29))
# A level whose error is above this share of that three levels before, with steps 2.8 times as long, is at the floor.
GAIN, OVER = 0.7, 3
# A scene and its reference solution by longer step [s]; None: at the scene's own samples.
References = Mapping[float | None, tuple[Scene, Truth]]
ASYMPTOTIC = 1e-3  # of the body's size: larger errors need not fall with the step
# Errors whose run times are reported [m].
TARGETS_M = (1e-3, 1e-6, 1e-9, 1e-12)
# Where a run takes more than this share of the budget the steps are halved, and only where the error passes one of
# those above there is a run between: four levels a decade would take 1.7 times as long.
COSTLY = 0.03
# The last halvings, which take three quarters of the time of all, are run where an error to be reported may be between
# them, or where the orders of the pairs of levels before differ by more than this.
LAST_HALVINGS, SETTLED = 2, 0.3


@dataclass(frozen=True)
class Effort:
    """How far a sweep goes.

    budget_s: run time of one run [s], by the engine's stated cost per step and not by a clock, so that the levels are
    the same on a busy machine; tolerances: of adaptive methods; sampling: of the times.
    """

    budget_s: float = 1.25
    tolerances: tuple[float, ...] = TOLERANCES
    sampling: Sampling = USUAL


FULL = Effort()
# For the page: a third of the tolerances, sequences a twenty-fifth as long.
BRIEF = Effort(0.05, TOLERANCES[::3], Sampling(span_s=0.0, rounds=8, budget_s=2.0))


@dataclass(frozen=True, eq=False)
class Sweep:
    """All runs of one scene.

    Parameters
    ----------
    scene : the scene
    timed : runs with a run time
    untimed : runs without a run time, among them those without a trajectory, which have a reason
    why_untimed : reason by name, of contestants that ran but could not be timed
    observed : errors of an observable of contact with their run times; empty without a plane
    """

    scene: Scene
    timed: tuple[Timed, ...]
    untimed: tuple[Run, ...]
    why_untimed: dict[str, str] = field(default_factory=dict)
    observed: tuple[ObservableCostRow, ...] = ()

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
    enough_m: float = 0.0,
    beyond_samples: bool = False,
    reference: str = "",
) -> Sweep:
    """Return one scene's error and run time for every contestant and every level of its sequence.

    Parameters
    ----------
    running_engines : with their methods
    scene : the scene
    on_progress : called for every contestant, and when all are timed
    effort : how far the sequences go, and how times are sampled
    enough_m : a sequence ends when it reaches this error [m]
    beyond_samples : fixed steps start above the sampling interval, with errors measured where they end
    reference : ENGINE:METHOD that run times are divided by; empty: by any

    Returns
    -------
    all runs, timed if possible

    Raises
    ------
    NoTruth : there is no reference solution
    RayMissed : the ray of a later impulse misses the true body
    """
    return against_the_clock(
        running_engines,
        scene,
        ladders(running_engines, scene, on_progress, effort, enough_m, beyond_samples=beyond_samples),
        on_progress,
        effort,
        reference,
    )


def ladders(
    running_engines: Sequence[RunningEngine],
    scene: Scene,
    on_progress: ProgressCallback = no_progress,
    effort: Effort = FULL,
    enough_m: float = 0.0,
    truths: Truths | None = None,
    beyond_samples: bool = False,
) -> list[Run]:
    """Return every level of every contestant's sequence, untimed.

    Parameters
    ----------
    truths : has the scene's reference solution already; None: it is computed
    running_engines, scene, on_progress, effort, enough_m, beyond_samples : as of `sweep`

    Returns
    -------
    the runs, contestant by contestant

    Raises
    ------
    as `sweep`
    """
    longer = longer_steps(scene) if beyond_samples else {}
    own = [] if truths else [with_all_samples(scene, longer)]
    with Truths(own, limit_s=truth_limit(running_engines)) as computed:
        answer = (truths or computed).answer(scene)
    if answer.truth is None:
        raise NoTruth(f"{scene.name} has no reference solution: {answer.why}")
    found_references = ((dt, seen, answer.at(seen).truth) for dt, seen in [(None, scene), *longer.items()])
    references = {dt: (seen, true) for dt, seen, true in found_references if true is not None}

    def task(running_engine: RunningEngine, method: str) -> Task[list[RunAnswer]]:
        key = scene.name, running_engine.title, method
        ask = partial(climb, references=references, method=method, effort=effort, enough_m=enough_m)
        return Task(key, running_engine, ask)

    def run_of(running_engine: RunningEngine, run_answer: RunAnswer) -> Run:
        seen, true = reference_for(references, running_engine, run_answer.method, run_answer.dt)
        return run_answer.run(seen, running_engine.title, true)

    tasks = [task(each, method) for each in running_engines for method in each.methods_for(scene)]
    found = run(tasks, on_progress=on_progress)
    return [
        run_of(one.running_engine, run_answer)
        for one, ladder in zip(tasks, found, strict=True)
        for run_answer in ladder
    ]


def reference_for(references: References, running_engine: RunningEngine, method: str, dt: float) -> tuple[Scene, Truth]:
    """Return the scene of one level and its reference solution: at its samples, or at the ends of longer steps."""
    return references[None if running_engine.takes_own_steps(method) or dt not in references else dt]


def against_the_clock(
    running_engines: Sequence[RunningEngine],
    scene: Scene,
    runs: Sequence[Run],
    on_progress: ProgressCallback = no_progress,
    effort: Effort = FULL,
    reference: str = "",
) -> Sweep:
    """Return the sweep of one scene's sequences, all times sampled in the same rounds.

    Parameters
    ----------
    running_engines : of the runs
    scene : the scene
    runs : as of `ladders`
    on_progress : called when all are timed
    effort : how times are sampled
    reference : ENGINE:METHOD that run times are divided by; empty: by any

    Returns
    -------
    all runs, timed if possible
    """
    ((timed, why_untimed),) = time_runs(running_engines, [(scene, runs)], effort.sampling, reference)
    on_progress("timed")
    clocked = {id(each.run) for each in timed}
    return Sweep(
        scene=scene,
        timed=tuple(timed),
        untimed=tuple(one for one in runs if id(one) not in clocked),
        why_untimed=why_untimed,
    )


def climb(
    running_engine: RunningEngine, references: References, method: str, effort: Effort, enough_m: float
) -> list[RunAnswer]:
    """Return the sequence of one method from its longest step to its floor, the error asked for, or the budget.

    It ends one or two halvings before the budget where no error to be reported is among them.
    references: the scene at its samples, and at longer steps, each with its reference solution.
    """
    scene, truth = references[None]
    longer = [] if running_engine.takes_own_steps(method) else [(method, dt) for dt in references if dt is not None]
    longest = longest_step(running_engine, method, truth)
    ladder: list[tuple[RunAnswer, Run]] = []

    def simulate(name: str, dt: float) -> Trajectory | Failure:
        seen, true = reference_for(references, running_engine, name, dt)
        answer = RunAnswer.of(running_engine, name, dt, running_engine.simulate(seen, name, dt, probe=True))
        ladder.append((answer, answer.run(seen, running_engine.title, true)))
        return answer.answer

    for name, dt in (*longer, *levels(running_engine, scene, method, effort)):
        if dt > longest:
            continue
        answer = simulate(name, dt)
        runs = [each for _, each in ladder]
        # The error of an adaptive method falls irregularly, and its tolerances are few: all are tried.
        if isinstance(answer, Failure) or (name == method and at_floor(runs)):
            break
        # The next level has at most twice the steps.
        halvings = math.log2(effort.budget_s / run_time_s(running_engine, name, answer.steps * len(scene.start)))
        if halvings < 1.0:
            break
        if (
            name == method
            and halvings < LAST_HALVINGS + 1
            and not may_reach(runs, (*TARGETS_M, enough_m), int(halvings))
        ):
            break
        if float(runs[-1].distances.max()) <= enough_m and runs[-1].status is Status.OK:  # the audit takes longest
            break
    for dt in [*left_out([each for _, each in ladder])]:
        simulate(method, dt)
    return [answer for answer, _ in sorted(ladder, key=lambda each: -each[0].dt)]


def longest_step(running_engine: RunningEngine, method: str, truth: Truth) -> float:
    """Return the longest step [s] that the method takes as one while the body spins as in the reference."""
    info = running_engine.info
    turn = math.inf if isinstance(info, Failure) else info.whole_turn.get(method, math.inf)
    fastest = float(np.nanmax(np.linalg.norm(truth.states[..., 10:13], axis=-1)))
    return turn / fastest if fastest else math.inf


def levels(
    running_engine: RunningEngine, scene: Scene, method: str, effort: Effort = FULL
) -> Iterator[tuple[str, float]]:
    """Yield (method, dt [s]): tolerances of an adaptive method, one step of a whole one, else steps.

    There are 2^k and 3 2^k steps, but of costly ones 2^k alone.
    """
    bare = not isinstance(running_engine.info, Failure) and method in running_engine.info.adaptive
    if bare:
        yield from ((f"{method}@{tolerance:.3g}", scene.duration) for tolerance in effort.tolerances)
    elif running_engine.takes_own_steps(method):
        yield method, scene.duration
    else:
        cuts = len(legs(scene, scene.duration))
        for count in COUNTS:
            cost_s = run_time_s(running_engine, method, count * cuts * len(scene.start))
            if cost_s <= COSTLY * effort.budget_s or count.bit_count() == 1:
                yield method, scene.duration / (cuts * count)


def left_out(ladder: Sequence[Run]) -> Iterator[float]:
    """Yield the steps [s] left out of a sequence where the error passes one that is reported: it is interpolated there.

    Between n and 2 n steps it is 3 n/2.
    """
    for coarse, fine in pairwise(ladder):
        if coarse.tolerance is None and coarse.flight.steps >= 4 and coarse.dt == 2.0 * fine.dt:
            worse, better = (float(run.distances.max()) for run in (coarse, fine))
            if any(better <= target < worse for target in TARGETS_M):
                yield fine.dt * 4.0 / 3.0


def run_time_s(running_engine: RunningEngine, method: str, steps: float) -> float:
    """Return how long so many steps of one throw take [s], by what the engine says that one takes."""
    info = running_engine.info
    return steps * (STEP_NS if isinstance(info, Failure) else info.step_of(method)) / 1e9


def may_reach(runs: Sequence[Run], targets_m: Collection[float], halvings: int) -> bool:
    """Whether as many halvings of the step may reach one of these errors [m], by the order of the errors before."""
    last = [Level(run.dt, float(run.distances.max()), float(run.limits.max())) for run in runs[-OVER - 1 :]]
    falling_steps = all(coarse.dt_s > fine.dt_s for coarse, fine in pairwise(last))
    if len(last) <= OVER or not falling_steps or not all(0.0 < level.error_m < math.inf for level in last):
        return True
    # Also of errors that fall no more, which no halving helps.
    orders = [order_between(coarse, fine) for coarse, fine in pairwise(last)]
    if not max(orders) - min(orders) <= SETTLED:
        return True
    error_m = last[-1].error_m
    return any(error_m * 2.0 ** (-halvings * max(orders)) <= target < error_m for target in targets_m)


def at_floor(runs: Sequence[Run]) -> bool:
    """Whether smaller steps no longer help: the error is within the resolution of the reference, or no longer falls."""
    errors = [float(run.distances.max()) for run in runs]
    limit = float(runs[-1].limits.max())
    if len(errors) > 1 and max(errors[-2:]) <= limit:
        return True
    size = runs[-1].scene.body.reach
    return len(errors) > OVER and max(errors[-OVER - 1 :]) < ASYMPTOTIC * size and errors[-1] > GAIN * errors[-OVER - 1]
