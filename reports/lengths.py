"""Lengths as text, in a suitable unit."""

import math
from collections.abc import Sequence

from tumble.reports.numerals import superscript
from tumble.scenarios.frames import Array

LENGTHS = (("km", 1e3), ("m", 1.0), ("mm", 1e-3), ("µm", 1e-6), ("nm", 1e-9), ("pm", 1e-12), ("fm", 1e-15))
# Beyond this many of the largest unit, and below this part of the smallest, a power of ten is printed.
BEYOND = 1e4
RULERS = LENGTHS[:5]  # of positions


def length(metres: float) -> str:
    """Return a length in two digits and a suitable unit.

    Parameters
    ----------
    metres : the length [m]

    Returns
    -------
    the text
    """
    if metres == 0.0 or not math.isfinite(metres):
        return f"{metres:g} m"
    unit, size = unit_of(metres)
    return f"{float(f'{metres / size:.2g}'):g} {unit}"


def unit_of(metres: float) -> tuple[str, float]:
    """Return a suitable unit for a length; a power of ten beyond the named units.

    Parameters
    ----------
    metres : the length [m]; if beyond the named units, neither 0 nor infinite

    Returns
    -------
    unit
    its size [m]
    """
    if abs(metres) >= BEYOND * LENGTHS[0][1] or abs(metres) < LENGTHS[-1][1] / BEYOND:
        power = math.floor(math.log10(abs(metres)))
        return f"10{superscript(power)} m", 10.0**power
    return next(((unit, size) for unit, size in LENGTHS if abs(metres) >= 0.9995 * size), LENGTHS[-1])


def ruler(positions: Array, units: Sequence[tuple[str, float]] = RULERS) -> tuple[str, float, int]:
    """Return the unit that positions [m] are printed in, its length [m], and decimals for three digits."""
    largest = float(abs(positions).max())
    unit, metres = next((unit for unit in units if largest >= unit[1]), units[-1])
    return unit, metres, sum(largest < bound * metres for bound in (100, 10))
