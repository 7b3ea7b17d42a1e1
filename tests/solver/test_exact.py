"""The closed form of the solver against the closed form of the truth, which shares no formula with it.

One is theta series on quaternions in doubles, the other Landen's Jacobi functions and Carlson's integral on matrices in
as many digits as it takes; which motion is which is decided in each on its own.
"""

from itertools import product

import numpy as np
import pytest

from tumble.compare.engines import tumble
from tumble.compare.run.flight import simulate
from tumble.scenarios import scene as scenes
from tumble.scenarios.frames import rotation_matrix
from tumble.scenarios.read import catalogue, read_scene
from tumble.scenarios.truth import truth
from tumble.solver.body import Body
from tumble.solver.flight import Flight
from tumble.solver.integrators.exact import exact

CORNERS = np.array(list(product((-0.5, 0.5), repeat=3)))
# The truth's floor is what half an ulp of every input does.  The closed form rounds each input once, as reading does,
# and then some ten numbers that count as much.
ALLOWED = 10.0
# Two roundings of the numbers compared, which a floor of no motion does not count.
LEAST = 4e-16


def scene(moments, q, w_body, duration):
    start = np.zeros((1, 13))
    start[0, 3:7] = q / np.linalg.norm(q)
    start[0, 10:13] = rotation_matrix(start[0, 3:7]) @ w_body
    body = scenes.Body("rigid", 1.0, scenes.frozen_array(moments), scenes.frozen_array(CORNERS), np.empty((0, 3), int))
    times = scenes.frozen_array([duration])
    return scenes.Scene("", "", "", duration, times, duration, body, scenes.frozen_array(start))


def excess(question):
    """How many times the truth's limit a vertex is off."""
    true = truth(question)
    flight = Flight(Body(1.0, tuple(question.body.moments.tolist())), "exact")
    flight.write(question.start)
    flight.advance(1, question.duration)
    off = np.linalg.norm(flight.vertices(CORNERS)[0] - true.vertices[-1, 0], axis=1).max()
    return off / (true.resolution[-1, 0] + LEAST)


def sphere(rng):
    return np.full(3, rng.uniform(0.1, 1.0))


def brick(rng):
    edges = rng.uniform(0.1, 1.0, 3) ** 2
    return edges.sum() - edges


def symmetric(rng):
    return np.array([1.0, 1.0, rng.uniform(0.01, 2.0)])


def nearly_symmetric(rng):
    return np.array([1.0, 1.0 + 10.0 ** rng.uniform(-15, -2), rng.uniform(0.01, 1.9)])


def nearly_a_sphere(rng):
    return 1.0 + 10.0 ** rng.uniform(-14, -2) * rng.normal(size=3)


def needle(rng):
    thin = 10.0 ** rng.uniform(-8, -2)
    return np.array([thin, 1.0, 1.0 + thin * rng.uniform(-1.0, 1.0)])


def flat(rng):
    first, second = rng.uniform(0.1, 1.0, 2)
    return np.array([first, second, first + second])


BODIES = [sphere, brick, symmetric, nearly_symmetric, nearly_a_sphere, needle, flat]


def any_spin(rng, moments):
    return rng.normal(size=3)


def steady(rng, moments):
    return np.eye(3)[rng.integers(3)]


def nearly_steady(rng, moments):
    return rng.normal(size=3) * 10.0 ** rng.uniform(-16, 0, 3)


def near_the_separatrix(rng, moments):
    """L with 2 E I2 = L^2 but for a part in 10 to 1e16, on either side; on it, as far as doubles can, in each tenth."""
    least, middle, greatest = np.argsort(moments)
    L = moments * rng.normal(size=3)
    off = rng.choice([-1.0, 1.0]) * 10.0 ** rng.uniform(-16, -1) if rng.random() < 0.9 else 0.0
    up = (moments[middle] - moments[least]) / moments[least]
    down = (moments[greatest] - moments[middle]) / moments[greatest]
    if down > 0.0:
        L[greatest] = L[least] * np.sqrt(up / down) * (1.0 + off)
    return L / moments


SPINS = [any_spin, steady, nearly_steady, near_the_separatrix]


@pytest.mark.parametrize("spin", SPINS)
@pytest.mark.parametrize("shape", BODIES)
def test_any_throw_of_any_body_is_as_good_as_its_input(shape, spin):
    rng = np.random.default_rng([BODIES.index(shape), SPINS.index(spin)])
    worst = {}
    for _ in range(THROWS):
        moments = shape(rng)
        w_body = spin(rng, moments)
        # From slow to a million radians a second, for a hundredth of a radian up to ten thousand.
        w_body *= 10.0 ** rng.uniform(-2, 6) / np.linalg.norm(w_body)
        duration = 10.0 ** rng.uniform(-2, 4) / np.linalg.norm(w_body)
        axes = rng.permutation(3)
        attitude = rng.normal(size=4) if rng.random() < 0.5 else np.array([1.0, 0.0, 0.0, 0.0])
        question = scene(moments[axes], attitude, w_body[axes], duration)
        worst[excess(question)] = question
    assert max(worst) < ALLOWED, worst[max(worst)].start


THROWS = 4


@pytest.mark.parametrize("name", [name for name in catalogue() if read_scene(name).is_free])
def test_every_free_scene_of_the_catalogue(name):
    question = read_scene(name)
    true = truth(question)
    flight = simulate(tumble, question, "exact", question.duration)
    off = np.linalg.norm(flight.vertices - true.vertices, axis=-1).max(axis=-1)
    assert (off <= ALLOWED * true.resolution).all(), (off / true.resolution).max()


def test_negative_control_one_moment_off_by_1e_12_is_seen():
    question = scene(np.array([0.2, 0.7, 0.8]), np.array([1.0, 0.0, 0.0, 0.0]), np.array([1.0, 2.0, 3.0]), 10.0)
    assert excess(question) < ALLOWED
    true = truth(question)
    flight = Flight(Body(1.0, (0.2, 0.7, 0.8 * (1 + 1e-12))), "exact")
    flight.write(question.start)
    flight.advance(1, question.duration)
    assert (
        np.linalg.norm(flight.vertices(CORNERS)[0] - true.vertices[-1, 0], axis=1).max() > 50 * true.resolution[-1, 0]
    )


@pytest.mark.parametrize("momentum", [(1e-170, 0.0, 1.0), (0.0, 1.0, 5e-324), (1.0, -1e-160, 1e-200)])
def test_a_component_too_small_to_square_turns_nobody(momentum):
    body = Body(1.0, (0.3, 0.5, 0.7))

    def flown(l_body):
        row = np.array([[0.5, -0.5, 0.5, 0.5, *l_body] * 2])
        exact(row, 7, 0.3, body.inverse_moments, body.gyroscopic)
        return row[0, :7]

    steady = np.where(np.abs(momentum) < 1e-100, 0.0, momentum)
    np.testing.assert_array_equal(flown(momentum), flown(steady))
    assert np.isfinite(flown(momentum)).all()
