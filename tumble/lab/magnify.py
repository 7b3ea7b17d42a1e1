"""Magnification: each vertex drawn where it would be if its error were larger by a factor."""

from collections.abc import Iterable

import numpy as np

from tumble.scenarios.frames import Array

FIT, AS_IT_IS = "fit the view", "1"
FACTORS = {
    AS_IT_IS: 1.0,
    "10": 10.0,
    "100": 100.0,
    "1000": 1e3,
    "10\N{SUPERSCRIPT FOUR}": 1e4,
    "10\N{SUPERSCRIPT SIX}": 1e6,
}
MAGNIFIED = (FIT, *FACTORS)
# So large, in radii of the body, an error is drawn that fits; larger than the other it is in no picture as it is.
FITS, IN_VIEW = 0.7, 2.0


def magnified(true: Array, seen: Array, factor: float) -> Array:
    """Return true + factor (seen - true) [m], (n, 3): the true body itself where there is no error."""
    return true + factor * (seen - true)


def fitting(curves: Iterable[Array], limit: Array, radius: float, others: Iterable[float] = ()) -> float:
    """Return the magnification, at most the last of FACTORS, at which the largest error just fits the view.

    curves: largest errors over time [m], (S,) each, NaN where not known; limit: their resolution [m]; radius: of the
    body [m]; others: more errors [m].  A curve that leaves the view unmagnified does not count.  Unknown errors are
    assumed to grow in proportion to time, so that the factor need not change while a throw is watched.
    """
    known = max(int(np.isfinite(limit).sum()) - 1, 1)
    growth = (len(limit) - 1) / known
    largest = [*others, *(growth * float(np.nanmax(curve)) for curve in curves if (curve > limit).any())]
    seen = [one for one in largest if one <= IN_VIEW * radius]
    if not seen:
        return 1.0
    return float(np.clip(rounded_down(FITS * radius / max(seen)), 1.0, max(FACTORS.values())))


def times(factor: float) -> str:
    """Return a factor as it is written, in one piece: 1 000 000."""
    return f"{factor:,.0f}".replace(",", "\N{NO-BREAK SPACE}")


def rounded_down(value: float) -> float:
    """Return the next smaller number that is 1, 2 or 5 times a power of ten."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(power * max(step for step in (1, 2, 5) if step * power <= value * (1 + 1e-12)))
