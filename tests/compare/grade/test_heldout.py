"""The held-out half of docs/confusion.md: what its table says is what its script finds, and what its page counts."""

import csv
from dataclasses import replace
from pathlib import Path

import planted
import pytest
import unnamed

from tools import heldout
from tumble.compare.grade.verdicts import EXPLAINED_PARTLY, UNEXPLAINED

DOCS = Path(__file__).parents[3] / "docs"


@pytest.fixture(scope="module")
def shown():
    with (DOCS / "heldout.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def test_a_planted_row_is_what_the_script_makes(shown):
    """Of a mistake of which a longer search, as here, explains nothing either."""
    row = next(row for row in shown if (row["source"], row["case"]) == (heldout.UNNAMED, "Magnus force"))
    made = heldout.planted((row["source"], row["case"], row["scene"]))
    assert (made.outcome, made.verdict) == (row["outcome"], row["verdict"])
    assert made.max_error_m == pytest.approx(float(row["max_error_m"]), rel=1e-4)  # six figures are written


def test_a_cause_that_leaves_most_of_the_error_is_no_partial_explanation(tmp_path):
    """Of all rows, or of the early ones: fine steps fit the first rows of any smooth motion."""
    scene = heldout.SCENES["struck"]
    throw = heldout.read(scene)
    rows = list(heldout.MISTAKES["gravity ramped up in 0.4 s"](throw).rows())
    heldout.write(tmp_path / "ramped.csv", rows, throw.vertices, form="{:.6g}".format)
    graded = heldout.grade(tmp_path / "ramped.csv", heldout.read_scene(str(scene)), {}, search_s=0.1)
    assert graded.verdict == EXPLAINED_PARTLY
    best, null = graded.diagnosis.best, graded.diagnosis.null
    for left in ({"rms_m": 0.9 * null.rms_m}, {"weighted_rms_m": 0.9 * null.weighted_rms_m}):
        other = replace(graded.diagnosis, best=replace(best, **left))
        assert replace(graded, diagnosis=other).verdict == UNEXPLAINED, left


def test_every_mistake_is_in_the_table_and_the_page_counts_them(shown):
    own = [row for row in shown if row["source"] == "planted"]
    assert {(row["case"], row["scene"]) for row in own} == {
        (mistake, scene) for mistake in heldout.MISTAKES for scene in heldout.SCENES
    }
    honest = sum(row["outcome"] in (heldout.NEAREST, heldout.UNEXPLAINED) for row in own)
    assert f"{honest} of {len(own)}" in (DOCS / "confusion.md").read_text(encoding="utf-8")


def test_every_mistake_with_a_name_is_in_the_table(shown):
    named = [(row["case"], row["scene"]) for row in shown if row["source"] == "named"]
    assert sorted(named) == sorted((mistake, case.scene) for mistake, case in planted.CASES.items())


def test_what_was_told_firmly_of_what_is_held_out_was_right_as_the_pages_say(shown):
    held_out = [row for row in shown if row["source"] in (heldout.UNNAMED, heldout.NAMED, heldout.LEFT_OUT)]
    firm = [row for row in held_out if row["verdict"] == heldout.EXPLAINED_WHOLLY]
    right = sum(not row["outcome"].startswith("wrong") for row in firm)
    for page, said in {
        DOCS / "confusion.md": f"of {len(held_out)} files",
        DOCS.parent / "README.md": f"{right} of {len(firm)} confident answers",
    }.items():
        assert said in page.read_text(encoding="utf-8"), page


def test_the_readme_has_the_figures_of_the_rows():
    def row(source, verdict, outcome):
        return heldout.HeldOutRow(source, "", "", outcome, verdict, "", 1.0, None)

    rows = [
        row(heldout.NAMED, heldout.EXPLAINED_WHOLLY, heldout.RIGHT),
        row(heldout.UNNAMED, heldout.EXPLAINED_WHOLLY, heldout.WRONG),
        row(heldout.LEFT_OUT, "not explained", heldout.UNEXPLAINED),
        row(heldout.ENGINE, heldout.EXPLAINED_WHOLLY, heldout.RIGHT),
    ]
    made = heldout.in_readme((DOCS.parent / "README.md").read_text(encoding="utf-8"), rows)
    assert "on 3 held-out files" in made
    assert "1 of 2 confident answers" in made


def test_the_spoilt_program_is_right_but_for_its_mistake(tmp_path):
    """What is judged is the mistake, not the program: without one its file is correct to its digits."""
    scene = heldout.SCENES["struck"]
    throw = heldout.read(scene)
    heldout.write(tmp_path / "right.csv", list(unnamed.Spoilt(throw).rows()), throw.vertices, form="{:.6g}".format)
    assert heldout.grade(tmp_path / "right.csv", heldout.read_scene(str(scene)), {}).verdict.startswith("correct")


@pytest.mark.parametrize(
    "mistake",
    [
        "impulse 2 at vertex 7",
        "torque of impulses in body axes",
        "start spin, y and z swapped",
        "inertia turned the wrong way",
        "damping of the body's z",
        "gravity a row late",
        "positions in feet",
        "edges in another order",
    ],
)
def test_a_mistake_with_a_name_is_named_alone(mistake):
    made = heldout.planted((heldout.NAMED, mistake, planted.CASES[mistake].scene))
    assert made.outcome == heldout.RIGHT, made
