"""Run times as ratios to one reference contestant, sampled in the same rounds: all that two machines have in common."""

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import replace

from compare.check.schemas import TimeRow
from compare.judge.cost import REFERENCE, time_runs
from compare.judge.errors import Run
from compare.run.flight import Trajectory
from compare.run.participants import Participant, launched
from compare.run.readings import ratio
from scenarios.scene import Scene


def time_rows(
    participants: Sequence[Participant], scene: Scene, runs: Sequence[Run], tick: Callable[[str], object]
) -> Iterator[TimeRow]:
    """Yield the time of every flight of one scene over the reference contestant's, which joins where it was not asked.

    A ratio whose interval says nothing is left empty.
    """
    flown = [run for run in runs if isinstance(run.answer, Trajectory)]
    with ExitStack() as guests:
        present = list(participants)
        if not any(run.name == REFERENCE for run in flown):
            (guest,) = guests.enter_context(launched([REFERENCE]))
            answer = guest.fly(scene, guest.methods[0], scene.step)
            flown.append(Run(scene, guest.title, guest.methods[0], scene.step, answer, None))
            present = [each for each in present if each.title != guest.title] + [guest]
        found, _ = time_runs(present, scene, flown)
    tick("timed")
    timed = {each.run.name: each for each in found}
    unit = timed.get(REFERENCE)
    for run in runs:
        if each := timed.get(run.name):
            figures: tuple[float | None, ...] = (None, None, None)
            if unit is not None:
                # Both flights are so many times what their readings are of.
                scale = each.flight_ns / each.reading.ns * unit.reading.ns / unit.flight_ns
                found_ratio = ratio(each.reading, unit.reading) * scale
                if not found_ratio.refusal:
                    figures = found_ratio.value, found_ratio.low, found_ratio.high
            yield TimeRow(scene.name, run.engine, run.method, REFERENCE, *figures)


def nearer(before: Sequence[TimeRow], found: Sequence[TimeRow], again: Sequence[TimeRow]) -> Iterator[TimeRow]:
    """Yield the times found, each as what is nearer to the one before: itself, or what was found of it again."""
    ratios = {row.key: row.time_ratio for row in before}
    repeated = {row.key: row for row in again}
    for row in found:
        other = repeated.get(row.key, row)
        old, first, second = ratios.get(row.key), row.time_ratio, other.time_ratio
        if not first or not second:
            yield replace(row, time_ratio=None, time_ratio_low=None, time_ratio_high=None)
        elif old and abs(math.log(second / old)) < abs(math.log(first / old)):
            yield other
        else:
            yield row
