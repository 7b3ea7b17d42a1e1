"""The solver's methods, each with what it claims: the tests ask for every claim, and deny what is not claimed."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any, Literal

import numpy as np

from tumble.solver.ensemble.blocks import LANES
from tumble.solver.ensemble.exact import exact as exact_lanes
from tumble.solver.ensemble.rkmk4 import WIDTH as RKMK4_LANES_WIDTH
from tumble.solver.ensemble.rkmk4 import rkmk4 as rkmk4_lanes
from tumble.solver.integrators.adaptive import adaptive
from tumble.solver.integrators.adaptive_forced import adaptive_forced
from tumble.solver.integrators.exact import exact
from tumble.solver.integrators.gauss6 import gauss6, gauss6_forced
from tumble.solver.integrators.implicit_midpoint import implicit_midpoint
from tumble.solver.integrators.magnus6 import magnus6
from tumble.solver.integrators.matrix_euler import matrix_euler
from tumble.solver.integrators.quaternion_euler import quaternion_euler
from tumble.solver.integrators.radau5 import radau5, radau5_forced
from tumble.solver.integrators.rk4 import rk4, rk4_forced
from tumble.solver.integrators.rkmk4 import rkmk4
from tumble.solver.integrators.semi_exact import semi_exact
from tumble.solver.integrators.splitting import splitting
from tumble.solver.integrators.splitting8 import splitting8
from tumble.solver.integrators.symplectic_euler import symplectic_euler, symplectic_euler_forced
from tumble.solver.integrators.taylor8 import taylor8
from tumble.solver.integrators.taylor12 import taylor12

# What rounding leaves to a step of order eight.
LEAST_TOLERANCE = 1e-15


@dataclass(frozen=True)
class Method:
    """How a method steps, how it keeps a rotation between two calls, and what it claims for a body of any moments.

    steps: the kernel, with the signature of `tumble.solver.integrators`.
    attitude: what the kernel's rows start with.  momentum_axes: the axes of the angular momentum that follows it.
    lag: how the position's steps use the velocity: -1 with the old one, +1 with the new one, 0 with their mean.
    order: the error of a finished flight falls as dt^order; None where it does not depend on dt.
    rigid: the attitude stays a rotation.  keeps_momentum, keeps_energy: in free flight, to rounding, at any dt.
    reversible: at steps of up to a radian a flight with v and w turned round comes back, to rounding.
    stable_turn: |w| dt [rad] beyond which a steady turn can grow into another; infinite where it never does; None where
    no such limit is claimed, because a small tilt grows at any step, or a resonance may make it grow.
    dense: it goes to an instant and not by steps; its rows remember where their count began.
    keeps: numbers at the end of a row that are the method's own, 0 when a count of steps begins.
    least_throws: fewer fly right too, but leave lanes of the processor empty.
    tolerance: for an adaptive method, of one step of its own, relative to |q| and |L|, unless another is asked for.
    forced: the kernel under forces, None for a method that carries none.  forced_width: numbers in a row of it.
    counts_unsolved: the last of those is how many steps it did not find.
    """

    steps: Callable
    attitude: Literal["quaternion", "matrix"]
    momentum_axes: Literal["world", "body"]
    lag: int
    order: int | None
    rigid: bool = True
    keeps_momentum: bool = False
    keeps_energy: bool = False
    reversible: bool = False
    stable_turn: float | None = None
    dense: bool = False
    keeps: int = 0
    least_throws: int = 1
    tolerance: float | None = None
    forced: Callable | None = None
    forced_width: int = 13
    counts_unsolved: bool = False

    @property
    def width(self) -> int:
        """How many numbers a row of its rotation has: q or a matrix, L, both at the start if dense, and its own."""
        return (12 if self.attitude == "matrix" else 7) + (7 if self.dense else 0) + self.keeps


def _dense(kernel: Callable, **claims: Any) -> Method:
    """Return a method that goes to any instant at once."""
    return Method(kernel, "quaternion", "body", lag=0, order=None, dense=True, **claims)


def _body(kernel: Callable, order: int, **claims: Any) -> Method:
    """Return a method on quaternion and L in body axes, exact on a parabola."""
    return Method(kernel, "quaternion", "body", lag=0, order=order, **claims)


def taylor_limit(order: int) -> float:
    """Return the largest y up to which |p(iy)| <= 1 for p the Taylor polynomial of exp, infinite where there is none.

    A steady turn multiplies by exp(i |w| dt) a step, and these methods by their polynomial: beyond, it grows.
    Source: Hairer & Wanner, "Solving Ordinary Differential Equations II" (1996), section IV.2.
    """
    terms = [Fraction(1, math.factorial(k)) for k in range(order + 1)]
    real = [0 if k % 2 else (-1) ** (k // 2) * term for k, term in enumerate(terms)]
    imaginary = [(-1) ** (k // 2) * term if k % 2 else 0 for k, term in enumerate(terms)]
    square = [
        sum(part[i] * part[k - i] for part in (real, imaginary) for i in range(max(0, k - order), min(k, order) + 1))
        for k in range(2 * order + 1)
    ]
    # All powers up to the order cancel, but for the 1; of what is left the first decides near 0.
    left = [(k, float(value)) for k, value in enumerate(square) if k and value]
    if left[0][1] > 0.0:
        return 0.0
    roots = np.roots([dict(left).get(k, 0.0) for k in range(2 * order, left[0][0] - 1, -1)])
    return float(min((root.real for root in roots if root.real > 0.0 and abs(root.imag) < 1e-9), default=math.inf))


METHODS = {
    "rk4": _body(rk4, order=4, stable_turn=taylor_limit(4), forced=rk4_forced),
    "exact": _dense(exact, stable_turn=math.inf, keeps_momentum=True, keeps_energy=True, reversible=True),
    "exact-lanes": _dense(
        exact_lanes,
        stable_turn=math.inf,
        keeps_momentum=True,
        keeps_energy=True,
        reversible=True,
        least_throws=LANES,
    ),
    "adaptive": _dense(
        adaptive, stable_turn=math.inf, keeps=2, tolerance=1e-9, forced=adaptive_forced, forced_width=28
    ),
    "rkmk4": _body(rkmk4, order=4, stable_turn=taylor_limit(4)),
    "rkmk4-lanes": _body(
        rkmk4_lanes, order=4, stable_turn=taylor_limit(4), keeps=RKMK4_LANES_WIDTH - 7, least_throws=LANES
    ),
    "magnus6": _body(magnus6, order=6, stable_turn=taylor_limit(8)),
    "taylor8": _body(taylor8, order=8, stable_turn=taylor_limit(8)),
    "taylor12": _body(taylor12, order=12, stable_turn=taylor_limit(12)),
    "semi-exact": _body(
        semi_exact, order=8, stable_turn=math.inf, keeps_momentum=True, keeps_energy=True, reversible=True
    ),
    "splitting": _body(splitting, order=2, keeps_momentum=True, reversible=True),
    "splitting8": _body(splitting8, order=8, keeps_momentum=True, reversible=True),
    "implicit-midpoint": _body(
        implicit_midpoint,
        order=2,
        stable_turn=math.inf,
        keeps_momentum=True,
        keeps_energy=True,
        reversible=True,
    ),
    "gauss6": _body(
        gauss6,
        order=6,
        stable_turn=math.inf,
        keeps_energy=True,
        forced=gauss6_forced,
        forced_width=14,
        counts_unsolved=True,
    ),
    "radau5": _body(radau5, order=5, stable_turn=math.inf, forced=radau5_forced, forced_width=14, counts_unsolved=True),
    "symplectic-euler": Method(
        symplectic_euler, "quaternion", "world", lag=+1, order=1, keeps_momentum=True, forced=symplectic_euler_forced
    ),
    "quaternion-euler": Method(quaternion_euler, "quaternion", "world", lag=-1, order=1, keeps_momentum=True),
    "matrix-euler": Method(matrix_euler, "matrix", "world", lag=-1, order=1, rigid=False),
}


def find(name: str) -> Method:
    """Return the method of a name, or of NAME@TOLERANCE for an adaptive one.

    Parameters
    ----------
    name

    Returns
    -------
    method

    Raises
    ------
    ValueError
        No method has that name, or it takes no such tolerance.
    """
    plain, at, asked = name.partition("@")
    if plain not in METHODS:
        raise ValueError(f"no method {plain!r}; there are {', '.join(METHODS)}")
    method = METHODS[plain]
    if not at:
        return method
    if method.tolerance is None:
        raise ValueError(f"{plain} takes no tolerance, got {name!r}")
    try:
        tolerance = float(asked)
    except ValueError:
        tolerance = math.nan
    if not LEAST_TOLERANCE <= tolerance <= 1.0:
        raise ValueError(f"the tolerance in {name!r} is no number from {LEAST_TOLERANCE:g} to 1")
    return replace(method, tolerance=tolerance)
