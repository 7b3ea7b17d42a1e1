"""Products and sums with one rounding, and the series written with them, against exact rational numbers."""

import math
import operator
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import njit

from tumble.solver.four import all_four, fused_four, minus_four, over_four, plus_four, times_four
from tumble.solver.fused import (
    fused,
    fused_cross,
    fused_exponential,
    fused_half_turn,
    fused_product,
    fused_stretch,
    times_units,
)
from tumble.solver.quaternion import exponential, product
from tumble.solver.series import momentum_terms, quaternion_terms

EPS = np.finfo(float).eps
number = st.floats(-1e3, 1e3).filter(lambda x: x == 0.0 or abs(x) > 1e-3)
vector, quaternion = st.tuples(*[number] * 3), st.tuples(*[number] * 4)
derandomized = settings(derandomize=True, deadline=None)


@njit
def call_fused(a, b, c):
    return fused(a, b, c)


@njit
def call_stretch(factor, q, c):
    return fused_stretch(factor, q, c)


@njit
def call_units(q):
    return times_units(q)


@njit
def call_half_turn(angle):
    return fused_half_turn(angle)


@njit
def call_four(a, b, c):
    return fused_four(a, b, c), times_four(a, b), plus_four(a, b), minus_four(a, b), over_four(a, b), all_four(a[2])


@njit
def terms(q, momentum, half_step, step_gyroscopic):
    momenta = momentum_terms(momentum, step_gyroscopic)
    return momenta, quaternion_terms(q, momentum, momenta, half_step)


@given(number, number, number)
@derandomized
def test_one_rounding(a, b, c):
    assert call_fused(a, b, c) == float(Fraction(a) * Fraction(b) + Fraction(c))


def test_one_rounding_is_not_two():
    a = 1.0 + EPS
    assert call_fused(a, a, -1.0 - 2 * EPS) == EPS**2 != a * a - (1.0 + 2 * EPS)


@given(number, quaternion, quaternion)
@derandomized
def test_four_at_once_are_four_times_one(factor, q, c):
    assert call_stretch(factor, q, c) == tuple(call_fused(factor, a, b) for a, b in zip(q, c, strict=True))


@given(quaternion, quaternion.filter(all), quaternion)
@derandomized
def test_a_formula_at_four_instants_is_that_at_each(a, b, c):
    fused_four, *plain, same = call_four(a, b, c)
    assert fused_four == tuple(call_fused(*numbers) for numbers in zip(a, b, c, strict=True))
    for found, operation in zip(plain, (operator.mul, operator.add, operator.sub, operator.truediv), strict=True):
        assert found == tuple(map(operation, a, b))
    assert same == (a[2],) * 4


@given(quaternion)
@derandomized
def test_units(q):
    i, j, k = (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0), (0.0, 0.0, 0.0, 1.0)
    assert call_units(q) == (product(q, i), product(q, j), product(q, k))


@given(quaternion, quaternion, vector, vector, vector)
@derandomized
def test_products(p, q, a, b, c):
    # Four roundings of a sum whose terms are no larger than the product of the lengths.
    size = np.linalg.norm(p) * np.linalg.norm(q)
    np.testing.assert_allclose(fused_product(p, q), product(p, q), rtol=0, atol=4 * EPS * size)
    size = np.linalg.norm(a) * np.linalg.norm(b) + np.linalg.norm(c)
    np.testing.assert_allclose(fused_cross(a, b, c), np.cross(a, b) + c, rtol=0, atol=4 * EPS * size)


@pytest.mark.parametrize("length", [0.0, 1e-9, 0.05, 0.0883, 0.0885, 1.0, 30.0])
def test_exponential(length):
    u = tuple(length * np.array([0.48, -0.6, 0.64]))
    np.testing.assert_allclose(fused_exponential(u), exponential(u), rtol=0, atol=2 * EPS)


@pytest.mark.parametrize("scale", [1e-3, 1.0, math.pi, 30.0, 1e6, 4e15, 1e18])
def test_half_turn(scale):
    angles = [*np.random.default_rng(4).uniform(-scale, scale, 200), math.pi, -math.pi, 0.0, scale]
    for angle in angles:
        half = (math.cos(angle / 2), math.sin(angle / 2))
        assert call_half_turn(angle) == pytest.approx(half, rel=0, abs=2 * EPS)


def test_series():
    """Every term is that of the recurrence L' = L x w, q' = q w~/2 in whole numbers."""
    q, momentum, half_step, gyroscopic = [(1, 2, -3, 5)], [(3, -2, 7)], (2, 3, 5), (1, -3, 2)
    for n in range(12):
        pairs = [(momentum[k], momentum[n - k]) for k in range(n + 1)]
        rate = [sum(a[(i + 1) % 3] * b[(i + 2) % 3] for a, b in pairs) for i in range(3)]
        momentum.append(tuple(Fraction(g * r) / (n + 1) for g, r in zip(gyroscopic, rate, strict=True)))
        turn = (0, 0, 0, 0)
        for k in range(n + 1):
            w, x, y, z = q[k]
            a, b, c = (h * rate for h, rate in zip(half_step, momentum[n - k], strict=True))
            by = (-x * a - y * b - z * c, w * a + y * c - z * b, w * b + z * a - x * c, w * c + x * b - y * a)
            turn = tuple(s + t for s, t in zip(turn, by, strict=True))
        q.append(tuple(Fraction(t) / (n + 1) for t in turn))
    floats = [tuple(map(float, numbers)) for numbers in (q[0], momentum[0], half_step, gyroscopic)]
    momentum_found, q_found = terms(*floats)
    # Sums of up to twelve products, each of terms that are off themselves: rounding grows like the power.
    for found, true in ((momentum_found, momentum[1:]), (q_found, q[1:])):
        for power, (a, b) in enumerate(zip(found, true, strict=True), 1):
            exact = np.array(b, dtype=float)
            np.testing.assert_allclose(a, exact, rtol=0, atol=20 * power * EPS * np.abs(exact).max())
