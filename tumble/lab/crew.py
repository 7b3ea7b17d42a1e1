"""Processes that stand ready for every throw of every page: engines, and the truth.

An engine's process is lent to one throw at a time; where none is free another is started.  One that is still at work
when its throw is over, because it hangs or is slow, is ended, so that nobody ever waits for it.

The runner of studies (`compare.run.tasks`) does not fit here: it works through a list that is known when it begins,
one process an engine, and stops all of them when one task is given up.  Here throws come while others fly, each gives
up its own flights alone, and one engine flies for several pages at once.  What a process is, what one flight is, time
limits and what becomes of a process that died are the same: `launched` and `Participant.fly`.
"""

import multiprocessing
import threading
from collections.abc import Callable, Iterable
from concurrent.futures import Future, ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any, Self

from compare.run.flight import Trajectory
from compare.run.participants import Participant, chosen, launched, titles, wanted
from compare.run.registry import BadEngine, EngineInfo
from compare.run.truths import end_with
from compare.run.worker import Failure
from scenarios.scene import Scene

ASIDE_PROCESSES = 2


@dataclass(frozen=True)
class Contestant:
    """One method of one engine, an engine's name or file; title: the engine's name in tables."""

    engine: str
    method: str
    title: str

    @property
    def name(self) -> str:
        """ENGINE:METHOD, as in every table."""
        return f"{self.title}:{self.method}"


class Loan:
    """An engine's process while it flies for one throw."""

    def __init__(self, engine: str, time_limit: float) -> None:
        self._stack, self.is_over = ExitStack(), False
        self.participant: Participant = self._stack.enter_context(launched([engine], time_limit))[0]

    def fly(self, scene: Scene, method: str) -> Trajectory | Failure:
        """Return the flight, or why there is none.  Raises Halted after `halt`."""
        return self.participant.fly(scene, method, scene.step)

    def halt(self) -> None:
        """Kill the process, from any thread; who waits for its flight gets a failure."""
        self.participant.halt()
        self.is_over = True

    def close(self) -> None:
        """End the process."""
        self._stack.close()


class Crew:
    """Who stands ready.  A context: when it is left no process is left either.

    time_limit [s] for each answer of an engine.
    """

    def __init__(self, time_limit: float) -> None:
        self._time_limit = time_limit
        self._lock = threading.Lock()
        self._idle: dict[str, list[Loan]] = {}
        self._closed = False
        self.engines: dict[str, EngineInfo] = {}
        self._titles: dict[str, str] = {}
        spawn = multiprocessing.get_context("spawn")
        # Its far end closes with this process, however that ends.
        self._far_end, self._lifeline = spawn.Pipe(duplex=False)
        self._aside_pool = lambda: ProcessPoolExecutor(
            ASIDE_PROCESSES, spawn, initializer=end_with, initargs=(self._far_end,)
        )
        self._pool = self._aside_pool()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        with self._lock:
            self._closed = True
            idle = [loan for loans in self._idle.values() for loan in loans]
        for loan in idle:
            loan.close()
        self._lifeline.close()
        self._pool.shutdown(wait=False, cancel_futures=True)

    def ready(self, asked: Iterable[str]) -> list[Contestant]:
        """Start the engines asked for, ENGINE[:METHOD], and return who flies: of an engine alone, its default method.

        An engine of ours that is not installed flies all the same, to say why it does not.  Raises BadEngine.
        """
        engines = wanted(asked)
        self._titles = titles((*self._titles, *engines))
        with ThreadPoolExecutor() as threads:
            loans = list(threads.map(lambda engine: Loan(engine, self._time_limit), engines))
        contestants = []
        for loan, (engine, methods) in zip(loans, engines.items(), strict=True):
            self.take_back(loan)
            info = loan.participant.info
            if isinstance(info, EngineInfo):
                self.engines[engine] = info
            contestants += [self.contestant(engine, method) for method in methods or chosen(engine, [], info)[:1]]
            chosen(engine, methods, info)
        return contestants

    def contestant(self, engine: str, method: str) -> Contestant:
        """Return a method of an engine that stands ready, under the name that tells it from the others."""
        return Contestant(engine, method, self._titles[engine])

    def tolerance(self, one: Contestant) -> float | None:
        """Return the tolerance under which a contestant chooses its steps, None of one that does not."""
        info = self.engines.get(one.engine)
        return None if info is None else info.tolerance(one.method)

    def lend(self, engine: str) -> Loan:
        """Return a process of that engine that nobody else has.  Raises BadEngine."""
        with self._lock:
            if self._closed:
                raise BadEngine("the lab is closing")
            if self._idle.get(engine):
                return self._idle[engine].pop()
        return Loan(engine, self._time_limit)

    def take_back(self, loan: Loan) -> None:
        """Keep a process for the next throw, if it still answers."""
        with self._lock:
            if loan.participant.worker.alive and not loan.is_over and not self._closed:
                self._idle.setdefault(loan.participant.engine, []).append(loan)
                return
        loan.close()

    def aside(self, function: Callable[..., Any], *arguments: Any) -> "Future[Any]":
        """Return what will be a function's result, worked out in another process."""
        with self._lock:
            try:
                return self._pool.submit(function, *arguments)
            except BrokenProcessPool:  # one of them died, of memory or by somebody's hand
                self._pool = self._aside_pool()
                return self._pool.submit(function, *arguments)
