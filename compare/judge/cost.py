"""What runs cost: each with the time of its flight, all sampled in the same rounds."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from tumble.compare.judge.errors import Run
from tumble.compare.run.contestant import Contestant
from tumble.compare.run.flight import Trajectory
from tumble.compare.run.running_engines import RunningEngine
from tumble.compare.run.status import Failure
from tumble.compare.run.timing.readings import USUAL, Reading, Sampling
from tumble.compare.run.timing.timer import Ready
from tumble.compare.run.timing.timing import Cost, Load, costs
from tumble.scenarios.scene import Scene

# Whose times others are told as multiples of, unless another is asked for.
REFERENCE = "tumble:rk4"


@dataclass(frozen=True, eq=False)
class Timed:
    """One run of the ladder with its time.

    Parameters
    ----------
    run : the run
    run_ns : time of the native loop for one throw of the run [ns], without the preparation of the timer
    reading : the timer's samples that run_ns comes from
    per_step : whether the reading is of one step; otherwise it is of the whole run
    ready : what preparing the timer measured
    """

    run: Run
    run_ns: float
    reading: Reading
    per_step: bool
    ready: Ready

    @cached_property
    def error_m(self) -> float:
        """The error the run is judged by: of one throw its own, of many their median [m]."""
        return float(np.median(self.run.throws_errors))


class Times(NamedTuple):
    """The runs of a scene that have a time, and why the others have none, by their names."""

    timed: list[Timed]
    why_untimed: dict[str, str]


def time_runs(
    running_engines: Sequence[RunningEngine],
    scenes: Sequence[tuple[Scene, Sequence[Run]]],
    sampling: Sampling = USUAL,
    reference: str = "",
) -> list[Times]:
    """Return the times of the runs that flew, of each scene: all sampled in the same rounds, a scene's side by side.

    reference: ENGINE:METHOD that the others' times are told as multiples of; empty: none is.
    """
    by_title = {running_engine.title: running_engine for running_engine in running_engines}
    loads = {
        f"{number} {run.name}": Load(by_title[run.engine], scene, run.method)
        for number, (scene, runs) in enumerate(scenes)
        for run in runs
        if isinstance(run.answer, Trajectory)
    }
    units = frozenset(
        f"{number} {run.name}"
        for number, (_, runs) in enumerate(scenes)
        for run in runs
        if Contestant.of(run.engine, run.method).is_among([reference])
    )
    found = costs(loads, sampling._replace(units=units & loads.keys()))
    times = []
    for number, (_, runs) in enumerate(scenes):
        own = [(run, key) for run in runs if (key := f"{number} {run.name}") in loads]
        known = [(run, loads[key], cost) for run, key in own if isinstance(cost := found[key], Cost)]
        untimed = {run.name: str(cost) for run, key in own if isinstance(cost := found[key], Failure)}
        times.append(Times([timed(*each) for each in known], untimed))
    return times


def timed(run: Run, load: Load, cost: Cost) -> Timed:
    """Return a run with its time: its steps times the cost of one, or of a flight as it is."""
    run_ns = cost.reading.ns * (run.flight.steps if load.by_step else 1)
    return Timed(
        run=run, run_ns=run_ns / len(load.scene.start), reading=cost.reading, per_step=load.by_step, ready=cost.ready
    )
