"""One engine in a process of its own: a crash or a hang there is an answer here, and what it answers is data."""

import math
import threading
from dataclasses import replace
from functools import cached_property
from time import monotonic
from typing import Any, Self

import numpy as np

from tumble.compare.run.digest import digest
from tumble.compare.run.engines.environments import HERE, Place, located
from tumble.compare.run.engines.registry import BadEngine, EngineInfo, is_file, package
from tumble.compare.run.engines.sources import sources
from tumble.compare.run.flight import Trajectory
from tumble.compare.run.process.fork_server import SERVE, Fork
from tumble.compare.run.process.message import Malformed
from tumble.compare.run.process.process import Died, Process, signal_name
from tumble.compare.run.questions import (
    Ended,
    PrepareTimer,
    Question,
    ReadSensors,
    Refusal,
    RunCheck,
    Simulate,
    StepMatrices,
    TakeSample,
    more_than,
)
from tumble.compare.run.sensing import SensorReadings
from tumble.compare.run.status import Failure, Status
from tumble.compare.run.timing.timer import Pace, Ready, Sample
from tumble.scenarios.frames import Array
from tumble.scenarios.scene import Scene

MEMORY_LIMIT = 4 << 30
# A process that has closed its line has so long to end [s].
TO_END_S = 5.0
# What a process may write to and never has: nearer its limit than this [B], it ended for want of memory.
UNTOUCHED = 128 << 20
# How native code ends that is given no memory.
BROKEN_OFF = ("SIGABRT", "SIGSEGV", "SIGBUS", "SIGKILL")
FLOAT = np.dtype(float)


class Worker:
    """A process that has one engine loaded and simulates the scenes it is sent.

    Parameters
    ----------
    engine : ENGINE[@RELEASE] of Tumble's engines, or path of a user's file
    time_limit : for each answer [s]
    memory_limit : for the process [B]
    place : where the process runs; None: in the engine's environment, or beside Tumble
    """

    def __init__(
        self, engine: str, time_limit: float, memory_limit: int = MEMORY_LIMIT, place: Place | None = None
    ) -> None:
        self.engine, self.time_limit, self.memory_limit, self._place = engine, time_limit, memory_limit, place
        self._turn = threading.Lock()
        self._process: Process | None = None
        self._info: EngineInfo | None = None  # which it says once
        self._why_gone = Failure(Status.CRASHED, "its process was ended", process_died=True)
        name, why = engine, ""
        if place is None:
            name, place, why = (engine, HERE, "") if is_file(engine) else located(engine)
        if place is None:
            self._why_gone = Failure(Status.MISSING, why)
            return
        # A user's file finds nothing imported but what it imports, and another Python has nothing of this one.
        is_ours = place == HERE and not is_file(engine)
        words = name, str(memory_limit)
        try:
            # Files in the working directory are the user's, and run only when he names one.
            self._process = Process(
                [place.python, "-P", SERVE, *words],
                place.variables,
                Fork(words, package(name).imports) if is_ours else None,
            )
        except OSError as error:
            reason = f"its process cannot be started: {error.strerror or error}"
            self._why_gone = Failure(Status.CRASHED, reason, process_died=True)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def renewed(self) -> Self:
        """Return a new process in place of one that is gone, under the same limits."""
        return type(self)(self.engine, self.time_limit, self.memory_limit, self._place)

    def describe(self) -> EngineInfo | Failure:
        """Return the engine's info, or why it has none.  Raises BadEngine for a user's file that cannot be used."""
        if self._info is not None and self._process is not None:
            return self._info
        answer = self._ask(None, EngineInfo | Failure | Refusal)
        if isinstance(answer, Refusal):
            raise BadEngine(answer.line)
        if isinstance(answer, Failure) and is_file(self.engine):
            raise BadEngine(f"{self.engine}: cannot be loaded: {answer}")
        if isinstance(answer, EngineInfo):
            self._info = answer
        return answer

    def simulate(
        self, scene: Scene, method: str, dt: float, keep: frozenset[str] = frozenset(), probe: bool = False
    ) -> Trajectory | Failure:
        """Return the flight, or why there is none; after `crashed` or `timeout` the process may be gone."""
        numbers = len(scene.rows) * (1 + len(scene.start) * (13 + scene.body.points.size)) + 4 * 13
        answer = self._ask(
            Simulate(for_engine(scene), method, dt, keep, probe), Trajectory | Failure, numbers * FLOAT.itemsize
        )
        if isinstance(answer, Trajectory) and not is_flight_of(answer, scene):
            return self._gone(Status.CRASHED, "what it sent is no trajectory of this scene")
        return answer

    def read_sensors(self, scene: Scene, method: str, dt: float) -> SensorReadings | Failure:
        """Return what the scene's sensors read, or why they cannot be read."""
        counts = [len(scene.sensor_times(sensor)) for sensor in scene.sensors]
        answer = self._ask(
            ReadSensors(replace(scene, written=None), method, dt),
            SensorReadings | Failure,
            9 * sum(counts) * FLOAT.itemsize,
        )
        shapes = [(count, 9) for count in counts]
        if isinstance(answer, SensorReadings) and [values.shape for values in answer.values] != shapes:
            return self._gone(Status.CRASHED, "what it sent are no readings of this scene's sensors")
        return answer

    def prepare_timer(
        self, key: str, scene: Scene, method: str, pace: Pace, keep: frozenset[str] = frozenset()
    ) -> Ready | Failure:
        """Make a timer ready under that key; return what that has shown, or why it cannot be."""
        return self._ask(PrepareTimer(key, for_engine(scene), method, pace, keep), Ready | Failure)

    def sample(self, key: str) -> Sample | Failure:
        """Return one sample of that timer."""
        return self._ask(TakeSample(key), Sample | Failure)

    def step_matrices(self, method: str, s: float, c: float, h: Array) -> Array | Failure:
        """Return what the engine's own scheme makes of u'' + c u' + s u = 0 in steps h [s], (n,) -> (n, 2, 2)."""
        return self._ask(StepMatrices(method, s, c, h), np.ndarray | Failure, 4 * h.nbytes)

    def check_failure(self, check: str, method: str) -> str | Failure:
        """Return why a check of the engine contract fails for a method, '' if it passes, or why it could not run."""
        return self._ask(RunCheck(check, method), str | Failure)

    @cached_property
    def source(self) -> str:
        """The digest of a user's engine files; empty of Tumble's engines, which have versions."""
        return digest([path.read_bytes() for path in sources(self.engine)]) if is_file(self.engine) else ""

    @property
    def alive(self) -> bool:
        """Whether it can still be asked."""
        return self._process is not None

    def close(self) -> None:
        """End the process and all it has started, whatever they are doing."""
        self.kill()
        with self._turn:
            self._end()

    def refuse(self, failure: Failure) -> None:
        """End the process; what is asked from now on has this answer."""
        self.close()
        self._info, self._why_gone = None, failure

    def kill(self) -> None:
        """Kill the process and all it has started, from any thread; who waits for its answer gets a Failure."""
        if process := self._process:
            process.kill()

    def _ask(self, question: Question | None, hint: Any, most_bytes: int = 0) -> Any:
        """Put a question, or none, and return the answer, or the Failure that it is none; then the process is gone."""
        with self._turn:
            by = monotonic() + self.time_limit  # what others have asked before is no time of this answer
            if self._process is None:
                return self._why_gone
            try:
                if question is not None:
                    self._process.send(question, by)
                answer = self._process.receive(Ended | hint, most_bytes, by)
                return self._lost(answer.failure) if isinstance(answer, Ended) else answer
            except TimeoutError:
                return self._gone(Status.TIMEOUT, f"no answer within {self.time_limit:g} s (--time-limit)")
            except Malformed as error:
                return self._gone(Status.CRASHED, str(error))
            except Died:
                return self._died(self._process)

    def _died(self, process: Process) -> Failure:
        code = self._end(TO_END_S)
        broken_off = code is not None and signal_name(-code) in BROKEN_OFF
        if process.peak_bytes > self.memory_limit - UNTOUCHED and (process.peak_is_its_own or broken_off):
            return self._gone(Status.CRASHED, more_than(self.memory_limit))
        if code is None:
            return self._gone(Status.CRASHED, "its process closed its line", process_died=True)
        if code >= 0:
            return self._gone(Status.CRASHED, f"its process ended with code {code}", process_died=True)
        return self._gone(Status.CRASHED, f"its process was killed by {signal_name(-code)}", process_died=True)

    def _gone(self, status: Status, reason: str, process_died: bool = False) -> Failure:
        return self._lost(Failure(status, reason, process_died))

    def _lost(self, failure: Failure) -> Failure:
        self._end()
        self._why_gone = failure
        return failure

    def _end(self, patience: float = 0.0) -> int | None:
        process, self._process = self._process, None
        return process.end(patience) if process else None


def for_engine(scene: Scene) -> Scene:
    """Return the scene that an engine gets: without the exact numbers of its file, which only the reference uses,

    and without sensors, which have a run of their own (`read_sensors`): nothing here pays for them.
    """
    return replace(scene, written=None, sensors=())


def is_flight_of(answer: Trajectory, scene: Scene) -> bool:
    """Whether the arrays are those of this scene: its instants, throws and vertices."""
    rows, throws = len(scene.rows), len(scene.start)
    return (
        np.array_equal(answer.times, scene.rows)
        and answer.states.shape == (rows, throws, 13)
        and answer.vertices.shape == (rows, throws, *scene.body.points.shape)
        and all(array.dtype == FLOAT for array in (answer.times, answer.states, answer.vertices))
        and (answer.probe is None or answer.probe.starts.shape == answer.probe.ends.shape == (2, 13))
        and answer.steps > 0
        and 0.0 <= answer.wall_s < math.inf
    )
