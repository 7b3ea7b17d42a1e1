"""Mistakes with the clock: what is written down as t is not the time that the physics has reached."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from compare.grade.account import Account
from compare.grade.hypotheses import STEPS, Hypothesis, Question, grid

# An offset of up to this share of the duration, a rate of up to this ratio.
FURTHEST, FASTEST = 0.2, 1.3
# Of a radian of the body's turn, which no two values tried first are further apart.
TURN = 0.4
# A tick that nobody uses is believed where so many rows show it; fewer could be met by chance.
ROWS_FOR_A_TICK = 10
LAGS = (
    (0.0, "physics moves in whole steps of {} s, up to one behind the clock"),
    (0.5, "physics moves in whole steps of {} s, half a step to one and a half behind the clock"),
    (1.0, "physics moves in whole steps of {} s, one to two behind the clock"),
    (-0.5, "physics moves in whole steps of {} s, the one nearest to the clock"),
)


def clocks(question: Question) -> Iterator[Hypothesis]:
    """Yield offset, rate, and physics in whole steps beneath a clock that runs on."""
    reach = FURTHEST * question.duration
    half = int(np.clip(reach / (TURN * question.turn_s), 10, 30))
    yield Hypothesis(
        "clock offset",
        "clock offset",
        "physics {} s ahead of the clock that was written down",
        lambda account, offset: _clocked(account, offset=offset),
        tuple(np.linspace(-reach, reach, 2 * half + 2).tolist()),
    )
    half = int(np.clip(np.log(FASTEST) * question.duration / (TURN * question.turn_s), 10, 40))
    yield Hypothesis(
        "clock rate",
        "clock rate",
        "physics {} times as fast as the clock that was written down",
        lambda account, rate: _clocked(account, rate=rate),
        (0.5, *grid(1 / FASTEST, FASTEST, 2 * half), 2.0),
        known={0.5: "half", 2.0: "double"},
    )
    yield from _ticks(question)


def _ticks(question: Question) -> Iterator[Hypothesis]:
    """Yield the hypotheses that physics moves in whole steps; of a few rows only steps that somebody uses."""
    longest = min(0.25 * question.duration, question.turn_s)
    used = {tick: name for tick, name in STEPS.items() if tick < longest}
    few = question.rows < ROWS_FOR_A_TICK
    values = tuple(sorted(used)) if few else tuple(sorted({*grid(longest / 50, longest, 16), *used}))
    for lag, says in LAGS if values else ():
        yield Hypothesis(
            "fixed physics step",
            "clock tick",
            says,
            lambda account, tick, lag=lag: _clocked(account, tick=tick, lag=lag),
            values,
            known=used,
            only_known=few,
            spacing=lambda tick: tick * tick / (2 * question.duration),
        )


def _clocked(account: Account, **changes: float) -> Account:
    return replace(account, clock=account.clock._replace(**changes))
