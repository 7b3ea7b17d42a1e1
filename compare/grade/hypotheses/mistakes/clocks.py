"""Mistakes with the clock: the logged time is not the time that the physics has reached."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import product

import numpy as np

from tumble.compare.grade.hypotheses.hypothesis import NEAR, TICKS, Context, Hypothesis, grid
from tumble.compare.grade.hypotheses.names import (
    BODY_NEVER_MOVES,
    CLOCK_OFFSET,
    CLOCK_RATE,
    EXTRAPOLATED_ROWS,
    INTERPOLATED_ROWS,
    LOG_LAG,
)
from tumble.compare.grade.model.kernel.reading import EXTRAPOLATED, LINEAR, SLERP
from tumble.compare.grade.model.program_model import ProgramModel

# Largest offset as a share of the duration, and largest ratio of rates on a fine grid.
FURTHEST, FASTEST = 0.2, 1.3
# Larger rates.
FASTER = (1.5, 2.0, 3.0, 4.0, 5.0, 10.0)
# Largest distance of two first values, in radians of the body's rotation.
TURN = 0.4
# Usual rates of ticks [Hz]; longest tick as a share of the duration, and most ticks in a row interval.
RATES = (20, 24, 25, 30, 40, 48, 50, 60, 72, 75, 90, 100, 120, 144, 165, 200, 240)
LONGEST, MOST_A_ROW = 0.25, 12.0
# Offsets of the clock that are tried, in row intervals: a program is late by a step rather than by a second.
OFFSETS = (0.125, 0.25, 0.5, 1.0, 2.0, 4.0)
# Weight that an unusual way to read rows costs.
UNUSUAL = 4.0
BEHIND = {0.0: "", 1.0: ", one step late"}
BETWEEN = {SLERP: "", LINEAR: " (quaternion linearly)"}
LAGS = (
    (0.0, "up to one behind the clock", 0.0),
    (1.0, "one to two behind the clock", 0.0),
    (0.5, "half a step to one and a half behind the clock", UNUSUAL),
    (-0.5, "the one nearest to the clock", UNUSUAL),
)


def clocks(context: Context) -> Iterator[Hypothesis]:
    """Yield an offset, a rate, and physics in whole steps under a continuous clock."""
    reach = FURTHEST * context.duration
    half = int(np.clip(reach / (TURN * context.turn_s), 10, 30))
    near = [sign * rows * context.spacing_s for sign, rows in product((-1.0, 1.0), OFFSETS)]
    yield Hypothesis(
        CLOCK_OFFSET,
        "clock offset",
        "physics {} s ahead of the logged clock",
        lambda program, offset: _clocked(program, offset=offset),
        tuple(sorted((*near, *np.linspace(-reach, reach, 2 * half + 2).tolist()))),
        named_values={sign * context.spacing_s: name for sign, name in ((1.0, "one row"), (-1.0, "one row late"))},
        unit="s",
        neutral=0.0,
    )
    kinds = [("", _faster)]
    if any(impulse.time > 0 for impulse in context.program.impulses):
        kinds.append((", by which impulses act", _faster_but_for_impulses))
        yield Hypothesis(
            LOG_LAG,
            "clock offset",
            "the body moves from t = {} s on, though impulses act at their times",
            _asleep,
            tuple(np.linspace(0.0, reach, half + 1).tolist()),
            named_values={context.spacing_s: "one row"},
            unit="s",
            neutral=0.0,
        )
    half = int(np.clip(np.log(FASTEST) * context.duration / (TURN * context.turn_s), 10, 40))
    for which, change in kinds:
        yield Hypothesis(
            CLOCK_RATE,
            "clock rate",
            f"physics {{}} times as fast as the logged clock{which}",
            change,
            (*(1 / rate for rate in reversed(FASTER)), *grid(1 / FASTEST, FASTEST, 10 if which else 2 * half), *FASTER),
            named_values={0.5: "half", 2.0: "double"} | dict.fromkeys((*FASTER, *(1 / rate for rate in FASTER)), ""),
            neutral=1.0,
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
    )
    yield Hypothesis(
        "body-stops",
        "clock stop",
        "the body stops at t = {} s, as if put to sleep",
        lambda program, instant: _clocked(program, stop=instant),
        tuple(np.linspace(0.0, context.duration, 40).tolist()),
        unit="s",
        at_ticks=True,
    )


def ticks(context: Context) -> dict[float, str]:
    """Return ticks of programs whose rows are not all at ticks [s], and their names.

    They are usual ones, unless they divide the row interval, and multiples of it.
    """
    spacing, longest = context.spacing_s, LONGEST * context.duration
    rows = {number * spacing: f"{number} rows" for number in TICKS}
    usual = {1 / rate: f"1/{rate} s" for rate in RATES}
    parts = {tick: spacing / tick for tick in usual}
    usual = {
        tick: name
        for tick, name in usual.items()
        if parts[tick] < MOST_A_ROW
        and abs(parts[tick] - round(parts[tick])) > NEAR * parts[tick]
        and all(abs(tick - other) > NEAR * tick for other in rows)
    }
    return {tick: name for tick, name in sorted((usual | rows).items()) if tick < longest}


def _ticks(context: Context) -> Iterator[Hypothesis]:
    """Yield that the physics moves in whole steps, and how rows are read between them."""
    if not (values := ticks(context)):
        return
    kinds = [
        ("fixed-physics-step", f"physics moves in whole steps of {{}} s, {where}", {"lag": lag}, unlikely)
        for lag, where, unlikely in LAGS
    ]
    kinds += [
        (
            INTERPOLATED_ROWS,
            f"physics moves in whole steps of {{}} s{delay}, and rows between two are interpolated{how}",
            {"lag": lag, "interpolation": interpolation},
            0.0,
        )
        for (lag, delay), (interpolation, how) in product(BEHIND.items(), BETWEEN.items())
    ]
    text = "physics moves in whole steps of {} s, and rows between two are moved on at the velocities of the first"
    kinds.append((EXTRAPOLATED_ROWS, text, {"interpolation": EXTRAPOLATED}, UNUSUAL))
    for name, text, changes, unlikely in kinds:
        yield Hypothesis(
            name,
            "clock tick",
            text,
            lambda program, tick, changes=changes: _clocked(program, tick=tick, **changes),
            tuple(values),
            named_values=values,
            only_named=True,
            unit="s",
            unlikely=unlikely,
        )


def _faster(program: ProgramModel, rate: float) -> ProgramModel:
    """Return a program whose clock is slow: its steps are a part of its own time from row to row."""
    scheme = program.scheme._replace(step=rate * program.scheme.step)
    return _clocked(program, rate=rate).but(scheme=scheme, tick=rate * program.tick)


def _asleep(program: ProgramModel, late: float) -> ProgramModel:
    """Return a program whose body does not move at first."""
    impulses = tuple(replace(each, time=max(each.time - late, 0.0)) for each in program.impulses)
    return _clocked(program, offset=-late).but(impulses=impulses)


def _faster_but_for_impulses(program: ProgramModel, rate: float) -> ProgramModel:
    """Return such a program whose impulses act when the logged clock shows their times."""
    moved = tuple(replace(impulse, time=rate * impulse.time) for impulse in program.impulses)
    return _faster(program, rate).but(impulses=moved)


def _clocked(program: ProgramModel, **changes: float) -> ProgramModel:
    return program.but(clock=program.clock._replace(**changes))  # type: ignore[arg-type]
