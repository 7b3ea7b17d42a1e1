"""Programs in steps: a slow clock has steps of its own time, rows may be a step late, and a step may be very long."""

from itertools import pairwise
from pathlib import Path

import pytest
from programs import Program, fly, read, write

from tumble.compare.grade.grade import EXPLAINED_WHOLLY, grade
from tumble.scenarios.read import read_scene, scene_path

LOOP = {"method": "symplectic", "axes": "world", "turn": "quaternion", "until": 1.5}


def named(folder, scene, rewritten=lambda rows: rows, **program):
    """Return the mistakes of a file of nine decimals by name: their values."""
    path = scene_path(scene)
    rows = rewritten(list(fly(path, Program(**LOOP | program))))
    file = write(folder / "loop.csv", rows, read(path).vertices, form=lambda number: f"{number:.9f}")
    found = grade(Path(file), read_scene(scene), {})
    assert found.verdict == EXPLAINED_WHOLLY
    return {mistake.hypothesis.name: mistake.value for mistake in found.diagnosis.best.mistakes}


def test_steps_are_a_part_of_a_slow_clocks_own_time(tmp_path):
    """The file's row interval is 1/60 s, in which the program moves on by 0.97/60 s, in four steps."""
    slow = lambda rows: [(t / 0.97, *rest) for t, *rest in rows]  # noqa: E731
    values = named(tmp_path, "brick-tumble", slow, dt=0.97 / 240, every=4)
    assert values["clock-rate"] == pytest.approx(0.97)
    assert values["symplectic-euler"] == pytest.approx(1 / 240)


def test_rows_a_step_late_are_named_upon_a_scheme(tmp_path):
    late = lambda rows: [rows[0], *((then[0], *before[1:]) for before, then in pairwise(rows))]  # noqa: E731
    every_step = lambda rows: late(rows)[::5]  # noqa: E731
    values = named(tmp_path, "brick-tumble", every_step, dt=0.01, every=1)
    assert values["log-lag"] == pytest.approx(0.01)
    assert values["symplectic-euler"] == pytest.approx(0.01)


def test_a_step_in_which_the_body_turns_by_radians_is_named(tmp_path):
    """Errors of such steps grow in no order, so a short one does not show how long they are."""
    values = named(tmp_path, "spin-fast", dt=0.02, every=1, until=0.4, turn="exponential", axes="momentum")
    assert values == {"symplectic-euler": pytest.approx(0.02)}


def test_w_in_world_axes_that_turns_the_body_as_if_in_body_axes_is_named_upon_a_scheme(tmp_path):
    values = named(tmp_path, "two-hits", dt=1 / 240, every=4, wrong_side=True)
    assert values.keys() == {"angular-velocity-in-wrong-frame", "symplectic-euler"}
    assert values["symplectic-euler"] == pytest.approx(1 / 240)
