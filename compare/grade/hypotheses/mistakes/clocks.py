"""Mistakes with the clock: what is written down as t is not the time that the physics has reached."""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from itertools import product

import numpy as np

from tumble.compare.grade.hypotheses.hypothesis import Hypothesis, Question, grid
from tumble.compare.grade.model.program_model import ALONG_ARCS, STRAIGHT, Account, in_ticks
from tumble.scenarios.frames import Array

# An offset of up to this share of the duration, a rate of up to this ratio.
FURTHEST, FASTEST = 0.2, 1.3
# Rates beyond.
FASTER = (1.5, 2.0, 3.0, 4.0, 5.0, 10.0)
# Of a radian of the body's turn, which no two values tried first are further apart.
TURN = 0.4
# A tick that nobody uses is believed where so many rows show it; fewer could be met by chance.
ROWS_FOR_A_TICK = 10
# More ticks of a flight than this are not sought, only tried where they have a name.
MOST_TICKS = 2000
# How far from the best tick others are tried, in turn, of what they were apart.
CLOSER = (1.0, 0.04)
WHOLE_HZ = (5, 8, 10, 12, 15, 16, 20, 24, 25, 30, 32, 40, 48, 50, 60, 64, 72, 75, 80, 90, 100, 120, 128, 144, 200, 240)
NEVER_MOVES = "never moves"
BEHIND = {0.0: "", 1.0: ", one step late"}
BETWEEN = {ALONG_ARCS: "", STRAIGHT: " (the quaternion straight)"}
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
        known={sign * question.spacing_s: name for sign, name in ((1.0, "one row"), (-1.0, "one row late"))},
        unit="s",
    )
    half = int(np.clip(np.log(FASTEST) * question.duration / (TURN * question.turn_s), 10, 40))
    yield Hypothesis(
        "clock rate",
        "clock rate",
        "physics {} times as fast as the clock that was written down",
        lambda account, rate: _clocked(account, rate=rate),
        (*(1 / rate for rate in reversed(FASTER)), *grid(1 / FASTEST, FASTEST, 2 * half), *FASTER),
        known={0.5: "half", 2.0: "double"} | dict.fromkeys((*FASTER, *(1 / rate for rate in FASTER)), ""),
    )
    yield from _ticks(question)
    yield from _stops(question)


def _stops(question: Question) -> Iterator[Hypothesis]:
    """Yield that the body never moves, or stops for good."""
    yield Hypothesis(
        NEVER_MOVES,
        "clock rate",
        "the body never moves",
        lambda account, _: _clocked(account, rate=0.0),
        rare=True,
    )
    yield Hypothesis(
        "stops",
        "clock stop",
        "the body stops at t = {} s, as if it had fallen asleep",
        lambda account, instant: _clocked(account, stop=instant),
        tuple(np.linspace(0.0, question.duration, 40).tolist()),
        rare=True,
        unit="s",
    )


def _ticks(question: Question) -> Iterator[Hypothesis]:
    """Yield the hypotheses that physics moves in whole steps; of a few rows only steps that somebody uses."""
    longest = min(0.25 * question.duration, question.turn_s)
    used = {tick: name for tick, name in question.ticks.items() if tick < longest}
    few = question.rows < ROWS_FOR_A_TICK
    values = tuple(sorted(used)) if few else tuple(sorted({*grid(longest / 50, longest, 16), *used}))
    # Rows between ticks are smooth in the tick, but only near the right one: those of whole rates are tried, each.
    rates = {1 / rate: f"1/{rate} s" for rate in WHOLE_HZ if question.spacing_s / 2 < 1 / rate < longest}
    between_rows = rates | used
    for (late, when), (between, how) in product(BEHIND.items(), BETWEEN.items()) if between_rows else ():
        yield Hypothesis(
            "interpolated rows",
            "clock tick",
            f"physics moves in whole steps of {{}} s{when}, and rows between two are interpolated{how}",
            lambda account, tick, late=late, between=between: _clocked(account, tick=tick, lag=late, between=between),
            tuple(sorted(between_rows)),
            known=between_rows,
            only_known=True,
            rare=True,
            variant=bool(late or how),
            unit="s",
        )
    for lag, says in LAGS if values else ():
        yield Hypothesis(
            "fixed physics step",
            "clock tick",
            says,
            lambda account, tick, lag=lag: _clocked(account, tick=tick, lag=lag),
            values,
            known=used,
            only_known=few,
            unit="s",
            sought=partial(_tick, max(min(values), question.duration / MOST_TICKS), max(values), lag),
        )


def _tick(shortest: float, longest: float, lag: float, written: Array, reached: Array) -> float:
    """Return the tick [s] whose whole steps are nearest to the instants reached, given those written [s], (S,).

    The last row's count of ticks changes by one where 1/tick does by 1/duration: ticks are tried four times as densely,
    then more densely about the best.  By the mean of lengths, not of squares: near the right tick most rows fit, and a
    few are off by all of it.
    """
    if not written[-1] > 0:
        return longest  # a clock that stands still
    apart = 1 / (4 * written[-1])

    def best(frequencies: Array) -> float:
        off = np.abs(in_ticks(written, 1 / frequencies[:, None], lag).clip(min=0.0) - reached).mean(axis=1)
        return float(frequencies[np.argmin(off)])

    found = best(np.arange(1 / longest, 1 / shortest + apart, apart))
    for closer in CLOSER:
        found = best(found + apart * closer * np.linspace(-1, 1, 81))
    return float(np.clip(1 / found, shortest, longest))


def _clocked(account: Account, **changes: float) -> Account:
    return replace(account, clock=account.clock._replace(**changes))  # type: ignore[arg-type]
