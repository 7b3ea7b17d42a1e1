"""Fractions: gmpy2's, which are many times as fast, or Python's where there is no gmpy2."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from fractions import Fraction
else:
    try:
        from gmpy2 import mpq as Fraction  # noqa: N812
    except ImportError:
        from fractions import Fraction

__all__ = ["Fraction"]
