"""The contact methods against the contact truth, on the catalogue and random scenes, and against laws without one."""

import numpy as np
import pytest
from random_contact import FAMILIES, drawn

from tumble.compare.engines import tumble
from tumble.compare.run.flight import simulate
from tumble.scenarios.read import contact_catalogue, read_scene
from tumble.scenarios.truth import NoTruth, truth

# Doubles beside 100 bits: what 1e4 operations and a growth of some hundred by the impacts may leave, over the size.
ROUNDING = 1e-12


def off(scene, true, method, dt=None):
    """How far vertices are off at most [m], over body and distance, where the truth is known; and the trajectory."""
    flight = simulate(tumble, scene, method, dt or scene.duration)
    known = np.isfinite(true.vertices).all(axis=(1, 2, 3))
    apart = np.linalg.norm(flight.vertices - true.vertices, axis=-1)[known]
    size = scene.body.reach + np.abs(true.vertices[known]).max()
    return float(apart.max()) / size, flight


@pytest.mark.parametrize("name", [name for name in contact_catalogue() if name != "top"])
def test_events_has_no_error_but_rounding(name):
    scene = read_scene(name)
    true = truth(scene, False)
    error, flight = off(scene, true, "events")
    assert error < ROUNDING
    ends = true.contacts[0].ended_s
    if np.isfinite(ends):
        assert f"{ends:.6g} s" in flight.notes[0]


@pytest.mark.parametrize("family", FAMILIES[:12])
def test_events_on_random_scenes(family, tmp_path):
    path, tried = tmp_path / "drawn.toml", 0
    for seed in range(40, 42):
        path.write_text(drawn(family, seed), encoding="utf-8")
        scene = read_scene(str(path))
        try:
            true = truth(scene, False)
        except NoTruth:
            continue
        assert off(scene, true, "events")[0] < ROUNDING, seed
        tried += 1
    assert tried


def test_a_method_without_contact_says_so():
    with pytest.raises(NotImplementedError, match="rk4 has no plane"):
        tumble.build(read_scene("ball-drop-half"), "rk4")
