"""Rotation of a rigid body that nothing turns: the closed form.

Numbers are exact fractions as long as they are rational, and extended-precision ones after that; vectors and matrices
are numpy arrays of such numbers.  Which branch a motion is on is decided in fractions, where `equal` means equal.
`axes` is the matrix whose columns are the body's axes in the world.
"""

from typing import Any, Protocol

import numpy as np

from tumble.scenarios.truth.elliptic import Amplitude, JacobiFunctions, third_kind_angle
from tumble.scenarios.truth.inertia import Numbers
from tumble.scenarios.truth.rational import Fraction, cross


class Rotation(Protocol):
    """Where a rotating body points, and its angular momentum in body axes."""

    def at(self, t: Fraction) -> tuple[Numbers, Numbers]:
        """Return (axes, L_body [kg m2/s]) at t [s] after the start, (3, 3) and (3,)."""
        ...


def exact(number: Any) -> Fraction:
    """Return a fraction or an extended-precision number as the fraction it is."""
    # gmpy2 2.3.2 never frees what its own fractions return as their integer ratio.
    return number if isinstance(number, Fraction) else Fraction(*number.as_integer_ratio())


def free_rotation(mp: Any, moments: Numbers, axes: Numbers, L_body: Numbers) -> Rotation:
    """Return the rotation that starts at the given axes, (3, 3), with the given angular momentum [kg m2/s], (3,).

    mp: mpmath context at the wanted precision; moments: principal moments of inertia [kg m2], (3,).
    """
    L_exact, moments = (np.array([exact(number) for number in numbers]) for numbers in (L_body, moments))
    steady = not cross(L_exact, L_exact / moments).any()
    return SteadySpin(mp, axes, L_body, L_body / moments) if steady else Polhode(mp, moments, axes, L_exact)


class SteadySpin:
    """w parallel to L: a sphere, a spin about a principal axis or across an axis of symmetry, or no spin at all."""

    def __init__(self, mp: Any, axes: Numbers, L_body: Numbers, w_body: Numbers) -> None:
        self._mp, self._axes, self._L_body = mp, axes, L_body
        self._speed = mp.sqrt(w_body @ w_body)
        if self._speed:
            x, y, z = line = w_body / self._speed
            self._along = axes @ np.outer(line, line)
            self._across = axes @ np.array(((0, -z, y), (z, 0, -x), (-y, x, 0)))

    def at(self, t: Fraction) -> tuple[Numbers, Numbers]:
        """Return (axes, L_body) at t [s]; without spin they stay the very numbers they were.

        Source: Rodrigues' formula, Goldstein, "Classical Mechanics" (1980), eq. 4-92.
        """
        if not self._speed or not t:
            return self._axes, self._L_body
        cos, sin = self._mp.cos_sin(self._speed * t)
        return self._axes * cos + self._along * (1 - cos) + self._across * sin, self._L_body


class Polhode:
    """The general motion: L_body runs round axis 3, the one of the least or the greatest moment, on Euler's curve

    L_body = (a1 cn, a2 sn, a3 dn)(u),  u = u0 + rate t,   axis 2 being the one of the middle moment.

    A symmetric body is the case m = 0, the separatrix the case m = 1: only their Jacobi functions are special.
    The axes turn about the fixed L by the angle

    phi = |L| t / I1 - (psi(u) - psi(u0)),  psi(u) = sqrt(-n (1 - n) (m - n)) sn^3 RJ(cn^2, dn^2, 1, 1 - n sn^2) / 3,

    n = -I3 (I2 - I1) / (I1 (I3 - I2)) <= 0, which is the integral of phi' = |L| (2E - L3^2/I3) / (L^2 - L3^2).
    Source: Landau & Lifshitz, "Mechanics" (1976), section 37; van Zon & Schofield, J. Comput. Phys. 225 (2007) 145;
    Celledoni, Fasso, Safstrom & Zanna, SIAM J. Sci. Comput. 30 (2008) 2084; Legendre's third integral by RJ:
    DLMF 19.25.14.
    """

    def __init__(self, mp: Any, moments: Numbers, axes: Numbers, L_body: Numbers) -> None:
        self._mp = mp
        self._frame = encircling_frame(moments, L_body)
        I1, I2, I3 = moments_123 = abs(self._frame) @ moments
        L = self._frame @ L_body
        # In exact fractions these may be subtracted however close they are; none is negative.
        twice_E, L_squared = L @ (L / moments_123), L @ L
        above_1 = (L_squared - twice_E * I1) / (I3 - I1)
        above_2 = (L_squared - twice_E * I2) / (I3 - I1)
        below_3 = (twice_E * I3 - L_squared) / (I3 - I1)
        a1_squared, a2_squared, a3_squared = I1 * below_3, I2 * below_3 * (I3 - I1) / (I3 - I2), I3 * above_1
        self._a = np.array([mp.sqrt(a1_squared), mp.sqrt(a2_squared), mp.sqrt(a3_squared)])
        self._rate = mp.sqrt(above_1 * (I3 - I2) * (I3 - I1) / (I1 * I2 * I3)) * (1 if I3 > I2 else -1)

        m1 = above_2 * (I3 - I1) / (above_1 * (I3 - I2))
        n = -I3 * (I2 - I1) / (I1 * (I3 - I2))
        self._jacobi = JacobiFunctions(mp, m1)
        self._n, self._root = mp.mpf(n), mp.sqrt(-n * (1 - n) * (1 - m1 - n))
        self._psi_quarter = self._angle(mp.one, mp.zero, mp.sqrt(m1)) if m1 else mp.inf

        cn, sn, dn = L / self._a
        self._u0 = sn * mp.elliprf(cn * cn, dn * dn, 1)
        self._psi0 = self._angle(sn, cn, dn)
        self._L = mp.sqrt(L_squared)
        self._precession = self._L / I1
        self._start = axes @ self._frame.T @ self._momentum_frame(L).T

    def at(self, t: Fraction) -> tuple[Numbers, Numbers]:
        """Return (axes, L_body) at t [s] after the start."""
        amplitude = self._jacobi(self._u0 + self._rate * t)
        L = self._a * np.array((amplitude.cn, amplitude.sn, amplitude.dn))
        cos, sin = self._mp.cos_sin(self._precession * t - (self._psi(amplitude) - self._psi0))
        polar, azimuthal, along = self._momentum_frame(L)
        turned = np.array((polar * cos - azimuthal * sin, polar * sin + azimuthal * cos, along))
        return self._start @ turned @ self._frame, self._frame.T @ L

    def _psi(self, amplitude: Amplitude) -> Any:
        sn, cn, dn, half_periods = amplitude
        rest = self._angle(-sn if half_periods % 2 else sn, cn, dn)
        return 2 * half_periods * self._psi_quarter + rest if half_periods else rest

    def _angle(self, sn: Any, cn: Any, dn: Any) -> Any:
        """Return psi [rad] for u within a quarter period of 0."""
        mp = self._mp
        if not self._root:
            return mp.zero
        p = 1 - self._n * sn * sn
        return mp.sign(sn) * third_kind_angle(mp, cn * cn, dn * dn, mp.one, p, self._root * abs(sn) ** 3)

    def _momentum_frame(self, L: Numbers) -> Numbers:
        """Return the rotation that takes L onto axis 3; its rows: down L's meridian, along its parallel, along L."""
        mp = self._mp
        L1, L2, L3 = L
        across = mp.sqrt(L1**2 + L2**2)
        cos, sin = L1 / across, L2 / across
        up, out = L3 / self._L, across / self._L
        return np.array(((cos * up, sin * up, -out), (-sin, cos, mp.zero), (cos * out, sin * out, up)))


def encircling_frame(moments: Numbers, L_body: Numbers) -> Numbers:
    """Return the signed permutation, body axes to frame axes, (3, 3), in which L3 > 0 circles axis 3 and L1 >= 0.

    Axis 2 has the middle moment; 2 E I2 against L^2 says which of the other two is circled: the one with the greatest
    moment on the separatrix, where either would do.  A rotation: its determinant is 1.
    """
    least, middle, greatest = sorted(range(3), key=lambda axis: moments[axis])
    if L_body @ (L_body / moments) * moments[middle] > L_body @ L_body:
        first, third = greatest, least
    else:
        first, third = least, greatest
    frame = np.zeros((3, 3), dtype=int)
    frame[0, first] = 1 if L_body[first] >= 0 else -1
    frame[2, third] = 1 if L_body[third] >= 0 else -1
    frame[1] = cross(frame[2], frame[0])
    return frame
