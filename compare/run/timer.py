"""The only file that reads a clock: what a contestant's native loop takes, so that it can be believed.

A sample is 1 to 2 ms of a contestant's own loop in thread CPU time, with nothing between the two readings but calls of
`advance`; building, compiling and writing states are outside.  Samples go round robin over all contestants, because
the machine itself is faster and slower by turns: only what was sampled in the same rounds may be compared.  The lower
decile is quoted, median and upper decile are kept, and two passes, the first and the second half, must agree.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from time import monotonic, perf_counter, thread_time_ns
from types import ModuleType

import numpy as np

from compare.run.registry import built
from scenarios.frames import Array
from scenarios.scene import Scene

SAMPLE_NS = 1e6
MOST_STEPS, MOST_COPIES = 1 << 20, 1 << 12
SPAN_S = 3.0
ROUNDS = 24
CALLS = 20
AGREE = 0.05


def timed(call: Callable[..., object], *arguments: object) -> float:
    """Return the wall time of one call [s]."""
    begin = perf_counter()
    call(*arguments)
    return perf_counter() - begin


@dataclass(frozen=True)
class Pace:
    """What one sample asks of `advance`: legs of (n, dt) [s].

    by_step: more of the same steps make a sample long enough, and its unit is a step; otherwise more copies of the
    throw in one world do, and its unit is a flight.
    """

    legs: tuple[tuple[int, float], ...]
    by_step: bool


class Timer:
    """One contestant, built and warm, with a load that takes long enough to be read.

    keep: what of its OPTIONAL the engine is to build although the scene has no use for it.
    """

    def __init__(
        self, engine: ModuleType, scene: Scene, method: str, pace: Pace, keep: frozenset[str] = frozenset()
    ) -> None:
        self._engine, self._pace, self._load, self._keep = engine, pace, 1, keep
        most = MOST_STEPS if pace.by_step else MOST_COPIES
        self._prepare(scene, method)
        self._lap()
        self._alone = min(self._lap() for _ in range(CALLS))
        while (took := self._lap()) < SAMPLE_NS and self._load < most:
            # A call has its own cost, so that a short load looks longer than it is: what is missing is asked for again.
            self._load = min(most, max(2 * self._load, round(self._load * SAMPLE_NS / max(took, 1))))
            if not pace.by_step:
                self._prepare(scene, method)
                self._lap()

    def _prepare(self, scene: Scene, method: str) -> None:
        copies = 1 if self._pace.by_step else self._load
        self._start = np.tile(scene.start, (copies, 1))
        self._world = built(self._engine, replace(scene, start=self._start), method, self._keep)

    def sample(self) -> float:
        """Return the thread CPU time of one step, or of one flight [ns]."""
        return self._lap() / self._load

    def call(self) -> float:
        """Return what calling from Python costs beyond the native loop [ns]: for one step, or for one flight alone."""
        return max(0.0, self._alone - self.sample())

    def _lap(self) -> int:
        advance, world = self._engine.advance, self._world
        self._engine.write(world, self._start.copy())
        stretch = self._load if self._pace.by_step else 1
        calls = [(n * stretch, dt) for n, dt in self._pace.legs]
        if hasattr(self._engine, "prepare"):
            return self._prepared_lap(calls)
        begin = thread_time_ns()
        for n, dt in calls:
            advance(world, n, dt)
        return thread_time_ns() - begin

    def _prepared_lap(self, calls: list[tuple[int, float]]) -> int:
        took = 0
        for n, dt in calls:
            self._engine.prepare(self._world, dt)
            begin = thread_time_ns()
            self._engine.advance(self._world, n, dt)
            took += thread_time_ns() - begin
        return took


@dataclass(frozen=True, eq=False)
class Reading:
    """What one timer said, round after round [ns], (rounds,)."""

    samples: Array

    @property
    def ns(self) -> float:
        """The lower decile, which a busy machine moves least."""
        return float(np.quantile(self.samples, 0.1))

    @property
    def spread(self) -> tuple[float, float]:
        """Median and upper decile."""
        return float(np.median(self.samples)), float(np.quantile(self.samples, 0.9))

    @property
    def passes(self) -> tuple[float, float]:
        """The lower deciles of the first and the second half of the rounds."""
        half = len(self.samples) // 2
        return float(np.quantile(self.samples[:half], 0.1)), float(np.quantile(self.samples[half:], 0.1))


def steady_ratio(a: Reading, b: Reading) -> bool:
    """Whether the ratio of two readings is the same in both passes to 5 %: only then may it be quoted."""
    first, second = (x / y for x, y in zip(a.passes, b.passes, strict=True))
    return abs(first - second) <= AGREE * min(first, second)


def round_robin(
    samplers: Mapping[str, Callable[[], float]], span_s: float = SPAN_S, rounds: int = ROUNDS
) -> dict[str, Reading]:
    """Sample all in turn, for that many rounds and at least that long [s], and return what each said."""
    said: dict[str, list[float]] = {key: [] for key in samplers}
    begin = monotonic()
    taken = 0
    while taken < rounds or monotonic() - begin < span_s:
        for key, sample in samplers.items():
            said[key].append(sample())
        taken += 1
    return {key: Reading(np.array(samples)) for key, samples in said.items()}
