"""The quaternion algebra: a group, the right one, and its exponential, compiled and interpreted alike."""

import math
from types import SimpleNamespace

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tumble.solver import quaternion

EPS = np.finfo(float).eps
# Every result below is a sum of at most a dozen products of numbers up to 1: a few roundings of 1.
ROUNDING = 16 * EPS

COMPILED = (
    "product",
    "product_vector",
    "vector_product",
    "plus",
    "stretch",
    "conjugate",
    "norm_squared",
    "normalise",
    "rotate",
    "rotate_back",
    "exponential",
)


@pytest.fixture(scope="module", params=["compiled", "interpreted"])
def algebra(request):
    functions = {name: getattr(quaternion, name) for name in COMPILED}
    if request.param == "interpreted":
        functions = {name: function.py_func for name, function in functions.items()}
    return SimpleNamespace(**functions)


coordinates = st.floats(-1.0, 1.0)
vectors = st.tuples(coordinates, coordinates, coordinates)


def _unit(parts):
    return tuple(float(c) for c in np.array(parts) / np.linalg.norm(parts))


# Two strata: anywhere, and within 1e-7 of the identity, where a careless formula loses half its digits.
anywhere = st.tuples(coordinates, *[coordinates] * 3).filter(lambda q: np.linalg.norm(q) > 0.1).map(_unit)
near_identity = vectors.map(lambda a: _unit((1.0, 1e-7 * a[0], 1e-7 * a[1], 1e-7 * a[2])))
units = st.one_of(anywhere, near_identity)

deterministic = settings(derandomize=True, deadline=None, max_examples=60)


def _near(a, b, tolerance=ROUNDING):
    np.testing.assert_allclose(a, b, rtol=0.0, atol=tolerance)


def test_hamiltons_product(algebra):
    i, j, k = (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0), (0.0, 0.0, 0.0, 1.0)
    assert algebra.product(i, j) == k
    assert algebra.product(j, k) == i
    assert algebra.product(k, i) == j
    assert algebra.product(algebra.product(i, j), k) == (-1.0, 0.0, 0.0, 0.0)


@deterministic
@given(p=units, q=units, r=units)
def test_group_axioms(algebra, p, q, r):
    identity = (1.0, 0.0, 0.0, 0.0)
    assert abs(algebra.norm_squared(algebra.product(p, q)) - 1.0) < ROUNDING
    assert algebra.product(identity, q) == q == algebra.product(q, identity)
    _near(algebra.product(q, algebra.conjugate(q)), identity)
    _near(algebra.product(algebra.product(p, q), r), algebra.product(p, algebra.product(q, r)))
    _near(algebra.conjugate(algebra.product(p, q)), algebra.product(algebra.conjugate(q), algebra.conjugate(p)))


@deterministic
@given(p=units, q=units, factor=st.floats(1e-100, 1e100))
def test_linear_structure(algebra, p, q, factor):
    _near(algebra.normalise(algebra.stretch(factor, q)), q)
    assert algebra.plus(p, q) == tuple(np.array(p) + np.array(q))


@deterministic
@given(q=units, a=vectors)
def test_products_with_a_vector_are_products_with_a_pure_quaternion(algebra, q, a):
    assert algebra.product_vector(q, a) == pytest.approx(algebra.product(q, (0.0, *a)), abs=ROUNDING)
    assert algebra.vector_product(a, q) == pytest.approx(algebra.product((0.0, *a), q), abs=ROUNDING)


@deterministic
@given(p=units, q=units, a=vectors)
def test_rotation_is_the_matrix(algebra, p, q, a):
    matrix = quaternion.to_matrix(np.array(q))
    _near(algebra.rotate(q, a), matrix @ a)
    _near(algebra.rotate_back(q, a), matrix.T @ a)
    _near(matrix.T @ matrix, np.eye(3))
    assert np.linalg.det(matrix) > 0.0
    _near(quaternion.to_matrix(np.array(algebra.product(p, q))), quaternion.to_matrix(np.array(p)) @ matrix)
    conjugation = algebra.product(algebra.product(q, (0.0, *a)), algebra.conjugate(q))
    _near((0.0, *algebra.rotate(q, a)), conjugation)


def test_the_matrix_of_one_throw_is_that_among_many_to_the_last_bit():
    many = np.random.default_rng(0).normal(0.0, 1.0, (100, 4))
    each = [quaternion.to_matrix(q[np.newaxis]) for q in many]
    assert np.array_equal(np.concatenate(each), quaternion.to_matrix(many))
    assert quaternion.to_matrix(many[0]).shape == (3, 3)


def test_a_positive_turn_is_counter_clockwise(algebra):
    quarter_about_z = algebra.exponential((0.0, 0.0, math.pi / 4))
    _near(algebra.rotate(quarter_about_z, (1.0, 0.0, 0.0)), (0.0, 1.0, 0.0))


# Lengths on both sides of where the series ends, tiny ones, whole turns, and those whose square underflows.
JUST_BELOW, JUST_ABOVE = (math.sqrt(quaternion.SERIES_LIMIT) * (1 + side * 1e-9) for side in (-1, 1))


@pytest.mark.parametrize("length", [0.0, 1e-200, 1e-12, 1e-7, 1e-3, 0.04, JUST_BELOW, JUST_ABOVE, 0.5, 3.0, 20.0])
def test_exponential_to_rounding(algebra, length):
    direction = np.array([2.0, -6.0, 9.0]) / 11.0
    u = tuple(length * direction)
    with mpmath.workdps(40):
        size = mpmath.sqrt(sum(mpmath.mpf(c) ** 2 for c in u))
        ratio = mpmath.sinc(size)
        cosine = float(mpmath.cos(size))
        vector = [float(ratio * c) for c in u]
    # The angle is rounded, relatively; after that a few roundings of the result, relative in the vector part too.
    tolerance = (4.0 + length) * EPS
    result = algebra.exponential(u)
    assert abs(result[0] - cosine) <= tolerance
    np.testing.assert_allclose(result[1:], vector, rtol=4 * EPS, atol=tolerance * min(1.0, length))


@deterministic
@given(a=vectors, s=st.floats(-3.0, 3.0), t=st.floats(-3.0, 3.0))
def test_exponentials_about_one_axis_add(algebra, a, s, t):
    turns = [tuple(factor * c for c in a) for factor in (s, t, s + t)]
    first, second, both = (algebra.exponential(turn) for turn in turns)
    _near(algebra.product(first, second), both, 4 * ROUNDING)


@deterministic
@given(q=units)
def test_matrix_round_trip(q):
    back = quaternion.from_matrix(quaternion.to_matrix(np.array(q)))
    _near(back * np.sign(back @ q), q)


def test_half_turns_survive_the_matrix():
    for axis in np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 1], [0.6, 0, 0.8], [2 / 3, -2 / 3, 1 / 3]]):
        half_turn = np.array([0.0, *axis])
        back = quaternion.from_matrix(quaternion.to_matrix(half_turn))
        _near(back * np.sign(back @ half_turn), half_turn)


def test_from_matrix_is_the_polar_factor():
    generator = np.random.default_rng(7)
    deformed = np.eye(3) + 0.3 * generator.uniform(-1.0, 1.0, (50, 3, 3))
    left, _, right = np.linalg.svd(deformed)
    assert np.abs(np.swapaxes(deformed, 1, 2) @ deformed - np.eye(3)).max() > 0.5, "the setup deforms nothing"
    # Both eigenvectors and singular vectors are good to a few roundings over gaps near 1.
    _near(quaternion.to_matrix(quaternion.from_matrix(deformed)), left @ right, 100 * EPS)


def test_from_matrix_of_what_is_not_finite():
    matrices = np.stack([np.eye(3), np.full((3, 3), np.nan), np.full((3, 3), np.inf)])
    quaternions = quaternion.from_matrix(matrices)
    _near(np.abs(quaternions[0]), (1.0, 0.0, 0.0, 0.0))
    assert np.isnan(quaternions[1:]).all()
