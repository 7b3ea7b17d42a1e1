"""What the process of an engine can be asked, and how it answers; it needs nothing but numpy."""

import socket
from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from types import ModuleType
from typing import BinaryIO

import numpy as np

from tumble.compare.run.engines.contract_checks import check_failure
from tumble.compare.run.engines.program import ProgramFailed
from tumble.compare.run.engines.registry import (
    BadEngine,
    EngineInfo,
    Missing,
    built,
    engine_info,
    in_one_line,
    load,
)
from tumble.compare.run.flight import Trajectory, simulate, with_impulses
from tumble.compare.run.process.message import PREFIX, Malformed, frame, lengths, unpacked
from tumble.compare.run.sensing import SensorReadings, sensed
from tumble.compare.run.status import Failure, Status
from tumble.compare.run.timing.timer import NoTime, Pace, Ready, Sample, Timer
from tumble.garbage import importing
from tumble.scenarios.frames import Array
from tumble.scenarios.scene import Scene


@dataclass(frozen=True)
class Refusal:
    """The line for the user about an engine file that cannot be used."""

    line: str


@dataclass(frozen=True)
class Ended:
    """The failure of an engine whose program or interpreter has ended: its process is of no further use."""

    failure: Failure


# Parts of a scene that a world of an engine with REUSES_WORLD depends on, and so many of its worlds are kept.
IN_WORLD = [
    field.name for field in fields(Scene) if field.name not in {"name", "title", "source", "duration", "times", "step"}
]
WORLDS = 4


class Loaded:
    """An engine, the timers that were made ready for it, and worlds of its last runs."""

    def __init__(self, module: ModuleType) -> None:
        self.module = module
        self.timers: dict[str, Timer] = {}
        self._worlds: dict[bytes, object] = {}

    def world(self, engine: ModuleType, scene: Scene, method: str, keep: frozenset[str]) -> object:
        """Return a world of the scene: a new one, or, of an engine that says so, that of a run like it."""
        if not getattr(engine, "REUSES_WORLD", False):
            return built(engine, scene, method, keep)
        key = b"".join(frame([method, keep, *(getattr(scene, name) for name in IN_WORLD)]))
        world = self._worlds.pop(key, None)
        self._worlds[key] = built(engine, scene, method, keep) if world is None else world
        if len(self._worlds) > WORLDS:
            del self._worlds[next(iter(self._worlds))]
        return self._worlds[key]


@dataclass(frozen=True)
class Simulate:
    """Run the scene with steps of dt [s]; probe: and briefly from another start that the scene does not have."""

    scene: Scene
    method: str
    dt: float
    keep: frozenset[str]
    probe: bool = False

    def answer(self, engine: Loaded) -> Trajectory:
        """Return the flight."""
        return simulate(engine.module, self.scene, self.method, self.dt, self.keep, self.probe, engine.world)


@dataclass(frozen=True)
class ReadSensors:
    """Run the scene's first throw with steps of dt [s] at most, and read its sensors."""

    scene: Scene
    method: str
    dt: float

    def answer(self, engine: Loaded) -> SensorReadings:
        """Return the readings."""
        return sensed(engine.module, self.scene, self.method, self.dt)


@dataclass(frozen=True)
class PrepareTimer:
    """Make a timer ready under that key."""

    key: str
    scene: Scene
    method: str
    pace: Pace
    keep: frozenset[str]

    def answer(self, engine: Loaded) -> Ready:
        """Return what that has shown.  Raises NoTime."""
        # As it flies: what an impulse at the start sets in motion is part of the load.
        moving = replace(self.scene, start=with_impulses(self.scene, 0.0, self.scene.start, []))
        engine.timers[self.key] = Timer(engine.module, moving, self.method, self.pace, self.keep)
        return engine.timers[self.key].ready


@dataclass(frozen=True)
class TakeSample:
    """Read the timer of that key."""

    key: str

    def answer(self, engine: Loaded) -> Sample:
        """Return one sample."""
        return engine.timers[self.key].sample()


@dataclass(frozen=True)
class StepMatrices:
    """Say what a scheme of the engine's own makes of u'' + c u' + s u = 0 in steps h [s], (n,)."""

    method: str
    s: float
    c: float
    h: Array

    def answer(self, engine: Loaded) -> Array:
        """Return the matrices on (u, u'), (n, 2, 2)."""
        scheme = engine.module.SCHEMES[self.method]
        return np.array([scheme(self.s, self.c, step) for step in self.h.tolist()], dtype=float).reshape(-1, 2, 2)


@dataclass(frozen=True)
class RunCheck:
    """Run a check of the engine contract, of tumble.compare.engines, on a method."""

    check: str
    method: str

    def answer(self, engine: Loaded) -> str:
        """Return why it fails, '' if it passes."""
        return check_failure(engine.module, self.check, self.method)


Question = Simulate | ReadSensors | PrepareTimer | TakeSample | StepMatrices | RunCheck


def answer_all(line: socket.socket, engine: str, memory_limit: int) -> None:
    """Load the engine and say what it is, then answer until nobody asks any more."""
    too_much = Failure(Status.CRASHED, more_than(memory_limit))
    try:
        if not (loaded := introduce(line, engine)):
            return
        for question in questions(line.makefile("rb")):
            try:
                send(line, question.answer(loaded))
            except MemoryError:
                send(line, too_much)
            except Exception as error:
                send(line, failure_of(error))
    except MemoryError:
        send(line, too_much)
    except Malformed as error:
        send(line, Ended(Failure(Status.CRASHED, f"it could not read what it was asked: {error}")))
    except ConnectionError:  # nobody is there any more
        return
    except SystemExit as error:
        if isinstance(error.code, str):  # otherwise the code says it
            reason = f"its process ended: {' '.join(error.code.split())}"
            send(line, Ended(Failure(Status.CRASHED, reason, process_died=True)))
            raise SystemExit(1) from None  # reported once, and not on standard error as well
        raise


def failure_of(error: Exception) -> Failure | Ended:
    """Return the failure that an engine's exception means."""
    if isinstance(error, NoTime):
        return Failure(Status.UNTIMED, str(error))
    if isinstance(error, NotImplementedError):
        return Failure(Status.SKIPPED, str(error))
    if isinstance(error, ProgramFailed):
        return Ended(Failure(Status.CRASHED, str(error)))
    return Failure(Status.CRASHED, in_one_line(error))


def introduce(line: socket.socket, engine: str) -> Loaded | None:
    """Send what the engine says of itself, or why it cannot be used, and return it loaded."""
    try:
        with importing():
            module = load(engine)
        send(line, engine_info(engine, module))
    except BadEngine as error:
        if isinstance(error.__cause__, MemoryError):
            raise error.__cause__ from None
        send(line, Refusal(str(error)))
        return None
    except Missing as error:
        send(line, Failure(Status.MISSING, str(error)))
        return None
    return Loaded(module)


def questions(stream: BinaryIO) -> Iterator[Question]:
    """Yield what is asked, until the other end is closed."""
    while prefix := stream.read(PREFIX.size):
        head, body = lengths(prefix)
        yield unpacked(Question, stream.read(head), stream.read(body))


def send(
    line: socket.socket,
    answer: EngineInfo | Trajectory | SensorReadings | Ready | Sample | Failure | Refusal | Ended | Array | str,
) -> None:
    """Send an answer.  Raises TypeError where it holds what is no plain value."""
    for part in frame(answer):
        line.sendall(part)


def more_than(memory_limit: int) -> str:
    """Say that an engine wanted more memory [B] than it may have."""
    return f"more than {memory_limit / 2**30:.3g} GiB of memory (--memory-limit)"
