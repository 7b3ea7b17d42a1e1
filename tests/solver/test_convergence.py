"""What the registry claims holds on every free triaxial scene of the catalogue, held against the exact truth."""

from itertools import pairwise

import numpy as np
import pytest

from tumble.compare.engines import tumble
from tumble.compare.run.flight import simulate
from tumble.scenarios.needs import needs
from tumble.scenarios.read import catalogue, read_scene
from tumble.scenarios.truth import truth
from tumble.solver.registry import METHODS

SCENES = [name for name in catalogue() if "gyroscopic" in needs(read_scene(name))]
HALVINGS = 11
# Errors that show an order, over the size of the body: above the first the next order is seen too (the slope nears 4
# from 4.35), below the second the rounding of 1e4 steps is, which an unstable spin magnifies.
LARGEST, LEAST = 1e-5, 3e-9


def slopes(name: str, method: str) -> list[float]:
    """Return log2 of the error ratio of each halving of the step that counts."""
    scene = read_scene(name)
    true = truth(scene)
    size = float(np.linalg.norm(scene.body.points, axis=1).max())
    first = scene.duration / len(scene.times)
    errors = []
    for halving in range(HALVINGS):
        flight = simulate(tumble, scene, method, first / 2**halving)
        errors.append(np.linalg.norm(flight.vertices - true.vertices, axis=-1).max())
    return [
        float(np.log2(coarse / fine))
        for coarse, fine in pairwise(errors)
        if coarse < LARGEST * size and fine > LEAST * size
    ]


def test_there_are_scenes_to_try():
    assert {"brick-tumble", "two-hits", "nesc-brick", "dzhanibekov", "mesh-die"} <= set(SCENES)


@pytest.mark.parametrize("name", SCENES)
def test_rk4_gains_sixteenfold_by_a_halved_step(name):
    found = slopes(name, "rk4")
    assert found, "the ladder has to reach the asymptotic range"
    assert all(abs(slope - METHODS["rk4"].order) < 0.2 for slope in found), found


@pytest.mark.parametrize("method", [name for name, claims in METHODS.items() if claims.order == 1 and claims.rigid])
def test_first_order_gains_twofold(method):
    scene = read_scene("nesc-brick")
    true = truth(scene)
    errors = []
    for halving in range(4):
        flight = simulate(tumble, scene, method, 0.004 / 2**halving)
        errors.append(np.linalg.norm(flight.vertices - true.vertices, axis=-1).max())
    assert np.log2(np.divide(errors[:-1], errors[1:])) == pytest.approx(1.0, abs=0.2)
