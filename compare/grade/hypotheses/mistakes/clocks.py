"""Mistakes with the clock: the logged time is not the time that the physics has reached."""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from itertools import product

import numpy as np

from tumble.compare.grade.hypotheses.hypothesis import Context, Hypothesis, grid
from tumble.compare.grade.hypotheses.names import BODY_NEVER_MOVES, CLOCK_OFFSET, CLOCK_RATE
from tumble.compare.grade.model.program_model import LINEAR, SLERP, ProgramModel, in_ticks
from tumble.scenarios.frames import Array

# Largest offset as a share of the duration, and largest ratio of rates on a fine grid.
FURTHEST, FASTEST = 0.2, 1.3
# Larger rates.
FASTER = (1.5, 2.0, 3.0, 4.0, 5.0, 10.0)
# Largest distance of two first values, in radians of the body's rotation.
TURN = 0.4
# An unusual tick is possible only with at least this many rows; fewer may fit by chance.
ROWS_FOR_A_TICK = 10
# More ticks in a run are not estimated, only tried if the tick has a name.
MOST_TICKS = 2000
# Ranges around the best tick that are tried more densely, of the spacing before.
CLOSER = (1.0, 0.04)
WHOLE_HZ = (5, 8, 10, 12, 15, 16, 20, 24, 25, 30, 32, 40, 48, 50, 60, 64, 72, 75, 80, 90, 100, 120, 128, 144, 200, 240)
BEHIND = {0.0: "", 1.0: ", one step late"}
BETWEEN = {SLERP: "", LINEAR: " (quaternion linearly)"}
LAGS = (
    (0.0, "physics moves in whole steps of {} s, up to one behind the clock"),
    (0.5, "physics moves in whole steps of {} s, half a step to one and a half behind the clock"),
    (1.0, "physics moves in whole steps of {} s, one to two behind the clock"),
    (-0.5, "physics moves in whole steps of {} s, the one nearest to the clock"),
)


def clocks(context: Context) -> Iterator[Hypothesis]:
    """Yield an offset, a rate, and physics in whole steps under a continuous clock."""
    reach = FURTHEST * context.duration
    half = int(np.clip(reach / (TURN * context.turn_s), 10, 30))
    yield Hypothesis(
        CLOCK_OFFSET,
        "clock offset",
        "physics {} s ahead of the logged clock",
        lambda program, offset: _clocked(program, offset=offset),
        tuple(np.linspace(-reach, reach, 2 * half + 2).tolist()),
        named_values={sign * context.spacing_s: name for sign, name in ((1.0, "one row"), (-1.0, "one row late"))},
        unit="s",
    )
    half = int(np.clip(np.log(FASTEST) * context.duration / (TURN * context.turn_s), 10, 40))
    yield Hypothesis(
        CLOCK_RATE,
        "clock rate",
        "physics {} times as fast as the logged clock",
        lambda program, rate: _clocked(program, rate=rate),
        (*(1 / rate for rate in reversed(FASTER)), *grid(1 / FASTEST, FASTEST, 2 * half), *FASTER),
        named_values={0.5: "half", 2.0: "double"} | dict.fromkeys((*FASTER, *(1 / rate for rate in FASTER)), ""),
    )
    yield from _ticks(context)
    yield from _stops(context)


def _stops(context: Context) -> Iterator[Hypothesis]:
    """Yield that the body never moves, or stops."""
    yield Hypothesis(
        BODY_NEVER_MOVES,
        "clock rate",
        "the body never moves",
        lambda program, _: _clocked(program, rate=0.0),
        rare=True,
    )
    yield Hypothesis(
        "body-stops",
        "clock stop",
        "the body stops at t = {} s, as if put to sleep",
        lambda program, instant: _clocked(program, stop=instant),
        tuple(np.linspace(0.0, context.duration, 40).tolist()),
        rare=True,
        unit="s",
    )


def _ticks(context: Context) -> Iterator[Hypothesis]:
    """Yield that the physics moves in whole steps; for few rows, only usual steps."""
    longest = min(0.25 * context.duration, context.turn_s)
    used = {tick: name for tick, name in context.ticks.items() if tick < longest}
    few = context.rows < ROWS_FOR_A_TICK
    values = tuple(sorted(used)) if few else tuple(sorted({*grid(longest / 50, longest, 16), *used}))
    # Interpolated rows depend smoothly on the tick only near the right one, so all whole rates are tried.
    rates = {1 / rate: f"1/{rate} s" for rate in WHOLE_HZ if context.spacing_s / 2 < 1 / rate < longest}
    between_rows = rates | used
    for (lag, delay), (interpolation, how) in product(BEHIND.items(), BETWEEN.items()) if between_rows else ():
        yield Hypothesis(
            "interpolated-rows",
            "clock tick",
            f"physics moves in whole steps of {{}} s{delay}, and rows between two are interpolated{how}",
            lambda program, tick, lag=lag, interpolation=interpolation: _clocked(
                program, tick=tick, lag=lag, interpolation=interpolation
            ),
            tuple(sorted(between_rows)),
            named_values=between_rows,
            only_named=True,
            rare=True,
            variant=bool(lag or how),
            unit="s",
        )
    for lag, text in LAGS if values else ():
        yield Hypothesis(
            "fixed-physics-step",
            "clock tick",
            text,
            lambda program, tick, lag=lag: _clocked(program, tick=tick, lag=lag),
            values,
            named_values=used,
            only_named=few,
            unit="s",
            estimator=partial(_tick, max(min(values), context.duration / MOST_TICKS), max(values), lag),
        )


def _tick(shortest: float, longest: float, lag: float, logged: Array, nearest: Array) -> float:
    """Return the tick [s] whose whole steps fit best, from logged times and the nearest times of a run [s], (S,), (S,).

    The number of ticks up to the last row changes by one if 1/tick changes by 1/duration.  Ticks are tried four times
    as densely, then more densely around the best.  Deviations are averaged without squares: near the right tick most
    rows fit, and a few are off by a whole tick.
    """
    if not logged[-1] > 0:
        return longest  # a clock that does not advance
    apart = 1 / (4 * logged[-1])

    def best(frequencies: Array) -> float:
        off = np.abs(in_ticks(logged, 1 / frequencies[:, None], lag).clip(min=0.0) - nearest).mean(axis=1)
        return float(frequencies[np.argmin(off)])

    found = best(np.arange(1 / longest, 1 / shortest + apart, apart))
    for closer in CLOSER:
        found = best(found + apart * closer * np.linspace(-1, 1, 81))
    return float(np.clip(1 / found, shortest, longest))


def _clocked(program: ProgramModel, **changes: float) -> ProgramModel:
    return replace(program, clock=program.clock._replace(**changes))  # type: ignore[arg-type]
