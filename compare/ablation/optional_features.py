"""Every contestant with its optional features on, and with only those that the scene needs.

A contestant is built lean, as always, then with each of its OPTIONAL features on, and with all of them:
`build(scene, method, keep)` of `tumble.compare.engines`.  The motion must stay the same, and the times of all are
sampled in the same rounds.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np

from tumble.compare.ablation.schemas import EVERYTHING, PLANE, AblationRow
from tumble.compare.judge.errors import quietly
from tumble.compare.run.execution import EXECUTION, Incomplete
from tumble.compare.run.flight import Trajectory, legs
from tumble.compare.run.progress import ProgressCallback, no_progress
from tumble.compare.run.running_engines import RunningEngine, truth_limit
from tumble.compare.run.status import Failure, Status
from tumble.compare.run.tasks import Task, work
from tumble.compare.run.timing.readings import USUAL, Reading, Sampling, ratio
from tumble.compare.run.timing.timing import Cost, Load, costs
from tumble.compare.run.truths import true_answer
from tumble.scenarios.needs import needs
from tumble.scenarios.scene import Plane, Scene, frozen_array
from tumble.scenarios.truth import Truth

# A free cube, a body that never rotates, and the benchmark scene, which needs most features.
SCENES = ("table-4-1", "die-straight", "yardstick")
# Of a page.
QUICK = Sampling(span_s=0.0, rounds=8, budget_s=1.0)
# Reason of an engine without optional features, or without any that the scene does not need.
NOTHING = "no unneeded features"
# Errors of one size: rounding or another choice of steps may double an error, a lost term does far worse.
ALIKE = 2.0
# How far below the body a plane is that it never touches, in sizes of it; engines look ahead by about one.
FAR = 10.0


@dataclass(frozen=True)
class Ablation:
    """The results of one scene.

    Parameters
    ----------
    scene : the scene
    rows : one for each contestant and feature, with its times or the reason that there are none
    resolution_m : resolution of the reference solution [m]; None: there is no reference solution
    inexact : rows whose motions differ by more than the resolution, because of the method's own error, for example by
        other steps
    altered : rows whose motions differ by more than the resolution, because the run without the feature is worse
    """

    scene: Scene
    rows: tuple[AblationRow, ...]
    resolution_m: float | None
    inexact: tuple[AblationRow, ...]
    altered: tuple[AblationRow, ...]


@dataclass(frozen=True, eq=False)
class Build:
    """One contestant built for a scene with some of its OPTIONAL features on; the lean one has none."""

    running_engine: RunningEngine
    scene: Scene
    method: str
    feature: str = ""
    keep: frozenset[str] = frozenset()

    @property
    def key(self) -> str:
        """Name of its timer."""
        return f"{self.running_engine.title}:{self.method} {self.feature}"

    @property
    def load(self) -> Load:
        """What is timed."""
        return Load(self.running_engine, self.scene, self.method, self.keep)

    def trajectory(self) -> Trajectory | Failure:
        """Return its run."""
        return self.running_engine.simulate(self.scene, self.method, self.scene.step, self.keep)

    def ns_per_step(self, reading: Reading) -> float:
        """Return the time per step by its reading [ns]."""
        return reading.ns / (1 if self.load.by_step else sum(leg.n for leg in legs(self.scene, self.scene.duration)))

    def row(self, why: str = "", **figures: float) -> AblationRow:
        """Return its row; why: figures are missing."""
        return AblationRow(
            scene=self.scene.name,
            engine=self.running_engine.title,
            method=self.method,
            feature=self.feature,
            why=why,
            **figures,
        )


@dataclass(frozen=True, eq=False)
class Pair:
    """A build with features on beside the lean one, the distance of their motions, and the errors of both [m]."""

    full: Build
    lean: Build
    apart_m: float
    full_error_m: float
    lean_error_m: float

    @property
    def harmless(self) -> bool:
        """Whether the lean run is about as accurate as the other, or more."""
        return self.lean_error_m <= ALIKE * self.full_error_m


class Untimed(NamedTuple):
    """The runs of one scene, or the rows of those that failed, and the resolution of its reference solution [m]."""

    scene: Scene
    resolution_m: float | None
    found: list[Pair | AblationRow]


def ablate(
    running_engines: Sequence[RunningEngine],
    scene: Scene,
    on_progress: ProgressCallback = no_progress,
    sampling: Sampling = USUAL,
    most_methods: int | None = None,
) -> Ablation:
    """Return the cost of each feature that a scene does not need, for every contestant.

    Parameters
    ----------
    running_engines : with their methods
    scene : the scene
    on_progress : called for every contestant, and when all are timed
    sampling : of the times
    most_methods : of each engine; None: all

    Returns
    -------
    all rows of the scene
    """
    found = untimed(running_engines, scene, on_progress, most_methods)
    return timed(found, on_progress, sampling)


def untimed(
    running_engines: Sequence[RunningEngine],
    scene: Scene,
    on_progress: ProgressCallback = no_progress,
    most_methods: int | None = None,
) -> Untimed:
    """Return the runs of `ablate`, before any is timed: other studies may run beside them.

    Parameters
    ----------
    running_engines : with their methods
    scene : the scene
    on_progress : called for every contestant
    most_methods : of each engine; None: all

    Returns
    -------
    for `timed`

    Raises
    ------
    Incomplete : in a shard, whose times are measured where it is merged
    """
    if EXECUTION.get().shard:
        raise Incomplete([f"{scene.name}, features"])
    true, _ = true_answer(scene, limit_s=truth_limit(running_engines))
    entries = [ask for each in running_engines for ask in questions(each, scene, true, most_methods)]
    # With the times, on this machine.
    tasks = [one for one in entries if isinstance(one, Task)]
    answers = iter(work(tasks, finished=lambda task, _: on_progress(str(task))))
    found = [one for ask in entries for one in (next(answers) if isinstance(ask, Task) else [ask])]
    return Untimed(scene, None if true is None else float(true.resolution.max()), found)


def timed(runs: Untimed, on_progress: ProgressCallback = no_progress, sampling: Sampling = USUAL) -> Ablation:
    """Return the cost of each feature, all times sampled in the same rounds.

    Parameters
    ----------
    runs : of `untimed`
    on_progress : called when all are timed
    sampling : of the times

    Returns
    -------
    all rows of the scene
    """
    scene, resolution_m, found = runs
    clocked = clock([one for one in found if isinstance(one, Pair)], sampling)
    on_progress(f"{scene.name} timed")
    rows = [(one, measured(one, clocked) if isinstance(one, Pair) else one) for one in found]
    # Above a plane engines have other settings, such as more substeps, which no option switches off.
    optional = [(one, row) for one, row in rows if isinstance(one, Pair) and one.full.feature != PLANE]
    apart = [(one, row) for one, row in optional if one.apart_m > (resolution_m or 0.0)]
    return Ablation(
        scene=scene,
        rows=tuple(row for _, row in rows),
        resolution_m=resolution_m,
        inexact=tuple(row for pair, row in apart if pair.harmless),
        altered=tuple(row for pair, row in apart if not pair.harmless),
    )


def questions(
    running_engine: RunningEngine, scene: Scene, true: Truth | None, most_methods: int | None
) -> list[Task[list[Pair | AblationRow]] | AblationRow]:
    """Return a task per method of one engine, or a row with the reason why there is none."""
    optional = [] if isinstance(running_engine.info, Failure) else running_engine.info.optional
    optional = [each for each in optional if each not in needs(scene)]
    unsupported = running_engine.unsupported(scene)
    why = str(unsupported) if unsupported else "" if optional or has_plane(running_engine, scene) else NOTHING
    if why:
        return [AblationRow(scene=scene.name, engine=running_engine.title, method="", feature="", why=why)]

    def task(method: str) -> Task[list[Pair | AblationRow]]:
        key = scene.name, running_engine.title, method
        return Task(key, running_engine, lambda able: list(pairs(able, scene, true, method, optional)))

    return [task(method) for method in running_engine.methods_for(scene)[:most_methods]]


def pairs(
    running_engine: RunningEngine, scene: Scene, true: Truth | None, method: str, optional: Sequence[str]
) -> Iterator[Pair | AblationRow]:
    """Yield one method with all its optional features on, and with each alone."""
    lean = Build(running_engine, scene, method)
    plain = lean.trajectory()
    if isinstance(plain, Failure):
        yield lean.row(str(plain))
        return
    runs = [
        (build, build.trajectory())
        for build in (Build(running_engine, scene, method, it, frozenset({it})) for it in optional)
    ]
    if has_plane(running_engine, scene):
        above = Build(running_engine, replace(scene, plane=far_below(scene, plain)), method, PLANE)
        trajectory = above.trajectory()
        if isinstance(trajectory, Trajectory) or trajectory.status is not Status.SKIPPED:
            runs.append((above, trajectory))
    able = frozenset(build.feature for build, trajectory in runs if isinstance(trajectory, Trajectory)) - {PLANE}
    if able:
        everything = Build(running_engine, scene, method, EVERYTHING, able)
        runs.insert(0, (everything, everything.trajectory()))
    refused: dict[str, list[str]] = {}
    for build, trajectory in runs:
        if isinstance(trajectory, Failure):
            refused.setdefault(str(trajectory), []).append(build.feature)
        else:
            errors = (0.0, 0.0) if true is None else (apart_m(trajectory, true), apart_m(plain, true))
            yield Pair(build, lean, apart_m(plain, trajectory), *errors)
    for why, features in refused.items():
        yield replace(lean, feature=", ".join(features)).row(why)


def has_plane(running_engine: RunningEngine, scene: Scene) -> bool:
    """Whether an engine has planes, and the scene none."""
    return (
        scene.plane is None and not isinstance(running_engine.info, Failure) and PLANE in running_engine.info.features
    )


def far_below(scene: Scene, run: Trajectory) -> Plane:
    """Return a plane below all that a run reaches, by the range of its heights and FAR sizes of the body."""
    pull = np.array((0.0, -1.0, 0.0)) if scene.gravity is None else scene.gravity
    normal = -pull / np.linalg.norm(pull)
    heights = run.vertices[np.isfinite(run.vertices).all(axis=-1)] @ normal
    depth = heights.min() - np.ptp(heights) - FAR * scene.body.reach
    return Plane(frozen_array(depth * normal), frozen_array(normal), restitution=0.5, friction=0.5)


def apart_m(a: Trajectory, b: Trajectory | Truth) -> float:
    """Return the largest distance between the vertices of two runs [m]; inf if only one of them is not finite."""
    lost_a, lost_b = (~np.isfinite(trajectory.vertices).all(axis=-1) for trajectory in (a, b))
    if (lost_a != lost_b).any():
        return math.inf
    with quietly():
        return float(np.linalg.norm(a.vertices[~lost_a] - b.vertices[~lost_a], axis=-1).max(initial=0.0))


def clock(pairs: Sequence[Pair], sampling: Sampling) -> dict[str, Cost | Failure]:
    """Return the times of all builds, sampled in the same rounds, or why one cannot be timed, by their keys."""
    loads = {build.key: build.load for pair in pairs for build in (pair.lean, pair.full)}
    return costs(loads, sampling)


def measured(pair: Pair, clocked: dict[str, Cost | Failure]) -> AblationRow:
    """Return the row of a pair, with the distance of its motions even if its times are unknown."""
    row = partial(pair.full.row, max_difference_m=pair.apart_m)
    with_it, without = clocked[pair.full.key], clocked[pair.lean.key]
    if isinstance(with_it, Failure):
        return row(str(with_it))
    if isinstance(without, Failure):
        return row(f"with the feature off: {without}")
    found = ratio(with_it.reading, without.reading)
    if found.refusal:
        return row(f"no ratio: {found.refusal}")
    return row(
        cpu_ns_per_step_with=pair.full.ns_per_step(with_it.reading),
        cpu_ns_per_step_without=pair.lean.ns_per_step(without.reading),
        ratio=found.value,
        ratio_low=found.low,
        ratio_high=found.high,
    )
