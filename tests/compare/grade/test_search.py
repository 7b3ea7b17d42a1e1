"""What a search follows: what has an effect, the right axes, clocks late by less than a row, rounded values."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from explanations import explanation, mistakes_of
from programs import Program, fly, read, write

from tumble.compare.grade.grade import EXPLAINED_WHOLLY, Grade, context_of, grade, scale_of
from tumble.compare.grade.hypotheses.explanation import Mistake
from tumble.compare.grade.hypotheses.hypothesis import Hypothesis
from tumble.compare.grade.hypotheses.mistakes.clocks import clocks
from tumble.compare.grade.measure.errors import measure
from tumble.compare.grade.model.program_model import output_points
from tumble.compare.grade.read.trajectory import Trajectory
from tumble.compare.grade.search.causal import Candidate, CausalSearch
from tumble.compare.grade.search.closing import HIDDEN, Closing
from tumble.compare.grade.search.shells import Shells
from tumble.scenarios.read import read_scene, scene_path

GAME = {"dt": 1 / 240, "every": 4, "method": "symplectic", "until": 1.5}


def written(folder, scene, form="{:.7f}", kind="pose", flip=None, **program):
    """Return the file of a program."""
    path = scene_path(scene)
    rows, vertices = fly(path, Program(**program)), read(path).vertices
    return Path(write(folder / "program.csv", rows, vertices, kind, form.format, flip=flip))


def named(file, scene):
    """Return the mistakes of a file that is explained, by name: their values."""
    found = grade(file, read_scene(scene), {}, search_s=0.1)
    assert found.verdict == EXPLAINED_WHOLLY
    return {mistake.hypothesis.name: mistake.value for mistake in found.diagnosis.best.mistakes}


def candidate(names, left):
    mistakes = mistakes_of(names)
    score = left + COST * len(mistakes)
    return Candidate(mistakes, score, score, False, score)


COST = 10.0


@pytest.mark.parametrize(("left", "is_followed"), [(500.0, False), (499.0, True)])
def test_a_mistake_without_an_effect_is_not_followed(left, is_followed):
    search = CausalSearch.__new__(CausalSearch)
    search._cost = lambda mistakes: COST * len(mistakes)
    pool = {}
    first = search._add(pool, candidate("a", 500.0))
    first.is_expanded = True
    assert search._add(pool, candidate("ab", left)).is_expanded is not is_followed
    assert not search._add(pool, candidate("b", left)).is_expanded


def test_a_body_that_turns_too_fast_for_any_step_has_no_scheme():
    search = CausalSearch.__new__(CausalSearch)
    search._upon_steps = lambda mistakes: []
    assert search._schemes(()) == []


def test_a_translation_that_is_late_by_a_step_is_left_out(tmp_path):
    """It jumps from the start on, and from each impulse on, as that of a program that moves the body by the old v."""
    scene = read_scene("two-hits")
    sample = measure(Trajectory(written(tmp_path, "two-hits"), scene, {}), scene).sample
    events = np.array([impulse.time for impulse in scene.impulses])
    assert (events > 0).any()
    points = output_points(scene.body)
    shells = Shells(sample, scale_of(sample, scene, 0.0), points, float(sample.times[-1]), events)
    errors = np.zeros((1, len(shells), 4, 3))
    late = 1e3 * (shells.times > 0) + 1e4 * (shells.times[:, None] > events).sum(axis=1)
    errors[0, :, 0] = late[:, None]
    assert np.abs(shells.without_translation(errors)).max() < 1.0
    errors[0, :, 0] = 1e3 * (shells.times > events.max() + 0.2)[:, None]
    assert np.abs(shells.without_translation(errors)).max() > 100.0


@pytest.mark.parametrize("rows", [0.2, 0.7])
def test_a_clock_that_is_late_by_a_part_of_a_row_is_named(tmp_path, rows):
    file = written(tmp_path, "two-hits", form="{:.5f}", dt=0.001, every=40, ahead=-rows * 0.04)
    assert named(file, "two-hits") == {"clock-offset": pytest.approx(-rows * 0.04, rel=1e-3)}


def test_clocks_that_are_late_by_a_part_of_a_row_are_tried_first(tmp_path):
    """The effect has a kink where an impulse passes a row, over which no fit gets from right clocks."""
    scene = read_scene("two-hits")
    measured = measure(Trajectory(written(tmp_path, "two-hits"), scene, {}), scene)
    offset = next(each for each in clocks(context_of(scene, 0, measured)) if each.name == "clock-offset")
    assert sum(0 < -value < measured.spacing_s for value in offset.values) >= 3


def test_other_axes_are_named_although_left_handed_ones_explain_the_rotation(tmp_path):
    swapped = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
    file = written(tmp_path, "two-hits", kind=range(8), flip=swapped, linear=0.3, angular=0.1, **GAME)
    assert "wrong-axes" in named(file, "two-hits")


def test_what_explains_most_of_the_translation_alone_is_tried_again_with_it():
    search, tried = CausalSearch.__new__(CausalSearch), []
    search._fit = SimpleNamespace(is_free=True)
    search._explored = lambda programs: tried.append((search._fit.is_free, list(programs))) or []
    alone, free = candidate("a", 1.0), candidate("b", 0.5)
    assert search._named([free], [alone.mistakes]) == [free]
    assert tried == [(False, [free.mistakes, alone.mistakes])]
    assert search._fit.is_free


def test_a_plain_value_is_told_of_a_program_of_single_precision(tmp_path):
    """It rounds 1 - c dt always in the same way, so that another rate fits the file best."""
    file = written(tmp_path, "brick-tumble", **GAME, linear=0.3, angular=0.1, number=np.float32)
    values = named(file, "brick-tumble")
    assert (values["linear-damping"], values["angular-damping"]) == (0.3, 0.1)


FITTED = replace(explanation("a", 1.0, nothing=True), in_digits=50.0, in_floors=0.1)


@pytest.mark.parametrize(
    ("other", "is_as_plain"),
    [
        (replace(FITTED, weighted_rms_m=2.9), True),
        (replace(FITTED, weighted_rms_m=3.1, in_floors=1.9), False),
        (replace(FITTED, weighted_rms_m=3.1, in_floors=0.9 * HIDDEN), True),
        (replace(FITTED, weighted_rms_m=3.1, in_floors=1.1 * HIDDEN), False),
    ],
)
def test_a_plain_value_may_leave_more_if_single_precision_hides_it(other, is_as_plain):
    closing = Closing.__new__(Closing)
    closing._evaluator = SimpleNamespace(scale=SimpleNamespace(floor_m=0.1))
    assert closing._is_as_plain(other, replace(FITTED, in_floors=0.3)) is is_as_plain
    only_digits = replace(FITTED, in_digits=1.0)
    assert not closing._is_as_plain(replace(other, in_digits=50.0), only_digits), "these need no single precision"


def test_fitted_values_of_others_are_no_reason_to_prefer_them_to_plain_ones():
    closing, plain = Closing.__new__(Closing), replace(FITTED, weight=7.0)
    closing._without_mistakes = closing._without_details = lambda best: best
    closing._plain = lambda best: plain
    assert closing.simplified(replace(FITTED, weight=9.0)).plain_cost == 0.0
    best, other = closing.simplified(replace(FITTED, weight=5.0)), replace(FITTED, weight=6.0)
    closing._search = SimpleNamespace(alternatives=lambda mistakes: [other.mistakes])
    closing._explained = lambda several: iter([other])
    assert [each.weight for each in closing.alternatives(best)] == [8.0]


@pytest.mark.parametrize(("value", "is_open"), [(0.25, False), (0.2503, True)])
def test_plain_values_are_firm_though_single_precision_explains_much(value, is_open):
    rate = Hypothesis("rate", "rate", "{}", lambda program, _: program, (0.1, 1.0))
    best = replace(explanation("ab", 1.0, nothing=True), in_digits=50.0)
    best = replace(best, mistakes=(*best.mistakes, Mistake(rate, value)))
    diagnosis = SimpleNamespace(engines=(), best=best, stopped_s=0.0)
    grade_of_it = SimpleNamespace(diagnosis=diagnosis, measured=SimpleNamespace(single=False))
    assert cast(Any, Grade.is_open).fget(grade_of_it) is is_open
