"""The force laws against the formulas of the scene file, and flights under forces against exact ones.

What is expected is written with rotation matrices and w in world axes, which the solver uses for no force.
"""

import dataclasses
import math
import os
import re
import subprocess
import sys
from itertools import pairwise

import numpy as np
import pytest
from numba import njit
from patience import PATIENCE_S
from scipy.integrate import solve_ivp

from tumble.compare.engines import tumble as engine
from tumble.scenarios.frames import rotation_matrix, vertices
from tumble.scenarios.read import read_scene
from tumble.scenarios.scene import Drag, Floor, Tether
from tumble.solver.body import Body
from tumble.solver.dual import dual, parts
from tumble.solver.eight import eight, lane, loaded, with_lane
from tumble.solver.flight import Flight
from tumble.solver.forces import LAWS, Forces, wrench
from tumble.solver.integrators.rk4 import rk4_forced
from tumble.solver.motion import load, slope
from tumble.solver.registry import METHODS
from tumble.solver.scene_forces import forces_of
from tumble.solver.stiffness import fastest

EPS = np.finfo(float).eps
BODY = Body(2.0, (0.2, 0.7, 0.8))
GRAVITY = (0.5, -9.75, 0.25)
CORNERS = np.array([[0.3, -0.2, 0.1], [-0.6, 0.5, 0.25], [0.1, 0.4, -0.5], [0.2, -0.3, 0.4]])
# Two tethers: one to all sides, one along its line; both damped.
TETHERS = np.array(
    [[0.3, -0.2, 0.1, 0.5, 1.0, -0.2, 80.0, 0.6, 0.0], [-0.6, 0.5, 0.25, -0.5, 0.5, 0.7, 30.0, 0.4, 0.8]]
)
DRAG = (0.3, 0.02)
NORMAL = (0.48, 0.6, 0.64)
FLOOR = (-0.2, *NORMAL, 50.0, 0.7)
ALL = Forces(BODY.mass, GRAVITY, TETHERS, DRAG, FLOOR, CORNERS)
SEPARATELY = {
    "none": Forces(BODY.mass),
    "gravity": Forces(BODY.mass, gravity=GRAVITY),
    "tethers": Forces(BODY.mass, tethers=TETHERS),
    "drag": Forces(BODY.mass, drag=DRAG),
    "linear drag": Forces(BODY.mass, drag=(0.3, None)),
    "angular drag": Forces(BODY.mass, drag=(None, 0.02)),
    "floor": Forces(BODY.mass, floor=FLOOR, points=CORNERS),
    "all": ALL,
}
FORCED = [name for name, method in METHODS.items() if method.forced is not None]
every_forced_method = pytest.mark.parametrize("method", FORCED)


def throws(count=1, seed=5):
    states = np.random.default_rng(seed).uniform(-1.0, 1.0, (count, 13))
    states[:, 3:7] /= np.linalg.norm(states[:, 3:7], axis=1, keepdims=True)
    return states


def expected_wrench(state, forces):
    """Force and torque in world axes, as the scene file states the laws."""
    x, q, v, w = np.split(state, (3, 7, 10))
    axes = rotation_matrix(q)
    force, torque = np.zeros(3), np.zeros(3)
    pulls = []
    if forces.gravity is not None:
        force += forces.mass * np.array(forces.gravity)
    if forces.drag is not None:
        force -= (forces.drag[0] or 0.0) * v
        torque -= (forces.drag[1] or 0.0) * w
    for tether in [] if forces.tethers is None else forces.tethers:
        lever = axes @ tether[:3]
        d, rate, (k, c, rest_length) = x + lever - tether[3:6], v + np.cross(w, lever), tether[6:]
        u = d / np.linalg.norm(d)
        along = -(k * (np.linalg.norm(d) - rest_length) + c * (rate @ u)) * u
        pulls.append((lever, along if rest_length else -k * d - c * rate))
    if forces.floor is not None:
        height, *normal, k, c = forces.floor
        for point in forces.points:
            lever = axes @ point
            y, rate = np.dot(normal, x + lever) - height, np.dot(normal, v + np.cross(w, lever))
            if y < 0:
                pulls.append((lever, max(0.0, -k * y - c * rate) * np.array(normal)))
    for lever, pull in pulls:
        force += pull
        torque += np.cross(lever, pull)
    return force, torque


def expected_flight(body, forces, state, times):
    """States by scipy's DOP853 on x, R, v and w in world axes, to about 1e-12."""

    def rates(_, y):
        x, axes, v, w = y[:3], y[3:12].reshape(3, 3), y[12:15], y[15:]
        whole = np.concatenate((x, quaternion(axes), v, w))
        force, torque = expected_wrench(whole, forces)
        tensor = axes @ np.diag(body.moments) @ axes.T
        spin = np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])
        acceleration = np.linalg.solve(tensor, torque - np.cross(w, tensor @ w))
        return np.concatenate((v, (spin @ axes).ravel(), force / body.mass, acceleration))

    y0 = np.concatenate((state[:3], rotation_matrix(state[3:7]).ravel(), state[7:]))
    y = solve_ivp(rates, (0.0, times[-1]), y0, "DOP853", times, rtol=1e-13, atol=1e-13).y.T
    return [(row[:3], row[3:12].reshape(3, 3)) for row in y]


def quaternion(axes):
    """The quaternion of a rotation matrix, away from half turns."""
    w = math.sqrt(1.0 + np.trace(axes)) / 2
    return np.array(
        [w, *(np.array([axes[2, 1] - axes[1, 2], axes[0, 2] - axes[2, 0], axes[1, 0] - axes[0, 1]]) / 4 / w)]
    )


def flown(method, body, forces, states, steps, duration):
    flight = Flight(body, method, forces)
    flight.write(states)
    flight.advance(steps, duration / steps)
    return flight


def tuples(state):
    """x, q, v and w in body axes, as the solver has them."""
    x, q, v, w = np.split(state, (3, 7, 10))
    return tuple(x), tuple(q), tuple(v), tuple(rotation_matrix(q).T @ w)


class TestLaws:
    @pytest.mark.parametrize("forces", SEPARATELY.values(), ids=SEPARATELY.keys())
    def test_each_and_all_are_those_of_the_scene_file(self, forces):
        for state in throws(20):
            force, torque = expected_wrench(state, forces)
            found, twist_body = wrench(*tuples(state), forces)
            # Numbers up to 200, through two turns and a few sums.
            np.testing.assert_allclose(found, force, rtol=0, atol=200 * 16 * EPS)
            np.testing.assert_allclose(rotation_matrix(state[3:7]) @ twist_body, torque, rtol=0, atol=200 * 16 * EPS)

    def test_the_throws_touch_and_miss_the_floor(self):
        heights = np.dot(vertices(throws(20), CORNERS), NORMAL) - FLOOR[0]
        assert (heights < 0).any(axis=1).sum() >= 5
        assert (heights > 0).all(axis=1).sum() >= 5

    def test_a_quaternion_of_any_length_is_the_same_attitude(self):
        x, q, v, w_body = tuples(throws()[0])
        longer = tuple(8.0 * c for c in q)
        assert wrench(x, longer, v, w_body, ALL) == wrench(x, q, v, w_body, ALL)

    @pytest.mark.parametrize("rest_length", [0.0, 0.5])
    def test_a_tether_of_no_length_pulls_nowhere(self, rest_length):
        tether = np.array([[0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 80.0, 0.0, rest_length]])
        force, torque = wrench(
            (1.0, 2.0, 3.0), (1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), Forces(1.0, tethers=tether)
        )
        np.testing.assert_array_equal([force, torque], np.zeros((2, 3)))

    def test_a_floor_only_pushes(self):
        # A corner deep under the floor leaves it so fast that its damper would pull.
        x, v = np.array(NORMAL) * (FLOOR[0] - 1.0), tuple(1e3 * np.array(NORMAL))
        forces = SEPARATELY["floor"]
        force, torque = wrench(tuple(x), (1.0, 0.0, 0.0, 0.0), v, (0.0, 0.0, 0.0), forces)
        np.testing.assert_array_equal([force, torque], np.zeros((2, 3)))
        assert np.dot(wrench(tuple(x), (1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), forces)[0], NORMAL) > 0


@njit
def slope_of_row(row, inverse_moments, gyroscopic, forces):
    x, q, v, l_body = slope(load(row, inverse_moments), inverse_moments, gyroscopic, forces)
    return (x[0], x[1], x[2], q[0], q[1], q[2], q[3], v[0], v[1], v[2], l_body[0], l_body[1], l_body[2])


@njit
def slope_of_eight(rows, inverse_moments, gyroscopic, forces):
    """The slopes of eight states, (13, 8)."""
    state = (
        (loaded(rows, 0), loaded(rows, 1), loaded(rows, 2)),
        (loaded(rows, 3), loaded(rows, 4), loaded(rows, 5), loaded(rows, 6)),
        (loaded(rows, 7), loaded(rows, 8), loaded(rows, 9)),
        (loaded(rows, 10), loaded(rows, 11), loaded(rows, 12)),
    )
    x, q, v, l_body = slope(state, inverse_moments, gyroscopic, forces)
    found = np.empty((13, 8))
    for number in range(8):
        for a in range(3):
            found[a, number], found[7 + a, number] = lane(x[a], number), lane(v[a], number)
            found[10 + a, number] = lane(l_body[a], number)
        for a in range(4):
            found[3 + a, number] = lane(q[a], number)
    return found


@pytest.mark.parametrize("forces", SEPARATELY.values(), ids=SEPARATELY)
def test_eight_states_at_once_are_each_alone_to_the_last_bit(forces):
    bodily, rows = (BODY.inverse_moments, BODY.gyroscopic, forces), throws(8)
    # One corner of the last is where its tether is tied, one body far above the floor.
    rows[7, 0:3] = TETHERS[1, 3:6] - rotation_matrix(rows[7, 3:7]) @ TETHERS[1, 0:3]
    rows[6, 0:3] += 5.0 * np.array(NORMAL)
    together = slope_of_eight(np.ascontiguousarray(rows.T), *bodily)
    np.testing.assert_array_equal(together.T, [slope_of_row(row, *bodily) for row in rows])


@njit
def changes_of_row(row, number, inverse_moments, gyroscopic, forces):
    """How the slope changes with one number of a state, as a place and as a speed."""
    x, q, v, l_body = load(row, inverse_moments)
    state = (
        (moving(x[0], number == 0), moving(x[1], number == 1), moving(x[2], number == 2)),
        (moving(q[0], number == 3), moving(q[1], number == 4), moving(q[2], number == 5), moving(q[3], number == 6)),
        (moving(v[0], number == 7), moving(v[1], number == 8), moving(v[2], number == 9)),
        (moving(l_body[0], number == 10), moving(l_body[1], number == 11), moving(l_body[2], number == 12)),
    )
    _, _, v, l_body = slope(state, inverse_moments, gyroscopic, forces)
    found = np.empty((6, 2))
    for a in range(3):
        _, place, speed = parts(v[a])
        found[a] = lane(place, 2), lane(speed, 5)
        _, place, speed = parts(l_body[a])
        found[3 + a] = lane(place, 2), lane(speed, 5)
    return found


@njit
def moving(value, does):
    """A number that moves along the third place and against the sixth speed."""
    one = 1.0 if does else 0.0
    return dual(value, with_lane(eight(0.0), 2, one), with_lane(eight(0.0), 5, -one))


def test_derivatives_by_dual_numbers():
    bodily = (BODY.inverse_moments, BODY.gyroscopic, ALL)
    off = []
    for row in throws(4):
        for column in range(13):
            exact = changes_of_row(row, column, *bodily)
            d = 2.0**-17
            ends = [np.array(slope_of_row(row + sign * d * np.eye(13)[column], *bodily)) for sign in (1, -1)]
            change = ((ends[0] - ends[1]) / (2 * d))[7:]
            off.append(np.abs(exact - np.outer(change, (1.0, -1.0))).max())
    # Off by d^2/6 times third derivatives of up to 1e3 here, and by the rounding of numbers of 100 over d.
    assert max(off) < 1e-7


class TestExactFlights:
    @pytest.mark.parametrize(("method", "off"), [("rk4", 1e-11), ("adaptive@1e-13", 1e-11)])
    def test_drag_under_gravity(self, method, off):
        state, rate, t, g = throws()[0], DRAG[0] / BODY.mass, 3.0, np.array(GRAVITY)
        flight = flown(method, BODY, Forces(BODY.mass, gravity=GRAVITY, drag=(DRAG[0], None)), state[None], 3000, t)
        gone = -math.expm1(-rate * t) / rate
        position = state[:3] + g / rate * t + (state[7:10] - g / rate) * gone
        velocity = g / rate + (state[7:10] - g / rate) * math.exp(-rate * t)
        np.testing.assert_allclose(flight.read()[0, 0:3], position, rtol=0, atol=off)
        np.testing.assert_allclose(flight.read()[0, 7:10], velocity, rtol=0, atol=off)
        # The rotation feels nothing of it: bit for bit that of free flight.
        free = Flight(BODY, method)
        free.write(state[None])
        free.advance(3000, t / 3000)
        np.testing.assert_array_equal(
            flight.read()[0, [3, 4, 5, 6, 10, 11, 12]], free.read()[0, [3, 4, 5, 6, 10, 11, 12]]
        )

    @pytest.mark.parametrize(("method", "off"), [("rk4", 1e-11), ("adaptive@1e-13", 1e-11)])
    def test_angular_drag_of_equal_moments_slows_a_turn_about_a_constant_axis(self, method, off):
        cube, drag, t, w = Body(2.0, (0.3, 0.3, 0.3)), 0.15, 2.0, np.array([1.0, -2.0, 0.5])
        state = np.array([0.0] * 3 + [1.0, 0.0, 0.0, 0.0] + [0.0] * 3 + [*w])
        read = flown(method, cube, Forces(cube.mass, drag=(None, drag)), state[None], 2000, t).read()[0]
        rate = drag / 0.3
        half = -math.expm1(-rate * t) / rate * np.linalg.norm(w) / 2
        np.testing.assert_allclose(read[10:13], w * math.exp(-rate * t), rtol=0, atol=off)
        turned = np.array([math.cos(half), *(math.sin(half) * w / np.linalg.norm(w))])
        np.testing.assert_allclose(rotation_matrix(read[3:7]), rotation_matrix(turned), rtol=0, atol=off)

    @pytest.mark.parametrize(("method", "off"), [("rk4", 1e-10), ("adaptive@1e-13", 1e-11)])
    def test_a_tether_at_the_centre_of_mass_is_a_harmonic_oscillator(self, method, off):
        anchor, state, t = np.array([0.5, 1.0, -0.2]), throws()[0], 2.0
        tether = np.array([[0.0, 0.0, 0.0, *anchor, 32.0, 0.0, 0.0]])
        read = flown(method, BODY, Forces(BODY.mass, tethers=tether), state[None], 4000, t).read()[0]
        rate = math.sqrt(32.0 / BODY.mass)
        position = anchor + (state[:3] - anchor) * math.cos(rate * t) + state[7:10] / rate * math.sin(rate * t)
        np.testing.assert_allclose(read[0:3], position, rtol=0, atol=off)


def energy(state, forces):
    """Of a body on undamped tethers."""
    axes = rotation_matrix(state[3:7])
    w_body = axes.T @ state[10:13]
    stretched = [t[6] / 2 * (np.linalg.norm(state[:3] + axes @ t[:3] - t[3:6]) - t[8]) ** 2 for t in forces.tethers]
    kinetic = BODY.mass * state[7:10] @ state[7:10] + w_body @ (BODY.moments * w_body)
    return kinetic / 2 + sum(stretched) - BODY.mass * np.dot(GRAVITY, state[:3])


def test_undamped_tethers_keep_the_energy():
    undamped = TETHERS * [1, 1, 1, 1, 1, 1, 1, 0, 1]
    forces = Forces(BODY.mass, GRAVITY, undamped)
    state = throws()[0]
    before = energy(state, forces)
    assert abs(before) > 1.0
    for method, drift in (("adaptive@1e-12", 1e-9), ("rk4", 1e-6), ("symplectic-euler", 0.1)):
        after = energy(flown(method, BODY, forces, state[None], 10_000, 10.0).read()[0], forces)
        assert abs(after - before) < drift * abs(before), method
    damped = energy(
        flown("rk4", BODY, Forces(BODY.mass, GRAVITY, TETHERS), state[None], 10_000, 10.0).read()[0], forces
    )
    assert damped < before - 0.1 * abs(before)


# All four laws without a kink: the floor is so high, and so soft, that every corner is pushed all the time.
SMOOTH = ALL._replace(floor=(8.0, *NORMAL, 5.0, 0.1))
SMOOTH_TIME = 0.5


@pytest.fixture(scope="module")
def true_corners():
    state = throws()[0]
    position, axes = expected_flight(BODY, SMOOTH, state, [SMOOTH_TIME])[-1]
    return state, position + CORNERS @ axes.T


def corner_error(method, steps, true_corners):
    state, corners = true_corners
    flight = flown(method, BODY, SMOOTH, state[None], steps, SMOOTH_TIME)
    return np.linalg.norm(flight.vertices(CORNERS)[0] - corners, axis=1).max()


# Read where the step shows the order, and both the truth and rounding are a tenth of the error or less.
@pytest.mark.parametrize("method", [name for name in FORCED if METHODS[name].order is not None])
def test_order_under_forces(method, true_corners):
    order = METHODS[method].order
    steps = {1: (1024, 2048, 4096, 8192), 4: (64, 128, 256)}.get(order, (12, 16, 24))  # pyright: ignore[reportCallIssue]
    errors = [corner_error(method, n, true_corners) for n in steps]
    slopes = [
        math.log(a / b) / math.log(n / m) for (a, b), (m, n) in zip(pairwise(errors), pairwise(steps), strict=True)
    ]
    assert min(errors) > 1e-11
    assert np.abs(np.array(slopes) - order).max() < 0.2, slopes


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8, 1e-10])
def test_an_adaptive_error_is_some_tolerances(tolerance, true_corners):
    # A handful of steps, over half a second in which nothing grows more than tenfold.
    assert tolerance / 1000 < corner_error(f"adaptive@{tolerance:g}", 1, true_corners) < 30 * tolerance


DIE = Body(1.0, (0.01 / 6,) * 3)
DIE_CORNERS = np.array([[x, y, z] for x in (-0.05, 0.05) for y in (-0.05, 0.05) for z in (-0.05, 0.05)])


def corners_after(method, forces, state, steps, duration):
    return flown(method, DIE, forces, state[None], steps, duration).vertices(DIE_CORNERS)[0]


def test_adaptive_steps_shorten_at_the_kinks_of_a_bouncing_die():
    floor = Forces(DIE.mass, GRAVITY, floor=(0.0, 0.0, 1.0, 0.0, 2e4, 15.0), points=DIE_CORNERS)
    state = np.array([0.0, 0.15, 0.0, 0.8, 0.2, -0.4, 0.4, 0.5, -1.0, 0.0, 1.0, -3.0, 2.0])
    fine = corners_after("adaptive@1e-14", floor, state, 1, 0.25)
    assert fine[:, 1].min() > 0, "it has been on the floor and left it"
    # Every kink is passed by a step that is off by the tolerance, and each of a dozen magnifies what came before.
    for tolerance in (1e-6, 1e-8, 1e-10):
        off = np.linalg.norm(corners_after(f"adaptive@{tolerance:g}", floor, state, 1, 0.25) - fine, axis=1).max()
        assert off < 1000 * tolerance
    # An integrator of its own order two at kinks, in steps of a microsecond.
    assert np.linalg.norm(corners_after("rk4", floor, state, 250_000, 0.25) - fine, axis=1).max() < 1e-5


def test_no_contact_is_jumped_over():
    # A spinning die's edge dips 10 um into the floor for 3 ms: a twelfth of a step in free flight, between two stages.
    floor = Forces(DIE.mass, floor=(1e-5 - 0.05 * math.sqrt(2), 0.0, 1.0, 0.0, 2e4, 15.0), points=DIE_CORNERS)
    state = np.array([0.0] * 3 + [1.0, 0.0, 0.0, 0.0] + [0.0] * 5 + [10.0])
    state[10:13] = (0.0, 0.0, 10.0)
    height = flown("rk4", DIE, floor, state[None], 200_000, 1.0).read()[0, 1]
    assert height > 5e-4, "the contact moves the die"
    assert flown("adaptive", DIE, floor, state[None], 1, 1.0).read()[0, 1] == pytest.approx(height, abs=1e-6)


class TestFlightLaws:
    @every_forced_method
    def test_what_is_written_is_read(self, method):
        states = throws(5)
        flight = Flight(BODY, method, ALL)
        flight.write(states)
        read = flight.read()
        np.testing.assert_array_equal(read[:, [0, 1, 2, 7, 8, 9]], states[:, [0, 1, 2, 7, 8, 9]])
        np.testing.assert_allclose(read, states, rtol=0, atol=64 * EPS)

    @pytest.mark.parametrize("forces", [ALL, SEPARATELY["linear drag"]], ids=["all", "linear drag"])
    @every_forced_method
    def test_two_advances_are_one(self, method, forces):
        at_once, in_two = (Flight(BODY, method, forces) for _ in range(2))
        for flight in (at_once, in_two):
            flight.write(throws(2))
        at_once.advance(100, 0.003)
        for steps in (1, 66, 33):
            in_two.advance(steps, 0.003)
            in_two.read()
        np.testing.assert_array_equal(in_two.read(), at_once.read())

    @every_forced_method
    def test_write_forgets_and_neighbours_do_not_matter(self, method):
        states = throws(4)
        states[2, 10:13] = 0.0
        together = flown(method, BODY, ALL, states, 50, 0.1).read()
        used = flown(method, BODY, ALL, throws(3, seed=8), 37, 0.4)
        for row in range(4):
            used.write(states[row : row + 1])
            used.advance(50, 0.002)
            np.testing.assert_array_equal(used.read()[0], together[row])

    def test_a_method_without_forces_says_so(self):
        with pytest.raises(NotImplementedError, match=r"^magnus6 carries no forces$"):
            Flight(BODY, "magnus6", ALL)

    @pytest.mark.parametrize("method", ["rk4", "symplectic-euler", "adaptive"])
    def test_blown_up_rows_are_left_for_the_judge_and_the_others_fly_on(self, method):
        states = throws(2)
        states[0, 7] = 1e308
        read = flown(method, BODY, ALL, states, 10, 0.1).read()
        assert not np.isfinite(read[0]).all()
        assert np.isfinite(read[1]).all()


class TestWhatIsNotThere:
    def test_a_throw_that_never_turns_has_no_rotation_to_step(self):
        states = throws(3)
        states[:, 10:13] = 0.0
        for forces in (Forces(BODY.mass, GRAVITY), SEPARATELY["drag"]):
            flight = Flight(BODY, "rk4", forces)
            flight._rotation._method = dataclasses.replace(flight.method, steps=None)
            flight.write(states)
            flight.advance(100, 0.01)
            np.testing.assert_allclose(flight.read()[:, 3:7], states[:, 3:7], rtol=0, atol=2 * EPS)
            assert (flight.read()[:, 10:13] == 0.0).all()

    def test_a_throw_without_spin_is_left_alone_among_others(self):
        states = throws(3)
        states[1, 10:13] = 0.0
        flight = Flight(BODY, "quaternion-euler", Forces(BODY.mass, GRAVITY))
        flight.write(states)
        before = flight.read()
        flight.advance(1000, 0.001)
        np.testing.assert_array_equal(flight.read()[1, 3:7], before[1, 3:7])
        assert (flight.read()[[0, 2], 3:7] != before[[0, 2], 3:7]).all()

    def test_six_numbers_are_those_of_thirteen(self):
        """Of a body that does not turn, the whole state's kernel gives the same bits for place and velocity."""
        forces, state = Forces(BODY.mass, GRAVITY, drag=(0.3, 0.02)), throws()
        state[:, 10:13] = 0.0
        rows = np.hstack((state[:, :10], np.zeros((1, 3))))
        rk4_forced(rows, 500, 0.01, BODY.moments, BODY.inverse_moments, BODY.gyroscopic, forces)
        np.testing.assert_array_equal(flown("rk4", BODY, forces, state, 500, 5.0).read()[0, 0:3], rows[0, 0:3])

    def test_what_is_kept_without_need_moves_nothing(self):
        scene = read_scene("tether-undamped")
        ends = []
        for keep in (frozenset(), frozenset(engine.OPTIONAL), *(frozenset((spare,)) for spare in engine.OPTIONAL)):
            world = engine.build(scene, "rk4", keep)
            engine.write(world, scene.start)
            engine.advance(world, 500, scene.step)
            ends.append(engine.read(world))
        for end in ends[1:]:
            np.testing.assert_array_equal(end, ends[0])

    def test_what_is_kept_is_really_computed(self):
        """A kernel with a term does more arithmetic than one without: no timer is needed to see it."""
        fresh = njit(error_model="numpy")(rk4_forced.py_func)  # pyright: ignore[reportFunctionMemberAccess]
        sizes = []
        for forces, turning in (
            (Forces(1.0, GRAVITY), (None, None)),
            (Forces(1.0, GRAVITY, drag=(0.1, None)), (None, None)),
            (Forces(1.0, GRAVITY), (BODY.inverse_moments, None)),
            (Forces(1.0, GRAVITY), (BODY.inverse_moments, BODY.gyroscopic)),
            (ALL._replace(tethers=None), (BODY.inverse_moments, BODY.gyroscopic)),
            (ALL, (BODY.inverse_moments, BODY.gyroscopic)),
        ):
            fresh(np.zeros((0, 13)), 0, 0.0, BODY.moments, *turning, forces)
            sizes.append(fresh.inspect_llvm(fresh.signatures[-1]).count("fmul"))
        assert all(b > 1.1 * a for a, b in pairwise(sizes)), sizes


# Each alone in a process, then in one where every other kernel was compiled before it.
SHOW_BITS = """
import sys
from tumble.compare.engines import tumble as engine
from tumble.scenarios.read import read_scene
if sys.argv[1] == "crowded":
    scene = read_scene("tether-critical")
    for keep in (engine.OPTIONAL, ("drag",), ("floor",)):
        engine.write(engine.build(scene, "rk4", frozenset(keep)), scene.start)
for name in ("brick-tumble", "tether-undamped", "drag-stiff"):
    scene = read_scene(name)
    world = engine.build(scene, "rk4")
    engine.write(world, scene.start)
    engine.advance(world, 1000, scene.step)
    print(name, engine.read(world).tobytes().hex())
"""


def test_features_of_other_scenes_change_no_bit(tmp_path):
    processes = [
        subprocess.Popen(
            [sys.executable, "-c", SHOW_BITS, how],
            stdout=subprocess.PIPE,
            text=True,
            env={**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / how)},
        )
        for how in ("alone", "crowded")
    ]
    alone, crowded = (process.communicate(timeout=PATIENCE_S)[0].splitlines() for process in processes)
    assert len(alone) == 3
    assert alone == crowded


class TestEngine:
    def test_a_scenes_forces_are_the_solvers(self):
        scene = dataclasses.replace(
            read_scene("brick-tumble"),
            gravity=np.array(GRAVITY),
            tethers=tuple(Tether(row[:3], row[3:6], *row[6:].tolist()) for row in TETHERS),
            drag=Drag(*DRAG),
            floor=Floor(FLOOR[0], np.array(NORMAL), *FLOOR[4:]),
        )
        forces = forces_of(scene)
        assert (forces.mass, forces.gravity, forces.drag, forces.floor) == (scene.body.mass, GRAVITY, DRAG, FLOOR)
        np.testing.assert_array_equal(forces.tethers, TETHERS)
        np.testing.assert_array_equal(forces.points, scene.body.points)

    def test_what_a_scene_has_not_got_is_none(self):
        free = forces_of(dataclasses.replace(read_scene("brick-tumble"), gravity=None))
        assert free == Forces(free.mass)
        assert forces_of(dataclasses.replace(read_scene("drag-stiff"), drag=Drag(0.0, 2.0))).drag == (None, 2.0)

    def test_what_is_kept_is_there_without_strength(self):
        free = dataclasses.replace(read_scene("brick-tumble"), gravity=None)
        for spare, law in (("gravity", "gravity"), ("tether", "tethers"), ("drag", "drag"), ("floor", "floor")):
            kept = forces_of(free, frozenset((spare,)))
            assert [name for name in LAWS if getattr(kept, name) is not None] == [law]
            for state in throws(3):
                np.testing.assert_array_equal(wrench(*tuples(state), kept), np.zeros((2, 3)))
        assert engine.build(free, "rk4", frozenset(("rotation",))).flight._rotation._always_turning
        with pytest.raises(NotImplementedError, match="carries no forces"):
            engine.build(free, "magnus6", frozenset(("tether",)))
        with pytest.raises(NotImplementedError, match="not a sum of terms"):
            engine.build(free, "exact", frozenset(("gyroscopic",)))

    def test_auto_says_what_it_took_and_why(self):
        scene = read_scene("tether-overdamped")
        for changes, took in (
            ({}, r"^took adaptive: w dt = 9\.38 in the stiffest mode at the scene's step"),
            ({"step": 1e-3}, r"^took radau5: overdamped with w dt = 93\.8 "),
            ({"tethers": (), "gravity": np.array(GRAVITY)}, "^took exact: a free flight"),
            (
                {"duration": 1e9, "tethers": read_scene("tether-undamped").tethers},
                "^took gauss6: w dt = 0.235 .* 2.3e.12",
            ),
        ):
            world = engine.build(dataclasses.replace(scene, **changes), "auto")
            assert re.match(took, engine.remark(world))
            assert world.flight.method is METHODS[engine.remark(world).split()[1].rstrip(":")]
        assert engine.remark(engine.build(scene, "rk4")) == ""

    def test_steps_that_are_not_found_are_audited(self):
        scene = read_scene("tether-undamped")
        world = engine.build(scene, "gauss6")
        engine.write(world, scene.start)
        engine.advance(world, 2, scene.step)
        assert engine.audit(world) == []
        # A pull that is no number any more.
        faster = engine.read(world)
        faster[:, 7] = 1e308
        engine.write(world, faster)
        engine.advance(world, 3, 1.0)
        assert engine.audit(world) == [("unsolved", "Newton did not converge in 3 steps")]
        assert np.isnan(engine.read(world)[0, 0:3]).all()

    def test_the_stiffest_mode(self):
        # A cube of 1 kg and 1 m on a tether at its corner: w = sqrt(5.5 k), and a damper as much.
        corner = [0.5, 0.5, 0.5]
        cube, tether = Body(1.0, (1 / 6,) * 3), np.array([[*corner, 0.0, 0.0, 0.0, 100.0, 2.0, 0.0]])
        assert fastest(cube, Forces(1.0, tethers=tether)) == pytest.approx((math.sqrt(550.0), 11.0))
        assert fastest(cube, Forces(1.0, drag=(3.0, 1.0))) == pytest.approx((0.0, 6.0))
        floor = Forces(1.0, floor=(0.0, 0.0, 1.0, 0.0, 100.0, 2.0), points=np.array([corner, [0.0, 0.0, 0.0]]))
        assert fastest(cube, floor) == pytest.approx((math.sqrt(550.0), 11.0))
