"""Many throws: the [ensemble] of a scene is drawn as it says, and the solver's lanes do what its scalar kernels do."""

import math
from dataclasses import replace

import numpy as np
import pytest
from triaxial import SIZE
from triaxial import scene as triaxial

from tumble.scenarios.ensemble import throws
from tumble.scenarios.frames import rotation_matrix
from tumble.scenarios.impulse import jump
from tumble.scenarios.read import catalogue, read_scene
from tumble.scenarios.scene import Impulse, frozen_array
from tumble.scenarios.truth import truth
from tumble.solver.body import Body
from tumble.solver.ensemble import blocks
from tumble.solver.ensemble.exact import exact
from tumble.solver.ensemble.rkmk4 import WIDTH as RKMK4_WIDTH
from tumble.solver.ensemble.rkmk4 import rkmk4
from tumble.solver.integrators.exact import exact as scalar_exact
from tumble.solver.integrators.rk4 import rk4
from tumble.solver.quaternion import to_matrix

EPS = np.finfo(float).eps
MANY = 20_000
BODY = triaxial().body

HEAD = 'title = "a"\nduration = 1.0\nsamples = 4\nstep = 0.1\n[body]\nmass = 2.0\n'
BOX = HEAD + 'shape = "box"\nsize = [1.0, 2.0, 3.0]\norientation = [1, 2, 0, -1]\nvelocity = [1, 0, 2]\n'
STRUCK = "[[impulse]]\nvalue = [0, 0, -4]\npoint = [0.2, 0.1, 0.3]\n[[impulse]]\nvalue = [1, 2, 3]\nvertex = 5\n"
SPREAD = "magnitude = 0.2\ncone = 0.3\npoint = 3.0\norientation = 0.5\n"


@pytest.fixture
def read(tmp_path):
    def read_text(text):
        (tmp_path / "a.toml").write_text(text)
        return read_scene(str(tmp_path / "a.toml"))

    return read_text


# --- the scene's [ensemble]


def test_throw_0_is_the_scene_as_written(read):
    plain, many = read(BOX + STRUCK), read(f"{BOX}{STRUCK}[ensemble]\nthrows = 5\n{SPREAD}")
    struck = plain.start
    for impulse in plain.impulses:
        struck = jump(impulse, struck, plain.body)
    assert many.impulses == ()
    # The sums of the jump in another order; w is 3 rad/s at most.
    np.testing.assert_allclose(many.start[:1], struck, rtol=0, atol=20 * EPS)
    assert (np.ptp(many.start[:, 3:13], axis=0) > 0.01).all(), "the other throws are spread"


def test_without_a_spread_all_throws_are_one(read):
    many = read(f"{BOX}{STRUCK}[ensemble]\nthrows = 3\n")
    np.testing.assert_array_equal(many.start, np.repeat(many.start[:1], 3, axis=0))


def test_later_impulses_are_left_to_the_flight(read):
    late = "[[impulse]]\ntime = 0.5\nvalue = [1, 2, 3]\nvertex = 5\n"
    scene = read(f"{BOX}{STRUCK}{late}[ensemble]\nthrows = 3\norientation = 0.5\n")
    assert [impulse.time for impulse in scene.impulses] == [0.5]


@pytest.mark.parametrize("n", [1, 2, 1000])
def test_a_seed_gives_the_same_bits_and_another_seed_others(read, n):
    starts = [read(f"{BOX}{STRUCK}[ensemble]\nthrows = {n}\nseed = {seed}\n{SPREAD}").start for seed in (7, 7, 8)]
    assert starts[0].shape == (n, 13)
    assert starts[0].tobytes() == starts[1].tobytes()
    assert (starts[0].tobytes() == starts[2].tobytes()) == (n == 1)


def thrown(value, n=MANY, spot=(0.0, 0.0, 0.0), body=BODY, **spread):
    """Return the states after a blow on a body at rest at the origin, without the throw as written, (n - 1, 13)."""
    start = frozen_array([[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, *[0.0] * 6]])
    blow = Impulse(0.0, frozen_array(value), point_body=frozen_array(spot))
    return throws(start, [blow], body, n, 5, **spread)[1:]


def test_widening_one_spread_leaves_the_draws_of_another():
    narrow, wide = (thrown((0.0, 0.0, -4.0), 50, magnitude=0.5, cone=cone)[:, 7:10] for cone in (0.0, 0.5))
    np.testing.assert_allclose(np.linalg.norm(narrow, axis=1), np.linalg.norm(wide, axis=1), rtol=4 * EPS)
    assert np.abs(narrow - wide).max() > 0.1


def test_two_blows_are_drawn_apart():
    body, start = BODY, frozen_array([[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, *[0.0] * 6]])
    blow = Impulse(0.0, frozen_array((0.0, 0.0, body.mass)), point_body=frozen_array((0.0, 0.0, 0.0)))
    once, twice = (throws(start, [blow] * blows, body, MANY, magnitude=0.5)[1:, 9] for blows in (1, 2))
    # Four standard deviations of the correlation of what is independent.
    assert abs(np.corrcoef(once, twice - once)[0, 1]) < 4 / math.sqrt(MANY)


def assert_uniform(values, low, high):
    """Kolmogorov's test at one in ten thousand: its sup is below 2.23 / sqrt(n)."""
    share = (np.sort(values) - low) / (high - low)
    assert share[0] >= -1e-12
    assert share[-1] <= 1 + 1e-12
    n = len(share)
    assert np.abs(share - (np.arange(n) + 0.5) / n).max() < 2.23 / math.sqrt(n)


@pytest.mark.parametrize("cone", [1e-6, 0.3, math.pi])
def test_the_cone_is_uniform_on_the_cap(cone):
    blow = np.array([2.0, -1.0, 0.5])
    size = np.linalg.norm(blow)
    pole = blow / size
    pushes = thrown(blow, cone=cone)[:, 7:10] * BODY.mass / size
    np.testing.assert_allclose(np.linalg.norm(pushes, axis=1), 1.0, rtol=8 * EPS)
    # 1 - cos by the chord: the cosine of a narrow cone has not the digits.  The chord has those that 1e-6 leaves it.
    depth = np.sum((pushes - pole) ** 2, axis=1) / 2
    assert_uniform(depth / (2 * math.sin(cone / 2) ** 2), 0.0, 1.0 + 1e-9)
    side = np.cross(pole, (0.0, 0.0, 1.0)) / np.linalg.norm(np.cross(pole, (0.0, 0.0, 1.0)))
    assert_uniform(np.arctan2(pushes @ np.cross(pole, side), pushes @ side), -math.pi, math.pi)


def test_the_magnitude_is_uniform_within_its_share():
    assert_uniform(thrown((0.0, 0.0, -4.0), magnitude=0.25)[:, 9] * BODY.mass / -4.0, 0.75, 1.25)


def test_the_turn_is_uniform_in_angle_and_axis():
    q = thrown((0.0, 0.0, 0.0), orientation=2.0)[:, 3:7]
    np.testing.assert_allclose(np.linalg.norm(q, axis=1), 1.0, rtol=8 * EPS)
    half_sine = np.linalg.norm(q[:, 1:], axis=1)
    assert_uniform(2 * np.arctan2(half_sine, q[:, 0]), 0.0, 2.0)
    for axis in (1, 2, 3):
        assert_uniform(q[:, axis] / half_sine, -1.0, 1.0)


def spots(spot, reach, body=BODY):
    """Return where blows land, (n, 3), from the angular momentum that two of them leave."""
    along_z, along_x = (
        thrown(value, spot=spot, body=body, point=reach)[:, 10:13] * body.moments for value in np.eye(3)[[2, 0]]
    )
    # (x, y, z) x (0, 0, 1) = (y, -x, 0), and (x, y, z) x (1, 0, 0) = (0, z, -y).
    return np.stack((-along_z[:, 1], along_z[:, 0], along_x[:, 1]), axis=1)


def test_a_spot_is_uniform_on_the_disc_around_it():
    middle = np.array([0.0, 0.0, BODY.points[7, 2]])
    off = spots(middle, 0.07) - middle
    np.testing.assert_allclose(off[:, 2], 0.0, rtol=0, atol=4 * EPS)
    assert_uniform(np.sum(off[:, :2] ** 2, axis=1), 0.0, 0.07**2)
    assert_uniform(np.arctan2(off[:, 1], off[:, 0]), -math.pi, math.pi)


def test_a_spot_far_and_wide_is_uniform_on_the_whole_surface():
    off = spots(BODY.points[7], 1.0) / BODY.points[7]
    on_face = np.isclose(np.abs(off), 1.0, rtol=0, atol=1e-12)
    assert (on_face.sum(axis=1) == 1).all()
    sides = np.array([SIZE[1] * SIZE[2], SIZE[2] * SIZE[0], SIZE[0] * SIZE[1]])
    # Four standard deviations of a share, which is a half at most.
    assert np.abs(on_face.mean(axis=0) - sides / sides.sum()).max() < 4 * 0.5 / math.sqrt(MANY)
    assert_uniform(off[on_face[:, 2], 0], -1.0, 1.0)


def test_a_spot_at_a_corner_stays_within_reach_on_its_three_faces():
    corner = BODY.points[7]
    found = spots(corner, 0.03)
    assert np.linalg.norm(found - corner, axis=1).max() <= 0.03 * (1 + 1e-12)
    on_face = np.isclose(found, corner, rtol=1e-12, atol=0)
    assert (on_face.sum(axis=1) == 1).all()
    assert np.abs(on_face.mean(axis=0) - 1 / 3).max() < 4 * 0.5 / math.sqrt(MANY)


def test_a_body_without_a_surface_is_struck_in_the_ball():
    bare = replace(BODY, faces=np.empty((0, 3), dtype=int))
    spot = np.array([0.3, 0.1, -0.2])
    off = spots(spot, 0.5, bare) - spot
    assert_uniform(np.linalg.norm(off, axis=1) ** 3, 0.0, 0.5**3)
    assert_uniform(off[:, 1] / np.linalg.norm(off, axis=1), -1.0, 1.0)


def test_a_ray_finds_each_turned_body(read):
    ray = "[[impulse]]\nmagnitude = 1.0\nray = { origin = [0, 0, 9], direction = [0.01, 0.02, -1] }\n"
    scene = read(f"{BOX}{ray}[ensemble]\nthrows = 9\norientation = 3.0\n")
    plain = read(BOX + ray)
    for state in scene.start:
        before = np.array([[*plain.start[0, :3], *state[3:7], *plain.start[0, 7:]]])
        np.testing.assert_allclose(state, jump(plain.impulses[0], before, plain.body)[0], rtol=0, atol=20 * EPS)


# --- the solver's lanes


def spins(n, moments, seed=0, width=7):
    """Return n random attitudes and momenta, and the same again where a dense method remembers them, or 0."""
    random = np.random.default_rng(seed)
    q = random.standard_normal((n, 4))
    rows = np.hstack((q / np.linalg.norm(q, axis=1, keepdims=True), moments * random.standard_normal((n, 3))))
    return widened(rows, width)


def widened(rows, width):
    """Return rows of q and L as a method with rows of a width begins with."""
    return np.hstack((rows, rows)) if width == 14 else np.hstack((rows, np.zeros((len(rows), width - 7))))


def turn(method, rows, body, *steps):
    rows = rows.copy()
    for n, dt in steps:
        method(rows, n, dt, body.inverse_moments, body.gyroscopic)
    return rows


def apart(rows, others):
    """Return the largest difference of rotation matrices and of L over its length, (n,)."""
    matrices, other_matrices = (to_matrix(r[:, :4] / np.linalg.norm(r[:, :4], axis=1)[:, None]) for r in (rows, others))
    momenta = np.abs(rows[:, 4:7] - others[:, 4:7]).max(axis=1) / np.linalg.norm(others[:, 4:7], axis=1)
    return np.maximum(np.abs(matrices - other_matrices).max(axis=(1, 2)), momenta)


BRICK = Body(1.0, (0.58 / 12, 1.09 / 12, 1.49 / 12))
WIDTH = {rkmk4: RKMK4_WIDTH, exact: 14}
BOTH = pytest.mark.parametrize("method", [rkmk4, exact])


def test_rkmk4_is_of_order_4():
    start = spins(70, BRICK.moments, width=RKMK4_WIDTH)
    truth = turn(scalar_exact, spins(70, BRICK.moments, width=14), BRICK, (1, 1.0))
    errors = np.array([np.median(apart(turn(rkmk4, start, BRICK, (n, 1.0 / n)), truth)) for n in 2 ** np.arange(4, 9)])
    assert errors[-1] > 1e-13, "an error of rounding has no order"
    assert np.abs(np.log2(errors[:-1] / errors[1:]) - 4).max() < 0.2


def test_rkmk4_is_rk4_at_a_small_step():
    start = spins(70, BRICK.moments, width=RKMK4_WIDTH)
    fine, other = (turn(method, start, BRICK, (4000, 2.5e-4)) for method in (rkmk4, rk4))
    # Both err by some (|w| dt)^5 / 100 a step, |w| = 4 at most, and 4000 steps of a few roundings.
    assert apart(fine, other).max() < 4000 * (1e-15 / 100 + 4 * EPS)


@pytest.mark.parametrize(
    "moments",
    [
        BRICK.moments,
        (1.49, 0.58, 1.09),
        (1.09, 1.49, 0.58),
        (1.0, 1.01, 1.02),
        (1.0, 1.0 + 1e-9, 1.0 + 2e-9),
        (1.0, 1.0, 0.4),
        (1.0, 2.0, 2.0),
        (0.01, 1.0, 1.005),
        (0.3, 0.3, 0.3),
    ],
)
@pytest.mark.parametrize("t", [1e-3, 3.0, 1000.0])
def test_exact_is_the_scalar_closed_form(moments, t):
    body = Body(1.0, moments)
    rows = spins(300, moments, width=14)
    lanes, alone = (turn(method, rows, body, (1, t)) for method in (exact, scalar_exact))
    radians = 1 + t * np.linalg.norm(rows[:, 11:14], axis=1) / min(moments)
    # A few roundings of the angle, some tenfold near the separatrix.
    assert (apart(lanes, alone) / radians).max() < 100 * EPS
    assert np.median(apart(lanes, alone) / radians) < 2 * EPS


def test_exact_at_rest_in_steady_spin_and_on_the_separatrix():
    special = np.array(
        [
            [0.0, 0.0, 0.0],
            [0.0, 0.0, 2.0],
            [-2.0, 0.0, 0.0],
            [0.0, 3.0, 0.0],
            [1e-9, 3.0, 1e-9],
            [1.0, 3.0, math.sqrt((1 / 0.58 - 1 / 1.09) / (1 / 1.09 - 1 / 1.49))],
        ]
    )
    rows = np.zeros((len(special), 14))
    rows[:, [0, 7]] = 1.0
    rows[:, 4:7] = rows[:, 11:14] = special
    body = Body(1.0, (0.58, 1.09, 1.49))
    lanes, alone = (turn(method, rows, body, (7, 0.5)) for method in (exact, scalar_exact))
    np.testing.assert_allclose(to_matrix(lanes[:, :4]), to_matrix(alone[:, :4]), rtol=0, atol=1e-13)
    np.testing.assert_allclose(lanes[:, 4:7], alone[:, 4:7], rtol=0, atol=1e-13)


def test_exact_where_a_momentum_is_too_small_to_square():
    body = Body(1.0, (0.58, 1.09, 1.49))
    rows = np.array([[1.0, *[0.0] * 3, x, 0.0, 1.0] * 2 for x in (0.0, 1e-170)])
    steady, almost = turn(exact, rows, body, (7, 0.5))
    np.testing.assert_allclose(almost, steady, rtol=0, atol=1e-160)
    np.testing.assert_allclose(
        steady[:4] ** 2, [math.cos(1.75 / 1.49) ** 2, 0, 0, math.sin(1.75 / 1.49) ** 2], atol=4 * EPS
    )


def test_lanes_against_the_truth():
    scene = read_scene("many-throws")
    few = replace(scene, start=scene.start[:4], times=frozen_array([1.0]))
    answer = truth(few)
    a, b, c = few.body.moments.tolist()
    body = Body(few.body.mass, (a, b, c))
    w_body = np.einsum("nji,nj->ni", rotation_matrix(few.start[:, 3:7]), few.start[:, 10:13])
    rows = np.hstack((few.start[:, 3:7], few.body.moments * w_body))
    for method, steps in ((rkmk4, (20_000, 5e-5)), (exact, (1, 1.0))):
        flown = turn(method, widened(rows, WIDTH[method]), body, steps)
        turned = to_matrix(flown[:, :4]) @ few.body.points.T
        true = np.swapaxes(answer.vertices[-1] - answer.states[-1][:, None, 0:3], 1, 2)
        # 20 rad/s at 5e-5 s leave rkmk4 1e-12 of a body of 0.2 m, and 20 000 roundings as much.
        assert np.abs(turned - true).max() < (1e-12 if method is rkmk4 else 1e-14)


@BOTH
def test_steps_add_up_to_the_last_bit(method):
    rows = spins(100, BRICK.moments, width=WIDTH[method])
    at_once = turn(method, rows, BRICK, (11, 0.01))
    # A dense method is asked for all the steps since its count began.
    parts = ((3, 0.01), (8, 0.01)) if method is rkmk4 else ((3, 0.01), (11, 0.01))
    np.testing.assert_array_equal(turn(method, rows, BRICK, *parts), at_once)


@BOTH
@pytest.mark.parametrize("n", [1, 63, 64, 65, 130])
@pytest.mark.parametrize("moments", [BRICK.moments, (0.3, 0.3, 0.3)])
def test_a_throw_alone_is_the_throw_in_the_crowd(method, n, moments):
    body, rows = Body(1.0, moments), spins(n, moments, width=WIDTH[method])
    crowd = turn(method, rows, body, (5, 0.03))
    assert not np.array_equal(crowd, rows)
    for throw in range(n):
        np.testing.assert_array_equal(turn(method, rows[throw : throw + 1], body, (5, 0.03))[0], crowd[throw])


@BOTH
def test_two_cores_give_the_bits_of_one(method, monkeypatch):
    rows = spins(500, BRICK.moments, width=WIDTH[method])
    one = turn(method, rows, BRICK, (5, 0.03))
    monkeypatch.setattr(blocks, "LEAST_WORK", 0)
    monkeypatch.setattr(blocks.numba.config, "NUMBA_NUM_THREADS", 3)  # pyright: ignore[reportPrivateImportUsage]
    shared = []
    monkeypatch.setattr(blocks, "_threads", Counting(blocks._threads(), shared))
    np.testing.assert_array_equal(turn(method, rows, BRICK, (5, 0.03)), one)
    assert len(shared) == 2, "the thread that asks does one of three parts itself"


class Counting:
    """The pool of threads, noting what is handed to it."""

    def __init__(self, pool, handed):
        self._pool, self._handed = pool, handed

    def __call__(self):
        return self

    def submit(self, *task):
        self._handed.append(task[1:3])
        return self._pool.submit(*task)


@BOTH
def test_nan_in_one_throw_stays_there(method):
    rows = spins(130, BRICK.moments, width=WIDTH[method])
    clean = turn(method, rows, BRICK, (5, 0.03))
    rows[70] = np.nan
    spoilt = turn(method, rows, BRICK, (5, 0.03))
    assert np.isnan(spoilt[70]).all()
    others = np.arange(130) != 70
    np.testing.assert_array_equal(spoilt[others], clean[others])


@BOTH
def test_no_throws_and_no_steps(method):
    rows = spins(10, BRICK.moments, width=WIDTH[method])
    assert turn(method, rows[:0], BRICK, (5, 0.03)).shape == (0, WIDTH[method])
    np.testing.assert_allclose(turn(method, rows, BRICK, (0, 0.03))[:, :7], rows[:, :7], rtol=0, atol=8 * EPS)


def test_the_catalogue_has_the_yardstick_and_an_ensemble():
    assert {"yardstick", "many-throws"} <= set(catalogue())
    yardstick, many = read_scene("yardstick"), read_scene("many-throws")
    # 1/12 m (b^2 + c^2) of 1.0 x 0.7 x 0.3 m.
    np.testing.assert_allclose(yardstick.body.moments, BRICK.moments, rtol=4 * EPS)
    assert yardstick.start[0].tolist() == [0, 0, 0, 1, 0, 0, 0, 3, 1, 5, 0.8, 2.8, 0.7]
    assert yardstick.times.tolist() == [10.0]
    assert len(many.start) == 24
    assert len(set(many.body.moments)) == 3
