"""Refusals in the lab's own words: its controls are named, and no option that nobody can type there."""

import pytest

from tumble.compare.grade.read.columns import BadTrajectory
from tumble.lab.draft import Draft
from tumble.lab.refusals import in_words
from tumble.scenarios.read import BadScene


@pytest.mark.parametrize(
    ("path", "value", "begins"),
    [
        (("body", "mass"), -1.0, "Mass: -1.0 is not allowed"),
        (("body", "size"), [1.0, -1.0, 1.0], "Size y: -1.0 is not allowed"),
        (("gravity",), [0.0, float("inf"), 0.0], "Gravity y: inf is not allowed"),
        (("step",), 0.0, "Step: 0.0 is not allowed"),
        (("duration",), -1.0, "Duration: -1.0 is not allowed"),
    ],
)
def test_a_value_is_refused_by_the_name_of_its_control(path, value, begins):
    with pytest.raises(BadScene) as refused:
        Draft.opened("two-hits").edited({path: value})
    line = in_words(refused.value)
    assert line.startswith(begins)
    assert "two-hits" not in line


def test_a_shorter_duration_is_no_matter_of_instants_that_nobody_sees():
    draft = Draft.opened("two-hits").without_impulses().edited({("duration",): 0.1})
    assert draft.scene.duration == 0.1


def test_options_are_said_to_be_those_of_the_command_line():
    line = in_words(BadTrajectory("mine.csv: no column says the time, t_s: perhaps --map Time=t_s"))
    assert line.startswith("mine.csv: no column says the time")
    assert "tumble grade" in line


def test_other_lines_are_left_as_they_are():
    assert in_words(BadTrajectory("mine.csv: empty")) == "mine.csv: empty"
