"""The only file that reads a clock: what a contestant's native loop takes, so that it can be believed.

A sample is little more than 1 ms of a contestant's own loop, with nothing between two readings but calls of `advance`,
and after it a `read`, which waits for what `advance` has only begun; building, compiling and writing states are
outside.  Before it the loop has run for a while, so that no sample pays for caches that others have filled meanwhile.
Three clocks are read; `tumble.compare.run.timing.readings` says which of them is right.
"""

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter, perf_counter_ns, process_time_ns, thread_time_ns
from types import ModuleType
from typing import Any

import numpy as np

from tumble.compare.run.engines.registry import built
from tumble.compare.run.process import usage
from tumble.scenarios.frames import Array
from tumble.scenarios.scene import Scene

SAMPLE_NS = 1e6
MOST_STEPS, MOST_COPIES = 1 << 20, 1 << 12
# A program is asked over a line, and to be woken takes some 0.1 ms more or less.
LINE_NS, IDLE_LOOKS = 4e6, 3
# On a busy machine the way to a program and back may once take longer than the steps: such a lap is made again.
AGAIN = 2
CALLS = 20
# What a first `read` takes longer than a second one by chance [s].
LEFT_S = 20e-6
# A load is made as long as a sample and a little longer, for no look at it is exact.
SPARE = 1.1
# What a call costs is nothing beside a load this long, which is not looked at often for it [ns].
LONG_NS = 1e7
# Caches that others have filled cost up to 50 us: before a load shorter than this [ns], a part of it is run.
WARM_NS, WARM_PART = 3e6, 8
# Twice the steps take twice the time; a loop that takes less than this has done something else.
GROWTH, LOOKS = 1.5, 3
# Untimed steps are made in calls of so many, twice as many, ...: as short as a flight's, and as long as a lap's.
FIRST_CALL, OTHER_CALL = 1, 3
# An engine that does not repeat its bits may be so many times as far from its untimed steps as so many runs of those
# differ, and by so much of a number's size at most: what differs more is no repetition.
CHANCE, RUNS, MOST_APART = 10.0, 8, 1e-3
# The numbers of a state, and the ends of its vectors.
PARTS = ("x", "x", "x", "q", "q", "q", "q", "v", "v", "v", "w", "w", "w")
VECTORS = ((0, 3), (3, 7), (7, 10), (10, 13))
# On a busy machine the way to another process and back hides a few steps there: more are asked for, so many times.
DOUBLED = 12


Clocks = tuple[float, float, float, float]


class NoTime(ValueError):
    """What the clock says is no time of these steps; the message says why."""


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


@dataclass(frozen=True)
class Sample:
    """One step, or one flight, by each of the clocks [ns]: as long as `advance` took, and what `read` took more.

    The clocks: CPU time of the calling thread; CPU time of the process and of children that it has waited for; wall
    time; and how much of that the thread waited for a core.  deferred: what the first `read` took longer than a second
    one.  said: of a program, what it says itself [ns], NaN where it says nothing.
    """

    advance: Clocks
    deferred: Clocks
    said: float | None = None

    @property
    def ns(self) -> float:
        """The most that any clock says, of wall time what the thread did not wait for a core."""
        thread, process, wall, queued = (a + b for a, b in zip(self.advance, self.deferred, strict=True))
        return max(thread, process, wall - queued)


@dataclass(frozen=True)
class Ready:
    """What making a timer ready has shown.

    call_ns: what a call from Python costs beyond the native loop, for one step or for one flight alone [ns]; build_s:
    building the world [s]; compile_s: what the first steps took beyond those after them [s]; peak_bytes: the most
    memory that the engine's process, or its program's, has held so far [B].
    """

    call_ns: float
    build_s: float
    compile_s: float
    peak_bytes: int


class Timer:
    """One contestant, built and warm, with a load that takes long enough to be read.

    keep: what of its OPTIONAL the engine is to build although the scene has no use for it.  Raises NoTime.
    """

    def __init__(
        self, engine: ModuleType, scene: Scene, method: str, pace: Pace, keep: frozenset[str] = frozenset()
    ) -> None:
        self._engine, self._scene, self._method, self._pace, self._keep = engine, scene, method, pace, keep
        self._load, self._warm = 1, False
        self._expected: Array | None = None  # known once the load is
        self._repeats: float | None = None
        # A program has wall time only, and one lap may have waited for a core.
        sample_ns, looks = (LINE_NS, IDLE_LOOKS) if hasattr(engine, "reported_ns") else (SAMPLE_NS, 1)
        most = MOST_STEPS if pace.by_step else MOST_COPIES
        build_s = timed(self._prepare)
        first = self._lap().ns
        self._alone = self._lap().ns
        looks_alone = min(CALLS, int(LONG_NS / max(self._alone, 1.0)))
        self._alone = min([self._alone, *(self._lap().ns for _ in range(looks_alone))])
        while (took := min(self._lap().ns for _ in range(looks))) < sample_ns and self._load < most:
            # A call has its own cost, so that a short load looks longer than it is: what is missing is asked for again.
            self._load = min(most, max(self._load + 1, round(SPARE * self._load * sample_ns / max(took, 1))))
            if not pace.by_step:
                self._prepare()
                self._lap()
        if pace.by_step:
            self._refuse_no_time()
        self._warm = took < WARM_NS
        self._expected = self._untimed(FIRST_CALL)
        call_ns = max(0.0, self._alone - self.sample().ns)
        own = engine.process(self._world) if hasattr(engine, "process") else None
        self.ready = Ready(call_ns, build_s, max(0.0, first - self._alone) / 1e9, peak_bytes(own))

    def _prepare(self) -> None:
        copies = 1 if self._pace.by_step else self._load
        self._start = np.tile(self._scene.start, (copies, 1))
        self._world = built(self._engine, replace(self._scene, start=self._start), self._method, self._keep)

    def _refuse_no_time(self) -> None:
        """Raise NoTime where the steps cannot have been taken in the time that the clock says."""
        took = min(self._lap().ns for _ in range(LOOKS))
        if took < self._load:
            raise NoTime(f"{self._load} steps in {took:.3g} ns: under a nanosecond a step is no time")
        if took > LONG_NS:
            return
        growth = 0.0
        for _ in range(DOUBLED):
            self._load *= 2
            twice = min(self._lap().ns for _ in range(LOOKS))
            growth, took = twice / took, twice
            if growth >= GROWTH:
                self._load //= 2
                return
        said = f"{self._load} steps take {growth:.3g} times as long as half as many"
        raise NoTime(f"{said}: what does not grow with the steps is no time of theirs")

    def _calls(self, first: int = 0) -> Iterator[tuple[int, float]]:
        """Yield the calls of `advance` that the load consists of: each leg at once, or in calls of growing length.

        first: the steps of the first of those.  A flight's legs stay as they are.
        """
        for n, dt in self._pace.legs:
            left = n * self._load if self._pace.by_step else n
            part = first if first and self._pace.by_step else left
            while left:
                yield min(part, left), dt
                left -= min(part, left)
                part *= 2

    def _untimed(self, first: int) -> Array:
        """Return the state of one throw after the load's steps in a new world, called as flights call, (N, 13)."""
        engine = self._engine
        world = built(engine, self._scene, self._method, self._keep)
        engine.write(world, self._scene.start.copy())
        for n, dt in self._calls(first):
            prepare(engine, world, dt)
            engine.advance(world, n, dt)
        return np.array(engine.read(world), dtype=float)

    def _refuse_other_work(self, states: Array, expected: Array) -> None:
        """Raise NoTime where a timed lap ends elsewhere than the same steps when nobody times them, as `expected`.

        Bit by bit, or, of an engine that does not repeat its own bits, by far more than several untimed runs of it
        differ: two may end close to each other by chance.
        """
        expected = np.tile(expected, (len(self._start) // len(expected), 1))
        if np.array_equal(states, expected, equal_nan=True):
            return
        off = apart(states, expected)
        if self._repeats is None:
            once = self._untimed(FIRST_CALL)
            self._repeats = max(float(apart(self._untimed(OTHER_CALL), once).max()) for _ in range(RUNS))
        if off.max() <= CHANCE * self._repeats <= MOST_APART:
            return
        row, column = np.unravel_index(int(np.argmax(off)), off.shape)
        timed_at, untimed_at = states[row, column], expected[row, column]
        raise NoTime(
            f"{PARTS[column]} of throw {row} is {timed_at:.9g} after {self._load} timed steps or flights, and "
            f"{untimed_at:.9g} after the same ones untimed: they are not the same work"
        )

    def sample(self) -> Sample:
        """Return the time of one step, or of one flight."""
        lap = self._lap()
        for _ in range(AGAIN):
            if lap.ns > 0:
                break
            lap = self._lap()
        said = None if lap.said is None else lap.said / self._load
        return sample(np.array(lap.advance) / self._load, np.array(lap.deferred) / self._load, said)

    def _lap(self) -> Sample:
        """Return what the whole load takes."""
        engine, world, advance = self._engine, self._world, self._engine.advance
        calls = [*self._calls()]
        # An engine that fixes its step when it is told, which is not timed, is read between legs.
        legs = [[call] for call in calls] if hasattr(engine, "prepare") else [calls]
        if self._warm:
            engine.write(world, self._start.copy())
            for n, dt in calls:
                # A flight is not cut into steps: a shorter one.
                part = (-(-n // WARM_PART), dt) if self._pace.by_step else (n, dt / WARM_PART)
                prepare(engine, world, part[1])
                advance(world, *part)
            engine.read(world)
        engine.write(world, self._start.copy())
        taken = flown = np.zeros(len(CLOCKS))
        reported_ns = getattr(engine, "reported_ns", None)
        if reported_ns:
            taken = -idle(engine, world, calls)
            reported_ns(world)
        for leg in legs:
            prepare(engine, world, leg[0][1])
            begun = before()
            for n, dt in leg:
                advance(world, n, dt)
            flown = after()
            taken = taken + flown - begun
        said = reported_ns(world) if reported_ns else None
        engine.read(world)
        looked = after()
        states = engine.read(world)
        again = after()
        if self._expected is not None:
            self._refuse_other_work(np.array(states, dtype=float), self._expected)
        return sample(np.maximum(taken, 0.0), np.maximum((looked - flown) - (again - looked), 0.0), said)


def apart(states: Array, others: Array) -> Array:
    """Return how far apart states are, number by number, over the largest of its vector, (N, 13); inf beside NaN."""
    scale = np.hstack([np.full(last - first, np.abs(others[:, first:last]).max()) for first, last in VECTORS])
    off = np.where(states == others, 0.0, np.abs(states - others) / np.maximum(scale, np.finfo(float).tiny))
    return np.where(np.isnan(off), np.where(np.isnan(states) & np.isnan(others), 0.0, np.inf), off)


def idle(engine: ModuleType, world: object, calls: Sequence[tuple[int, float]]) -> Array:
    """Return what these calls of `advance` cost where no steps are asked for: the way to a program and back [ns].

    The least of a few: what is taken off must not be more than what is there.
    """
    looks = []
    for _ in range(IDLE_LOOKS):
        begun = before()
        for _, dt in calls:
            engine.advance(world, 0, dt)
        looks.append(after() - begun)
    return np.min(looks, axis=0)


class Steps:
    """The steps of a run, and what they have taken so far: wall time and CPU time of the engine's native loops [s].

    What `advance` has left to be done when it is read counts; of a program, the way there and back does not.
    """

    def __init__(self, engine: ModuleType, world: object) -> None:
        self._engine, self._world, self._is_program = engine, world, hasattr(engine, "reported_ns")
        self.wall_s, self._cpu_ns, self._children_ns = 0.0, 0, usage.children_ns()
        self._read_s = 0.0  # what a read takes where nothing was left; 0 until it has taken long once

    @property
    def cpu_s(self) -> float:
        """CPU time of the process and of its children that have ended."""
        return (self._cpu_ns + usage.children_ns() - self._children_ns) / 1e9

    def make(self, n: int, dt: float) -> Any:
        """Make n steps of dt [s]; return the states read after them."""
        engine, world = self._engine, self._world
        cpu_ns = process_time_ns()
        took = timed(engine.advance, world, n, dt)
        begin = perf_counter()
        states = engine.read(world)
        first = perf_counter() - begin
        if first > self._read_s + LEFT_S:
            self._read_s = timed(engine.read, world)
            left = first - self._read_s
            took += left if left > LEFT_S else 0.0
        if self._is_program:
            took = max(0.0, took - idle(engine, world, [(n, dt)])[2] / 1e9)
        self._cpu_ns += process_time_ns() - cpu_ns
        self.wall_s += took
        return states


def prepare(engine: ModuleType, world: object, dt: float) -> None:
    """Tell the engine of the step to come [s], if it fixes its step when it is told."""
    if hasattr(engine, "prepare"):
        engine.prepare(world, dt)


def sample(advance: Array, deferred: Array, said: float | None = None) -> Sample:
    """Return a sample of what the clocks say [ns], (4,) each."""
    thread, process, wall, queued = advance.tolist()
    later_thread, later_process, later_wall, later_queued = deferred.tolist()
    return Sample((thread, process, wall, queued), (later_thread, later_process, later_wall, later_queued), said)


def before() -> Array:
    """Return what the clocks say [ns], (4,); what is to be timed begins now."""
    return np.array([read() for read in reversed(CLOCKS)], dtype=float)[::-1]


def after() -> Array:
    """Return what the clocks say [ns], (4,); what is to be timed is over."""
    return np.array([read() for read in CLOCKS], dtype=float)


def process_ns() -> int:
    """Return the CPU time of this process and of its children that have ended [ns]."""
    return process_time_ns() + usage.children_ns()


def queued_ns() -> int:
    """Return how long this thread has waited for a core that others were on [ns], 0 where the system does not tell."""
    return int(os.pread(SCHEDULE[0], 64, 0).split()[1]) if SCHEDULE[0] else 0


def schedule() -> int | None:
    """Return a descriptor of what Linux says of how this thread was scheduled: time on a core, time waiting for one."""
    with suppress(OSError):
        return os.open("/proc/thread-self/schedstat", os.O_RDONLY)
    return None


def peak_bytes(process: int | None = None) -> int:
    """Return the most memory that a process has held [B], this one unless another is named.

    Where the system does not tell of others it is this one's.
    """
    with suppress(OSError):
        # Not ru_maxrss, which begins with that of the process that started this one.
        for line in Path(f"/proc/{process or 'self'}/status").read_text().splitlines():
            if line.startswith("VmHWM:"):
                return int(line.split()[1]) << 10
    return usage.peak_bytes()


SCHEDULE = [schedule()]
if hasattr(os, "register_at_fork"):  # a fork's thread is another
    os.register_at_fork(after_in_child=lambda: SCHEDULE.__setitem__(0, schedule()))
# The thread's is read next to what is timed: most engines are timed by it.
CLOCKS = (thread_time_ns, process_ns, perf_counter_ns, queued_ns)
