"""What leaving out pays: every contestant with all that it could leave out, and with only what the scene needs.

A contestant is built lean, as it always is, then with one of its OPTIONAL kept after the other, and with all of them:
`build(scene, method, keep)` of `tumble.compare.engines`.  The motion must stay the same, and one clock reads them all
in the same rounds.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from tumble.compare.ablation.schemas import EVERYTHING, AblationRow
from tumble.compare.judge.errors import quietly
from tumble.compare.run.flight import Trajectory, legs
from tumble.compare.run.progress import ProgressCallback, no_progress
from tumble.compare.run.running_engines import RunningEngine, truth_limit
from tumble.compare.run.status import Failure
from tumble.compare.run.tasks import Task, run
from tumble.compare.run.timing.readings import USUAL, Reading, Sampling, ratio
from tumble.compare.run.timing.timing import Cost, Load, costs
from tumble.compare.run.truths import true_answer
from tumble.scenarios.needs import needs
from tumble.scenarios.scene import Scene
from tumble.scenarios.truth import Truth

# A free cube, a body that never turns, and the throw on which times are compared, which has most use for it all.
SCENES = ("table-4-1", "die-straight", "yardstick")
# Of a page.
QUICK = Sampling(span_s=0.0, rounds=12, budget_s=1.0)
# Of an engine that has no optional features, or none that a scene leaves out.
NOTHING = "nothing to leave out"
# Errors of one size: rounding or another choice of steps doubles an error by chance, a lost term does far worse.
ALIKE = 2.0


@dataclass(frozen=True)
class Ablation:
    """All rows of one scene; resolution_m: of the scene's reference [m], None where it has none.

    Of the rows whose motions are further apart than that: inexact, where a method's own error explains it, as where
    fewer terms allow for other steps; altered, where the lean flight is off by more than that.
    """

    scene: Scene
    rows: tuple[AblationRow, ...]
    resolution_m: float | None
    inexact: tuple[AblationRow, ...]
    altered: tuple[AblationRow, ...]


@dataclass(frozen=True, eq=False)
class Build:
    """One contestant built for a scene with some of its OPTIONAL kept, under their name; the lean one has none."""

    running_engine: RunningEngine
    scene: Scene
    method: str
    kept: str = ""
    keep: frozenset[str] = frozenset()

    @property
    def key(self) -> str:
        """What its timer is called."""
        return f"{self.running_engine.title}:{self.method} {self.kept}"

    @property
    def load(self) -> Load:
        """What the clock reads."""
        return Load(self.running_engine, self.scene, self.method, self.keep)

    def flight(self) -> Trajectory | Failure:
        """Return its flight."""
        return self.running_engine.fly(self.scene, self.method, self.scene.step, self.keep)

    def ns_per_step(self, reading: Reading) -> float:
        """Return the time of a step by what its timer said [ns]."""
        return reading.ns / (1 if self.load.by_step else sum(leg.n for leg in legs(self.scene, self.scene.duration)))

    def row(self, why: str = "", **figures: float) -> AblationRow:
        """Return its row; why: its figures are not all there."""
        return AblationRow(
            scene=self.scene.name,
            engine=self.running_engine.title,
            method=self.method,
            feature=self.kept,
            why=why,
            **figures,
        )


@dataclass(frozen=True, eq=False)
class Pair:
    """A build with something kept beside the lean one; how far apart their flights are, and each off the truth [m]."""

    kept: Build
    lean: Build
    apart_m: float
    kept_error_m: float
    lean_error_m: float

    @property
    def harmless(self) -> bool:
        """Whether the lean flight is about as near to the truth as the other, or nearer."""
        return self.lean_error_m <= ALIKE * self.kept_error_m


def ablate(
    running_engines: Sequence[RunningEngine],
    scene: Scene,
    on_progress: ProgressCallback = no_progress,
    sampling: Sampling = USUAL,
    most_methods: int | None = None,
) -> Ablation:
    """Return what each feature that the scene has no use for would cost every contestant.

    sampling: of the times; most_methods: of each engine, None for all.
    """
    true, _ = true_answer(scene, limit_s=truth_limit(running_engines))
    asked = [ask for each in running_engines for ask in questions(each, scene, true, most_methods)]
    answers = iter(run([one for one in asked if isinstance(one, Task)], on_progress=on_progress))
    found = [one for ask in asked for one in (next(answers) if isinstance(ask, Task) else [ask])]
    clocked = against_the_clock([one for one in found if isinstance(one, Pair)], sampling)
    on_progress(f"{scene.name} timed")
    rows = [(one, measured(one, clocked) if isinstance(one, Pair) else one) for one in found]
    resolution_m = None if true is None else float(true.resolution.max())
    apart = [(one, row) for one, row in rows if isinstance(one, Pair) and one.apart_m > (resolution_m or 0.0)]
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
    """Return a task a method of one participant, or a row with the reason why there is none."""
    optional = [] if isinstance(running_engine.info, Failure) else running_engine.info.optional
    optional = [each for each in optional if each not in needs(scene)]
    unsupported = running_engine.unsupported(scene)
    why = str(unsupported) if unsupported else NOTHING if not optional else ""
    if why:
        return [AblationRow(scene=scene.name, engine=running_engine.title, method="", feature="", why=why)]

    def task(method: str) -> Task[list[Pair | AblationRow]]:
        key = scene.name, running_engine.title, method
        return Task(key, running_engine, lambda able: list(pairs(able, scene, true, method, optional)))

    return [task(method) for method in running_engine.methods_for(scene)[:most_methods]]


def pairs(
    running_engine: RunningEngine, scene: Scene, true: Truth | None, method: str, optional: Sequence[str]
) -> Iterator[Pair | AblationRow]:
    """Yield one method with everything kept that it can keep, and with one after the other."""
    lean = Build(running_engine, scene, method)
    straight = lean.flight()
    if isinstance(straight, Failure):
        yield lean.row(str(straight))
        return
    flown = [
        (build, build.flight())
        for build in (Build(running_engine, scene, method, it, frozenset({it})) for it in optional)
    ]
    able = frozenset(build.kept for build, flight in flown if isinstance(flight, Trajectory))
    if able:
        everything = Build(running_engine, scene, method, EVERYTHING, able)
        flown.insert(0, (everything, everything.flight()))
    refused: dict[str, list[str]] = {}
    for build, flight in flown:
        if isinstance(flight, Failure):
            refused.setdefault(str(flight), []).append(build.kept)
        else:
            errors = (0.0, 0.0) if true is None else (apart_m(flight, true), apart_m(straight, true))
            yield Pair(build, lean, apart_m(straight, flight), *errors)
    for why, kept in refused.items():
        yield replace(lean, kept=", ".join(kept)).row(why)


def apart_m(a: Trajectory, b: Trajectory | Truth) -> float:
    """Return how far apart the vertices of two flights are at most [m]; inf where one of them alone is lost."""
    lost_a, lost_b = (~np.isfinite(flight.vertices).all(axis=-1) for flight in (a, b))
    if (lost_a != lost_b).any():
        return math.inf
    with quietly():
        return float(np.linalg.norm(a.vertices[~lost_a] - b.vertices[~lost_a], axis=-1).max(initial=0.0))


def against_the_clock(pairs: Sequence[Pair], sampling: Sampling) -> dict[str, Cost | Failure]:
    """Return what the timers of all builds said in the same rounds, or why they cannot be timed, by their keys."""
    loads = {build.key: build.load for pair in pairs for build in (pair.lean, pair.kept)}
    return costs(loads, sampling)


def measured(pair: Pair, clocked: dict[str, Cost | Failure]) -> AblationRow:
    """Return the row of a pair; how far apart its flights are is known where their times are not."""
    row = partial(pair.kept.row, max_difference_m=pair.apart_m)
    with_it, without = clocked[pair.kept.key], clocked[pair.lean.key]
    if isinstance(with_it, Failure):
        return row(str(with_it))
    if isinstance(without, Failure):
        return row(f"without it {without}")
    found = ratio(with_it.reading, without.reading)
    if found.refusal:
        return row(f"no ratio: {found.refusal}")
    return row(
        cpu_ns_per_step_with=pair.kept.ns_per_step(with_it.reading),
        cpu_ns_per_step_without=pair.lean.ns_per_step(without.reading),
        ratio=found.value,
        ratio_low=found.low,
        ratio_high=found.high,
    )
