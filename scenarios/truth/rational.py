"""Fractions: gmpy2's, which are many times as fast, or Python's where there is no gmpy2 (None); vectors of them."""

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from fractions import Fraction

    gmpy2: Any  # its types lack most of what it has
else:
    try:
        import gmpy2
        from gmpy2 import mpq as Fraction  # noqa: N812
    except ImportError:
        from fractions import Fraction

        gmpy2 = None

__all__ = ["Fraction", "cross", "gmpy2"]


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return a x b of two vectors, (3,), of any kind of number: numpy's takes ten times as long for one pair."""
    return np.array((a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]))
