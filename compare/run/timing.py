"""What is timed together: the parent's side of the timers that stand in the workers."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial

from compare.run.flight import legs
from compare.run.participants import Participant
from compare.run.readings import USUAL, Reading, Sampling, round_robin
from compare.run.tasks import Task, run
from compare.run.timer import Pace, Ready
from compare.run.worker import Failure
from scenarios.scene import Scene


@dataclass(frozen=True, eq=False)
class Load:
    """A contestant as it is built for a scene, with what of its OPTIONAL is kept."""

    participant: Participant
    scene: Scene
    method: str
    keep: frozenset[str] = frozenset()

    @property
    def by_step(self) -> bool:
        """Whether the clock's unit is a step and not a flight."""
        return not self.participant.takes_own_steps(self.method)

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

    One whose process ends in the middle has samples that are not a number.
    """
    ready = dict(zip(loads, run([making_ready(key, load) for key, load in loads.items()]), strict=True))
    able = [key for key, shown in ready.items() if not isinstance(shown, Failure)]
    readings = round_robin({key: partial(loads[key].participant.sample, key) for key in able}, *sampling)
    return {key: shown if isinstance(shown, Failure) else Cost(readings[key], shown) for key, shown in ready.items()}


def making_ready(key: str, load: Load) -> Task[Ready | Failure]:
    """Return the task of making a load's timer ready, which engines do side by side: nothing of it is compared."""
    return Task(
        (load.scene.name, key),
        load.participant,
        lambda able: able.prepare_timer(key, load.scene, load.method, load.pace, load.keep),
    )
