"""What timers say, taken together: samples of all contestants in the same rounds, and ratios with their intervals.

Samples go round robin over all contestants, because the machine itself is faster and slower by turns: only what was
sampled in the same rounds may be compared.  A ratio is the median of the rounds' ratios, and its interval covers what a
quiet machine would say in 95 of 100 runs: a paired bootstrap over the rounds in blocks, for neighbours in time are
alike, widened by what one process differs from the next for as long as it lives.  Rounds are added until the intervals
are narrow or the time for it is over.
"""

import math
import os
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from time import monotonic
from typing import NamedTuple

import numpy as np
import psutil

from tumble.compare.run.status import Failure
from tumble.compare.run.timing.machine_load import machine, other_work, say
from tumble.compare.run.timing.timer import Sample
from tumble.scenarios.frames import Array

SPAN_S, BUDGET_S = 2.0, 12.0
ROUNDS = 8
# More of a sample than that in `read`, or on another clock, is no chance.
DISAGREE = 0.1
CLOCKS = ("thread CPU", "process CPU", "wall")
# A bootstrap of a few blocks covers less than it says: these ends are so far out that 95 of 100 runs are covered on a
# machine with much other work (tests/compare/run/test_timing.py).
LEVEL, RESAMPLES, BLOCK = 0.99, 400, 4
# How a process lies in memory moves its loops: by so much at most in 95 of 100 new processes (tests/bench/rounds.csv).
PROCESS = 0.03
# Rounds are added while what chance leaves of an interval is wider than this, from its middle to its end.
NARROW = 0.03
# Rounds of those whose ratios to a unit stay wider, over the rounds of all: where the machine's pace drifts, four times
# as many are no narrower than twice as many.
MORE = 2
GONE, STOOD = "its process ended while it was timed", "the clock stood still while it was timed"
NO_NUMBER = "its clock showed no number while it was timed"


class Sampling(NamedTuple):
    """How long is sampled: at least that long [s] and that many rounds, and at most so long [s] for narrow ratios.

    units: the keys of what all others are told as multiples of; empty: of each other.
    """

    span_s: float = SPAN_S
    rounds: int = ROUNDS
    budget_s: float = BUDGET_S
    units: frozenset[str] = frozenset()


USUAL = Sampling()


@dataclass(frozen=True, eq=False)
class Reading:
    """What one timer said, round after round from the first, by the clock that is right for it [ns], (rounds,).

    finding: how the clocks disagree, empty where they do not.
    """

    samples: Array
    clock: str = CLOCKS[0]
    finding: str = ""

    @property
    def ns(self) -> float:
        """The lower decile, which a busy machine moves least."""
        return float(np.quantile(self.samples, 0.1))

    @property
    def doubt(self) -> str:
        """Why this is no time of anything, empty where it is one."""
        if not np.isfinite(self.samples).all():
            return NO_NUMBER
        return "" if (self.samples > 0).all() else STOOD

    @property
    def spread(self) -> tuple[float, float]:
        """Median and upper decile."""
        return float(np.median(self.samples)), float(np.quantile(self.samples, 0.9))


def reading(samples: Sequence[Sample]) -> Reading:
    """Return a reading by the clock that is right: the calling thread's unless others have done the work.

    Work that `advance` has left to `read` counts.  Work of other threads and children counts as CPU time; where the
    thread has waited longer than anything computed, for a device or for processes that live on, wall time is all there
    is.
    """
    if not all(math.isfinite(sample.ns) for sample in samples):
        return Reading(np.full(len(samples), np.nan))
    advance = np.array([sample.advance for sample in samples])
    deferred = np.array([sample.deferred for sample in samples])
    findings = []
    if np.median(deferred[:, 2]) > DISAGREE * np.median(advance[:, 2]):
        share = np.median(deferred[:, 2] / np.maximum(advance + deferred, 1e-9)[:, 2])
        findings.append(f"{share:.0%} of its work is done when it is read")
        advance = advance + deferred
    thread, process, wall, queued = advance.T
    if samples[0].said is not None:
        said = np.array([sample.said for sample in samples], dtype=float)
        told = what_it_says(said, wall)
        return Reading(wall, CLOCKS[2], "; ".join((*findings, told)))
    computed = np.maximum(thread, process)
    # A few rounds at least were not interrupted.  While it waited for a core, what it waits for may have had it: of a
    # thread that waits at all, that is its time too.
    if np.quantile((wall - queued) / np.maximum(computed, 1e-9), 0.1) > 1 + DISAGREE:
        findings.append(f"it waits: wall time is {np.median(wall) / max(np.median(computed), 1e-9):.3g} times CPU time")
        return Reading(wall, CLOCKS[2], "; ".join(findings))
    if np.median(process) > (1 + DISAGREE) * np.median(thread):
        findings.append(f"other threads do {1 - np.median(thread) / np.median(process):.0%} of its work")
        return Reading(process, CLOCKS[1], "; ".join(findings))
    return Reading(thread, CLOCKS[0], "; ".join(findings))


def what_it_says(said: Array, wall: Array) -> str:
    """Say what a program says of its own time beside what the clock says of it, (rounds,) [ns] both.

    They disagree where they do in nearly every round: in some the program itself waited for a core.
    """
    line = "a program: what `advance 0` takes is taken off"
    if np.isnan(said).any():
        return line
    least, most = np.quantile(said / np.maximum(wall, 1e-9), (0.1, 0.9))
    line = f"{line}; it says {np.quantile(said, 0.1):.4g} ns itself"
    if most < 1 - DISAGREE:
        return f"{line}, {1 - most:.0%} too little at least"
    return f"{line}, {least - 1:.0%} too much at least" if least > 1 + DISAGREE else line


@dataclass(frozen=True)
class Ratio:
    """How many times as long one takes as another: value, and the ends of its interval.

    No number is too uncertain to be told, for its interval says how uncertain it is.  Where a process has ended all
    three are NaN; where a clock has shown no time at all anything is possible, from 0 to infinity.
    """

    value: float
    low: float
    high: float

    def __mul__(self, factor: float) -> "Ratio":
        return Ratio(self.value * factor, self.low * factor, self.high * factor)

    @property
    def refusal(self) -> str:
        """Why it is not to be told, empty where it is."""
        if not math.isnan(self.value):
            return ""
        return f"{GONE if math.isnan(self.low) else STOOD}: {load_seen()}"


def ratio(a: Reading, b: Reading) -> Ratio:
    """Return how many times as long a takes as b, by the rounds in which both were sampled."""
    both = min(len(a.samples), len(b.samples))
    over, under = a.samples[:both], b.samples[:both]
    if np.isnan([over, under]).any():
        return Ratio(math.nan, math.nan, math.nan)
    if not (np.minimum(over, under) > 0).all():
        return Ratio(math.nan, 0.0, math.inf)
    logs = np.log(over / under)
    low, high = interval(logs)
    return Ratio(*np.exp((np.median(logs), low - PROCESS, high + PROCESS)).tolist())


def interval(values: Array) -> tuple[float, float]:
    """Return the interval of the median of values in the order of time, (rounds,), by a moving-block bootstrap.

    Source: Kunsch, "The jackknife and the bootstrap for general stationary observations" (1989).
    """
    count = len(values)
    draw = np.random.default_rng(0)  # the same table says the same interval
    starts = draw.integers(0, count, (RESAMPLES, -(-count // BLOCK)))
    places = (starts[:, :, None] + np.arange(BLOCK)).reshape(RESAMPLES, -1)[:, :count] % count
    low, high = np.quantile(np.median(values[places], axis=1), ((1 - LEVEL) / 2, (1 + LEVEL) / 2))
    return float(low), float(high)


def round_robin(
    samplers: Mapping[str, Callable[[], Sample | Failure]],
    span_s: float = SPAN_S,
    rounds: int = ROUNDS,
    budget_s: float = BUDGET_S,
    units: Collection[str] = (),
) -> dict[str, Reading | Failure]:
    """Sample all in turn and return what each said, or why one could not be sampled to the end.

    At least that many rounds and that long [s], and on until the ratios are narrow or the budget [s] is spent.  Where
    the ratios are those to units, one whose ratio is narrow is not sampled any more, and no other in more than MORE
    times as many rounds.  What else the machine did meanwhile is said once, on standard error.
    """
    if not samplers:
        return {}
    said: dict[str, list[Sample]] = {key: [] for key in samplers}
    failed: dict[str, Failure] = {}
    begin, before = monotonic(), machine()
    taken, look_again, going_on = 0, rounds, [*samplers]
    while going_on:
        for key in going_on:
            one = samplers[key]()
            if isinstance(one, Failure):
                failed[key] = one
            else:
                said[key].append(one)
        going_on = [key for key in going_on if key not in failed]
        taken += 1
        spent = monotonic() - begin
        if taken < rounds or spent < span_s:
            continue
        if spent >= budget_s:
            break
        if taken >= look_again:
            found = {key: reading(said[key]) for key in going_on}
            known = [key for key in units if key in found]
            if known:
                still = wide(found, known) if taken < MORE * rounds else []
                going_on = [key for key in going_on if key in still or key in known] if still else []
            elif narrow([*found.values()]):
                break
            look_again = taken + taken // 4
            if known:
                look_again = min(look_again, MORE * rounds)
    say(other_work(before, machine()))
    return {key: failed[key] if key in failed else reading(said[key]) for key in samplers}


def wide(readings: Mapping[str, Reading], units: Collection[str]) -> list[str]:
    """Return those that have a time, and room left by chance in their ratios to units, sampled in the same rounds."""
    logs = {key: np.log(each.samples) for key, each in readings.items() if not each.doubt}
    paces = [logs[key] for key in units if key in logs]
    if not paces:
        return []
    pace = np.mean(paces, axis=0)
    ends = {key: interval(each - pace) for key, each in logs.items()}
    return [key for key, (low, high) in ends.items() if high - low > 2 * NARROW]


def narrow(readings: Sequence[Reading]) -> bool:
    """Whether chance has left the ratios of all that have a time little room."""
    times = [reading.samples for reading in readings if not reading.doubt]
    if not times:
        return True
    logs = np.log(times)
    pace = logs.mean(axis=0)
    ends = [interval(each - pace) for each in logs]
    return all(high - low <= 2 * NARROW for low, high in ends)


def load_seen() -> str:
    """Say how busy the machine is."""
    return f"load {psutil.getloadavg()[0]:.1f} on {os.cpu_count()} cores"
