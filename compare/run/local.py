"""An engine of the calling program, run in its process: not isolated, and a hang there is a hang here."""

from collections.abc import Callable
from dataclasses import dataclass
from types import ModuleType, SimpleNamespace
from typing import Any

from tumble.compare.run.engines.registry import EngineInfo, engine_info
from tumble.compare.run.engines.step_function import StepEngine
from tumble.compare.run.flight import Trajectory
from tumble.compare.run.questions import (
    Ended,
    Loaded,
    PrepareTimer,
    Question,
    ReadSensors,
    RunCheck,
    Simulate,
    StepMatrices,
    TakeSample,
    failure_of,
)
from tumble.compare.run.sensing import SensorReadings
from tumble.compare.run.status import Failure
from tumble.compare.run.timing.timer import Pace, Ready, Sample
from tumble.scenarios.frames import Array
from tumble.scenarios.scene import Scene

NOT_ISOLATED = "a function of the calling program: not isolated, timed in Python"


@dataclass(eq=False)
class LocalEngine:
    """An engine that is no file.

    Parameters
    ----------
    name : name of the engine in tables
    module : what an engine file would have as a module
    """

    name: str
    module: ModuleType

    @classmethod
    def of_step(cls, step: Callable[..., Any], name: str, **stated: Any) -> "LocalEngine":
        """Return the engine of a function step(state, dt, body); stated: FEATURES, GYROSCOPIC, ORDERS, EXEMPT."""
        about = {"version": NOT_ISOLATED, "precision": "double", **stated.pop("ABOUT", {})}
        return cls(name, StepEngine(SimpleNamespace(__name__=name, step=step, ABOUT=about, **stated)))  # type: ignore[arg-type]


# How a contestant is named to a study: by words as on the command line, or as it is.
Asked = str | LocalEngine


class LocalWorker:
    """Answers as a Worker does, in this process and without its limits; who interrupts it interrupts the caller.

    Parameters
    ----------
    engine : the engine
    time_limit : limit of a Worker [s]; recorded here, not enforced
    """

    memory_limit = 0
    alive = True
    source = ""

    def __init__(self, engine: LocalEngine, time_limit: float) -> None:
        self.engine, self.time_limit = engine.name, time_limit
        self._local, self._loaded = engine, Loaded(engine.module)

    def renewed(self) -> "LocalWorker":
        """Return another one of the same engine."""
        return LocalWorker(self._local, self.time_limit)

    def describe(self) -> EngineInfo:
        """Return what the engine says of itself.  Raises BadEngine."""
        return engine_info(self.engine, self._loaded.module)

    def simulate(
        self, scene: Scene, method: str, dt: float, keep: frozenset[str] = frozenset(), probe: bool = False
    ) -> Trajectory | Failure:
        """Return the run, or why there is none."""
        return self._answer(Simulate(scene, method, dt, keep, probe))

    def read_sensors(self, scene: Scene, method: str, dt: float) -> SensorReadings | Failure:
        """Return what the scene's sensors read, or why they cannot be read."""
        return self._answer(ReadSensors(scene, method, dt))

    def prepare_timer(
        self, key: str, scene: Scene, method: str, pace: Pace, keep: frozenset[str] = frozenset()
    ) -> Ready | Failure:
        """Make a timer ready under that key; return what that has shown, or why it cannot be."""
        return self._answer(PrepareTimer(key, scene, method, pace, keep))

    def sample(self, key: str) -> Sample | Failure:
        """Return one sample of that timer."""
        return self._answer(TakeSample(key))

    def step_matrices(self, method: str, s: float, c: float, h: Array) -> Array | Failure:
        """Return what the engine's own scheme makes of u'' + c u' + s u = 0 in steps h [s]."""
        return self._answer(StepMatrices(method, s, c, h))

    def check_failure(self, check: str, method: str) -> str | Failure:
        """Return why a check of the engine contract fails for a method, '' if it passes."""
        return self._answer(RunCheck(check, method))

    def close(self) -> None:
        """Keep nothing."""
        self._loaded.timers.clear()

    def kill(self) -> None:
        """Do nothing: the caller's own interrupt ends what runs here."""

    def _answer(self, question: Question) -> Any:
        try:
            return question.answer(self._loaded)
        except Exception as error:
            failed = failure_of(error)
            return failed.failure if isinstance(failed, Ended) else failed
