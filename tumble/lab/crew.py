"""Engines that stand ready for every throw of every page.

An engine's process is lent to one throw at a time; where none is free another is started.  One that is still at work
when its throw is over, because it hangs or is slow, is ended, so that nobody ever waits for it.  An engine that takes
long to start, or hangs there, flies when it is up: who does not name its method learns by then which that is.

The runner of studies (`compare.run.tasks`) does not fit here: it works through a list that is known when it begins,
one process an engine, and stops all of them when one task is given up.  Here throws come while others fly, each gives
up its own flights alone, and one engine flies for several pages at once.  What a process is, what one flight is, time
limits and what becomes of a process that died are the same: `launched` and `Participant.fly`.
"""

import threading
import time
from collections.abc import Iterable
from contextlib import ExitStack
from dataclasses import dataclass, replace
from typing import Self

from compare.run.flight import Trajectory
from compare.run.participants import AS_ASKED, DEFAULT, Participant, chosen, launched, titles, wanted
from compare.run.registry import BadEngine, EngineInfo, names
from compare.run.worker import Failure
from scenarios.scene import Scene
from tumble.lab.aside import Hands

HELD = "+held"
READY_S = 10.0  # the longest that the page waits for an engine


@dataclass(frozen=True)
class Contestant:
    """One method of one engine, an engine's name or file; title: the engine's name in tables.

    method: '' for the default one of an engine that has not said yet which that is.
    """

    engine: str
    method: str
    title: str

    @property
    def name(self) -> str:
        """ENGINE:METHOD, as in every table."""
        return f"{self.title}:{self.method}" if self.method else self.title


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
    """Who stands ready.  A context: when it is left no process stands idle; one that is not up yet ends when it is,
    or with this process.

    time_limit [s] for each answer of an engine; engines: those that are up and what they said of themselves; hands:
    who works out truths and grades.
    """

    def __init__(self, time_limit: float) -> None:
        self._time_limit = time_limit
        self._lock = threading.Lock()
        self._idle: dict[str, list[Loan]] = {}
        self._begun: dict[str, threading.Event] = {}
        self._failed: dict[str, Failure | BadEngine] = {}
        self._closed = False
        self._titles = titles(names())
        self.engines: dict[str, EngineInfo] = {}
        self.hands = Hands()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        with self._lock:
            self._closed = True
            idle = [loan for loans in self._idle.values() for loan in loans]
        for loan in idle:
            loan.close()
        self.hands.close()

    def ready(self, asked: Iterable[str]) -> list[Contestant]:
        """Start the engines asked for, ENGINE[:METHOD], and return who flies: of an engine alone, its default method.

        An engine that is not installed, or not up yet, flies all the same: when it is up, or to say why it is not.
        Raises BadEngine.
        """
        engines = wanted(asked)
        self._titles = titles((*self._titles, *engines))
        end = time.monotonic() + READY_S
        for begun in [self._begin(engine) for engine in engines]:
            begun.wait(end - time.monotonic())
        for engine, methods in engines.items():
            self._check(engine, methods)
        found = [self.contestant(engine, method) for engine, methods in engines.items() for method in methods]
        return [*dict.fromkeys(map(self.resolved, found))]

    def all_contestants(self) -> list[Contestant]:
        """Return who can be asked for: every method of the engines that are up, and those that are not up by name."""
        found = []
        for engine in sorted(self._titles, key=lambda engine: engine not in self.engines):
            info = self.engines.get(engine)
            methods = ("",) if info is None else (*info.methods, *info.forced, *info.on_request)
            found += [self.contestant(engine, method) for method in methods]
        return found

    def contestant(self, engine: str, method: str) -> Contestant:
        """Return a method of an engine under the name that tells it from the others."""
        return Contestant(engine, method, self._titles[engine])

    def resolved(self, one: Contestant) -> Contestant:
        """Return a contestant with the method that it flies, as soon as that is known."""
        info = self.engines.get(one.engine)
        return one if one.method or info is None else replace(one, method=info.methods[0])

    def held(self, one: Contestant) -> Contestant | None:
        """Return the method beside a contestant's that is given the force of a scene's laws once a step."""
        info, method = self.engines.get(one.engine), f"{one.method}{HELD}"
        return replace(one, method=method) if info is not None and method in info.forced else None

    def role(self, one: Contestant) -> str:
        """Return what a contestant is to its engine; whoever takes part in the lab was asked for."""
        info = self.engines.get(one.engine)
        return DEFAULT if info is not None and one.method in info.default else AS_ASKED

    def tolerance(self, one: Contestant) -> float | None:
        """Return the tolerance under which a contestant chooses its steps, None of one that does not."""
        info = self.engines.get(one.engine)
        return None if info is None else info.tolerance(one.method)

    def lend(self, engine: str, methods: list[str]) -> Loan | Failure:
        """Return a process of that engine that nobody else has, or why there is none; it may take a while.

        methods: what it is to fly, '' for its default.  Raises BadEngine.
        """
        # Of an engine that has never been up no second process is started: it may hang there.
        self._begin(engine).wait()
        self._check(engine, methods)
        with self._lock:
            if self._closed:
                raise BadEngine("the lab is closing")
            if isinstance(why := self._failed.get(engine), Failure):
                return why
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

    def _begin(self, engine: str) -> threading.Event:
        """Start an engine if nobody has yet; return what is set when it is up or it is known why it is not."""
        with self._lock:
            begun = self._begun.get(engine)
            if begun is None:
                begun = self._begun[engine] = threading.Event()
                threading.Thread(target=self._bring_up, args=(engine, begun), daemon=True).start()
        return begun

    def _bring_up(self, engine: str, begun: threading.Event) -> None:
        try:
            loan = Loan(engine, self._time_limit)
        except BadEngine as error:
            self._failed[engine] = error
        else:
            info = loan.participant.info
            if isinstance(info, EngineInfo):
                self.engines[engine] = info
                self.take_back(loan)
            else:
                self._failed[engine] = info
                loan.close()
        finally:
            begun.set()

    def _check(self, engine: str, methods: list[str]) -> None:
        """Refuse a file that is no engine, and methods that an engine which is up has not.  Raises BadEngine."""
        if isinstance(why := self._failed.get(engine), BadEngine):
            raise why
        if engine in self.engines:
            chosen(engine, [method for method in methods if method], self.engines[engine])
