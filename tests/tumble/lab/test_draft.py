"""The scene being asked: what is edited in it, the frames it is shown in, and that its text says it all."""

import tomllib

import numpy as np
import pytest

from tumble.lab.click import impulse_table
from tumble.lab.draft import MOST, Draft, frames
from tumble.scenarios.read import BadScene, catalogue, read_scene

RAY = ([0.1 + 0.2, 7.0 / 3.0, 20.000000000000004], [1.0 / 70.0, 0.02, -1.0])


def same(one, other) -> bool:
    """Whether two scenes are one question, to the last bit."""
    blows = zip(one.impulses, other.impulses, strict=True)
    return (
        all(np.array_equal(getattr(one, name), getattr(other, name)) for name in ("times", "start", "gravity"))
        and (one.duration, one.step) == (other.duration, other.step)
        and np.array_equal(one.body.moments, other.body.moments)
        and all(a.time == b.time and np.array_equal(a.value, b.value) for a, b in blows)
    )


@pytest.mark.parametrize("name", catalogue())
def test_the_text_of_every_scene_is_that_scene(name, tmp_path):
    draft = Draft.opened(name)
    file = tmp_path / "mine.toml"
    if draft.mesh:
        (tmp_path / draft.mesh.name).write_bytes(draft.mesh.read_bytes())
    file.write_text(draft.named(file, draft.mesh.name if draft.mesh else None).text, encoding="utf-8")
    assert same(read_scene(str(file)), draft.scene)


@pytest.mark.parametrize("name", catalogue())
def test_every_impulse_of_a_file_is_at_a_frame(name):
    scene = Draft.opened(name).scene
    assert {impulse.time for impulse in scene.impulses} <= set(scene.rows.tolist())
    assert len(scene.times) <= MOST + len(scene.impulses)


@pytest.mark.parametrize(
    ("duration", "step", "count"),
    [(0.5, 0.02, 25), (10.0, 0.002, 240), (2.0, 0.001, 96), (0.1, 0.0001, 120), (1.0, 0.002, 120), (60.0, 0.01, 600)],
)
def test_frames_are_whole_steps_apart(duration, step, count):
    assert frames(duration, step) in range(round(0.6 * count), round(1.7 * count) + 1)
    assert round(duration / step) % frames(duration, step) == 0


def test_where_no_number_of_frames_divides_the_steps_they_are_cut():
    assert frames(1.009, 0.001) == 121  # 1009 is prime


def test_the_frames_of_the_coursework_hold_its_five_times():
    published = read_scene("table-4-1").times
    assert set(published) <= set(np.round(Draft.opened("table-4-1").scene.times, 12))


def test_a_click_is_an_impulse_of_the_text():
    draft = Draft.opened("table-4-1-ray").without_impulses().with_impulse(impulse_table(*RAY, 5.0, 0.0))
    (table,) = tomllib.loads(draft.text)["impulse"]
    assert table == {"time": 0.0, "magnitude": 5.0, "ray": {"origin": RAY[0], "direction": RAY[1]}}


def test_edits_are_in_the_scene_and_the_text():
    draft = Draft.opened("two-hits").edited({("body", "size"): [1.0, 2.0, 3.0], ("body", "mass"): 7.5, ("step",): 0.01})
    assert draft.scene.body.size.tolist() == [1.0, 2.0, 3.0]
    assert tomllib.loads(draft.text)["body"]["mass"] == 7.5
    assert len(draft.scene.times) < len(Draft.opened("two-hits").scene.times) * 2


@pytest.mark.parametrize(
    ("path", "value", "says"),
    [
        (("body", "mass"), 0.0, "body.mass"),
        (("body", "size"), [1.0, -1.0, 1.0], "body.size"),
        (("step",), 0.0, "step"),
        (("duration",), -1.0, "duration"),
        (("gravity",), [0.0, float("nan"), 0.0], "gravity"),
        (("duration",), 1e300, "step"),
    ],
)
def test_bad_values_are_refused_in_one_line_that_names_the_key(path, value, says):
    with pytest.raises(BadScene, match=says) as refused:
        Draft.opened("brick-tumble").edited({path: value})
    assert "\n" not in str(refused.value)
