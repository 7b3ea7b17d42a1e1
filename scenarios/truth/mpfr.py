"""Extended-precision numbers of gmpy2's, whose sums and products take a tenth of the time that mpmath's take.

Both round a sum, a product, a quotient or a root to the nearest number of the precision.  Where there is no gmpy2
mpmath's numbers stay.
"""

from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np

from tumble.scenarios.truth.rational import gmpy2

# Tuples of arrays of numbers: principal axes, a pose.
Parts = TypeVar("Parts", bound=tuple)
Found = TypeVar("Found", bound=tuple)


class Mpfr:
    """What the closed form asks of a context, as mpmath has it, at the precision that gmpy2 has meanwhile."""

    def __init__(self, mp: Any) -> None:
        self._mp, self.prec = mp, mp.prec
        self.mpf, self.sqrt, self.atan, self.floor = gmpy2.mpfr, gmpy2.sqrt, gmpy2.atan, gmpy2.floor
        self.sech, self.tanh, self.sign, self.inf = gmpy2.sech, gmpy2.tanh, gmpy2.sign, gmpy2.inf()
        self.zero, self.one, self.pi = gmpy2.mpfr(0), gmpy2.mpfr(1), gmpy2.const_pi()

    @staticmethod
    def cos_sin(x: Any) -> tuple[Any, Any]:
        """Return cosine and sine."""
        sin, cos = gmpy2.sin_cos(x)
        return cos, sin

    @staticmethod
    def ldexp(x: Any, n: int) -> Any:
        """Return 2^n x, exactly."""
        return gmpy2.mul_2exp(x, n) if n >= 0 else gmpy2.div_2exp(x, -n)

    def elliprf(self, *arguments: Any) -> Any:
        """Return Carlson's integral of the first kind."""
        return self.of(self._mp.elliprf(*map(self.back, arguments)))

    def of(self, number: Any) -> Any:
        """Return one of mpmath's numbers, exactly; any other as it is."""
        if not hasattr(number, "man_exp"):
            return number
        mantissa, exponent = number.man_exp
        # It may have more digits than the precision, as principal moments do.
        with gmpy2.context(precision=max(self.prec, mantissa.bit_length())):
            return self.ldexp(gmpy2.mpfr(-mantissa if number < 0 else mantissa), int(exponent))

    def back(self, number: Any) -> Any:
        """Return a number as mpmath's, exactly; any other as it is."""
        if not isinstance(number, gmpy2.mpfr):
            return number
        mantissa, exponent = number.as_mantissa_exp()
        return self._mp.ldexp(mantissa, int(exponent))


def in_mpfr(function: Callable[[Any, Any, Parts], list[Found]], mp: Any, throw: Any, own: Parts) -> list[Found]:
    """Return what a function of a context, a throw and arrays of numbers gives: a list of tuples of such arrays.

    Its numbers are gmpy2's meanwhile; given and returned they are mpmath's.
    """
    if gmpy2 is None:
        return function(mp, throw, own)
    with gmpy2.context(precision=mp.prec, trap_divzero=True, trap_invalid=True):
        fast = Mpfr(mp)
        found = function(fast, throw, _each(fast.of, own))
        return [_each(fast.back, parts) for parts in found]


def _each(change: Callable[[Any], Any], parts: Parts) -> Parts:
    """Return arrays with each of their numbers changed."""
    return type(parts)(
        *(np.array([change(number) for number in part.flat], dtype=object).reshape(part.shape) for part in parts)
    )
