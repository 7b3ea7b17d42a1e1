"""Run times as ratios to one reference contestant, sampled in the same rounds, which two machines can compare."""

from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd

from tumble.compare.check.schemas import TIMES, TimeRow
from tumble.compare.judge.cost import REFERENCE, time_runs
from tumble.compare.judge.errors import Run
from tumble.compare.run.flight import Trajectory
from tumble.compare.run.progress import ProgressCallback
from tumble.compare.run.running_engines import RunningEngine, launched
from tumble.compare.run.timing.readings import ratio
from tumble.scenarios.scene import Scene


def time_rows(
    running_engines: Sequence[RunningEngine], scene: Scene, runs: Sequence[Run], on_progress: ProgressCallback
) -> Iterator[TimeRow]:
    """Yield the time of every run of one scene over the reference contestant's, which joins if it was not asked for.

    An untimed run has no row; without a time of the reference all are empty.
    """
    finished = [run for run in runs if isinstance(run.answer, Trajectory)]
    with ExitStack() as guests:
        present = list(running_engines)
        if not any(run.name == REFERENCE for run in finished):
            (guest,) = guests.enter_context(launched([REFERENCE]))
            answer = guest.simulate(scene, guest.methods[0], scene.step)
            finished.append(
                Run(scene=scene, engine=guest.title, method=guest.methods[0], dt=scene.step, answer=answer, truth=None)
            )
            present = [each for each in present if each.title != guest.title] + [guest]
        found, _ = time_runs(present, scene, finished)
    on_progress("timed")
    timed = {each.run.name: each for each in found}
    unit = timed.get(REFERENCE)
    for run in runs:
        if each := timed.get(run.name):
            row = TimeRow(scene=scene.name, engine=run.engine, method=run.method, reference=REFERENCE)
            if unit is not None:
                found_ratio = ratio(each.reading, unit.reading)
                if not found_ratio.refusal:
                    # From the times of the readings to those of the whole runs.
                    found_ratio *= each.run_ns / each.reading.ns * unit.reading.ns / unit.run_ns
                    row = replace(
                        row,
                        time_ratio=found_ratio.value,
                        time_ratio_low=found_ratio.low,
                        time_ratio_high=found_ratio.high,
                    )
            yield row


def nearer(before: pd.DataFrame, found: pd.DataFrame, again: pd.DataFrame) -> pd.DataFrame:
    """Return the times found, each as measured once or again, whichever is nearer to the one before.

    A time that was not measured both times is left empty.
    """
    key, figures = list(TIMES.key), ["time_ratio", "time_ratio_low", "time_ratio_high"]
    old, first, second = (each.set_index(key)[figures] for each in (before, found, again))
    either: Any = pd.concat([second, first])
    second = either[~either.index.duplicated()].reindex(first.index)
    known: Any = old.time_ratio.reindex(first.index)
    off = [np.log(each.time_ratio / known).abs() for each in (first, second)]
    nearest: Any = first.mask(off[1] < off[0], second)
    nearest[~(first.time_ratio > 0) | ~(second.time_ratio > 0)] = np.nan
    return nearest.reset_index()[TIMES.names]
