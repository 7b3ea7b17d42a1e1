"""gauss6 and radau5: their order, what they keep, and that no step is too long for them."""

import math
import time
from itertools import product

import numpy as np
import pytest
from numba import njit
from scipy.integrate import solve_ivp

from tumble.solver.body import Body
from tumble.solver.collocation.changes import changes_at
from tumble.solver.collocation.corrections import inverse, real_inverse
from tumble.solver.compilation import OPTIONS
from tumble.solver.eight import lane
from tumble.solver.forces import Forces
from tumble.solver.integrators.gauss6 import GAUSS, gauss6, gauss6_forced
from tumble.solver.integrators.radau5 import RADAU, radau5, radau5_forced
from tumble.solver.motion import load, slope, store
from tumble.solver.quaternion import to_matrix

EPS = np.finfo(float).eps
FORCED = {"gauss6": gauss6_forced, "radau5": radau5_forced}
ORDERS = {"gauss6": 6, "radau5": 5}
SIZE = np.array([0.4, 0.3, 0.2])
CORNERS = np.array(list(product((-0.5, 0.5), repeat=3))) * SIZE


def box(size=SIZE, mass=1.0):
    h, w, d = size
    return Body(mass, (mass * (w * w + d * d) / 12, mass * (h * h + d * d) / 12, mass * (h * h + w * w) / 12))


def row(body, x=(0.0, 0.0, 0.0), q=(1.0, 0.0, 0.0, 0.0), v=(0.0, 0.0, 0.0), w_body=(0.0, 0.0, 0.0)):
    unit = np.array(q) / np.linalg.norm(q)
    return np.array([[*x, *unit, *v, *(np.array(body.moments) * w_body), 0.0]])


def fly(method, body, start, n, dt, forces):
    rows = start.copy()
    FORCED[method](rows, n, dt, body.moments, body.inverse_moments, body.gyroscopic, forces)
    return rows


def corners(rows):
    return rows[0, 0:3] + CORNERS @ to_matrix(rows[0, 3:7]).T


def tether(point, anchor, stiffness, damping=0.0, rest_length=0.0):
    return np.array([[*point, *anchor, stiffness, damping, rest_length]])


def energy(body, rows, tethers=(), weight=0.0, floor=None):
    """Of motion, springs, weight along -y and a penalty floor at y = 0 [J]."""
    state = rows[0]
    rotation = to_matrix(state[3:7])
    total = body.mass * state[7:10] @ state[7:10] / 2 + sum(state[10:13] ** 2 / body.moments) / 2
    for one in tethers:
        length = np.linalg.norm(state[0:3] + rotation @ one[0:3] - one[3:6])
        total += one[6] * (length - one[8]) ** 2 / 2
    if floor is not None:
        total += floor / 2 * sum(np.minimum(0.0, corners(rows)[:, 1]) ** 2)
    return total + body.mass * weight * state[1]


def frequency(body, one):
    """The fastest of a body at a stretched tether [rad/s]: k (1/m + the pull of the turn)."""
    x, y, z = one[0:3]
    lever = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
    mobility = np.eye(3) / body.mass + lever @ np.diag(body.inverse_moments) @ lever.T
    return math.sqrt(one[6] * np.linalg.eigvalsh(mobility)[-1])


def at_random(seed, stiffness, rest_length, stretch, spin=3.0, damping=0.0):
    """A body of random shape, pose and motion, its corner on a stretched tether."""
    random = np.random.default_rng(seed)
    size = random.uniform(0.2, 1.0, 3)
    body = box(size)
    start = row(body, q=random.normal(size=4), v=random.normal(size=3), w_body=spin * random.normal(size=3))
    corner = to_matrix(start[0, 3:7]) @ (size / 2)
    away = random.normal(size=3)
    anchor = corner + (rest_length + stretch) * away / np.linalg.norm(away)
    return body, start, tether(size / 2, anchor, stiffness, damping, rest_length)


# ---- order -----------------------------------------------------------------------------------------------------------


def true_corners(body, start, duration, forces):
    """By DOP853 on rotation matrices and the angular momentum in world axes, with the laws written out once more."""
    inertia = np.diag(body.moments)

    def rate(_, y):
        x, rotation, v, l_world = y[0:3], y[3:12].reshape(3, 3), y[12:15], y[15:18]
        w = rotation @ (l_world @ rotation / np.diag(inertia))
        force = body.mass * np.array(forces.gravity) - forces.drag[0] * v
        torque = -forces.drag[1] * w
        for one in forces.tethers:
            lever = rotation @ one[0:3]
            offset, velocity = x + lever - one[3:6], v + np.cross(w, lever)
            length = np.linalg.norm(offset)
            along = offset / length
            pull = -(one[6] * (length - one[8]) + one[7] * velocity @ along) * along
            if one[8] == 0.0:
                pull = -one[6] * offset - one[7] * velocity
            force, torque = force + pull, torque + np.cross(lever, pull)
        turning = np.cross(w, rotation.T).T
        return np.concatenate((v, turning.ravel(), force / body.mass, torque))

    rotation = to_matrix(start[0, 3:7])
    y = np.concatenate((start[0, 0:3], rotation.ravel(), start[0, 7:10], rotation @ start[0, 10:13]))
    y = solve_ivp(rate, (0.0, duration), y, "DOP853", rtol=2.3e-14, atol=1e-15).y[:, -1]
    return y[0:3] + CORNERS @ y[3:12].reshape(3, 3).T


@pytest.mark.parametrize("rest_length", [0.0, 0.4])
@pytest.mark.parametrize("method", FORCED)
def test_order_under_all_smooth_forces(method, rest_length):
    body = box()
    start = row(body, q=(0.8, 0.2, -0.4, 0.4), v=(0.5, 0.2, -0.3), w_body=(1.0, -2.0, 1.5))
    tethers = np.vstack(
        (
            tether(SIZE / 2, (0.3, 0.8, 0.1), 30.0, 0.2, rest_length),
            tether(-SIZE / 2, (-0.2, -0.7, 0.3), 20.0, 0.1, rest_length),
        )
    )
    forces = Forces(body.mass, (0.3, -9.81, 0.1), tethers, (0.3, 0.02))
    true = true_corners(body, start, 1.0, forces)
    steps = np.array([64, 96, 128, 192])
    errors = np.array([np.abs(corners(fly(method, body, start, n, 1.0 / n, forces)) - true).max() for n in steps])
    assert errors.min() > 1e-12, "above the rounding of both"
    slopes = np.log(errors[:-1] / errors[1:]) / np.log(steps[1:] / steps[:-1])
    assert np.abs(slopes - ORDERS[method]).max() < 0.2, slopes


# ---- exact solutions -------------------------------------------------------------------------------------------------


def rational(method, z):
    """What one step makes of y' = (z / dt) y: Pade's (3, 3) or (2, 3).  Hairer & Wanner II, table IV.3.1."""
    if method == "gauss6":
        return (1 + z / 2 + z**2 / 10 + z**3 / 120) / (1 - z / 2 + z**2 / 10 - z**3 / 120)
    return (1 + 2 * z / 5 + z**2 / 20) / (1 - 3 * z / 5 + 3 * z**2 / 20 - z**3 / 60)


@pytest.mark.parametrize("w_dt", [0.01, 0.1, 1.0, 10.0, 100.0, 1000.0])
@pytest.mark.parametrize("method", FORCED)
def test_a_spring_through_the_centre_is_the_linear_method_to_rounding(method, w_dt):
    # Off the centre nothing pulls: x + i v / w turns by exactly the method's own number each step, at any step.
    body, stiffness, steps = box(mass=2.0), 5e3, 20
    w = math.sqrt(stiffness / body.mass)
    start = row(body, x=(0.01, 0.0, 0.0))
    forces = Forces(body.mass, tethers=tether((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), stiffness))
    after = fly(method, body, start, steps, w_dt / w, forces)[0]
    turned = 0.01 * rational(method, -1j * w_dt) ** steps
    # Each step rounds w dt times, for the momentum is dt times a slope of w^2 x.
    assert after[0] == pytest.approx(turned.real, abs=0.01 * steps * 20 * EPS * max(1.0, w_dt))
    assert after[7] / w == pytest.approx(turned.imag, abs=0.01 * steps * 20 * EPS * max(1.0, w_dt))
    assert after[13] == 0


@pytest.mark.parametrize("method", FORCED)
def test_drag_under_gravity(method):
    body, g, duration = box(mass=2.0), np.array([0.0, -9.81, 0.0]), 2.0
    linear, v = 0.7, np.array([1.0, 4.0, -2.0])
    rate = linear / body.mass
    start = row(body, v=v, w_body=(1.0, 2.0, 0.5))
    rows = fly(method, body, start, 200, duration / 200, Forces(body.mass, tuple(g), drag=(linear, None)))
    gone = -math.expm1(-rate * duration)
    true = (v - g / rate) * gone / rate + g / rate * duration
    # 200 steps of a rounding or two of a number of 10.
    assert rows[0, 0:3] == pytest.approx(true, abs=200 * 10 * EPS)


def test_what_never_turns_moves_the_same_without_a_rotation():
    body = box()
    start = row(body, v=(1.0, 4.0, -2.0), w_body=(1.0, 2.0, 0.5))
    forces = Forces(body.mass, (0.0, -9.81, 0.0), drag=(0.7, None))
    whole, place = fly("gauss6", body, start, 50, 0.02, forces), start.copy()
    gauss6_forced(place, 50, 0.02, body.moments, None, None, forces)
    np.testing.assert_allclose(place[0, [0, 1, 2, 7, 8, 9]], whole[0, [0, 1, 2, 7, 8, 9]], rtol=50 * 4 * EPS)
    np.testing.assert_array_equal(place[0, [3, 4, 5, 6, 10, 11, 12]], start[0, [3, 4, 5, 6, 10, 11, 12]])


# ---- no step is too long ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("rest_length", [0.0, 0.3])
@pytest.mark.parametrize(
    ("w_dt", "steps", "band"), [(0.1, 100, 1e-10), (1.0, 100, 1e-5), (10.0, 60, 1e-3), (100.0, 10, 1e-3)]
)
@pytest.mark.parametrize("seed", range(4))
def test_an_undamped_tether_keeps_its_energy_at_any_step(seed, w_dt, steps, band, rest_length):
    # From soft to stiff; a stretch beyond the rest length would lead through the anchor, where the force jumps.
    body, start, tethers = at_random(seed, 10.0 ** (3 + seed), rest_length, 0.012)
    forces = Forces(body.mass, tethers=tethers)
    dt = w_dt / frequency(body, tethers[0])
    before, rows = energy(body, start, tethers), start
    for _ in range(steps):
        rows = fly("gauss6", body, rows, 1, dt, forces)
        assert energy(body, rows, tethers) == pytest.approx(before, rel=band)
    assert rows[0, 13] == 0


@pytest.mark.parametrize("w_dt", [3.0, 10.0])
@pytest.mark.parametrize("seed", range(6))
def test_an_undamped_tether_that_slackens_keeps_its_energy(seed, w_dt):
    # Swung through its anchor, where the force jumps: only a step in parts sees that.
    body, start, tethers = at_random(seed, 1e4, 0.02, 0.03)
    forces, dt = Forces(body.mass, tethers=tethers), w_dt / frequency(body, tethers[0])
    before, rows = energy(body, start, tethers), start
    for _ in range(40):
        rows = fly("gauss6", body, rows, 5, dt, forces)
        assert energy(body, rows, tethers) == pytest.approx(before, rel=1e-3)
    assert rows[0, 13] == 0


@pytest.mark.parametrize(("w_dt", "most"), [(10.0, 1e-8), (1e2, 1e-7), (1e3, 1e-6), (1e4, 1e-5)])
@pytest.mark.parametrize("rest_length", [0.0, 0.3])
@pytest.mark.parametrize("seed", range(3))
def test_ten_thousand_long_steps_keep_the_energy(seed, rest_length, w_dt, most):
    # At one step, on ever stiffer tethers that store as much.
    body, start, tethers = at_random(seed, 1e6, rest_length, 0.012, spin=1.0)
    times = (w_dt / (1e-4 * frequency(body, tethers[0]))) ** 2
    corner = start[0, 0:3] + to_matrix(start[0, 3:7]) @ tethers[0, 0:3]
    away = (tethers[0, 3:6] - corner) / (rest_length + 0.012)
    tethers[0, 3:6] = corner + (rest_length + 0.012 / math.sqrt(times)) * away
    tethers[0, 6] *= times
    before, rows = energy(body, start, tethers), start
    for _ in range(10):
        rows = fly("gauss6", body, rows, 1000, 1e-4, Forces(body.mass, tethers=tethers))
        # A thousandth is asked for; left is the rounding of places, which such springs feel.
        assert energy(body, rows, tethers) == pytest.approx(before, rel=most)
    assert rows[0, 13] == 0


def test_ten_thousand_steps_at_one_radian_keep_the_energy():
    body, start, tethers = at_random(0, 1e6, 0.3, 0.012)
    forces = Forces(body.mass, tethers=tethers)
    before, rows = energy(body, start, tethers), start
    for _ in range(10):
        rows = fly("gauss6", body, rows, 1000, 1.0 / frequency(body, tethers[0]), forces)
        # A thousandth is asked for; only the quadrature of a power of degree above 13, and rounding, are lost.
        assert energy(body, rows, tethers) == pytest.approx(before, rel=1e-9)


@pytest.mark.parametrize("w_dt", [0.1, 1.0, 10.0, 100.0, 1000.0])
@pytest.mark.parametrize("rest_length", [0.0, 0.3])
@pytest.mark.parametrize("method", FORCED)
def test_a_damper_never_drives(method, rest_length, w_dt):
    # Twenty times the critical damping.
    body, start, tethers = at_random(5, 1e5, rest_length, 0.012)
    w = frequency(body, tethers[0])
    tethers[0, 7] = 40.0 * tethers[0, 6] / w
    rows, before = start, energy(body, start, tethers)
    for _ in range(12):
        rows = fly(method, body, rows, 1, w_dt / w, Forces(body.mass, tethers=tethers))
        after = energy(body, rows, tethers)
        assert after <= before * (1 + 1e-6)
        before = after
    assert rows[0, 13] == 0


@pytest.mark.parametrize("w_dt", [100.0, 1e4])
def test_a_long_step_without_a_rotation_is_the_same(w_dt):
    body, stiffness = box(), 1e6
    start = row(body, x=(0.01, 0.02, -0.01), v=(1.0, -2.0, 0.5))
    forces = Forces(body.mass, (0.0, -9.81, 0.0), tether((0.0, 0.0, 0.0), (0.0, 0.5, 0.0), stiffness, 0.0, 0.4))
    dt = w_dt * math.sqrt(body.mass / stiffness)
    whole, place = fly("gauss6", body, start, 3, dt, forces), start.copy()
    gauss6_forced(place, 3, dt, body.moments, None, None, forces)
    # Newton's method ends where 2^-40 of the body's size is left to correct.
    np.testing.assert_allclose(place[0, 0:3], whole[0, 0:3], rtol=0.0, atol=3 * 2.0**-40)
    assert place[0, 13] == whole[0, 13] == 0


def hung(rest_length, w_dt, dt, count):
    """Return a body at rest that hangs from a stiff tether, and its rows after so many steps."""
    body, weight = box(), 9.81
    stiffness = body.mass * (w_dt / dt) ** 2
    start = row(body, x=(0.0, -(rest_length + weight / stiffness) - SIZE[1] / 2, 0.0))
    tethers = tether((0.0, SIZE[1] / 2, 0.0), (0.0, 0.0, 0.0), stiffness, 0.0, rest_length)
    return start, fly("gauss6", body, start, count, dt, Forces(body.mass, (0.0, -weight, 0.0), tethers))


@pytest.mark.parametrize("w_dt", [100.0, 1e3, 1e4])
@pytest.mark.parametrize("rest_length", [0.0, 0.3])
def test_a_body_that_hangs_at_rest_stays(rest_length, w_dt):
    dt = 1e-3
    start, rows = hung(rest_length, w_dt, dt, 1000)
    assert rows[0, 13] == 0
    np.testing.assert_allclose(rows[0, 0:3], start[0, 0:3], rtol=0.0, atol=100 * EPS)
    # A rounding of the place, of the fastest mode or of those that w dt does not count.
    assert np.abs(rows[0, 7:10]).max() < 100 * EPS * w_dt / dt


def test_what_rounding_does_to_a_stiff_tether_is_no_work_that_is_missed():
    # It would be sought in ever shorter parts of a step: 20 to 3 000 times the time.
    def taken_s(w_dt):
        begun = time.thread_time()
        hung(0.3, w_dt, 1e-3, 200)
        return time.thread_time() - begun

    taken = [[taken_s(w_dt) for w_dt in (1.0, 100.0, 1e3, 1e4)] for _ in range(5)]
    plain, *stiff = np.min(taken, axis=0)
    assert max(stiff) < 10 * plain


@pytest.mark.parametrize("rate_dt", [10.0, 100.0, 1e4])
def test_what_is_overdamped_is_gone_after_a_step_of_radau_and_lingers_with_gauss(rate_dt):
    # Drag that would stop the body within dt / rate_dt: (1 + 2z/5 + z^2/20) / ... falls as 3 / |z|, and Gauss's as -1.
    body, dt = box(), 0.1
    forces = Forces(body.mass, (0.0, 0.0, 0.0), drag=(rate_dt * body.mass / dt, None))
    left = {method: fly(method, body, row(body, v=(1.0, 0.0, 0.0)), 1, dt, forces)[0, 7] for method in FORCED}
    assert abs(left["radau5"]) < 3.0 / rate_dt
    for method in FORCED:
        assert left[method] == pytest.approx(rational(method, -rate_dt), abs=rate_dt * 20 * EPS)
    assert rate_dt < 100.0 or left["gauss6"] < -0.7


@pytest.mark.parametrize("w_dt", [0.1, 1.0, 10.0, 100.0])
@pytest.mark.parametrize(
    ("method", "damping", "most"), [("gauss6", 0.0, 1.02), ("gauss6", 15.0, 1.0), ("radau5", 15.0, 1.0)]
)
def test_a_stiff_floor_never_drives(method, damping, most, w_dt):
    body = box()
    stiffness, weight = 2e4, 9.81
    dt = w_dt / math.sqrt(8 * stiffness / body.mass)
    floor = (0.0, 0.0, 1.0, 0.0, stiffness, damping)
    forces = Forces(body.mass, (0.0, -weight, 0.0), floor=floor, points=CORNERS)
    start = row(body, x=(0.0, 0.6, 0.0), q=(0.8, 0.2, -0.4, 0.4), w_body=(3.0, 2.0, -4.0))
    rows, before, lowest = start, energy(body, start, (), weight, stiffness), np.inf
    for _ in range(20):
        rows = fly(method, body, rows, max(1, round(0.06 / dt)), dt, forces)
        lowest = min(lowest, corners(rows)[:, 1].min())
        # The kink costs an undamped floor what the work of one contact is unclear by; a damper only takes.
        assert energy(body, rows, (), weight, stiffness) < most * before * (1 + 1e-3)
    assert rows[0, 13] == 0
    assert lowest < 0.05, "it has been at the floor"


def test_a_body_comes_to_rest_on_the_floor():
    body = box()
    forces = Forces(body.mass, (0.0, -9.81, 0.0), floor=(0.0, 0.0, 1.0, 0.0, 2e4, 300.0), points=CORNERS)
    rows = fly("radau5", body, row(body, x=(0.0, 0.3, 0.0)), 300, 0.01, forces)
    # Four corners carry the weight.
    assert rows[0, 1] == pytest.approx(SIZE[1] / 2 - 9.81 / (4 * 2e4), abs=1e-12)
    assert np.abs(rows[0, 7:13]).max() < 1e-12
    assert rows[0, 13] == 0


# ---- what was not found ----------------------------------------------------------------------------------------------


def test_steps_that_are_not_found_are_counted_and_leave_no_number():
    body = box()
    # 1e15 rad in a step: its least part would still turn the body a thousand radians.
    start = row(body, w_body=(1e15, 2e15, 3e15))
    forces = Forces(body.mass, tethers=tether(SIZE / 2, SIZE, 80.0))
    rows = fly("gauss6", body, start, 7, 1.0, forces)
    assert rows[0, 13] == 7
    assert np.isnan(rows[0, 0:13]).all()
    assert fly("gauss6", body, rows, 5, 1.0, forces)[0, 13] == 12


@pytest.mark.parametrize("method", [gauss6, radau5])
def test_a_free_turn_that_is_not_found_is_nan(method):
    body = box()
    spins = row(body, w_body=(1e15, 2e15, 3e15))[:, [3, 4, 5, 6, 10, 11, 12]]
    method(spins, 1, 1.0, body.inverse_moments, body.gyroscopic)
    assert np.isnan(spins).all()


def test_a_neighbour_that_is_not_found_changes_nothing():
    body, start, tethers = at_random(1, 1e4, 0.0, 0.012)
    both = np.vstack((row(body, w_body=(1e15, 2e15, 3e15)), start))
    forces = Forces(body.mass, tethers=tethers)
    gauss6_forced(both, 10, 0.01, body.moments, body.inverse_moments, body.gyroscopic, forces)
    np.testing.assert_array_equal(both[1], fly("gauss6", body, start, 10, 0.01, forces)[0])
    assert (both[:, 13] == (10, 0)).all()


# ---- the parts -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("method", FORCED)
def test_steps_add_up_to_the_last_bit(method):
    body, start, tethers = at_random(2, 1e5, 0.3, 0.05, damping=3.0)
    forces = Forces(body.mass, tethers=tethers)
    once = fly(method, body, start, 30, 0.01, forces)
    twice = fly(method, body, fly(method, body, start, 11, 0.01, forces), 19, 0.01, forces)
    np.testing.assert_array_equal(once, twice)


def test_gauss_comes_back():
    body, start, tethers = at_random(3, 1e4, 0.3, 0.05)
    forces = Forces(body.mass, tethers=tethers)
    dt = 0.3 / frequency(body, tethers[0])
    turned = fly("gauss6", body, start, 50, dt, forces)
    turned[0, 7:13] *= -1.0
    back = fly("gauss6", body, turned, 50, dt, forces)
    # 100 steps of a few roundings each, which the swing of a tether magnifies no more than tenfold.
    np.testing.assert_allclose(to_matrix(back[0, 3:7]), to_matrix(start[0, 3:7]), rtol=0.0, atol=100 * 40 * EPS)
    np.testing.assert_allclose(back[0, 0:3], start[0, 0:3], rtol=0.0, atol=100 * 40 * EPS)


@njit(**OPTIONS)
def columns_of(state, inverse_moments, gyroscopic, forces):
    """How dv/dt and dL/dt change with x, a turn, v and L."""
    found = np.empty((6, 12))
    _, _, changes = changes_at(load(state, inverse_moments), inverse_moments, gyroscopic, forces)
    for number in range(6):
        for row in range(6):
            found[row, number] = lane(changes.by_place[number + number // 3], row + row // 3)
            found[row, 6 + number] = lane(changes.by_speed[number + number // 3], row + row // 3)
    return found


@njit(**OPTIONS)
def slope_of(state, inverse_moments, gyroscopic, forces):
    found = np.empty(13)
    store(found, slope(load(state, inverse_moments), inverse_moments, gyroscopic, forces))
    return found


def stiff_all_over():
    body, start, tethers = at_random(4, 80.0, 0.3, 0.2, damping=0.6)
    floor = (0.1, 0.0, 1.0, 0.0, 300.0, 4.0)
    return body, start[0, :13], Forces(body.mass, (0.0, -9.81, 0.0), tethers, (0.3, 0.02), floor, CORNERS)


def test_the_changes_are_those_of_the_equations_of_motion():
    body, state, forces = stiff_all_over()
    turning, step = (body.inverse_moments, body.gyroscopic), 1e-5
    found = columns_of(state, *turning, forces)
    # A turn about an axis of the body is I^-1 of its column, and q moves by half of it.
    ways = np.zeros((12, 13))
    ways[0:3, 0:3] = ways[6:9, 7:10] = ways[9:12, 10:13] = np.eye(3)
    w, x, y, z = state[3:7]
    axes = np.array([[-x, w, z, -y], [-y, -z, w, x], [-z, y, -x, w]])
    ways[3:6, 3:7] = axes * np.array(body.inverse_moments)[:, None] / 2
    differences = [
        (slope_of(state + step * way, *turning, forces) - slope_of(state - step * way, *turning, forces)) / (2 * step)
        for way in ways
    ]
    # Differences are off by step^2 and by a rounding over step, of numbers up to 1e4.
    np.testing.assert_allclose(found, np.transpose(differences)[7:], rtol=1e-6, atol=1e-6)
    assert np.abs(found).max() > 100.0, "stiff enough to tell"


@njit(**OPTIONS)
def inverse_of(state, inverse_moments, gyroscopic, forces, h):
    found = np.empty((6, 6), np.complex128)
    _, _, changes = changes_at(load(state, inverse_moments), inverse_moments, gyroscopic, forces)
    six = inverse(changes, h)
    for number in range(6):
        for row in range(6):
            column = six[number]
            found[row, number] = complex(lane(column.real, row + row // 3), lane(column.imaginary, row + row // 3))
    return found


@pytest.mark.parametrize("h", [0.02 * GAUSS.real_rate + 0j, 2.0 * GAUSS.pair_rate, 50.0 * RADAU.pair_rate])
def test_the_inverse_of_a_correction(h):
    body, state, forces = stiff_all_over()
    motion = (state, body.inverse_moments, body.gyroscopic, forces)
    place, speed = np.split(columns_of(*motion), 2, axis=1)
    matrix = np.eye(6) - h * speed - h * h * place
    # Elimination loses up to the condition of the matrix, without pivots a little more.
    most = 100 * EPS * np.linalg.cond(matrix)
    np.testing.assert_allclose(inverse_of(*motion, h) @ matrix, np.eye(6), rtol=0.0, atol=most)


@njit(**OPTIONS)
def real_inverse_of(state, inverse_moments, gyroscopic, forces, h):
    found = np.empty((6, 6))
    _, _, changes = changes_at(load(state, inverse_moments), inverse_moments, gyroscopic, forces)
    six = real_inverse(changes, h)
    for number in range(6):
        for row in range(6):
            found[row, number] = lane(six[number], row + row // 3)
    return found


@pytest.mark.parametrize("h", [0.02, 3.0])
def test_the_inverse_of_a_real_correction_is_the_complex_one_to_the_last_bit(h):
    body, state, forces = stiff_all_over()
    motion = (state, body.inverse_moments, body.gyroscopic, forces)
    np.testing.assert_array_equal(real_inverse_of(*motion, h), inverse_of(*motion, h + 0j).real)


@pytest.mark.parametrize("method", [GAUSS, RADAU])
def test_the_numbers_of_a_scheme(method):
    # A stage's integrals are right for parabolas, and its modes put the coefficients together again.
    nodes = method.coefficients.sum(axis=1)
    for power in range(3):
        np.testing.assert_allclose(method.coefficients @ nodes**power, nodes ** (power + 1) / (power + 1), atol=4 * EPS)
    again = method.real_rate * np.outer(method.from_real, method.to_real)
    again = again + 2 * (method.pair_rate * np.outer(method.from_pair, method.to_pair)).real
    np.testing.assert_allclose(again, method.coefficients, atol=20 * EPS)
    # A constant force counts for itself.
    for means in (method.means[:8], method.means[8:]):
        np.testing.assert_allclose(means[:, :3].sum(axis=0), 1.0, atol=20 * EPS)
    # With the stages for instants it is what is seen there that counts, and velocities and places are theirs.
    np.testing.assert_allclose(method.means[8:11, :3], np.eye(3), atol=20 * EPS)
    np.testing.assert_allclose(method.values[3:, :3], np.eye(3), atol=20 * EPS)
    np.testing.assert_allclose(method.integrals[3:, :3], method.to_stages[:, :3], atol=20 * EPS)


def test_gauss_keeps_every_quadratic_and_radau_does_not():
    # b_i a_ij + b_j a_ji = b_i b_j: Cooper (1987); Hairer, Lubich & Wanner (2006), theorem IV.2.2.
    def defect(method):
        product_of = method.weights[:, None] * method.coefficients
        return np.abs(product_of + product_of.T - np.outer(method.weights, method.weights)).max()

    assert defect(GAUSS) < 4 * EPS
    assert defect(RADAU) > 1e-3
