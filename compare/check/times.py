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
from compare.run.timer import steady_ratio
from scenarios.scene import Scene


def time_rows(
    participants: Sequence[Participant], scene: Scene, runs: Sequence[Run], tick: Callable[[str], object]
) -> Iterator[TimeRow]:
    """Yield the time of every flight of one scene over the reference contestant's, which joins where it was not asked.

    A ratio is kept only where two passes of the clock agree on it.
    """
    flown = [run for run in runs if isinstance(run.answer, Trajectory)]
    with ExitStack() as guests:
        present = list(participants)
        if not any(run.name == REFERENCE for run in flown):
            (guest,) = guests.enter_context(launched([REFERENCE]))
            answer = guest.fly(scene, guest.methods[0], scene.step)
            flown.append(Run(scene, guest.title, guest.methods[0], scene.step, answer, None))
            present = [each for each in present if each.title != guest.title] + [guest]
        found = time_runs(present, scene, flown)
    tick("timed")
    timed = {each.run.name: each for each in found}
    unit = timed.get(REFERENCE)
    for run in runs:
        if each := timed.get(run.name):
            steady = unit is not None and steady_ratio(each.reading, unit.reading)
            ratio = each.flight_ns / unit.flight_ns if unit is not None and steady else None
            yield TimeRow(scene.name, run.engine, run.method, REFERENCE, ratio)


def nearer(before: Sequence[TimeRow], found: Sequence[TimeRow], again: Sequence[TimeRow]) -> Iterator[TimeRow]:
    """Yield the times found, each as what is nearer to the one before: itself, or what was found of it again."""
    ratios = {row.key: row.time_ratio for row in before}
    repeated = {row.key: row.time_ratio for row in again}
    for row in found:
        old, first, second = ratios.get(row.key), row.time_ratio, repeated.get(row.key, row.time_ratio)
        if not first or not second:
            yield replace(row, time_ratio=None)  # not steady
        elif old and abs(math.log(second / old)) < abs(math.log(first / old)):
            yield replace(row, time_ratio=second)
        else:
            yield row
