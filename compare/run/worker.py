"""One engine in a process of its own: a crash or a hang there is an answer here."""

import multiprocessing
import os
import signal
import sys
from dataclasses import dataclass, replace
from multiprocessing.connection import Connection
from types import ModuleType
from typing import Self

from compare.run.flight import Trajectory, fly, struck
from compare.run.registry import BadEngine, EngineInfo, Missing, engine_info, in_one_line, is_file, load
from compare.run.timer import Pace, Timer
from scenarios.scene import Scene


@dataclass(frozen=True)
class Failure:
    """Why there is no trajectory, as a run's status: `missing: why`, `skipped: why`, `crashed: why` or `timeout`."""

    status: str


class Worker:
    """A process that has one engine loaded and flies what it is sent.

    engine: a name of ours or the path of a user's file; time_limit [s] for each answer.
    """

    def __init__(self, engine: str, time_limit: float) -> None:
        self.engine = engine
        self.time_limit = time_limit
        spawn = multiprocessing.get_context("spawn")
        self.connection, far_end = spawn.Pipe()
        self.process = spawn.Process(target=serve, args=(far_end, engine), daemon=True)
        self.process.start()
        far_end.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def describe(self) -> EngineInfo | Failure:
        """Return the engine's info, or why it has none.  Raises BadEngine for a user's file that cannot be used."""
        answer = self._answer()
        if isinstance(answer, BadEngine):
            raise answer
        if isinstance(answer, Failure) and is_file(self.engine):
            raise BadEngine(f"{self.engine}: cannot be loaded: {answer.status}")
        assert isinstance(answer, EngineInfo | Failure)
        return answer

    def fly(self, scene: Scene, method: str, dt: float, keep: frozenset[str] = frozenset()) -> Trajectory | Failure:
        """Return the flight, or why there is none; after `crashed` or `timeout` the process is gone."""
        answer = self._ask("fly", scene, method, dt, keep)
        assert isinstance(answer, Trajectory | Failure)
        return answer

    def prepare_timer(
        self, key: str, scene: Scene, method: str, pace: Pace, keep: frozenset[str] = frozenset()
    ) -> float | Failure:
        """Make a timer ready under that key; return what a call from Python costs [ns], or why it cannot be."""
        answer = self._ask("prepare_timer", key, scene, method, pace, keep)
        assert isinstance(answer, float | Failure)
        return answer

    def sample(self, key: str) -> float | Failure:
        """Return one sample of that timer [ns]."""
        answer = self._ask("sample", key)
        assert isinstance(answer, float | Failure)
        return answer

    @property
    def alive(self) -> bool:
        """Whether it can still be asked."""
        return not self.connection.closed

    def close(self) -> None:
        """End the process, whatever it is doing."""
        self.connection.close()
        self.process.kill()
        self.process.join()

    def _ask(self, task: str, *arguments: object) -> object:
        try:
            self.connection.send((task, arguments))
        except OSError:
            return self._died()
        return self._answer()

    def _answer(self) -> object:
        try:
            if self.connection.poll(self.time_limit):
                return self.connection.recv()
        except (EOFError, OSError):
            return self._died()
        self.close()
        return Failure("timeout")

    def _died(self) -> Failure:
        self.process.join()
        code = self.process.exitcode or 0
        self.close()
        if code < 0:
            return Failure(f"crashed: its process was killed by {signal.Signals(-code).name}")
        return Failure(f"crashed: its process ended with code {code}")


class Tasks:
    """What the process can be asked to do with its engine."""

    def __init__(self, engine: ModuleType) -> None:
        self._engine = engine
        self._stopwatches: dict[str, Timer] = {}

    def fly(self, scene: Scene, method: str, dt: float, keep: frozenset[str]) -> Trajectory:
        """Fly the scene."""
        return fly(self._engine, scene, method, dt, keep)

    def prepare_timer(self, key: str, scene: Scene, method: str, pace: Pace, keep: frozenset[str]) -> float:
        """Make a timer ready and return what a call costs [ns]."""
        # As it flies: what an impulse at the start sets in motion is part of the load.
        moving = replace(scene, start=struck(scene, 0.0, scene.start, []))
        self._stopwatches[key] = Timer(self._engine, moving, method, pace, keep)
        return self._stopwatches[key].call()

    def sample(self, key: str) -> float:
        """Read a timer [ns]."""
        return self._stopwatches[key].sample()


def serve(connection: Connection, engine: str) -> None:
    """The process: load the engine, say what it is, then fly until told no more."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the parent's to handle; it ends this process
    os.dup2(2, 1)  # whatever an engine prints goes to standard error: standard output is for results
    sys.stdout = sys.stderr  # where it is not kept back in a buffer that dies with the process
    try:
        module = load(engine)
        connection.send(engine_info(engine, module))
    except BadEngine as error:
        connection.send(error)
        return
    except Missing as error:
        connection.send(Failure(f"missing: {error}"))
        return
    tasks = Tasks(module)
    while True:
        try:
            task, arguments = connection.recv()
        except EOFError:
            return
        try:
            connection.send(getattr(tasks, task)(*arguments))
        except NotImplementedError as error:
            connection.send(Failure(f"skipped: {error}"))
        except Exception as error:
            connection.send(Failure(f"crashed: {in_one_line(error)}"))
