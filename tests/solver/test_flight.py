"""A flight keeps the laws of an engine, falls as its scheme says, and its points move as the report's equations say."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tumble.scenarios.frames import vertices
from tumble.solver.body import Body, angular_acceleration, point_acceleration, point_position, point_velocity
from tumble.solver.flight import Flight
from tumble.solver.forces import Forces
from tumble.solver.registry import METHODS

EPS = np.finfo(float).eps
GRAVITY = (0.5, -9.75, 0.25)
BODIES = {"brick": Body(2.0, (0.2, 0.7, 0.8)), "cube": Body(2.0, (0.3, 0.3, 0.3))}
POINTS = np.array([[0.3, -0.2, 0.1], [-1.0, 0.5, 0.25], [0.0, 0.0, 0.0]])

every_method = pytest.mark.parametrize("method", METHODS)
every_body = pytest.mark.parametrize("body", BODIES.values(), ids=BODIES.keys())
with_and_without = pytest.mark.parametrize("gravity", [None, GRAVITY], ids=["free", "falling"])


def throws(count, seed=3):
    states = np.random.default_rng(seed).uniform(-2.0, 2.0, (count, 13))
    states[:, 3:7] /= np.linalg.norm(states[:, 3:7], axis=1, keepdims=True)
    return states


def flight_of(method, body, states, gravity=None):
    flight = Flight(body, method, Forces(body.mass, gravity))
    flight.write(states)
    return flight


def same_sign(states, like):
    """q and -q are one attitude."""
    aligned = states.copy()
    aligned[:, 3:7] *= np.sign(np.sum(states[:, 3:7] * like[:, 3:7], axis=1, keepdims=True))
    return aligned


@every_body
@every_method
def test_what_is_written_is_read(method, body):
    states = throws(20)
    read = flight_of(method, body, states, GRAVITY).read()
    assert (read[:, 0:3] == states[:, 0:3]).all()
    assert (read[:, 7:10] == states[:, 7:10]).all()
    # w goes through R^T, I, I^-1 and R, each a few roundings of numbers up to 4; q through at most an eigenvector.
    np.testing.assert_allclose(same_sign(read, states), states, rtol=0.0, atol=64 * EPS)


@settings(derandomize=True, deadline=None, max_examples=25)
@given(a=st.integers(0, 200), b=st.integers(0, 200), dt=st.floats(1e-4, 0.7))
@with_and_without
@every_body
@every_method
def test_two_advances_are_one(method, body, gravity, a, b, dt):
    states = throws(2)
    at_once, in_two = (flight_of(method, body, states, gravity) for _ in range(2))
    at_once.advance(a + b, dt)
    in_two.advance(a, dt)
    in_two.read()
    in_two.advance(b, dt)
    np.testing.assert_array_equal(in_two.read(), at_once.read())
    np.testing.assert_array_equal(in_two.vertices(POINTS), at_once.vertices(POINTS))


@every_body
@every_method
def test_write_forgets(method, body):
    states = throws(3)
    fresh, used = flight_of(method, body, states, GRAVITY), flight_of(method, body, throws(5, seed=8), GRAVITY)
    used.advance(37, 0.01)
    used.write(states)
    for flight in (fresh, used):
        flight.advance(10, 0.02)
    np.testing.assert_array_equal(used.read(), fresh.read())


@every_method
def test_a_flight_shares_no_memory_with_its_caller(method):
    states = throws(2)
    given_states = states.copy()
    flight = flight_of(method, BODIES["brick"], given_states, GRAVITY)
    np.testing.assert_array_equal(given_states, states)
    first = flight.read()
    expected = first.copy()
    for array in (given_states, first, flight.vertices(POINTS), flight.matrices()):
        array[:] = 0.0
    np.testing.assert_array_equal(flight.read(), expected)


@every_body
@every_method
def test_no_force_and_no_spin(method, body):
    states = throws(4)
    states[:, 10:13] = 0.0
    flight = flight_of(method, body, states)
    flight.advance(1000, 2.0**-8)
    read = flight.read()
    np.testing.assert_array_equal(read[:, 0:3], states[:, 0:3] + 1000 * 2.0**-8 * states[:, 7:10])
    np.testing.assert_array_equal(read[:, 7:13], states[:, 7:13])
    # q is normalised, or found as an eigenvector: rounding that does not grow with the steps.
    np.testing.assert_allclose(same_sign(read, states)[:, 3:7], states[:, 3:7], rtol=0.0, atol=8 * EPS)


@pytest.mark.parametrize("count", [2, 3, 7, 64])
@with_and_without
@every_body
@every_method
def test_a_throw_is_the_same_alone_and_among_others(method, body, gravity, count):
    states = throws(count)
    together = flight_of(method, body, states, gravity)
    together.advance(50, 0.013)
    read, points = together.read(), together.vertices(POINTS)
    for row in range(count):
        alone = flight_of(method, body, states[row : row + 1], gravity)
        alone.advance(50, 0.013)
        np.testing.assert_array_equal(alone.read()[0], read[row])
        np.testing.assert_array_equal(alone.vertices(POINTS)[0], points[row])


def stepped_exactly(lag, state, legs):
    """Position and velocity by the scheme's own steps in exact fractions: old velocity, new velocity, or their mean."""
    x, v = ([Fraction(c) for c in part] for part in (state[0:3], state[7:10]))
    g = [Fraction(c) for c in GRAVITY]
    for steps, dt in legs:
        dt = Fraction(dt)
        for _ in range(steps):
            new = [vi + dt * gi for vi, gi in zip(v, g, strict=True)]
            speed = {-1: v, 0: [(a + b) / 2 for a, b in zip(v, new, strict=True)], +1: new}[lag]
            x, v = [xi + dt * si for xi, si in zip(x, speed, strict=True)], new
    return np.array(x, dtype=float), np.array(v, dtype=float)


@pytest.mark.parametrize("legs", [[(3000, 2.0**-10)], [(100, 0.01), (7, 0.3), (100, 0.01)]], ids=["long", "dt"])
@every_method
def test_gravity_is_the_schemes_own_parabola_to_rounding(method, legs):
    lag = {"symplectic-euler": +1, "quaternion-euler": -1, "matrix-euler": -1}.get(method, 0)
    states = throws(1)
    flight = flight_of(method, BODIES["cube"], states, GRAVITY)
    for steps, dt in legs:
        flight.advance(steps, dt)
    x, v = stepped_exactly(lag, states[0], legs)
    # A handful of roundings a leg, relative to the largest terms: not one a step.
    scale = np.abs([*x, *v]).max()
    np.testing.assert_allclose(flight.read()[0, 0:3], x, rtol=0.0, atol=8 * len(legs) * EPS * scale)
    np.testing.assert_allclose(flight.read()[0, 7:10], v, rtol=0.0, atol=8 * len(legs) * EPS * scale)


def test_a_hundred_thousand_steps_of_rk4_are_the_parabola():
    states = throws(1)
    flight = flight_of("rk4", BODIES["brick"], states, GRAVITY)
    flight.advance(100_000, 1e-4)
    t = 100_000 * 1e-4
    exact = states[0, 0:3] + t * states[0, 7:10] + t * t / 2 * np.array(GRAVITY)
    np.testing.assert_allclose(flight.read()[0, 0:3], exact, rtol=0.0, atol=4 * EPS * t * t * 9.75)


@every_method
def test_vertices_are_the_states_own_but_for_a_deformed_matrix(method):
    states = throws(3)
    flight = flight_of(method, BODIES["brick"], states, GRAVITY)
    flight.advance(200, 2.0**-6)
    off = np.abs(flight.vertices(POINTS) - vertices(flight.read(), POINTS)).max()
    if METHODS[method].rigid:
        assert off < 64 * EPS
    else:
        assert off > 0.01


def test_what_is_refused():
    with pytest.raises(ValueError, match=r"no method 'rk5'; there are rk4, "):
        Flight(BODIES["cube"], "rk5")
    for name, why in (
        ("rk4@1e-9", "rk4 takes no tolerance"),
        ("adaptive@", "no number"),
        ("adaptive@0", "no number"),
        ("adaptive@nan", "no number"),
        ("adaptive@2", "from 1e-15 to 1"),
        ("rk5@1e-9", "no method 'rk5'"),
    ):
        with pytest.raises(ValueError, match=why):
            Flight(BODIES["cube"], name)
    flight = Flight(BODIES["cube"], "rk4")
    for shape in ((13,), (1, 12), (1, 1, 13)):
        with pytest.raises(ValueError, match=r"shape \(N, 13\)"):
            flight.write(np.zeros(shape))
    for mass, moments in ((0.0, (1.0, 1.0, 1.0)), (1.0, (1.0, -1.0, 1.0)), (1.0, (1.0, float("nan"), 1.0))):
        with pytest.raises(ValueError, match="must be positive"):
            Body(mass, moments)


def test_points_move_as_equations_2_12_to_2_14_with_alpha():
    body, point = BODIES["brick"], (0.3, -0.2, 0.5)
    h, middle = 2.0**-7, throws(1)
    flight = flight_of("rk4", body, middle, GRAVITY)
    track = {}
    for step in (-2, -1, 0, 1, 2):
        flight.write(middle)
        flight.advance(64, step * h / 64)
        state = flight.read()[0]
        track[step] = np.array(point_position(tuple(state[0:3]), tuple(state[3:7]), point))
        np.testing.assert_allclose(track[step], flight.vertices([point])[0, 0], rtol=0.0, atol=16 * EPS)

    # Central differences of fourth order: off by h^4/30 and h^4/90 times the next derivatives, |w|^5 and |w|^6 |p| with
    # |w| under 4 here; and by rounding over h, and over h^2.
    velocity = (track[-2] - 8 * track[-1] + 8 * track[1] - track[2]) / (12 * h)
    acceleration = (16 * (track[-1] + track[1]) - track[-2] - track[2] - 30 * track[0]) / (12 * h * h)
    v, q, w_world = (tuple(middle[0, part]) for part in (slice(7, 10), slice(3, 7), slice(10, 13)))
    np.testing.assert_allclose(velocity, point_velocity(v, q, w_world, point), rtol=0.0, atol=h**4 * 4**5 / 30)

    alpha_world = angular_acceleration(q, w_world, body.moments, body.gyroscopic)
    tolerance = h**4 * 4**6 / 90
    with_alpha = point_acceleration(GRAVITY, q, w_world, alpha_world, point)
    np.testing.assert_allclose(acceleration, with_alpha, rtol=0.0, atol=tolerance)
    as_printed = point_acceleration(GRAVITY, q, w_world, (0.0, 0.0, 0.0), point)
    assert np.abs(acceleration - as_printed).max() > 1e4 * tolerance, "eq. 2.14 as printed would pass as well"


def test_equal_moments_have_no_angular_acceleration():
    cube, state = BODIES["cube"], throws(1)[0]
    assert cube.gyroscopic is None
    assert angular_acceleration(tuple(state[3:7]), tuple(state[10:13]), cube.moments, None) == (0.0, 0.0, 0.0)
