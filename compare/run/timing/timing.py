"""What is timed together: the parent's side of the timers that stand in the workers."""

from collections.abc import Mapping
from dataclasses import dataclass

from tumble.compare.run.execution import EXECUTION
from tumble.compare.run.flight import legs
from tumble.compare.run.local import LocalWorker
from tumble.compare.run.running_engines import RunningEngine
from tumble.compare.run.status import Failure, Status
from tumble.compare.run.tasks import Task, work
from tumble.compare.run.timing.readings import GONE, USUAL, Reading, Sampling, load_seen, round_robin
from tumble.compare.run.timing.timer import Pace, Ready, Sample
from tumble.compare.run.worker import Worker
from tumble.scenarios.scene import Scene


@dataclass(frozen=True, eq=False)
class Load:
    """A contestant as it is built for a scene, with what of its OPTIONAL is kept."""

    running_engine: RunningEngine
    scene: Scene
    method: str
    keep: frozenset[str] = frozenset()

    @property
    def by_step(self) -> bool:
        """Whether the clock's unit is a step and not a flight."""
        return not self.running_engine.takes_own_steps(self.method)

    @property
    def pace(self) -> Pace:
        """What a sample asks for: steps of the scene's own length, or the legs of a flight."""
        if self.by_step:
            return Pace(((1, self.scene.step),), True)
        return Pace(tuple((leg.n, leg.dt) for leg in legs(self.scene, self.scene.duration)), False)


@dataclass(frozen=True, eq=False)
class Cost:
    """What the clock said: of a step or of a flight, and what making its timer ready has shown."""

    reading: Reading
    ready: Ready


def costs(loads: Mapping[str, Load], sampling: Sampling = USUAL) -> dict[str, Cost | Failure]:
    """Return what each load costs, all sampled in the same rounds, or why it cannot be timed.

    Whatever becomes of one, the others have their times.
    """
    if (elsewhere := EXECUTION.get().times) and (found := elsewhere(loads, sampling)) is not None:
        return found
    timers = {key: StandingTimer(key, load) for key, load in loads.items()}
    # Engines make theirs ready side by side: nothing of it is compared.
    ready = dict(zip(loads, work([timer.task for timer in timers.values()]), strict=True))
    readings = round_robin(
        {key: timers[key].sample for key, shown in ready.items() if not isinstance(shown, Failure)}, *sampling
    )
    return {
        key: shown if isinstance(shown, Failure) else believed(readings[key], shown) for key, shown in ready.items()
    }


def believed(reading: Reading | Failure, ready: Ready) -> Cost | Failure:
    """Return the cost that a reading says, or why it says none."""
    if isinstance(reading, Failure):
        return reading if reading.status is Status.UNTIMED else Failure(Status.UNTIMED, f"{GONE}: {reading}")
    return Failure(Status.UNTIMED, f"{reading.doubt}: {load_seen()}") if reading.doubt else Cost(reading, ready)


class StandingTimer:
    """The timer of one load in its engine's process, made anew where another load has ended that process."""

    def __init__(self, key: str, load: Load) -> None:
        self._key, self._load = key, load
        self._worker: Worker | LocalWorker | None = None

    @property
    def task(self) -> Task[Ready | Failure]:
        """What makes it ready for the first time."""
        return Task((self._load.scene.name, self._key), self._load.running_engine, lambda _: self.make())

    def make(self) -> Ready | Failure:
        """Make it ready in the process that there is now; return what that has shown, or why it cannot be."""
        load = self._load
        shown = load.running_engine.prepare_timer(self._key, load.scene, load.method, load.pace, load.keep)
        self._worker = load.running_engine.worker
        return shown

    def sample(self) -> Sample | Failure:
        """Return one sample, or why there is none."""
        running_engine = self._load.running_engine
        if not (running_engine.worker is self._worker and running_engine.worker.alive):
            shown = self.make()
            if isinstance(shown, Failure):
                return shown
        return running_engine.sample(self._key)
