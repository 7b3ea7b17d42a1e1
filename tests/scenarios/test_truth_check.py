"""The truth's bound on scenes drawn at random, against the second formulation, and that the check itself can fail."""

import re
from dataclasses import replace

import pytest
from random_scenes import FAMILIES, REACHED, drawn
from second_truth import worst

from tumble.scenarios.read import read_scene
from tumble.scenarios.truth import truth


@pytest.fixture
def file_of(tmp_path):
    def written(family, seed):
        (tmp_path / "drawn.toml").write_text(drawn(family, seed), encoding="utf-8")
        return tmp_path / "drawn.toml"

    return written


@pytest.mark.parametrize("family", FAMILIES)
def test_the_bound_holds(family, file_of):
    # A seed that `make truth-check` does not reach.
    path = file_of(family, 1000)
    true = truth(read_scene(str(path)))
    ratio, off = worst(path, true, REACHED.get(family))
    assert ratio <= 1
    assert off > 0, "nothing is rounded: the check is moot"


def test_moments_rounded_at_reading_would_be_seen(file_of):
    path = file_of("needle, oblique tensor", 1000)
    handed = truth(replace(read_scene(str(path)), written=None))
    assert worst(path, handed)[0] > 2


def test_large_bodies_are_rounded_once(file_of):
    # Corners more than a metre off, at a place that is no short fraction: one rounding more is seen.
    path = file_of("oblique tensor", 0)
    text = re.sub("position = .*", "position = [0.7, -3.3, 1.9]", path.read_text())
    path.write_text(text)
    assert worst(path, truth(read_scene(str(path))))[0] <= 1
