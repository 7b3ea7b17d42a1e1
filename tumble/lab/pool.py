"""Engines that stand ready for every throw of every page.

An engine's process is leased to one throw at a time.  Where none is free another is started, up to MOST of an engine;
then throws wait.  A process that still runs when its throw is over is ended, so that no later throw waits for it.  An
engine that starts slowly, or hangs there, runs when it is up; a contestant without a method gets its default method
then.  A few idle processes stay, those used last; the others are ended.

The runner of studies (`tumble.compare.run.tasks`) does not fit here: it works through a list that is known when it
begins, one process an engine, and stops all of them when one task is given up.  Here throws come while others run, each
gives up its own runs alone, and one engine runs for several pages at once.  What a process is, what one run is, time
limits and what happens to a process that died are the same: `launched` and `RunningEngine.simulate`.
"""

import threading
import time
from collections import Counter
from collections.abc import Callable, Iterable
from contextlib import ExitStack
from dataclasses import dataclass, replace
from typing import Self

from tumble.compare.run.asked import chosen, titles, wanted
from tumble.compare.run.engines.environments import located
from tumble.compare.run.engines.registry import BadEngine, EngineInfo, is_file, names
from tumble.compare.run.flight import Trajectory
from tumble.compare.run.running_engines import AS_ASKED, DEFAULT, RunningEngine, launched
from tumble.compare.run.status import Failure, Status
from tumble.lab.background import Workers
from tumble.scenarios.scene import Scene

HELD = "+held"
READY_S = 10.0  # the longest that the page waits for an engine
# Processes of one engine at most; those that stay when they are idle, of one engine and of all.
MOST, IDLE_OF_ONE, IDLE = 4, 2, 8
LOOK_S = 0.1  # how often a throw that waits for a process looks whether it is still wanted


@dataclass(frozen=True)
class Contestant:
    """One method of one engine, an engine's name or file; title: the engine's name in tables.

    method: '' for the default one of an engine that is not up yet.
    """

    engine: str
    method: str
    title: str

    @property
    def name(self) -> str:
        """ENGINE:METHOD, as in every table."""
        return f"{self.title}:{self.method}" if self.method else self.title


class Lease:
    """An engine's process while it runs for one throw."""

    def __init__(self, engine: str, time_limit: float) -> None:
        self._stack, self.is_over = ExitStack(), False
        self.running_engine: RunningEngine = self._stack.enter_context(launched([engine], time_limit))[0]

    def run(self, scene: Scene, method: str) -> Trajectory | Failure:
        """Return the trajectory, or why there is none.  Raises Halted after `halt`."""
        return self.running_engine.simulate(scene, method, scene.step)

    def halt(self) -> None:
        """Kill the process, from any thread; pending calls return Failure."""
        self.running_engine.halt()
        self.is_over = True

    def close(self) -> None:
        """End the process."""
        self._stack.close()

    @property
    def can_go_on(self) -> bool:
        """Whether it still answers."""
        return self.running_engine.worker.alive and not self.is_over


class Pool:
    """The engines' processes.  A context: at its end the idle ones end, and one that is not up yet ends when it is.

    Parameters
    ----------
    time_limit
        For each answer of an engine [s].

    Attributes
    ----------
    engines
        The engines that are up, and what they state of themselves.
    background
        The processes that compute truths and grades.
    """

    def __init__(self, time_limit: float) -> None:
        self._time_limit = time_limit
        self._lock = threading.Lock()
        self._returned = threading.Condition(self._lock)
        self._idle: list[Lease] = []  # the one used last is the last
        self._count: Counter[str] = Counter()  # processes by engine, idle or not
        self._waiting: Counter[str] = Counter()
        self._begun: dict[str, threading.Event] = {}
        self._failed: dict[str, Failure | BadEngine] = {}
        self._closed = False
        self._titles = titles(names())
        self._not_installed: dict[str, str] = {}
        self.engines: dict[str, EngineInfo] = {}
        self.background = Workers()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        with self._lock:
            self._closed = True
            idle, self._idle = self._idle, []
            self._returned.notify_all()
        closing = [threading.Thread(target=lease.close) for lease in idle]
        for one in closing:
            one.start()
        self.background.close()
        for one in closing:
            one.join()

    def begin(self, asked: Iterable[str]) -> list[str]:
        """Start the engines asked for, ENGINE[:METHOD], and return them.  Raises BadEngine."""
        engines = wanted(asked)
        self._titles = titles((*self._titles, *engines))
        for engine in engines:
            self._begin(engine)
        return list(engines)

    def ready(
        self, asked: Iterable[str], on_progress: Callable[[str], object] = lambda engine: None
    ) -> list[Contestant]:
        """Start the requested engines.

        Parameters
        ----------
        asked
            ENGINE[:METHOD] each; an engine alone stands for its default method.
        on_progress
            Called with each engine that is up, or that is not waited for any longer.

        Returns
        -------
        list of Contestant
            An engine that is not installed, or not up yet, is among them: it runs when it is up, or reports why not.

        Raises
        ------
        BadEngine
            There is no such engine or method, or a file is no engine.
        """
        asked = list(asked)
        engines = wanted(asked)
        end = time.monotonic() + READY_S
        for engine in self.begin(asked):
            self._begin(engine).wait(end - time.monotonic())
            on_progress(engine)
        for engine, methods in engines.items():
            self._check(engine, methods)
        found = [self.contestant(engine, method) for engine, methods in engines.items() for method in methods]
        return [*dict.fromkeys(map(self.resolved, found))]

    def all_contestants(self) -> list[Contestant]:
        """Return all contestants: every method of the engines that are up, and those that are not up by name."""
        found = []
        for engine in sorted(self._titles, key=lambda engine: engine not in self.engines):
            info = self.engines.get(engine)
            methods = ("",) if info is None else info.every_method
            found += [self.contestant(engine, method) for method in methods]
        return found

    def why_not(self, engine: str) -> str:
        """Return why an engine cannot take part, as far as that is known; '' for one that may."""
        if engine in self.engines:
            return ""
        if why := self._failed.get(engine):
            return str(why)
        if is_file(engine):
            return ""
        if engine not in self._not_installed:
            _, place, why_nowhere = located(engine)
            self._not_installed[engine] = "" if place else str(Failure(Status.MISSING, why_nowhere))
        return self._not_installed[engine]

    def contestant(self, engine: str, method: str) -> Contestant:
        """Return a method of an engine under its unique name."""
        return Contestant(engine, method, self._titles[engine])

    def role(self, one: Contestant) -> str:
        """Return the role of a contestant for its engine; every contestant of the lab was requested."""
        info = self.engines.get(one.engine)
        return DEFAULT if info is not None and one.method in info.default else AS_ASKED

    def resolved(self, one: Contestant) -> Contestant:
        """Return a contestant with the method that it runs, as soon as that is known."""
        info = self.engines.get(one.engine)
        return one if one.method or info is None else replace(one, method=info.methods[0])

    def instead(self, one: Contestant, scene: Scene) -> Contestant | None:
        """Return what may run where a contestant cannot, None where there is nothing.

        Above a plane the engine's first method for that, else the variant that holds the forces over a step.
        """
        info = self.engines.get(one.engine)
        if info is None:
            return None
        others = info.contact if scene.plane else [each for each in info.forced if each == f"{one.method}{HELD}"]
        return next((replace(one, method=method) for method in others), None)

    def tolerance(self, one: Contestant) -> float | None:
        """Return the tolerance under which a contestant chooses its steps, None of one that does not."""
        info = self.engines.get(one.engine)
        return None if info is None else info.tolerance(one.method)

    def lease(
        self, engine: str, methods: list[str], is_wanted: Callable[[], bool] = lambda: True
    ) -> Lease | Failure | None:
        """Return a process of that engine for one throw alone, or why there is none; it may take a while.

        methods: what it is to run, '' for its default.  None where it was not wanted any more, or the lab is closing.
        Raises BadEngine.
        """
        # Of an engine that has never been up no second process is started: it may hang there.
        self._begin(engine).wait()
        self._check(engine, methods)
        with self._returned:
            self._waiting[engine] += 1
            try:
                while True:
                    if self._closed or not is_wanted():
                        return None
                    if isinstance(why := self._failed.get(engine), Failure):
                        return why
                    if idle := [lease for lease in self._idle if lease.running_engine.engine == engine]:
                        self._idle.remove(idle[-1])
                        return idle[-1]
                    if self._count[engine] < MOST:
                        self._count[engine] += 1
                        break
                    self._returned.wait(LOOK_S)
            finally:
                self._waiting[engine] -= 1
        return self._started(engine)

    def take_back(self, lease: Lease) -> None:
        """Keep a process for the next throw, if it still answers and there are not enough that wait already."""
        engine = lease.running_engine.engine
        with self._returned:
            gone = []
            if lease.can_go_on and not self._closed:
                self._idle.append(lease)
                of_one = [one for one in self._idle if one.running_engine.engine == engine]
                if not self._waiting[engine]:
                    gone = of_one[:-IDLE_OF_ONE] or self._idle[:-IDLE]
            else:
                gone = [lease]
            self._idle = [one for one in self._idle if one not in gone]
            self._count.subtract(one.running_engine.engine for one in gone)
            self._returned.notify_all()
        for one in gone:
            one.close()

    def _started(self, engine: str) -> Lease:
        """Return a new process, which is counted already."""
        try:
            return Lease(engine, self._time_limit)
        except BaseException:
            with self._returned:
                self._count[engine] -= 1
                self._returned.notify_all()
            raise

    def _begin(self, engine: str) -> threading.Event:
        """Start an engine unless it has begun; return what is set when it is up or it is known why it is not."""
        with self._lock:
            begun = self._begun.get(engine)
            if begun is None:
                begun = self._begun[engine] = threading.Event()
                self._count[engine] += 1
                threading.Thread(target=self._bring_up, args=(engine, begun), daemon=True).start()
        return begun

    def _bring_up(self, engine: str, begun: threading.Event) -> None:
        try:
            lease = self._started(engine)
        except BadEngine as error:
            self._failed[engine] = error
        else:
            info = lease.running_engine.info
            if isinstance(info, EngineInfo):
                self.engines[engine] = info
                self.take_back(lease)
            else:
                self._failed[engine] = info
                lease.halt()
                self.take_back(lease)
        finally:
            begun.set()

    def _check(self, engine: str, methods: list[str]) -> None:
        """Refuse a file that is no engine, and methods that an engine which is up has not.  Raises BadEngine."""
        if isinstance(why := self._failed.get(engine), BadEngine):
            raise why
        if engine in self.engines:
            chosen(engine, [method for method in methods if method], self.engines[engine])
