"""Run times as ratios to one reference contestant, sampled in the same rounds, which two machines can compare."""

from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd

from tumble.compare.check.schemas import TIMES, TimeRow
from tumble.compare.judge.cost import REFERENCE, Timed, time_runs
from tumble.compare.judge.errors import Run
from tumble.compare.run.flight import Trajectory
from tumble.compare.run.running_engines import RunningEngine, launched
from tumble.compare.run.timing.readings import ratio
from tumble.scenarios.scene import Scene


def time_rows(
    running_engines: Sequence[RunningEngine], scenes: Sequence[tuple[Scene, Sequence[Run]]]
) -> Iterator[TimeRow]:
    """Yield the time of every run over the reference contestant's of its scene, which joins where it was not asked for.

    An untimed run has no row; without a time of the reference all of its scene are empty.
    """
    finished = [(scene, [run for run in runs if isinstance(run.answer, Trajectory)]) for scene, runs in scenes]
    alone = [number for number, (_, runs) in enumerate(finished) if not any(run.name == REFERENCE for run in runs)]
    with ExitStack() as guests:
        present = list(running_engines)
        if alone:
            (guest,) = guests.enter_context(launched([REFERENCE]))
            present = [each for each in present if each.title != guest.title] + [guest]
            for number in alone:
                finished[number][1].append(own_run(guest, finished[number][0]))
        times = time_runs(present, finished)
    for (scene, runs), (found, _) in zip(scenes, times, strict=True):
        timed = {each.run.name: each for each in found}
        unit = timed.get(REFERENCE)
        yield from (row_of(scene, each, unit) for run in runs if (each := timed.get(run.name)))


def own_run(guest: RunningEngine, scene: Scene) -> Run:
    """Return the reference contestant's run of a scene."""
    (method,) = guest.methods
    answer = guest.simulate(scene, method, scene.step)
    return Run(scene=scene, engine=guest.title, method=method, dt=scene.step, answer=answer, truth=None)


def row_of(scene: Scene, each: Timed, unit: Timed | None) -> TimeRow:
    """Return the time of one run over that of the reference contestant, empty without one."""
    row = TimeRow(scene=scene.name, engine=each.run.engine, method=each.run.method, reference=REFERENCE)
    if unit is None or (found := ratio(each.reading, unit.reading)).refusal:
        return row
    # From the times of the readings to those of the whole runs.
    found *= each.run_ns / each.reading.ns * unit.reading.ns / unit.run_ns
    return replace(row, time_ratio=found.value, time_ratio_low=found.low, time_ratio_high=found.high)


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
