"""The closed form against a Taylor integration, published numbers and conservation laws; the truth's two limits."""

import itertools
import subprocess
import sys
from dataclasses import replace
from fractions import Fraction
from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tumble.scenarios.frames import rotation_matrix, vertices
from tumble.scenarios.impulse import RayMissed, jump
from tumble.scenarios.scene import Body, Impulse, Ray, Scene, frozen_array
from tumble.scenarios.truth import truth
from tumble.scenarios.truth.elliptic import JacobiFunctions, third_kind_angle
from tumble.scenarios.truth.resolution import PRECISIONS, settle
from tumble.scenarios.truth.rotation import SteadySpin, free_rotation
from tumble.scenarios.truth.throw import read_throw

# 45 digits: what is compared to 25 or more has twenty to lose to radians and the separatrix.
BITS = 150
MP: Any = mpmath.MPContext()
MP.prec = BITS
EYE = np.array([[Fraction(int(row == column)) for column in range(3)] for row in range(3)])
HALF_ULP = 2.0**-53

slow = settings(derandomize=True, deadline=None, max_examples=12)
quick = settings(derandomize=True, deadline=None, max_examples=25)


def exactly(*numbers):
    return np.array([Fraction(number) for number in numbers])


def numbers(*printed):
    return np.array([MP.mpf(number) for number in printed])


def rotate(moments, w_body, t, axes=EYE):
    """The closed form: axes and w_body at t."""
    axes, L_body = free_rotation(MP, moments, axes, moments * w_body).at(Fraction(t))
    return axes, L_body / moments


# --- an independent answer: Taylor series of Euler's and Poisson's equations in whole numbers -----------------------

SHIFT = 140  # a number is a whole multiple of 2^-140
ORDER = 46


def taylor(moments, w_body, t):
    """Axes and w_body at t by Taylor steps of the 46th order: products and sums, nothing elliptic.

    With G = max(1, |factors of Euler's equations|) and W = max |w_i| the series are majorised by those of
    W / (1 - G W t) and (1 - G W t)^-2, so at G W t = 0.2 what is left out is below 47 x 0.2^47 = 7e-32 a step.
    """
    I1, I2, I3 = moments
    gyro = [(I2 - I3) / I1, (I3 - I1) / I2, (I1 - I2) / I3]
    speed = max(abs(w_body)) * max(1, *(abs(factor) for factor in gyro))
    steps = max(1, int(np.ceil(float(speed * Fraction(t)) / 0.2)))
    whole = lambda number: round(Fraction(number) * 2**SHIFT)  # noqa: E731
    gyro, h = [whole(factor) for factor in gyro], whole(Fraction(t) / steps)
    w = [whole(rate) for rate in w_body]
    rows = [[whole(int(row == column)) for column in range(3)] for row in range(3)]
    for _ in range(steps):
        w, rows = _taylor_step(gyro, w, rows, h)
    back = lambda number: MP.mpf(Fraction(number, 2**SHIFT))  # noqa: E731
    return np.array([[back(number) for number in row] for row in rows]), np.array([back(rate) for rate in w])


def _taylor_step(gyro, w, rows, h):
    # Series in t/h, so that every coefficient stays small: w' = gyro w w, and a row r of the axes has r' = r x w.
    w_series = [[rate] for rate in w]
    row_series = [[[number] for number in row] for row in rows]
    for k in range(ORDER):
        convolve = lambda a, b: sum(map(int.__mul__, a, reversed(b))) >> SHIFT  # noqa: E731
        pairs = [convolve(w_series[(i + 1) % 3], w_series[(i + 2) % 3]) for i in range(3)]
        turned = [
            [
                convolve(r[(i + 1) % 3], w_series[(i + 2) % 3]) - convolve(r[(i + 2) % 3], w_series[(i + 1) % 3])
                for i in range(3)
            ]
            for r in row_series
        ]
        for i in range(3):
            w_series[i].append(((gyro[i] * pairs[i] >> SHIFT) * h >> SHIFT) // (k + 1))
        for r, rates in zip(row_series, turned, strict=True):
            for i in range(3):
                r[i].append((rates[i] * h >> SHIFT) // (k + 1))
    return [sum(series) for series in w_series], [[sum(series) for series in r] for r in row_series]


def assert_same_motion(moments, w_body, t, digits=28):
    for got, expected in zip(rotate(moments, w_body, t), taylor(moments, w_body, t), strict=True):
        assert abs(got - expected).max() < 10.0**-digits * max(1, abs(expected).max())


def test_taylor_integration_knows_a_steady_spin():
    axes, w_body = taylor(exactly(1, 2, 3), exactly(0, 0, 2), 3)
    cos, sin = MP.cos(6), MP.sin(6)
    assert abs(axes - np.array(((cos, -sin, 0), (sin, cos, 0), (0, 0, 1)))).max() < 1e-32
    assert abs(w_body - exactly(0, 0, 2)).max() < 1e-40


# --- the closed form, branch by branch ------------------------------------------------------------------------------


@pytest.mark.parametrize("moments", list(itertools.permutations((1.0, 1.7, 2.3))))
@pytest.mark.parametrize("w_body", [(1.5, 0.4, -0.3), (-0.2, 0.5, 1.4)])
def test_every_ordering_of_the_moments(moments, w_body):
    assert_same_motion(exactly(*moments), exactly(*w_body), 4)


moment = st.floats(0.05, 20.0)
rate = st.floats(-1.5, 1.5)


@slow
@given(moment, moment, moment, rate, rate, rate)
def test_any_body_even_one_with_too_great_a_moment(I1, I2, I3, w1, w2, w3):
    # Only as far as the Taylor steps stay few: a moment above the sum of the others turns w faster than w itself.
    gyro = max(1, abs(I2 - I3) / I1, abs(I3 - I1) / I2, abs(I1 - I2) / I3)
    assert_same_motion(exactly(I1, I2, I3), exactly(w1, w2, w3), 5 / gyro, digits=25)


STEADY = {
    "sphere": ((2, 2, 2), (0.3, -1, 0.5)),
    "axis of the least moment": ((1, 2, 2.5), (-0.9, 0, 0)),
    "axis of the middle moment": ((1, 2, 2.5), (0, 1.1, 0)),
    "axis of the greatest moment": ((1, 2, 2.5), (0, 0, 0.7)),
    "across an axis of symmetry": ((2, 1, 2), (0.6, 0, -0.8)),
    "no rotation": ((1, 2, 2.5), (0, 0, 0)),
}


@pytest.mark.parametrize(("moments", "w_body"), STEADY.values(), ids=STEADY)
def test_steady_spin(moments, w_body):
    moments, w_body = exactly(*moments), exactly(*w_body)
    assert isinstance(free_rotation(MP, moments, EYE, moments * w_body), SteadySpin)
    assert_same_motion(moments, w_body, 6)


def test_steady_spin_is_decided_in_the_turned_body_without_rounding():
    # Worked out in doubles, w_body would come out 1e-16 off the axis and fall off it within the 84 e-folds.
    assert np.ptp(rotation_matrix(MIDDLE_Q / np.sqrt(15))[:, 1] * 15 - MIDDLE_WORLD) < 1e-14
    scene = a_scene(body=MIDDLE_BRICK, start=MIDDLE_SPIN, times=[1.0, 200.0])
    answer = truth(scene)
    assert (answer.states[-1, 0, 10:13] == MIDDLE_WORLD / 16).all()
    # It is so, but no program in doubles can know.
    assert answer.horizon == 1.0
    assert "last bit" in answer.why


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("special", [0.4, 3.0])
def test_symmetric_body(axis, special):
    moments = [1.0, 1.0, 1.0]
    moments[axis] = special
    assert_same_motion(exactly(*moments), exactly(0.9, -0.5, 0.7), 4)


@pytest.mark.parametrize("order", list(itertools.permutations(range(3))))
@pytest.mark.parametrize("signs", [(1, 1, 1), (-1, 1, 1)])
def test_exact_separatrix(order, signs):
    # With I = (3, 4, 6) it lies at L1^2 (4/3 - 1) = L3^2 (1 - 4/6), L1 = L3: few bodies have a rational one.
    moments, w_body = exactly(3, 4, 6)[list(order)], (exactly("1/3", "1/5", "1/6") * np.array(signs))[list(order)]
    L_body = moments * w_body
    rotation = free_rotation(MP, moments, EYE, L_body)
    assert L_body @ w_body * 4 == L_body @ L_body
    # Far out L is along the middle axis, and stays: no rounding may throw it back.
    along_middle = abs(rotation.at(Fraction(10**6))[1][order.index(1)])
    assert abs(along_middle - MP.sqrt(L_body @ L_body)) < 1e-38
    assert_same_motion(moments, w_body, 9)


@pytest.mark.parametrize("offset", [1e-6, -1e-6, 1e-15, -1e-15])
def test_near_the_separatrix(offset):
    # Long enough to pass the middle axis and come back: at 28 digits, though errors grow by 1/k' ~ 1/sqrt(offset).
    assert_same_motion(exactly(3, 4, 6), exactly(1 / 3, 0.01, 1 / 6 * (1 + offset)), 45)


@pytest.mark.parametrize("slender", [1e-3, 1e-6])
def test_extreme_moments(slender):
    assert_same_motion(exactly(slender, 1, 1 + slender / 2), exactly(0.4, 0.3, -0.5), 6, digits=25)


@quick
@given(moment, moment, moment, rate, rate, rate, st.floats(0.1, 1e3))
def test_energy_and_angular_momentum_are_conserved(I1, I2, I3, w1, w2, w3, t):
    moments, w_start = exactly(I1, I2, I3), exactly(w1, w2, w3)
    axes, w_body = rotate(moments, w_start, t)
    momentum, energy = moments * w_start, w_start @ (moments * w_start)
    assert abs(axes @ (moments * w_body) - momentum).max() <= 1e-28 * abs(momentum).max()
    assert abs(w_body @ (moments * w_body) - energy) <= 1e-28 * energy
    assert abs(axes @ axes.T - EYE).max() < 1e-28


@slow
@given(moment, moment, moment, rate, rate, rate, st.floats(0.1, 50), st.floats(0.1, 50))
def test_two_flights_in_turn_are_one(I1, I2, I3, w1, w2, w3, first, second):
    moments, w_body = exactly(I1, I2, I3), exactly(w1, w2, w3)
    one_axes, one_w = rotate(moments, w_body, Fraction(first) + Fraction(second))
    half_axes, half_w = rotate(moments, w_body, first)
    two_axes, two_w = rotate(moments, half_w, second, half_axes)
    assert abs(one_axes - two_axes).max() < 1e-25
    assert abs(one_w - two_w).max() < 1e-25


# --- published numbers ----------------------------------------------------------------------------------------------


def test_detest_b5():
    # Hull et al. (1972), problem B5 = Krogh's: y1' = y2 y3, y2' = -y1 y3, y3' = -0.51 y1 y2, y(0) = (0, 1, 1), t = 20.
    # As it stands no body has these factors (I3 would be 0); with w = c y, c = (1.78, 1.28, 2) a real one has.
    c = exactly("1.78", "1.28", "2")
    gyro_1, gyro_2 = c[0] / (c[1] * c[2]), -c[1] / (c[0] * c[2])
    I1 = Fraction(1)
    I2 = (I1 + gyro_1) / (1 - gyro_2)
    I3 = I1 + gyro_2 * I2
    assert (I2 - I1) / I3 * c[0] * c[1] / c[2] == Fraction("0.51")
    w_body = rotate(np.array((I1, I2, I3)), c * exactly(0, 1, 1), 20)[1]
    exact = numbers("-0.93965707987292039619", "-0.34211777540007490653", "0.74141265961999530078")
    assert abs(w_body / c - exact).max() < 1e-20
    # As printed by others: their second number is off by 3e-15.
    assert (w_body / c).astype(float) == pytest.approx(
        (-0.9396570798729192, -0.3421177754000779, 0.7414126596199957), abs=1e-14
    )


def test_hairer_lubich_wanner_body():
    # I = (2, 1, 2/3), L(0) = (cos 1.1, 0, sin 1.1): Hairer, Lubich & Wanner, "Geometric Numerical Integration" (2006).
    moments = exactly(2, 1, "2/3")
    rotation = free_rotation(MP, moments, EYE, np.array((MP.cos(MP.mpf("1.1")), 0 * MP.one, MP.sin(MP.mpf("1.1")))))
    expected = {
        10: ("0.407066136588040811", "0.283007426812844076", "0.868449167661561644"),
        100: ("-0.177348313874973959", "-0.590418524333427169", "0.787371285791933099"),
    }
    for t, L in expected.items():
        assert abs(rotation.at(Fraction(t))[1] - numbers(*L)).max() < 1e-18
    period = rotation.at(Fraction("10.731465234882803834"))[1]
    assert abs(period - rotation.at(Fraction(0))[1]).max() < 1e-17


def test_van_zon_and_schofield_top():
    moments, w_body = exactly(10, 20, 26), exactly(1, 15, 1)
    axes, w_at_10 = rotate(moments, w_body, 10)
    expected = numbers("-8.93297814787053809", "10.9515235719156112", "7.17715832767186367")
    assert abs(w_at_10 - expected).max() < 1e-16
    q = np.array([0.801155476531130077, -0.17783618504593759, -0.458441586159510271, -0.341109228535431518])
    assert axes.astype(float) == pytest.approx(rotation_matrix(q), abs=1e-15)
    assert abs(rotate(moments, w_body, Fraction("2.3471129928878467209"))[1] - w_body).max() < 1e-16


def test_nesc_brick_nutates_in_the_known_period():
    # NASA NESC check case 2 (Jackson et al., 2015): the tumbling brick without air.
    moments = exactly(2.56821747408831e-3, 8.42101103762735e-3, 9.75465593923173e-3)
    w_body = exactly(*np.radians((10.0, 20.0, 30.0)))
    period = 17.3844892719394
    # The period is known to 1e-13 s and w changes by less than 1 rad/s2.
    assert abs(rotate(moments, w_body, period)[1] - w_body).max() < 1e-13
    assert abs(rotate(moments, w_body, period / 2)[1] - w_body).max() > 0.1


# --- the special functions, against mpmath's own --------------------------------------------------------------------


@quick
@given(st.floats(0.0, 1.0), st.floats(-40, 40))
def test_jacobi_functions(m1, u):
    sn, cn, dn, _ = JacobiFunctions(MP, Fraction(m1))(MP.mpf(u))
    m = 1 - MP.mpf(m1)
    for name, got in (("sn", sn), ("cn", cn), ("dn", dn)):
        assert abs(got - MP.ellipfun(name, u, m=m)) < 1e-40


@quick
@given(st.floats(0, 1), st.floats(1e-9, 1), st.floats(1e-9, 1e6))
def test_third_kind_angle(x, y, above):
    x, y, p = MP.mpf(x), MP.mpf(y), 1 + MP.mpf(above)
    root = MP.sqrt((p - x) * (p - y) * (p - 1))
    expected = root * MP.elliprj(x, y, 1, p) / 3
    assert abs(third_kind_angle(MP, x, y, MP.one, p, root) - expected) < 1e-40 * (1 + expected)


# --- whole scenes ---------------------------------------------------------------------------------------------------

# Counter-clockwise from outside, vertices in the order of a box.
BOX_FACES = [
    (0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1),
    (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3),
]  # fmt: skip


def brick(size=(0.4, 0.15, 0.1), mass=2.4, moments=None):
    half = np.array(size) / 2
    points = np.array(list(itertools.product((-1, 1), repeat=3))) * half
    a, b, c = size
    box_moments = np.array((b * b + c * c, a * a + c * c, a * a + b * b)) * mass / 12
    moments = box_moments if moments is None else moments
    return Body("box", mass, frozen_array(moments), frozen_array(points), frozen_array(BOX_FACES, int))


Q = np.array([0.8, 0.2, -0.4, 0.4])
START = np.concatenate(((0.3, -1.2, 0.7), Q, (0.5, 3.0, -1.0), (0.2, -0.1, 0.4)))
# A spin about the axis of the middle moment of a turned body: exactly, though no unit quaternion in doubles says so.
MIDDLE_Q = np.array([1.0, 2.0, -1.0, 3.0])
MIDDLE_WORLD = np.array([-10.0, -11.0, -2.0])  # 15 times the middle column of the matrix
MIDDLE_SPIN = np.concatenate((np.zeros(3), MIDDLE_Q, np.zeros(3), MIDDLE_WORLD / 16))
MIDDLE_BRICK = brick(moments=(1.0, 2.0, 2.5))
GRAVITY = frozen_array((0.0, -9.81, 0.0))


def a_scene(body=None, start=START, times=(0.05, 0.25, 1.0, 2.5, 4.0), impulses=(), gravity=None, **forces):
    times = frozen_array(times)
    start = frozen_array(np.atleast_2d(start))
    body = brick() if body is None else body
    return Scene("case", "", "", float(times[-1]), times, 1e-3, body, start, gravity, tuple(impulses), **forces)


def blow(time=0.0, value=(-3.1, 0.9, 2.2), **where):
    points: Any = {name: frozen_array(point) for name, point in where.items()}
    return Impulse(time, frozen_array(value), **points)


def settled(scene):
    """The first throw at two precisions, in a context of its own."""
    return settle(mpmath.MPContext(), read_throw(scene, 0))


def poses(scene):
    """The extended-precision poses of the first throw."""
    return settled(scene)[1].poses


def click(time, origin, direction, value):
    # A value along the ray would not tell at what depth the ray was stopped: the lever's torque is the same all along.
    return Impulse(time, frozen_array(value), ray=Ray(frozen_array(origin), frozen_array(direction)))


def test_parabola_is_the_nearest_double():
    gravity = frozen_array((0.1, -9.81, 0.3))
    scene = a_scene(times=[0.1, 1e6], gravity=gravity)
    answer = truth(scene)
    for t, state in zip(answer.times, answer.states[:, 0], strict=True):
        t = Fraction(float(t))
        for i in range(3):
            x, v, g = (Fraction(float(number)) for number in (START[i], START[7 + i], gravity[i]))
            assert state[i] == float(x + v * t + g * t * t / 2)
            assert state[7 + i] == float(v + g * t)


def test_states_and_vertices_are_one_body():
    answer = truth(a_scene(impulses=[blow(point_world=(0.372, -1.054, 0.83))], gravity=GRAVITY))
    assert np.linalg.norm(answer.states[..., 3:7], axis=-1) == pytest.approx(1, abs=3e-16)
    # Heights reach 66 m, where a double's grain is 1.4e-14.
    assert vertices(answer.states, brick().points) == pytest.approx(answer.vertices, abs=3e-14)


def test_vertices_are_the_nearest_doubles():
    scene = a_scene(impulses=[blow(point_world=(0.372, -1.054, 0.83))])
    for pose, got in zip(poses(scene), truth(scene).vertices[:, 0], strict=True):
        exact = exactly(*scene.body.points.flat).reshape(-1, 3) @ pose.axes.T + pose.x
        assert (abs(exact - exactly(*got.flat).reshape(-1, 3)) <= np.spacing(abs(got)) * (0.5 + 1e-6)).all()


def test_w_is_the_nearest_double():
    scene = a_scene()
    for pose, got in zip(poses(scene), truth(scene).states[:, 0, 10:13], strict=True):
        assert (abs(pose.w_world - got) <= np.spacing(abs(got)) * (0.5 + 1e-6)).all()


BLOWS = {
    "world point": lambda t: blow(t, point_world=(0.9, 0.1, 0.2)),
    "body point": lambda t: blow(t, point_body=(0.2, -0.075, 0.05)),
    "ray": lambda t: click(t, (0.57, 5.3, 0.21), (0.0, -1.0, 0.0), (1.0, -2.0, 0.5)),
}


@pytest.mark.parametrize("kind", BLOWS)
def test_blows_at_two_times_are_flights_and_jumps_in_turn(kind):
    # At 0.5 s the brick's middle is at (0.55, 0.3, 0.2), moved on by each blow.
    first, second = BLOWS[kind](0.25), BLOWS["body point"](1.0)
    first = replace(first, time=0.5) if kind == "ray" else first
    whole = truth(a_scene(times=[2.0], impulses=[first, second]))

    state = truth(a_scene(times=[first.time])).states[-1]
    state = truth(a_scene(start=jump(first, state, brick()), times=[1.0 - first.time])).states[-1]
    state = truth(a_scene(start=jump(second, state, brick()), times=[1.0])).states[-1]
    # Two roundings to doubles, of w ~ 100 rad/s, turned on for 2 s: 200 rad x 1e-16 x a few.
    assert vertices(state, brick().points) == pytest.approx(whole.vertices[-1], abs=3e-13)


def test_blows_of_one_instant_act_in_order_before_the_sample():
    there, and_back = blow(0.25, point_body=(0.2, 0.0, 0.05)), blow(0.25, (4.0, 0.5, 0.0), point_body=(0.0, 0.07, 0.05))
    scene = a_scene(impulses=[there, and_back])
    before = truth(a_scene(times=[0.25])).states[-1]
    after = jump(and_back, jump(there, before, brick()), brick())
    at_blow = truth(scene).states[list(scene.rows).index(0.25)]
    assert at_blow[:, 7:13] == pytest.approx(after[:, 7:13], rel=1e-13)


def test_a_blow_at_the_start_is_in_the_first_row():
    hit = blow(point_body=(0.2, 0.0, 0.05))
    first = truth(a_scene(impulses=[hit])).states[0]
    assert first == pytest.approx(jump(hit, a_scene().start, brick()), rel=1e-14)


def test_a_central_blow_does_not_touch_the_rotation():
    struck, free = poses(a_scene(impulses=[blow(1.0, point_body=(0, 0, 0))])), poses(a_scene())
    for one, other in zip(struck, free, strict=True):
        assert (one.axes == other.axes).all()
    assert (struck[-1].v != free[-1].v).all()


def test_a_ray_is_met_where_the_surface_is():
    # A still, unturned brick is struck on its face at x = 0.2, 0.03 below the middle: all numbers are known.
    start = np.concatenate((np.zeros(3), (1, 0, 0, 0), np.zeros(6)))
    hit = click(0.0, (3.0, -0.03125, 0.0), (-1.0, 0.0, 0.0), (-2.0, 0.0, 1.5))
    state = truth(a_scene(start=start, impulses=[hit])).states[0, 0]
    assert state[7:10] == pytest.approx((-2 / 2.4, 0, 1.5 / 2.4), rel=1e-15)
    # (0.2, -0.03125, 0) x (-2, 0, 1.5)
    assert state[10:13] == pytest.approx(np.array((-0.046875, -0.3, -0.0625)) / brick().moments, rel=1e-15)


def test_rays_that_miss_or_start_inside_are_refused():
    for origin, what in (((3.0, 9.0, 0.0), "misses"), ((0.3, -1.2, 0.7), "inside")):
        with pytest.raises(RayMissed, match=what):
            truth(a_scene(impulses=[click(0.0, origin, (-1.0, 0.0, 0.0), (-2.0, 0.0, 0.0))]))


def test_throws_fly_alone():
    other = START * np.where(np.arange(13) < 10, 1.0, -2.0)
    together = truth(a_scene(start=np.stack((START, other)), times=[0.5, 2.0]))
    for row, start in enumerate((START, other)):
        alone = truth(a_scene(start=start, times=[0.5, 2.0]))
        for name in ("states", "vertices", "bound", "input_error"):
            assert (getattr(together, name)[:, row] == getattr(alone, name)[:, 0]).all()


def test_quaternions_follow_one_another():
    q = truth(a_scene(times=np.arange(1, 13))).states[:, 0, 3:7]
    assert (np.einsum("ij,ij->i", q[1:], q[:-1]) > 0).all()
    assert q[0] @ Q > 0


# --- the two limits -------------------------------------------------------------------------------------------------


def test_bound_is_the_rounding_to_doubles():
    # A brick within a metre: half a unit in the last place of each of three numbers, at most 2^-54 sqrt(3) m each.
    answer = truth(a_scene(start=np.concatenate((np.zeros(3), Q, np.zeros(3), (2.0, -1.0, 4.0)))))
    assert answer.bound.max() < 2.0**-54 * np.sqrt(3) * 1.001
    assert (answer.resolution == np.maximum(answer.bound, answer.input_error)).all()


@pytest.mark.parametrize("start_bits", PRECISIONS[3:4])
def test_bound_holds_against_a_much_finer_flight(start_bits, monkeypatch):
    scene = a_scene(impulses=[blow(0.25, point_body=(0.2, 0.07, 0.05))], times=[1.0, 1e3, 1e6])
    answer = truth(scene)
    monkeypatch.setattr("tumble.scenarios.truth.resolution.PRECISIONS", (start_bits, 2 * start_bits))
    for row, pose in enumerate(poses(scene)):
        exact = exactly(*scene.body.points.flat).reshape(-1, 3) @ pose.axes.T + pose.x
        error = np.array(exact - exactly(*answer.vertices[row, 0].flat).reshape(-1, 3), dtype=float)
        assert np.linalg.norm(error, axis=-1).max() <= answer.bound[row, 0] * (1 + 1e-12)


def test_long_flight_needs_no_more_precision_than_a_short_one():
    rougher, finer = settled(a_scene(times=[1e6]))
    assert (rougher.bits, finer.bits) == PRECISIONS[:2]
    axes, w_body = rotate(exactly(3, 4, 7), exactly(1, 0.5, 2), Fraction(10**6))
    half_axes, half_w = rotate(exactly(3, 4, 7), exactly(1, 0.5, 2), Fraction(10**6, 2))
    again_axes, again_w = rotate(exactly(3, 4, 7), half_w, Fraction(10**6, 2), half_axes)
    # 45 digits less seven for the radians, twice.
    assert abs(axes - again_axes).max() < 1e-30
    assert abs(w_body - again_w).max() < 1e-30


def test_precision_rises_with_the_radians():
    fast = np.concatenate((START[:10], (1e6, 3e5, -2e5)))
    rougher, _ = settled(a_scene(start=fast, times=[1e6]))
    assert rougher.bits > PRECISIONS[0]


def test_precision_rises_where_rounding_would_upset_the_body():
    # A steady spin about the middle axis is struck in line with that axis: there is no torque, but rounding makes some,
    # of 2^-112, which 160 e-folds would make a somersault.
    hit = blow(1.0, MIDDLE_WORLD, point_body=(0.0, 0.075, 0.0))
    scene = a_scene(body=MIDDLE_BRICK, start=MIDDLE_SPIN, times=[1.5, 400.0], impulses=[hit])
    rougher, _ = settled(scene)
    assert rougher.bits > PRECISIONS[0]
    answer = truth(scene)
    assert (answer.states[-1, 0, 10:13] == MIDDLE_WORLD / 16).all()
    assert answer.bound[-1] == pytest.approx(np.linalg.norm(np.spacing(answer.vertices[-1]) / 2, axis=-1).max())


def test_bound_stays_where_a_body_falls_off_its_middle_axis():
    # All but 2^-300 of the spin is about it: 208 e-folds, 624 s, until it falls.
    start = np.concatenate((np.zeros(3), (1, 0, 0, 0), np.zeros(3), (0.0, 1.0, 2.0**-300)))
    scene = a_scene(body=brick(moments=(3.0, 4.0, 6.0)), start=start, times=[600.0, 630.0, 1e5])
    answer = truth(scene)
    assert abs(answer.states[1, 0, 10]) < 1e-3
    assert abs(answer.states[2, 0, 10]) > 0.05, "the body never fell: the case is moot"
    assert answer.bound.max() < 2.0**-54


EXTREMES = {
    "nanogram": {"body": brick(mass=1e-9), "impulses": [blow(0.05, point_body=(0.2, 0.07, 0.05))]},
    "gigatonne": {"body": brick((1e6, 2e6, 3e6), 1e12), "impulses": [blow(0.05, (1e15,) * 3, point_body=(5e5, 0, 0))]},
    "micrometre": {"body": brick((1e-6, 2e-6, 3e-6), 1e-12)},
    "denormal rates": {"start": np.concatenate((START[:10], (5e-324, 1e-310, 2e-320)))},
    "denormal spin of a spinning body": {"start": np.concatenate((START[:10], (5e-324, 1.0, 0.0)))},
    "needle": {"body": brick(moments=(1e-9, 1.0, 1.0 + 1e-10))},
    "fast and long": {"start": np.concatenate((START[:10], (1e6, 3e5, -2e5))), "times": [1.0, 1e6]},
}


@pytest.mark.parametrize("case", EXTREMES.values(), ids=EXTREMES)
def test_extremes(case):
    scene = a_scene(**case)
    answer = truth(scene)
    assert np.isfinite(answer.states).all()
    size = abs(answer.vertices).max(axis=(1, 2, 3))
    # Half a unit in the last place, in three axes: sqrt(3) 2^-53 of the largest coordinate.
    assert (answer.bound[:, 0] <= size * np.sqrt(3) * HALF_ULP * 1.001).all()


def perturbed(scene, random):
    """The scene with every double of the body's and the start moved to one of its neighbours."""
    next_door = lambda array: frozen_array(np.nextafter(array, array * random.choice((0, 2), np.shape(array))))  # noqa: E731
    body = replace(scene.body, moments=next_door(scene.body.moments), points=next_door(scene.body.points))
    return replace(scene, body=body, start=next_door(scene.start), gravity=next_door(scene.gravity))


FLOORED = {
    "ordinary": (brick(), (0.3, -1.2, 0.7), (2.0, 1.0, 4.0)),
    "near the separatrix": (brick(moments=(3.0, 4.0, 6.0)), (0.3, -1.2, 0.7), (2.0, 0.1, 1.0 + 1e-12)),
    # How it turns is known far worse than where it is, and moves it by no more than its size however much is changed.
    "far away and fast": (brick(), (3e10, -1.2e10, 0.7e10), (2e11, 1e11, 4e11)),
}


@pytest.mark.parametrize(("body", "place", "w"), FLOORED.values(), ids=FLOORED)
def test_floor_is_how_far_neighbouring_doubles_lead(body, place, w):
    start = np.concatenate((place, (1, 0, 0, 0), np.zeros(3), w))
    scene = a_scene(body=body, start=start, times=[5.0, 30.0], gravity=GRAVITY)
    answer = truth(scene)
    moved = [
        np.linalg.norm(truth(perturbed(scene, np.random.default_rng(seed))).vertices - answer.vertices, axis=-1).max(
            axis=2
        )
        for seed in range(4)
    ]
    largest = np.max(moved, axis=0)
    # A neighbour is one to two 2^-53 away, and another sign pattern may go twice as far as the eight that were tried.
    assert (largest <= 4 * answer.input_error + 2 * answer.bound).all()
    assert (largest >= answer.input_error / 8)[1:].all()


def test_floor_grows_at_the_separatrix():
    def floor(w3):
        start = np.concatenate((np.zeros(3), (1, 0, 0, 0), np.zeros(3), (2.0, 0.1, w3)))
        return truth(a_scene(body=brick(moments=(3.0, 4.0, 6.0)), start=start, times=[0.1, 80.0])).input_error[-1, 0]

    away, near, on = floor(1.5), floor(1.0 + 1e-10), floor(1.0)
    # Near it 1e-16 of 1e-10 decide when the body falls; on it, whether it falls at all.
    assert away < 1e-13
    assert 1e-10 < near < 1e-5
    assert on > 1e-3


def test_floor_of_a_still_body_is_the_rounding_of_its_place():
    start = np.concatenate(((3.0, 4.0, 12.0), (1, 0, 0, 0), np.zeros(6)))
    answer = truth(a_scene(start=start))
    # Half the last bits of 3, 4 and 12, and of each vertex, 0.22 m off: of its coordinates and of the quaternion's.
    place = np.linalg.norm(np.spacing((3.0, 4.0, 12.0))) / 2
    assert answer.input_error.min() > place
    assert answer.input_error.max() < place + 0.5 * HALF_ULP


def test_others_keep_their_precision_and_imports_stay_light():
    before = mpmath.mp.prec
    truth(a_scene(times=[1.0]))
    assert mpmath.mp.prec == before
    heavy = ("mpmath", "numba", "tumble.solver")
    code = f"import sys, tumble.scenarios.truth; print([name for name in {heavy} if name in sys.modules])"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "[]"
