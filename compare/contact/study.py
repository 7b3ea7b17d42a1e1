"""The study of contact: every contestant above a plane, over a ladder of steps, against the true observables."""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Protocol

import numpy as np

from tumble.compare.contact.asked import BY_OWN_LAW, Asked
from tumble.compare.contact.directions import (
    Rose,
    Slide,
    is_turnable,
    read_slides,
    slid,
    slip_factor,
    true_slide,
    turned_scene,
)
from tumble.compare.contact.impacts import MOST_IMPACTS, Impact, impacts, read_impact, row_step
from tumble.compare.contact.limit import Level, Limit, limit, shifted
from tumble.compare.contact.own_law import own_creep, own_numbers
from tumble.compare.contact.scans import ScanRun, heights, tilts
from tumble.compare.contact.watched import Watched
from tumble.compare.contact.whole_run import WholeRun, read_whole, whole_run
from tumble.compare.run.flight import Trajectory
from tumble.compare.run.local import Asked as Named
from tumble.compare.run.progress import Display, ProgressCallback, no_display, no_progress
from tumble.compare.run.running_engines import TIME_LIMIT_S, RunningEngine, flights
from tumble.compare.run.starting import started
from tumble.compare.run.status import Failure
from tumble.compare.run.tasks import Task, run
from tumble.compare.run.worker import MEMORY_LIMIT
from tumble.scenarios.frames import Array
from tumble.scenarios.scene import Scene
from tumble.scenarios.truth import Truth

# The ladder, in steps of the scene; the first few are for the order, the last for the limit.
LADDER = (4.0, 2.0, 1.0, 0.5, 0.25, 0.125)
# Run time of one run, by the engine's stated cost of a step [s]; finer levels are left out.
BUDGET_S = 2.0
# From this share of an error on what the last steps span is more than a blur of it.
SCATTERS = 0.25


@dataclass(frozen=True)
class Extent:
    """How much is run.

    Parameters
    ----------
    ladder : steps, the longest first, in those at which values are reported
    impacts : of a scene, at most
    few : only what a scene with an impact shows by it alone, by the methods that a page of the whole catalogue shows
    """

    ladder: tuple[float, ...] = LADDER
    impacts: int = MOST_IMPACTS
    few: bool = False

    def runs(self, running_engines: Iterable[RunningEngine], scenes: Iterable[Scene]) -> int:
        """Return the number of pairs of a scene and a method that takes part in it."""
        return sum(1 for one in running_engines for scene in scenes for _ in self.methods(one, scene))

    def methods(self, running_engine: RunningEngine, scene: Scene) -> Iterator[str]:
        """Yield an engine's methods that take part in a scene."""
        info = running_engine.info
        for method in running_engine.methods_for(scene):
            if not self.few or isinstance(info, Failure) or method in (*info.landing, *running_engine.named):
                yield method


WHOLE, BRIEF = Extent(), Extent(impacts=1, few=True)


class Answered(Protocol):
    """A scene and its reference solution, as a comparison has them."""

    @property
    def scene(self) -> Scene:
        """The scene."""
        ...

    @property
    def truth(self) -> Truth | None:
        """Its reference solution, if there is one."""
        ...


@dataclass(frozen=True, eq=False)
class Question:
    """What a scene asks: of a whole run, of throws in other directions, of each impact alone, and of changed scenes.

    step: at which values are reported [s]; turned: directions [rad], and the scene with a throw in each.
    """

    scene: Scene
    step: float
    extent: Extent
    whole: WholeRun | None
    turned: tuple[Array, Scene] | None
    impacts: tuple[Impact, ...]
    scans: tuple[ScanRun, ...]

    @property
    def identity(self) -> list[object]:
        """What all of it follows from."""
        parts = [one.key for one in self.asked], self.turned is not None, len(self.scans)
        return [self.scene, self.step, self.extent, *parts]

    @property
    def asked(self) -> Iterator[Asked]:
        """Everything that is asked."""
        if self.whole:
            yield from (asked for asked, _ in self.whole.asked.values())
        for impact in self.impacts:
            yield from impact.asked


Key = tuple[str, int | None]


@dataclass
class Readings:
    """What one contestant's runs showed: ladders by observable and impact, slides in other directions, and scans.

    By impact, None for the whole run: unfinished: not over when the next was due; stays: the body did not leave the
    plane, at the finest step; through: it passed the plane, at the step of the values or a finer one.
    own: numbers of the law that a soft engine states, by step [s]; ladders of these have the differences.  own_law:
    what law that is at an impact.
    failure: why there is nothing.
    """

    ladders: dict[Key, list[Level]] = field(default_factory=dict)
    own: dict[tuple[Key, float], float] = field(default_factory=dict)
    own_law: str = ""
    slides: list[Slide] = field(default_factory=list)
    scanned: list[float] = field(default_factory=list)
    unfinished: set[int | None] = field(default_factory=set)
    stays: set[int | None] = field(default_factory=set)
    through: set[int | None] = field(default_factory=set)
    failure: Failure | None = None


@dataclass(frozen=True, eq=False)
class Observation:
    """One observable of one contestant: its value at a step [s], and the limit of the ladder."""

    asked: Asked
    dt_s: float
    value: float
    limit: Limit

    @property
    def is_right(self) -> bool:
        """Whether the interval of the limit has the true value in it, or is nearer to it than one step is."""
        low, high, one_step = self.limit.low - self.asked.true, self.limit.high - self.asked.true, self.asked.one_step
        return (self.limit.converges and low <= 0 <= high) or -one_step <= low <= high <= one_step

    @property
    def scatters(self) -> bool:
        """Whether there is no limit, and what the last steps span is a good part of what they are off."""
        low, high = self.limit.low, self.limit.high
        return not self.limit.converges and high - low >= SCATTERS * abs(self.limit.value - self.asked.true)

    @property
    def share(self) -> float:
        """The law error over the observable's scale."""
        return abs(self.limit.value - self.asked.true) / (self.asked.scale or 1.0)


@dataclass(frozen=True, eq=False)
class Contact:
    """One contestant in one scene.

    Parameters
    ----------
    question : what the scene asks
    engine : name of the engine
    method : METHOD[@TOLERANCE]
    tolerance : of a method that chooses its own steps, else None
    observations : in the order of the question
    rose : the slides in all directions; None where there are none
    readings : what its runs showed
    """

    question: Question
    engine: str
    method: str
    tolerance: float | None
    observations: tuple[Observation, ...]
    rose: Rose | None
    readings: Readings

    @property
    def scene(self) -> Scene:
        """The scene."""
        return self.question.scene

    @property
    def name(self) -> str:
        """ENGINE:METHOD."""
        return f"{self.engine}:{self.method}" if self.method else self.engine


def contact_scenes(
    answers: Sequence[Answered],
    contestants: Sequence[Named] = (),
    *,
    dt: float | None = None,
    time_limit: float = TIME_LIMIT_S,
    memory_limit: int = MEMORY_LIMIT,
    display: Display = no_display,
) -> list[Contact]:
    """Measure the contact law of every contestant in the scenes that have a plane and a reference solution.

    Parameters
    ----------
    answers : scenes with their reference solutions
    contestants : ENGINE[@RELEASE][:METHOD] or FILE[:METHOD] of each; empty: the engines installed with Tumble
    dt : step at which values are reported [s]; None: each scene's own
    time_limit : for each run [s]
    memory_limit : for each engine's process [B]
    display : shows progress

    Returns
    -------
    the contestants' results, scene by scene; empty where no scene has a plane

    Raises
    ------
    BadEngine : an engine or a method is unknown
    """
    if not any(answer.scene.plane and answer.truth for answer in answers):
        return []
    with started(contestants, time_limit, memory_limit, display) as running_engines:
        scenes = [answer.scene for answer in answers if answer.scene.plane and answer.truth]
        with display(flights(running_engines, scenes)) as on_progress:
            return contacts(running_engines, answers, dt, on_progress)


def contacts(
    running_engines: Sequence[RunningEngine],
    answers: Sequence[Answered],
    dt: float | None = None,
    on_progress: ProgressCallback = no_progress,
    extent: Extent = WHOLE,
) -> list[Contact]:
    """Measure the contact law of every contestant in the scenes that have a plane and a reference solution.

    Parameters
    ----------
    running_engines : with their methods
    answers : scenes with their reference solutions
    dt : step at which values are reported [s]; None: each scene's own
    on_progress : called for every contestant and scene
    extent : how much is run

    Returns
    -------
    the contestants' results, scene by scene
    """
    found = (question(answer.scene, answer.truth, dt, extent) for answer in answers if answer.truth)
    return ask(running_engines, [one for one in found if one], on_progress)


def ask(
    running_engines: Sequence[RunningEngine], questions: Sequence[Question], on_progress: ProgressCallback = no_progress
) -> list[Contact]:
    """Return every contestant's results in scenes whose questions are known; arguments as of `contacts`."""

    def task(one: Question, running_engine: RunningEngine, method: str) -> Task[Readings]:
        key = one.scene.name, running_engine.title, method, "contact"
        return Task(key, running_engine, partial(read, asked=one, method=method))

    tasks = [
        (one, task(one, running_engine, method))
        for one in questions
        for running_engine in running_engines
        for method in one.extent.methods(running_engine, one.scene)
    ]
    readings = run([task for _, task in tasks], on_progress=on_progress)
    return [
        judged(one, task.running_engine, task.key[2], read) for (one, task), read in zip(tasks, readings, strict=True)
    ]


def question(scene: Scene, truth: Truth | None, dt: float | None = None, extent: Extent = WHOLE) -> Question | None:
    """Return what a scene asks, None where it has no plane, or nothing that an engine can be held to."""
    if scene.plane is None or truth is None or not truth.contacts:
        return None
    step = dt or scene.step
    steps = [step * factor for factor in extent.ladder]
    known = tuple(impacts(scene, truth.contacts[0], steps, step, extent.impacts))
    whole = None if extent.few and known else whole_run(scene, truth, steps, step)
    turned = turned_scene(scene, whole, step) if whole and is_turnable(scene, whole) else None
    scans = (*(tilts(scene, whole, step) if whole else ()), *(heights(scene, known[0], step) if known else ()))
    found = Question(scene, step, extent, whole, turned, known, scans)
    return found if any(found.asked) else None


def read(running_engine: RunningEngine, asked: Question, method: str) -> Readings:
    """Run all that a scene asks, at every step, and return what it shows."""
    found = Readings()
    whole, own_steps = asked.whole, running_engine.takes_own_steps(method)
    for dt, scene in whole.scenes.items() if whole else ():
        if skips(running_engine, method, own_steps, dt, asked.step, scene.duration):
            continue
        answer = running_engine.simulate(scene, method, dt)
        if isinstance(answer, Failure):
            found.failure = answer
            return found
        assert whole is not None
        seen = Watched(scene, answer)
        if seen.through and dt <= asked.step:
            found.through.add(None)
        law = answer.soft_law
        own = own_creep(law, scene) if law else {}
        for name, value in read_whole(whole, seen).items():
            if name in own:
                found.own[(name, None), dt] = own[name]
            value -= own.get(name, 0.0)
            found.ladders.setdefault((name, None), []).append(Level(dt, np.array([value])))
    if whole and asked.turned:
        directions, scene = asked.turned
        answer = running_engine.simulate(scene, method, asked.step)
        if isinstance(answer, Trajectory):
            found.slides += read_slides(whole, directions, scene, answer)
    for impact in asked.impacts:
        read_ladder(running_engine, asked, method, impact, found)
        if found.failure:
            return found
    for one in asked.scans:
        answer = running_engine.simulate(one.scene, method, one.scene.step)
        found.scanned.append(one.read(Watched(one.scene, answer)) if isinstance(answer, Trajectory) else math.nan)
    return found


def read_ladder(running_engine: RunningEngine, asked: Question, method: str, impact: Impact, found: Readings) -> None:
    """Run one impact at every step, and add what it shows."""
    own_steps, first = running_engine.takes_own_steps(method), row_step(impact, asked.step)
    for dt, runs in impact.runs.items():
        if skips(running_engine, method, own_steps, dt, first, runs[0].scene.duration):
            continue
        readings, law = [], None
        for one in runs:
            answer = running_engine.simulate(one.scene, method, dt)
            if isinstance(answer, Failure):
                found.failure = answer
                return
            law = answer.soft_law
            if answer.diverged_at is None:
                readings.append(read_impact(impact, one, Watched(one.scene, answer)))
        if dt <= first and any(reading.through for reading in readings):
            found.through.add(impact.number)
        if any(reading.unfinished for reading in readings):
            found.unfinished.add(impact.number)
        (found.stays.add if any(reading.stays for reading in readings) else found.stays.discard)(impact.number)
        own = own_numbers(law, asked.scene, impact) if law and asked.scene.body.radius else {}
        found.own_law = law.kind if law else ""
        for each in impact.asked:
            name, of_own = each.observable.removesuffix(BY_OWN_LAW), each.observable.endswith(BY_OWN_LAW)
            if of_own and each.observable not in own:
                continue
            values = np.array([reading.values.get(name, math.nan) for reading in readings] or [math.nan])
            if of_own:
                found.own[each.key, dt] = own[each.observable]
                values = values - own[each.observable]
            found.ladders.setdefault(each.key, []).append(Level(dt, values))


def skips(
    running_engine: RunningEngine, method: str, own_steps: bool, dt: float, first: float, duration: float
) -> bool:
    """Whether a level is left out: all but the first of a method that takes its own steps, and what takes too long."""
    if own_steps or dt >= first or isinstance(running_engine.info, Failure):
        return own_steps and dt != first
    return duration / dt * running_engine.info.step_of(method) > 1e9 * BUDGET_S


def judged(asked: Question, running_engine: RunningEngine, method: str, found: Readings) -> Contact:
    """Return a contestant's limits and rose."""
    steps = {impact.number: row_step(impact, asked.step) for impact in asked.impacts}
    observations = []
    for each in asked.asked if found.failure is None else ():
        ladder = found.ladders.get(each.key, [])
        dt = asked.step if each.impact is None else steps[each.impact]
        value = next((level.mean for level in ladder if level.dt_s == dt), math.nan)
        reached = limit(ladder, each.resolution(running_engine.rounding))
        if each.observable.endswith(BY_OWN_LAW):
            if (each.key, dt) not in found.own:
                continue
            own = found.own[each.key, dt]
            each, value, reached = replace(each, true=own), value + own, shifted(reached, own)
        observations.append(Observation(each, dt, value, reached))
    return Contact(
        question=asked,
        engine=running_engine.title,
        method=method,
        tolerance=running_engine.tolerance(method),
        observations=tuple(observations),
        rose=rose(asked, found.slides, observations),
        readings=found,
    )


def rose(asked: Question, slides: Sequence[Slide], observations: Sequence[Observation]) -> Rose | None:
    """Return the slides in all directions, held to what the step changes in the scene's own direction."""
    own = next((one for one in observations if one.asked.observable == slid(asked.scene)), None)
    if not slides or own is None or asked.whole is None:
        return None
    step_error = abs(own.value - own.limit.value)
    tolerance = slip_factor(asked.scene) * max(own.limit.high - own.limit.low, own.asked.one_step, 2 * step_error)
    true = true_slide(asked.scene, asked.whole)
    return Rose(asked.step, tuple(slides), true, tolerance if math.isfinite(tolerance) else math.inf)
