"""One throw at many instants: what the scalar closed form says of each, and what the truth says of some."""

import math
from dataclasses import replace
from itertools import permutations

import numpy as np
import pytest
from numpy.typing import ArrayLike
from triaxial import THROWS
from triaxial import scene as triaxial

from tumble.scenarios.frames import rotation_matrix
from tumble.scenarios.scene import frozen_array
from tumble.scenarios.truth import truth
from tumble.solver.body import Body
from tumble.solver.ensemble import blocks
from tumble.solver.ensemble.poses import poses
from tumble.solver.integrators.exact import exact
from tumble.solver.quaternion import to_matrix

EPS = np.finfo(float).eps
MOMENTS = (0.58 / 12, 1.09 / 12, 1.49 / 12)
BRICK = Body(1.0, MOMENTS)
W_BODY = (0.8, 2.8, 0.7)
TIMES = np.linspace(-3.0, 40.0, 131)
# L3/L1 on the separatrix of the brick.
SEPARATRIX = math.sqrt((1 / 0.58 - 1 / 1.09) / (1 / 1.09 - 1 / 1.49))


def thrown(body, w_body, q=(0.5, -0.1, 0.7, 0.4)):
    """Return a quaternion of unit length, then L in body axes, (7,)."""
    return np.array([*(np.array(q) / np.linalg.norm(q)), *(np.array(body.moments) * w_body)])


def near_the_separatrix(off):
    """Return a throw of the brick, a part off in L3."""
    return np.array([1.0, 0.0, 0.0, 0.0, 1.0, 3.0, SEPARATRIX * (1.0 + off)])


def found(body: Body, spin: ArrayLike, times: ArrayLike = TIMES):
    return poses(spin, times, body.inverse_moments, body.gyroscopic)


def one_by_one(body, spin, times=TIMES):
    """Return the poses that the scalar closed form finds, (T, 7)."""
    rows = np.tile(spin, (len(times), 2))
    for row, t in zip(rows, times, strict=True):
        exact(row[None], 1, t, body.inverse_moments, body.gyroscopic)
    return rows[:, :7]


def eps_apart(body, spin, times=TIMES):
    """Return how far the two are apart, of R and of L/|L|, in eps a radian turned, (T,)."""
    lanes, scalar = found(body, spin, times), one_by_one(body, spin, times)
    momentum = np.linalg.norm(spin[4:])
    matrices = np.abs(to_matrix(lanes[:, :4]) - to_matrix(scalar[:, :4])).max(axis=(1, 2))
    momenta = np.abs(lanes[:, 4:] - scalar[:, 4:]).max(axis=1) / momentum
    return np.maximum(matrices, momenta) / EPS / (1.0 + np.abs(times) * momentum / min(body.moments))


def assert_lanes_round_as_little(off):
    """A few roundings of the angle, some tenfold near the separatrix; none at all would be the scalar kernel's bits."""
    assert off.max() < 100
    assert 0 < np.median(off) < 2


@pytest.mark.parametrize("w_body", [W_BODY, (-3.0, 0.2, 0.1), (0.3, -0.2, -2.0), (0.0, 1.0, 5.0)])
@pytest.mark.parametrize("order", list(permutations(range(3))))
def test_the_lanes_are_the_scalar_closed_form(order, w_body):
    body = Body(1.0, tuple(np.array(MOMENTS)[list(order)].tolist()))
    assert_lanes_round_as_little(eps_apart(body, thrown(body, w_body)))


@pytest.mark.parametrize("w_body", [(1.0, 0.0, 1e-9), (1e-9, 0.0, -1.0), (0.0, 1e-100, 1.0)])
def test_the_lanes_near_a_steady_spin(w_body):
    assert_lanes_round_as_little(eps_apart(BRICK, thrown(BRICK, w_body)))


@pytest.mark.parametrize("moments", [(1.0, 1.01, 1.02), (1.0, 1.0 + 1e-9, 1.0 + 2e-9), (0.01, 1.0, 1.005)])
def test_the_lanes_near_symmetry(moments):
    body = Body(1.0, moments)
    assert_lanes_round_as_little(eps_apart(body, thrown(body, (0.3, -0.5, 0.9))))


@pytest.mark.parametrize("off", [0.1, -0.1, 0.01, -0.01])
def test_the_lanes_as_far_as_they_go_towards_the_separatrix(off):
    assert_lanes_round_as_little(eps_apart(BRICK, near_the_separatrix(off), TIMES / 10))


SCALAR = {
    "beside the separatrix": (BRICK, near_the_separatrix(1e-4)),
    "beside it, within": (BRICK, near_the_separatrix(-1e-4)),
    "a rounding beside it": (BRICK, near_the_separatrix(EPS)),
    "steady, greatest": (BRICK, thrown(BRICK, (0.0, 0.0, -3.0))),
    "steady, middle": (BRICK, thrown(BRICK, (0.0, 3.0, 0.0))),
    "steady, least": (BRICK, thrown(BRICK, (3.0, 0.0, 0.0))),
    "too small to square": (BRICK, thrown(BRICK, (3.0, 1e-170, 0.0))),
    "rest": (BRICK, thrown(BRICK, (0.0, 0.0, 0.0))),
    "sphere": (Body(1.0, (0.3, 0.3, 0.3)), np.array([0.6, 0.0, 0.8, 0.0, 1.0, 2.0, 3.0])),
    "symmetric": (Body(1.0, (1.0, 1.0, 0.4)), np.array([0.6, 0.0, 0.8, 0.0, 1.0, 2.0, 3.0])),
}


@pytest.mark.parametrize("name", SCALAR)
def test_what_the_lanes_cannot_do_is_the_scalar_kernels_answer(name):
    body, spin = SCALAR[name]
    momentum = np.linalg.norm(spin[4:])
    # The same code inlined into another loop: a few roundings of the angle turned, tenfold near the separatrix.
    turned = 1.0 + np.abs(TIMES).max() * momentum / min(body.moments)
    off = np.abs(found(body, spin) - one_by_one(body, spin)).max()
    assert off <= 100 * EPS * turned * max(1.0, momentum)


@pytest.mark.parametrize("row", range(len(THROWS)))
def test_against_the_truth(row):
    start = THROWS[row : row + 1].copy()
    start[:, [0, 1, 2, 7, 8, 9]] = 0.0
    scene = replace(triaxial(), start=frozen_array(start), times=frozen_array([0.01, 0.5, 10.0]))
    answer = truth(scene)
    a, b, c = scene.body.moments.tolist()
    w_body = rotation_matrix(start[0, 3:7]).T @ start[0, 10:13]
    spin = np.hstack((start[0, 3:7], scene.body.moments * w_body))
    flown = found(Body(scene.body.mass, (a, b, c)), spin, answer.times)
    corners = scene.body.points @ np.swapaxes(to_matrix(flown[:, :4]), 1, 2)
    off = np.linalg.norm(corners - answer.vertices[:, 0], axis=-1).max(axis=-1)
    # The truth's limit is half an ulp of every input; ten numbers, each rounded once, count as much.
    assert (off <= 10 * answer.resolution[:, 0]).all(), off / answer.resolution[:, 0]
    # L in world axes stays what it was: a rounding of q and of L each, and of the start, in a sum of three.
    world = np.einsum("tij,tj->ti", to_matrix(flown[:, :4]), flown[:, 4:])
    before = rotation_matrix(start[0, 3:7]) @ spin[4:]
    np.testing.assert_allclose(world, np.tile(before, (len(world), 1)), rtol=0, atol=20 * EPS * np.linalg.norm(before))


BOTH = pytest.mark.parametrize("name", ["lanes", "symmetric", "beside the separatrix"])
CASES = {"lanes": (BRICK, thrown(BRICK, W_BODY)), **SCALAR}


@BOTH
@pytest.mark.parametrize("count", [0, 1, 63, 64, 65, 128, 131])
def test_a_pose_alone_is_the_pose_among_many(name, count):
    body, spin = CASES[name]
    many = found(body, spin, TIMES[:count])
    assert many.shape == (count, 7)
    for row in range(count):
        np.testing.assert_array_equal(found(body, spin, TIMES[row : row + 1])[0], many[row])


@BOTH
def test_the_instants_come_in_any_order(name):
    body, spin = CASES[name]
    order = np.random.default_rng(1).permutation(len(TIMES))
    np.testing.assert_array_equal(found(body, spin, TIMES[order]), found(body, spin)[order])


@BOTH
def test_three_cores_give_the_bits_of_one(name, monkeypatch):
    body, spin = CASES[name]
    one = found(body, spin)
    parts = []
    pool = blocks._threads()

    class Counting:
        def submit(self, kernel, first, last, *arguments):
            parts.append((first, last))
            return pool.submit(kernel, first, last, *arguments)

    monkeypatch.setattr(blocks, "LEAST_WORK", 0)
    monkeypatch.setattr("numba.config.NUMBA_NUM_THREADS", 3)
    monkeypatch.setattr(blocks, "_threads", Counting)
    np.testing.assert_array_equal(found(body, spin), one)
    # The thread that asks does the last part itself.
    assert parts == [(0, 64), (64, 128)]


@BOTH
def test_at_time_0_it_is_the_throw_itself(name):
    body, spin = CASES[name]
    np.testing.assert_allclose(found(body, spin, [0.0])[0], spin, rtol=0, atol=8 * EPS * np.abs(spin).max())


@BOTH
def test_nan_at_one_instant_stays_there(name):
    body, spin = CASES[name]
    times = TIMES.copy()
    times[70] = np.nan
    spoilt = found(body, spin, times)
    assert np.isnan(spoilt[70, :4]).all()
    others = np.arange(len(times)) != 70
    np.testing.assert_array_equal(spoilt[others], found(body, spin)[others])


def test_what_is_not_one_throw_or_not_a_row_of_instants_is_refused():
    for spin, times in ((np.zeros((1, 7)), TIMES), (np.zeros(14), TIMES), (np.zeros(7), 1.0), (np.zeros(7), [TIMES])):
        with pytest.raises(ValueError, match="shape"):
            found(BRICK, spin, times)
