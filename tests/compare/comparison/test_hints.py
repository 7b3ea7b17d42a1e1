"""What a scene says to look at where its truth is lost."""

import pytest

from tumble.compare.comparison.hints import hints
from tumble.scenarios.read import catalogue, read_scene

SCENE = """
title = "tied"
duration = {duration}
samples = 4
step = 0.01
gravity = [0.0, -9.81, 0.0]
[body]
shape = "box"
size = [1.0, 0.5, 0.2]
mass = 1.0
"""
TETHER = "[[tether]]\nvertex = 7\nanchor = [0.0, 2.0, 0.0]\nstiffness = {k}\nrest_length = {rest}\n"


@pytest.mark.parametrize(
    ("duration", "more", "said"),
    [
        (1.0, TETHER.format(k=80.0, rest=0.0), "tether 0 starts stretched by 1.82 m: is a rest_length missing?"),
        (1.0, TETHER.format(k=80.0, rest=3.0), "tether 0 starts compressed by 1.18 m: is its rest_length correct?"),
        (10.0, TETHER.format(k=1e9, rest=1.82), "swings through 3e+05 radians in 10 s"),
        (1.0, "[floor]\nstiffness = 1e4\nheight = 0.6\n", "the body starts 0.85 m deep in the floor"),
        (1.0, "[floor]\nstiffness = 1e4\nheight = -0.6\n", "soon becomes chaotic"),
    ],
)
def test_what_is_likely_wrong_is_said_first(tmp_path, duration, more, said):
    (tmp_path / "tied.toml").write_text(SCENE.format(duration=duration) + more)
    assert said in next(hints(read_scene(str(tmp_path / "tied.toml"))))


def test_a_free_scene_has_nothing_to_look_at():
    for name in catalogue():
        scene = read_scene(name)
        if scene.is_free:
            assert not list(hints(scene))
