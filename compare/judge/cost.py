"""What runs cost: each with the time of its flight, all of a scene sampled in the same rounds."""

from collections.abc import Sequence
from dataclasses import dataclass

from compare.judge.errors import Run
from compare.run.flight import Trajectory
from compare.run.participants import Participant
from compare.run.timer import Reading
from compare.run.timing import Cost, Load, costs
from scenarios.scene import Scene

# Whose times others are told as multiples of, unless another is asked for.
REFERENCE = "tumble:rk4"


@dataclass(frozen=True, eq=False)
class Timed:
    """One run of the ladder with its time: the native loop of one throw's flight [ns], and the reading it comes from.

    call_ns: what one call from Python costs beyond the native loop, not in flight_ns.
    """

    run: Run
    flight_ns: float
    reading: Reading
    per_step: bool
    call_ns: float


def time_runs(participants: Sequence[Participant], scene: Scene, runs: Sequence[Run]) -> list[Timed]:
    """Return the runs that flew and could be timed, each with its time."""
    by_title = {participant.title: participant for participant in participants}
    flown = [run for run in runs if isinstance(run.answer, Trajectory)]
    loads = {run.name: Load(by_title[run.engine], scene, run.method) for run in flown}
    found = costs(loads)
    return [timed(run, loads[run.name], found[run.name]) for run in flown if run.name in found]


def timed(run: Run, load: Load, cost: Cost) -> Timed:
    """Return a run with its time: its steps times the cost of one, or of a flight as it is."""
    flight_ns = cost.reading.ns * (run.flight.steps if load.by_step else 1)
    return Timed(run, flight_ns / len(load.scene.start), cost.reading, load.by_step, cost.call_ns)
