"""Error against run time: every contestant down a ladder of steps or tolerances, then all of them against one clock.

Errors and times come from separate runs.  A fixed-step method's time is its steps times the cost of one; an adaptive
method, and one that takes a flight in one step, is timed by whole flights.
"""

import os
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from compare.comparison.comparison import give_up, true_answer
from compare.judge.errors import Run
from compare.run.flight import Trajectory, legs
from compare.run.participants import Participant
from compare.run.timer import Pace, Reading, round_robin
from compare.run.worker import Failure
from scenarios.scene import Scene
from scenarios.truth import NoTruth, Truth

YARDSTICK = "yardstick"
REFERENCE = "tumble:rk4"
BUDGET_S, QUICK_BUDGET_S = 1.25, 0.15
MOST_RUNGS = 60
TOLERANCES = tuple(10.0 ** (-half / 2) for half in range(4, 29))
# A rung that gains less than this over three of its predecessors, which shrink the step by 2.8, is at its floor.
GAIN, OVER = 0.7, 3
ASYMPTOTIC = 1e-3  # of the body's size: an error above it may rise and fall before it is one of a small step


@dataclass(frozen=True, eq=False)
class Timed:
    """One run of the ladder with its time: the native loop of one throw's flight [ns], and the reading it comes from.

    call_ns: what one call from Python costs beyond the native loop, not in flight_ns.
    """

    run: Run
    flight_ns: float
    reading: Reading
    per_step: bool
    call_ns: float


@dataclass(frozen=True, eq=False)
class Sweep:
    """All runs of one scene; those without a flight keep their reason and have no time."""

    scene: Scene
    timed: tuple[Timed, ...]
    untimed: tuple[Run, ...]


def sweep(
    participants: Sequence[Participant],
    scene: Scene,
    tick: Callable[[str], object] = lambda what: None,
    budget_s: float = BUDGET_S,
) -> Sweep:
    """Return one scene's error and time for every contestant and every rung of its ladder.

    budget_s: native loop that one flight may take [s]; a ladder ends above it.
    Raises NoTruth where there is nothing to measure errors against, RayMissed as compare does.
    """
    true, why = true_answer(scene, lambda what: None)
    if true is None:
        raise NoTruth(f"{scene.name} has no truth to be held against: {why}")
    stop = threading.Event()
    with ThreadPoolExecutor(max(1, min(len(participants), os.cpu_count() or 1))) as pool:
        climbs = [
            pool.submit(climb_all, participant, scene, true, budget_s, tick, stop) for participant in participants
        ]
        try:
            runs = [run for climb in climbs for run in climb.result()]
        except BaseException:
            give_up(participants, stop, climbs)
            raise
    return against_the_clock(participants, scene, runs, tick)


def climb_all(
    participant: Participant,
    scene: Scene,
    true: Truth,
    budget_s: float,
    tick: Callable[[str], object],
    stop: threading.Event,
) -> list[Run]:
    """Return every run of one participant."""
    runs: list[Run] = []
    for method in participant.methods_for(scene):
        if not stop.is_set():
            runs += climb(participant, scene, true, method, budget_s)
            tick(f"{participant.title}:{method}")
    return runs


def climb(participant: Participant, scene: Scene, true: Truth, method: str, budget_s: float) -> list[Run]:
    """Return the runs of one method from its longest step to its floor, or to the end of the budget."""
    runs: list[Run] = []
    for name, dt in rungs(participant, scene, method):
        answer = (
            participant.unsupported(scene) or participant.ensure_running() or participant.worker.fly(scene, name, dt)
        )
        runs.append(Run(scene, participant.title, name, dt, answer, true))
        # An adaptive method's error falls by fits and starts, and its tolerances are few: they are all tried.
        if isinstance(answer, Failure) or over_budget(answer, budget_s) or (name == method and at_floor(runs)):
            break
    return runs


def rungs(participant: Participant, scene: Scene, method: str) -> Iterator[tuple[str, float]]:
    """Yield (method, dt [s]): tolerances of an adaptive method, one step for a whole one, else 2^k and 3 2^k steps."""
    bare = not isinstance(participant.info, Failure) and method in participant.info.adaptive
    if bare:
        yield from ((f"{method}@{tolerance:.3g}", scene.duration) for tolerance in TOLERANCES)
    elif is_own_pace(participant, method):
        yield method, scene.duration
    else:
        # The steps of the whole flight: 2, 3, 4, 6, 8, 12, ... times the legs it is cut into.
        cuts = len(legs(scene, scene.duration))
        counts = sorted({2**k for k in range(MOST_RUNGS)} | {3 * 2**k for k in range(MOST_RUNGS)})[:MOST_RUNGS]
        yield from ((method, scene.duration / (cuts * count)) for count in counts)


def is_own_pace(participant: Participant, method: str) -> bool:
    """Whether the method's steps are its own, so that a flight is the unit of its time."""
    info = participant.info
    return not isinstance(info, Failure) and method.partition("@")[0] in info.adaptive | info.whole


def over_budget(flight: Trajectory, budget_s: float) -> bool:
    """Whether the next rung would take longer than a flight may."""
    return 1.5 * flight.wall_s > budget_s


def at_floor(runs: Sequence[Run]) -> bool:
    """Whether smaller steps have stopped paying: the error is the truth's limit, or no longer falls."""
    errors = [float(run.distances.max()) for run in runs]
    limit = float(runs[-1].limits.max())
    if len(errors) > 1 and max(errors[-2:]) <= limit:
        return True
    size = float(np.linalg.norm(runs[-1].scene.body.points, axis=1).max())
    return len(errors) > OVER and max(errors[-OVER - 1 :]) < ASYMPTOTIC * size and errors[-1] > GAIN * errors[-OVER - 1]


def against_the_clock(
    participants: Sequence[Participant], scene: Scene, runs: Sequence[Run], tick: Callable[[str], object]
) -> Sweep:
    """Time every run that flew, all in the same rounds."""
    by_title = {participant.title: participant for participant in participants}
    flown = [run for run in runs if isinstance(run.answer, Trajectory)]
    watches: dict[str, tuple[Participant, Run, bool]] = {}
    for run in flown:
        participant = by_title[run.engine]
        own_pace = is_own_pace(participant, run.method)
        watches.setdefault(run.name, (participant, run, not own_pace))
    calls: dict[str, float] = {}
    for key, (participant, run, by_step) in watches.items():
        if participant.ensure_running() is None:
            call = participant.worker.prepare_timer(key, scene, run.method, pace(scene, by_step))
            if not isinstance(call, Failure):
                calls[key] = call
    readings = round_robin({key: sampler(watches[key][0], key) for key in calls})
    tick("timed")
    timed = []
    for run in flown:
        if run.name in readings:
            reading, by_step = readings[run.name], watches[run.name][2]
            flight_ns = reading.ns * run.flight.steps if by_step else reading.ns
            timed.append(Timed(run, flight_ns / len(scene.start), reading, by_step, calls[run.name]))
    clocked = {id(each.run) for each in timed}
    return Sweep(scene, tuple(timed), tuple(run for run in runs if id(run) not in clocked))


def pace(scene: Scene, by_step: bool) -> Pace:
    """Return what a sample asks for: steps of the scene's own length, or the legs of a flight."""
    if by_step:
        return Pace(((1, scene.step),), True)
    return Pace(tuple((leg.n, leg.dt) for leg in legs(scene, scene.duration)), False)


def sampler(participant: Participant, key: str) -> Callable[[], float]:
    """Return what reads one timer; one that fails in the middle reads as not a number."""

    def sample() -> float:
        answer = participant.worker.sample(key) if participant.worker.alive else Failure("gone")
        return float("nan") if isinstance(answer, Failure) else answer

    return sample
