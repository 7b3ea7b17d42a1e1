"""Energy, momentum and angular momentum of states, against sums over the masses that a body is made of."""

from dataclasses import replace

import numpy as np
import pytest

from tumble.compare.judge import mechanics
from tumble.scenarios.frames import vertices
from tumble.scenarios.read import read_scene

BODY = read_scene("brick-tumble").body
STATES = np.random.default_rng(4).normal(size=(5, 3, 13))
STATES[..., 3:7] /= np.linalg.norm(STATES[..., 3:7], axis=-1, keepdims=True)


def masses() -> tuple[np.ndarray, np.ndarray]:
    """Six masses [kg] and their places [m], body axes, with the moments of the body: a pair on each axis."""
    a, b, c = BODY.moments
    second = (np.array((b + c - a, c + a - b, a + b - c)) / 2).repeat(2)  # the sum of m x^2 along an axis
    mass = np.full(6, BODY.mass / 6)
    places = np.zeros((6, 3))
    places[range(6), [0, 0, 1, 1, 2, 2]] = np.array([1, -1] * 3) * np.sqrt(second / (2 * mass))
    return mass, places


def moving() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The masses, their levers R p and their velocities v + w x R p, (5, 3, 6, 3)."""
    mass, places = masses()
    levers = vertices(STATES, places) - STATES[..., None, 0:3]
    return mass, levers, STATES[..., None, 7:10] + np.cross(STATES[..., None, 10:13], levers)


def test_kinetic_energy_is_that_of_the_masses():
    mass, _, velocities = moving()
    right = (mass * (velocities**2).sum(-1)).sum(-1) / 2
    np.testing.assert_allclose(mechanics.kinetic_energy(STATES, BODY), right, rtol=1e-12)
    still = STATES.copy()
    still[..., 7:10] = 0.0
    np.testing.assert_allclose(mechanics.spin_energy(STATES, BODY), mechanics.kinetic_energy(still, BODY), rtol=1e-12)


def test_momenta_are_those_of_the_masses():
    mass, levers, velocities = moving()
    impulses = mass[:, None] * velocities
    np.testing.assert_allclose(mechanics.momentum(STATES, BODY), impulses.sum(-2), rtol=1e-12, atol=1e-12)
    right = np.cross(levers, impulses).sum(-2)
    np.testing.assert_allclose(mechanics.angular_momentum(STATES, BODY), right, rtol=1e-11, atol=1e-12)


def test_what_rises_against_gravity_gains_energy():
    gravity, risen = np.array((0.0, -9.81, 0.0)), STATES.copy()
    risen[..., 1] += 2.0
    gained = mechanics.energy(risen, BODY, gravity) - mechanics.energy(STATES, BODY, gravity)
    np.testing.assert_allclose(gained, 2.0 * 9.81 * BODY.mass, rtol=1e-9)
    np.testing.assert_array_equal(mechanics.energy(STATES, BODY, None), mechanics.kinetic_energy(STATES, BODY))


def test_a_drift_is_the_largest_and_keeps_its_sign_where_it_has_one():
    true = np.zeros((4, 2))
    values = true.copy()
    values[2, 1], values[3, 0] = -3.0, 2.0
    assert mechanics.drift(values, true, 2.0) == -1.5
    assert mechanics.drift(values, true, 0.0) == -3.0
    vectors = np.zeros((4, 2, 3))
    vectors[1, 0] = (0.0, 3.0, -4.0)
    assert mechanics.drift(vectors, np.zeros((4, 2, 3)), 2.0) == pytest.approx(2.5)


def test_a_heavier_body_of_the_same_shape_has_more_of_all():
    heavy = replace(BODY, mass=3 * BODY.mass, moments=3 * BODY.moments)
    for quantity in (mechanics.kinetic_energy, mechanics.momentum, mechanics.angular_momentum):
        np.testing.assert_allclose(quantity(STATES, heavy), 3 * quantity(STATES, BODY), rtol=1e-12)
