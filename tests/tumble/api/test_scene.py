"""Scenes as Python values: the same question as the scene file, bit for bit, and refused in one line."""

import tomllib
from dataclasses import fields, is_dataclass

import numpy as np
import pytest

import tumble
from tumble.api.scene import questions
from tumble.scenarios.read import catalogue, contact_catalogue, extremes, read_scene

BRICK = tumble.Scene.box(size=(0.4, 0.15, 0.1), mass=2.4, gravity=(0, -9.81, 0), duration=2.0, samples=80)


def same(one: object, other: object) -> bool:
    """Whether two values are equal, arrays bit for bit."""
    if isinstance(one, np.ndarray):
        return isinstance(other, np.ndarray) and one.tobytes() == other.tobytes()
    if is_dataclass(one):
        return type(one) is type(other) and all(
            same(getattr(one, field.name), getattr(other, field.name)) for field in fields(one)
        )
    if isinstance(one, tuple):
        return isinstance(other, tuple) and len(one) == len(other) and all(map(same, one, other))
    return one == other


@pytest.mark.parametrize("name", [*catalogue(), *contact_catalogue(), *extremes()])
def test_a_scene_is_the_question_of_its_file_and_its_text_is_read_back(name, tmp_path):
    scene = tumble.Scene.read(name)
    assert same(scene.question, read_scene(name))
    assert tomllib.loads(scene.to_toml()) == scene.to_dict()
    if scene.document["body"]["shape"] != "mesh":
        (tmp_path / f"{name}.toml").write_text(scene.to_toml(), encoding="utf-8")
        assert same(read_scene(str(tmp_path / f"{name}.toml")), scene.question)


def test_a_scene_is_made_of_values_and_does_not_change():
    struck = BRICK.with_impulse((-3.1, 0.9, 2.2), vertex=0, time=0.5)
    assert (len(BRICK.question.impulses), len(struck.question.impulses)) == (0, 1)
    heavy = struck.replace(mass=np.float64(4.8), name="heavy", times=np.array([0.5, 1.0]), samples=None)
    assert (heavy.question.body.mass, heavy.name, heavy.question.times.tolist()) == (4.8, "heavy", [0.5, 1.0])
    assert struck.question.body.mass == 2.4
    assert heavy != struck == struck.replace()
    assert BRICK.replace(gravity=None).question.gravity is None
    heavy.to_dict()["body"]["mass"] = 1.0
    assert heavy.document["body"]["mass"] == 4.8


@pytest.mark.parametrize(
    "scene",
    [
        tumble.Scene.sphere(0.1, 1.0, duration=1.0, samples=2),
        tumble.Scene.rigid(np.diag((1.0, 2.0, 2.5)), np.eye(3), mass=1.0, duration=1.0, samples=2),
        tumble.Scene.from_dict({**BRICK.document, "tether": []}, name="x").with_tether(
            0, (0, 2, 0), stiffness=80.0, damping=0.5
        ),
    ],
    ids=lambda scene: scene.name,
)
def test_every_shape_and_part_makes_a_question(scene):
    assert scene.question.body.mass == scene.document["body"]["mass"]


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: BRICK.replace(mass=-1), "body.mass = -1: must be > 0"),
        (lambda: BRICK.replace(masss=1), "masss: unknown key"),
        (lambda: BRICK.with_impulse((1, 2), vertex=0), "impulse[0].value"),
        (lambda: BRICK.with_impulse((1, 2, 3), vertex=9), "impulse[0].vertex = 9"),
        (lambda: tumble.Scene.box((1, 1, 1), 1.0, samples=2), "duration: missing"),
        (lambda: tumble.Scene.read("bricks"), "unknown scene 'bricks'"),
        (lambda: tumble.Scene.of(3), "must be a scene's name, a path"),
        (lambda: BRICK.replace(name="a/b"), "must be printable text"),
        (lambda: questions([]), "no scene was given"),
    ],
)
def test_a_value_that_no_scene_has_is_refused_where_it_is_given(make, words):
    with pytest.raises(tumble.UserError) as refused:
        make()
    assert words in str(refused.value)
    assert "\n" not in str(refused.value)


def test_two_scenes_of_one_name_are_two_scenes():
    asked = questions(["brick-tumble", tumble.Scene.read("brick-tumble").replace(mass=3.0), "brick-tumble"])
    assert [(scene.name, scene.body.mass) for scene in asked] == [("brick-tumble", 10.0), ("brick-tumble-2", 3.0)]
