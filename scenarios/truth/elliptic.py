"""Jacobi's elliptic functions and Carlson's integral of the third kind, real arguments, any number of digits.

`mp` is always a context of mpmath whose working precision the caller has set, or mpmath's context of doubles.
"""

from typing import Any, NamedTuple

from tumble.scenarios.truth.rational import Fraction


class Amplitude(NamedTuple):
    """Jacobi's functions at u, and how many half periods 2K were taken off to bring u into [-K, K]."""

    sn: Any
    cn: Any
    dn: Any
    half_periods: int


class JacobiFunctions:
    """sn, cn, dn of one modulus, given by m1 = k'^2 = 1 - m in [0, 1], exact: nothing is lost near the separatrix.

    quarter_period: K, infinite where m1 = 0.
    Source: Bulirsch, "Numerical calculation of elliptic integrals and elliptic functions", Numer. Math. 7 (1965) 78:
    the arithmetic-geometric mean of 1 and k', then Landen's descending steps on cs = cn/sn.
    """

    def __init__(self, mp: Any, m1: Fraction) -> None:
        self._mp = mp
        self._means: list[tuple[Any, Any]] = []
        if m1 == 0:
            self.quarter_period = mp.inf
            return
        arithmetic, geometric = mp.one, mp.sqrt(m1)
        # One step after they agree to half the digits they agree to all: the gap is squared at each.
        gap = arithmetic
        while gap > mp.ldexp(arithmetic, -mp.prec // 2):
            self._means.append((arithmetic, geometric))
            gap = abs(arithmetic - geometric)
            arithmetic, geometric = (arithmetic + geometric) / 2, mp.sqrt(arithmetic * geometric)
        self._mean = arithmetic
        self.quarter_period = mp.pi / (2 * self._mean)

    def __call__(self, u: Any) -> Amplitude:
        """Return sn, cn, dn at u."""
        mp = self._mp
        if self.quarter_period == mp.inf:
            sech = mp.sech(u)
            return Amplitude(mp.tanh(u), sech, sech, 0)
        half_periods = int(mp.floor(u / (2 * self.quarter_period) + 0.5))
        u = u - 2 * half_periods * self.quarter_period
        if u == 0:
            sn, cn, dn = mp.zero, mp.one, mp.one
        else:
            sn, cn, dn = self._descend(u)
        return Amplitude(-sn, -cn, dn, half_periods) if half_periods % 2 else Amplitude(sn, cn, dn, half_periods)

    def _descend(self, u: Any) -> tuple[Any, Any, Any]:
        mp = self._mp
        cos, sin = mp.cos_sin(self._mean * u)
        mean_below, cs, dn = self._mean, self._mean * cos / sin, mp.one
        for arithmetic, geometric in reversed(self._means):
            ratio = cs * cs / mean_below
            cs = cs * dn
            dn = (geometric + ratio) / (arithmetic + ratio)
            mean_below = arithmetic
        sn = mp.sign(u) / mp.sqrt(1 + cs * cs)
        return sn, cs * sn, dn


def third_kind_angle(mp: Any, x: Any, y: Any, z: Any, p: Any, root: Any) -> Any:
    """Return (root / 3) RJ(x, y, z, p), root = sqrt((p - x)(p - y)(p - z)), for x, y, z >= 0 and p > 0: an angle [rad].

    root is asked for because the caller knows it without subtracting; it must be real.
    Source: Carlson, "Numerical computation of real or complex elliptic integrals", Numer. Algorithms 10 (1995) 13,
    sections 2-3, with RC(1, 1 + e) = atan(sqrt e) / sqrt e; last term to the 7th degree: DLMF 19.36.2.
    """
    mean = first_mean = (x + y + z + 2 * p) / 5
    off = [mean - x, mean - y, mean - z]
    # What is left out is of the 8th degree in the spread, which falls by 4 at each duplication.
    spread = mp.ldexp(max(abs(first_mean - p), *map(abs, off)), mp.prec // 8 + 1)
    angle, doublings = mp.zero, 0
    while mp.ldexp(spread, -2 * doublings) > mean:
        root_x, root_y, root_z, root_p = mp.sqrt(x), mp.sqrt(y), mp.sqrt(z), mp.sqrt(p)
        d = (root_p + root_x) * (root_p + root_y) * (root_p + root_z)
        angle += mp.ldexp(mp.atan(mp.ldexp(root / d, -3 * doublings)), doublings + 1)
        shift = root_x * root_y + root_y * root_z + root_z * root_x
        x, y, z, p, mean = (mp.ldexp(value + shift, -2) for value in (x, y, z, p, mean))
        doublings += 1
    X, Y, Z = (mp.ldexp(value, -2 * doublings) / mean for value in off)
    return angle + root / 3 * mp.ldexp(_near_mean(X, Y, Z), -2 * doublings) / (mean * mp.sqrt(mean))


def _near_mean(X: Any, Y: Any, Z: Any) -> Any:
    """Return RJ for a mean of 1 and small deviations X, Y, Z (DLMF 19.36.2)."""
    P = -(X + Y + Z) / 2
    XYZ, PP = X * Y * Z, P * P
    E2 = X * Y + X * Z + Y * Z - 3 * PP
    E3 = XYZ + 2 * P * (E2 + 2 * PP)
    E4 = P * (2 * XYZ + P * (E2 + 3 * PP))
    E5 = XYZ * PP
    return (
        1
        - 3 * E2 / 14
        + E3 / 6
        + 9 * E2**2 / 88
        - 3 * E4 / 22
        - 9 * E2 * E3 / 52
        + 3 * E5 / 26
        - E2**3 / 16
        + 3 * E3**2 / 40
        + 3 * E2 * E4 / 20
        + 45 * E2**2 * E3 / 272
        - 9 * (E3 * E4 + E2 * E5) / 68
    )
