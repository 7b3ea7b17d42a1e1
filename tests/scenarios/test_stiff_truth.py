"""The truth of what is stiff: dampers that hold, tethers of any strength, and how long the flights may take."""

import re

import numpy as np
import pytest

from tumble.scenarios.read import catalogue, read_scene, scene_of, scene_path
from tumble.scenarios.truth import truth
from tumble.scenarios.truth.forced import flight


def changed(name, **numbers):
    """A scene of the catalogue with other numbers."""
    path = scene_path(name)
    text = path.read_text(encoding="utf-8")
    for key, value in numbers.items():
        text, found = re.subn(rf"^{key}( *)=.*$", rf"{key}\1= {value}", text, flags=re.MULTILINE)
        assert found == 1
    return scene_of(text, path, name)


def size(scene):
    return 2 * np.linalg.norm(scene.body.points, axis=1).max()


@pytest.mark.parametrize("name", [name for name in catalogue() if not read_scene(name).is_free])
def test_forced_scenes_of_the_catalogue_are_known_to_1e_12_of_their_size(name):
    true = truth(read_scene(name))
    assert true.horizon == np.inf
    assert true.bound.max() <= 1e-12 * size(read_scene(name))


def test_collocation_and_series_agree(monkeypatch):
    scene = changed("tether-overdamped", duration=0.02)
    by_series = truth(scene)
    monkeypatch.setattr(flight, "STIFF_STEPS", 0)
    by_collocation = truth(scene)
    assert "Radau" in by_collocation.how
    assert "Radau" not in by_series.how
    off = np.linalg.norm(by_series.vertices - by_collocation.vertices, axis=-1).max(axis=-1)
    assert (off <= by_series.bound + by_collocation.bound).all()
    # Not by being generous: nearly all of either is the rounding of what is told.
    assert by_collocation.bound.max() < 3e-16 * size(scene)


def test_a_damper_a_million_times_stiffer_holds_to_the_end():
    # Its fastest motion dies out in 10 ns, and the corner is home after some 20 us, of 0.1 s.
    scene = changed("tether-overdamped", stiffness=1e12, damping=1.96e7)
    true = truth(scene)
    assert true.horizon == np.inf
    assert true.bound.max() <= 1e-12 * size(scene)
    # What is left of 13 mm is the stretch that pulls a corner round that is no faster than some m/s.
    anchor = scene.tethers[0].anchor
    assert np.linalg.norm(true.vertices[-1, 0, 7] - anchor) < 1e-6


def test_a_tether_of_1e9_newtons_a_metre():
    scene = changed("tether-undamped", stiffness=1e9, duration=0.002)
    true = truth(scene)
    assert true.horizon == np.inf
    assert true.bound.max() <= 1e-12 * size(scene)


def test_compiling_does_not_use_up_the_time_of_a_flight(monkeypatch):
    clock = iter((100.0, 100.0, 100.0 + flight.BUDGET_S - 1, 100.0 + flight.BUDGET_S + 1))
    monkeypatch.setattr(flight, "thread_time", lambda: next(clock))
    budget = flight.Budget()
    assert [budget.is_up() for _ in range(3)] == [False, False, True]


def test_what_there_is_time_for_is_told(monkeypatch):
    # All of it takes some forty times as long.  Of flights that are cut where the time is up, the last would be empty.
    monkeypatch.setattr(flight, "BUDGET_S", 1.0)
    true = truth(changed("tether-undamped", stiffness=1e8, duration=10.0, samples=500))
    assert 3 <= true.known < len(true.times)
    assert "processor time" in true.why
    known = truth(changed("tether-undamped", stiffness=1e8, duration=0.04, samples=2))
    assert true.times[2] == known.times[2]
    np.testing.assert_array_equal(true.vertices[:3], known.vertices)
    assert np.median(true.input_error[1:3] / known.input_error[1:]) == pytest.approx(1.0, rel=0.1)
