"""Taylor series of a free rotation in time, written out to the twelfth power: in a loop they take three times as long.

A term is the coefficient of a power of t/dt: so scaled, terms are summed without multiplying by powers of a step.
Each comes from Cauchy products of those before it, the pair that waits for the newest one last.
Source: Moore, "Interval Analysis" (1966), chapter 11; Jorba & Zou, "A software package for the numerical integration of
ODEs by means of high-order Taylor methods" (2005), section 2.
"""

from tumble.solver.compilation import inlined, scalar
from tumble.solver.fused import fused, fused_stretch, times_units
from tumble.solver.quaternion import Quaternion, plus
from tumble.solver.vectors import Vector, scale, times

NO_PRODUCTS = (0.0, 0.0, 0.0)
NO_TURNS = ((0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0))

Units = tuple[Quaternion, Quaternion, Quaternion]


@scalar
def _products(a: Vector, b: Vector, more: Vector) -> Vector:
    """Return (a2 b3, a3 b1, a1 b2) + more, the products in dL/dt = L x w."""
    return (fused(a[1], b[2], more[0]), fused(a[2], b[0], more[1]), fused(a[0], b[1], more[2]))


@scalar
def _both(a: Vector, b: Vector, more: Vector) -> Vector:
    """Return the products of a with b, and of b with a, + more."""
    return _products(a, b, _products(b, a, more))


@scalar
def _turn(q: Units, u: Vector, more: Units) -> Units:
    """Return (q i u1, q j u2, q k u3) + more, whose sum is q u~, with q given as q i, q j, q k."""
    return (
        fused_stretch(u[0], q[0], more[0]),
        fused_stretch(u[1], q[1], more[1]),
        fused_stretch(u[2], q[2], more[2]),
    )


@scalar
def _turned(p: Units, u: Vector, q: Units, v: Vector, more: Units) -> Units:
    """Return p u~ + q v~ + more."""
    return _turn(q, v, _turn(p, u, more))


@scalar
def _sum(share: float, turns: Units) -> Quaternion:
    """Return share times the sum of the three."""
    return fused_stretch(share, plus(plus(turns[0], turns[1]), turns[2]), NO_TURNS[0])


# The triangles of products keep their shape.
# fmt: off
@inlined
def momentum_terms(l0: Vector, g: Vector) -> tuple[Vector, ...]:
    """Return the terms 1 to 12 of L_body [kg m2/s] from term 0, for dL/dt = L x w.

    g: dt times `tumble.solver.body.Body.gyroscopic`.
    """
    l1 = times(scale(1 / 1, g), _products(l0, l0, NO_PRODUCTS))
    l2 = times(scale(1 / 2, g), _both(l0, l1, NO_PRODUCTS))
    l3 = times(scale(1 / 3, g), _both(l0, l2, _products(l1, l1, NO_PRODUCTS)))
    l4 = times(scale(1 / 4, g), _both(l0, l3, _both(l1, l2, NO_PRODUCTS)))
    l5 = times(scale(1 / 5, g), _both(l0, l4, _both(l1, l3, _products(l2, l2, NO_PRODUCTS))))
    l6 = times(scale(1 / 6, g), _both(l0, l5, _both(l1, l4, _both(l2, l3, NO_PRODUCTS))))
    l7 = times(scale(1 / 7, g), _both(l0, l6, _both(l1, l5, _both(l2, l4,
        _products(l3, l3, NO_PRODUCTS)))))
    l8 = times(scale(1 / 8, g), _both(l0, l7, _both(l1, l6, _both(l2, l5, _both(l3, l4, NO_PRODUCTS)))))
    l9 = times(scale(1 / 9, g), _both(l0, l8, _both(l1, l7, _both(l2, l6, _both(l3, l5,
        _products(l4, l4, NO_PRODUCTS))))))
    l10 = times(scale(1 / 10, g), _both(l0, l9, _both(l1, l8, _both(l2, l7, _both(l3, l6,
        _both(l4, l5, NO_PRODUCTS))))))
    l11 = times(scale(1 / 11, g), _both(l0, l10, _both(l1, l9, _both(l2, l8, _both(l3, l7, _both(l4, l6,
        _products(l5, l5, NO_PRODUCTS)))))))
    l12 = times(scale(1 / 12, g), _both(l0, l11, _both(l1, l10, _both(l2, l9, _both(l3, l8, _both(l4, l7,
        _both(l5, l6, NO_PRODUCTS)))))))
    return l1, l2, l3, l4, l5, l6, l7, l8, l9, l10, l11, l12


@inlined
def quaternion_terms(
    q0: Quaternion, l0: Vector, terms: tuple[Vector, ...], half_step: Vector
) -> tuple[Quaternion, ...]:
    """Return the terms 1 to 12 of q from term 0 and those of L_body, for dq/dt = q w~/2.

    half_step: dt/2 over the moments of inertia.
    """
    l1, l2, l3, l4, l5, l6, l7, l8, l9, l10, l11, _ = terms
    r0, u0 = times_units(q0), times(half_step, l0)
    q1 = _sum(1 / 1, _turn(r0, u0, NO_TURNS))
    r1, u1 = times_units(q1), times(half_step, l1)
    q2 = _sum(1 / 2, _turned(r0, u1, r1, u0, NO_TURNS))
    r2, u2 = times_units(q2), times(half_step, l2)
    q3 = _sum(1 / 3, _turned(r0, u2, r2, u0, _turn(r1, u1, NO_TURNS)))
    r3, u3 = times_units(q3), times(half_step, l3)
    q4 = _sum(1 / 4, _turned(r0, u3, r3, u0, _turned(r1, u2, r2, u1, NO_TURNS)))
    r4, u4 = times_units(q4), times(half_step, l4)
    q5 = _sum(1 / 5, _turned(r0, u4, r4, u0, _turned(r1, u3, r3, u1, _turn(r2, u2, NO_TURNS))))
    r5, u5 = times_units(q5), times(half_step, l5)
    q6 = _sum(1 / 6, _turned(r0, u5, r5, u0, _turned(r1, u4, r4, u1,
        _turned(r2, u3, r3, u2, NO_TURNS))))
    r6, u6 = times_units(q6), times(half_step, l6)
    q7 = _sum(1 / 7, _turned(r0, u6, r6, u0, _turned(r1, u5, r5, u1, _turned(r2, u4, r4, u2,
        _turn(r3, u3, NO_TURNS)))))
    r7, u7 = times_units(q7), times(half_step, l7)
    q8 = _sum(1 / 8, _turned(r0, u7, r7, u0, _turned(r1, u6, r6, u1, _turned(r2, u5, r5, u2,
        _turned(r3, u4, r4, u3, NO_TURNS)))))
    r8, u8 = times_units(q8), times(half_step, l8)
    q9 = _sum(1 / 9, _turned(r0, u8, r8, u0, _turned(r1, u7, r7, u1, _turned(r2, u6, r6, u2, _turned(r3, u5, r5, u3,
        _turn(r4, u4, NO_TURNS))))))
    r9, u9 = times_units(q9), times(half_step, l9)
    q10 = _sum(1 / 10, _turned(r0, u9, r9, u0, _turned(r1, u8, r8, u1, _turned(r2, u7, r7, u2,
        _turned(r3, u6, r6, u3, _turned(r4, u5, r5, u4, NO_TURNS))))))
    r10, u10 = times_units(q10), times(half_step, l10)
    q11 = _sum(1 / 11, _turned(r0, u10, r10, u0, _turned(r1, u9, r9, u1, _turned(r2, u8, r8, u2,
        _turned(r3, u7, r7, u3, _turned(r4, u6, r6, u4, _turn(r5, u5, NO_TURNS)))))))
    r11, u11 = times_units(q11), times(half_step, l11)
    q12 = _sum(1 / 12, _turned(r0, u11, r11, u0, _turned(r1, u10, r10, u1, _turned(r2, u9, r9, u2,
        _turned(r3, u8, r8, u3, _turned(r4, u7, r7, u4, _turned(r5, u6, r6, u5, NO_TURNS)))))))
    return q1, q2, q3, q4, q5, q6, q7, q8, q9, q10, q11, q12
# fmt: on
