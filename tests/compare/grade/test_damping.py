"""Damping of any rate in schemes of engines, forces, damping, move; and that no explanation enlarges an error."""

import re
from itertools import pairwise
from math import exp
from pathlib import Path

import pytest
from explained import evaluator_of, explained
from programs import Program, fly, read, write

from tumble.compare.grade.grade import grade
from tumble.compare.grade.hypotheses.engine_schemes import DAMPING_FORMS
from tumble.compare.grade.hypotheses.explanation import Mistake
from tumble.compare.grade.hypotheses.scheme_hypotheses import Step
from tumble.compare.grade.model.kernel.dynamics import EXPONENTIALLY, IMPLICITLY, LINEARLY
from tumble.compare.grade.search.causal import CausalSearch
from tumble.compare.grade.search.closing import left_in_a_step, rate_of_a_step
from tumble.compare.grade.search.proposals import Proposals
from tumble.compare.grade.verdicts import EXPLAINED_WHOLLY
from tumble.reports.grade import evidence
from tumble.scenarios.read import read_scene, scene_path

FORMS = {"factor": LINEARLY, "exp": EXPONENTIALLY, "implicit": IMPLICITLY}
METRES = {"m": 1.0, "mm": 1e-3, "µm": 1e-6, "nm": 1e-9, "pm": 1e-12, "fm": 1e-15}
GAME = {"method": "symplectic", "axes": "world", "turn": "quaternion", "until": 2.0}


def graded(folder, scene, **program):
    """Return the grade of a file of seven decimals, its clock of five."""
    path = scene_path(scene)
    rows = [(float(f"{t:.5f}"), *rest) for t, *rest in fly(path, Program(**GAME | program))]
    file = write(folder / "game.csv", rows, read(path).vertices, form=lambda number: f"{number:.7f}")
    return grade(Path(file), read_scene(scene), {})


CASES = {
    "forces, damping, move": ("brick-tumble", "before it moves", "factor", 0.3, 0.3),
    "forces, damping, move, exp": ("two-hits", "before it moves", "exp", 0.137, 0.5),
    "forces, move, damping": ("two-hits", "last", "exp", 0.3, 0.3),
    "velocity only": ("brick-tumble", "before it moves", "implicit", 0.2, 0.0),
}


@pytest.mark.parametrize("name", CASES)
def test_a_game_loop_with_damping_of_its_own_is_named_with_its_order_and_rates(tmp_path, name):
    scene, damps, damped, linear, angular = CASES[name]
    steps = {"brick-tumble": {"dt": 1 / 60, "every": 1}, "two-hits": {"dt": 1 / 240, "every": 4}}[scene]
    gyroscopic = "still in world" if angular else "right"
    how = {"damps": damps, "damped": damped, "linear": linear, "angular": angular, "gyroscopic": gyroscopic}
    found = graded(tmp_path, scene, **steps, **how)
    best = found.diagnosis.best
    assert found.verdict == EXPLAINED_WHOLLY
    assert best.max_m < 1e-6
    rates = {m.hypothesis.name: (m.value, dict(m.hypothesis.details)) for m in best.mistakes}
    where = "after the forces of a step" if damps == "before it moves" else "after a step has moved the body"
    form = {LINEARLY: "by c dt", EXPONENTIALLY: "by exp(-c dt)", IMPLICITLY: "by 1/(1 + c dt)"}[FORMS[damped]]
    for damping, rate in (("linear-damping", linear), ("angular-damping", angular)):
        assert (damping in rates) == bool(rate)
        if rate:
            assert rates[damping] == (pytest.approx(rate, rel=1e-9), {"damping-form": form, "damping-place": where})
    assert ("gyroscopic-term-missing" in rates) == (gyroscopic != "right")


@pytest.mark.parametrize(("linear", "angular"), [(0.3, 0.05), (0.27, 0.48)])
def test_rates_are_found_over_a_long_flight(tmp_path, linear, angular):
    """Over 10 s a rate that is a little off leaves as much as any: it is found from the first rows on."""
    how = {"dt": 1 / 60, "every": 1, "until": 10.0, "damps": "before it moves", "damped": "factor"}
    found = graded(tmp_path, "brick-tumble", linear=linear, angular=angular, **how)
    values = {mistake.hypothesis.name: mistake.value for mistake in found.diagnosis.best.mistakes}
    assert found.verdict == EXPLAINED_WHOLLY
    assert values["linear-damping"] == pytest.approx(linear, rel=1e-9)
    assert values["angular-damping"] == pytest.approx(angular, rel=1e-9)


@pytest.mark.parametrize("decays", FORMS.values())
def test_a_rate_in_another_form_takes_as_much(decays):
    share = 0.3 / 60
    other = rate_of_a_step(left_in_a_step(share, DAMPING_FORMS[LINEARLY]), DAMPING_FORMS[decays])
    left = {LINEARLY: 1 - other, EXPONENTIALLY: exp(-other), IMPLICITLY: 1 / (1 + other)}[decays]
    assert left == pytest.approx(1 - share, rel=1e-14)
    assert left_in_a_step(other, DAMPING_FORMS[decays]) == pytest.approx(left, rel=1e-14)


def test_damping_shows_in_which_steps_it_acts_though_nothing_else_does(tmp_path):
    """A smooth decay at 0.04996 /s leaves 0.2 mm."""
    found = graded(tmp_path, "brick-tumble", method="rk4", dt=0.0005, every=50, linear=0.05, damped="exp", damps="last")
    best = found.diagnosis.best
    assert {m.hypothesis.part: m.value for m in best.mistakes} == {
        "linear damping": pytest.approx(0.05, rel=1e-9), "steps": pytest.approx(0.0005),
    }  # fmt: skip
    assert best.max_m < 1e-6


def test_no_step_of_an_explanation_makes_the_error_larger(tmp_path):
    """Without its gyroscopic term alone this flight is further off than with all that is wrong with it."""
    how = {"linear": 0.05, "angular": 0.5, "damps": "before it moves", "damped": "exp", "gyroscopic": "still in world"}
    found = graded(tmp_path, "two-hits", dt=1 / 240, every=4, **how)
    steps = found.diagnosis.steps
    assert len(steps) > 2
    assert all(one.max_m > other.max_m for one, other in pairwise(steps))
    told = [re.search(r": (\S+) (\S+) -> (\S+) (\S+)", line) for line in evidence(found.diagnosis)]
    figures = [[float(one[k]) * METRES[one[k + 1]] for k in (1, 3)] for one in told if one]
    assert all(before > after for before, after in figures)
    numbers = [int(line.strip().partition(".")[0]) for line in evidence(found.diagnosis)]
    assert numbers == list(range(1, len(found.diagnosis.best.mistakes) + 1))


@pytest.mark.parametrize("kind", ["linear", "angular"])
def test_a_body_that_nearly_stops_is_named(tmp_path, kind):
    """Its velocity is a hundredth of what it was after half of the run."""
    found = graded(tmp_path, "brick-tumble", dt=1 / 600, every=10, method="rk4", damped="force", **{kind: 5.0})
    assert found.verdict == EXPLAINED_WHOLLY
    assert {m.hypothesis.name: m.value for m in found.diagnosis.best.mistakes} == {
        f"{kind}-damping": pytest.approx(5.0, rel=1e-6)
    }


def test_a_game_loop_is_named_whose_first_rows_are_nearer_to_another_law_of_drag(tmp_path):
    """In the first rows, steps of 4 ms and linear damping look like quadratic drag, and later like another start."""
    path = scene_path("table-4-1")
    program = Program(
        method="symplectic", dt=0.004, every=4, linear=1.0, angular=0.2, damps="before it moves", until=0.5
    )
    file = write(tmp_path / "loop.csv", fly(path, program), read(path).vertices, form="{:.5g}".format)
    values = explained(file, read_scene("table-4-1"), search_s=0.5)
    assert values == {
        "linear-damping": pytest.approx(1.0), "angular-damping": pytest.approx(0.2),
        "symplectic-euler": pytest.approx(0.004),
    }  # fmt: skip


def test_weak_damping_and_short_steps_are_named_together(tmp_path):
    """In the first rows, either explains little of the translation without the other one."""
    path = scene_path("brick-tumble")
    program = Program(
        method="symplectic", dt=0.001, every=8, linear=0.01, angular=0.1, gyroscopic="still in world",
        turn="exponential", until=2.0,
    )  # fmt: skip
    file = write(tmp_path / "loop.csv", fly(path, program), read(path).vertices, form="{:.8g}".format)
    evaluator, _ = evaluator_of(file, read_scene("brick-tumble"))
    search = CausalSearch(evaluator)
    search._look_at(search._horizons()[0])
    best = min(search._expanded(search._fitted(())), key=lambda each: each.score)
    assert {m.hypothesis.name: m.value for m in best.mistakes if m.hypothesis.unit} == {
        "linear-damping": pytest.approx(0.01, rel=0.01), "angular-damping": pytest.approx(0.1, rel=0.01),
        "symplectic-euler": pytest.approx(0.001),
    }  # fmt: skip


def test_linear_laws_are_tried_in_the_place_of_others(tmp_path):
    path = scene_path("brick-tumble")
    file = write(tmp_path / "right.csv", fly(path, Program(until=1.0)), read(path).vertices)
    evaluator, every = evaluator_of(file, read_scene("brick-tumble"))
    proposals, by_name = Proposals(evaluator.context, every), {each.name: each for each in every}
    program = [Mistake(by_name[name], 0.1) for name in ("quadratic-drag", "dry-angular-friction", "clock-rate")]
    [plain] = proposals.with_plain_damping(proposals.ordered(program))
    assert {m.hypothesis.name: m.value for m in plain} == {
        "linear-damping": 0.0, "angular-damping": 0.0, "clock-rate": 0.1,
    }  # fmt: skip
    assert not list(proposals.with_plain_damping(plain))


@pytest.fixture
def damped_search(tmp_path):
    """Return a search of a file of a loop in body axes, damped in proportion after each step."""
    path = scene_path("brick-tumble")
    rows = fly(path, Program(**GAME | {"dt": 1 / 120, "every": 1, "axes": "body", "angular": 0.3}))
    file = write(tmp_path / "game.csv", rows, read(path).vertices, form=lambda number: f"{number:.6f}")
    search = CausalSearch(evaluator_of(file, read_scene("brick-tumble"))[0])
    search._look_at(0.5)
    return search


def with_friction(search, loss=1.4):
    """Return dry friction, in the steps of another scheme."""
    friction = next(h for h in search.proposals.hypotheses if h.name == "dry-angular-friction" and not h.needs_steps)
    step = Mistake(search.proposals.schemes.step(Step("explicit", "exponential")), 1 / 120)
    return search.proposals.ordered((Mistake(friction, loss), step))


def test_another_law_of_damping_is_tried_with_values_of_its_own(damped_search):
    """No value of the friction says at which rate a law in proportion loses as much."""
    found = damped_search._with_other_laws(with_friction(damped_search))
    laws = {hypothesis.name for hypothesis, _ in found}
    rates = [m.value for _, tried in found for one in tried for m in one if m.hypothesis.name == "angular-damping"]
    assert {"angular-damping", "quadratic-angular-drag", "drag-torque", "dry-angular-friction"} <= laws
    assert any(rate == pytest.approx(0.3, rel=0.3) for rate in rates)


def test_a_law_at_a_place_in_a_step_is_tried_only_in_steps(damped_search):
    proposals, (friction, step) = damped_search.proposals, with_friction(damped_search)
    of_a_step = {law.needs_steps for law in proposals.other_laws(friction.hypothesis, (friction, step))}
    assert of_a_step == {True, False}
    assert {law.needs_steps for law in proposals.other_laws(friction.hypothesis, (friction,))} == {False}


def test_law_place_and_scheme_are_changed_at_once(damped_search):
    """Any one of these changes leaves more than twice as much."""
    begun = with_friction(damped_search)
    single = [each for _, several in damped_search._with_other_laws(begun) for each in several]
    single += [*damped_search.proposals.with_same_step(begun), *damped_search.proposals.damped_anywhere(begun)]
    alone = min(damped_search._fitted(each).score for each in single)
    best = min(map(damped_search._fitted, damped_search._damped_otherwise(begun)), key=lambda one: one.score)
    values = {m.hypothesis.name: m.value for m in best.mistakes}
    assert best.score < 0.5 * alone
    assert values["angular-damping"] == pytest.approx(0.3, rel=0.03)


@pytest.mark.parametrize("kept", ["step", "friction"])
def test_without_damping_or_a_step_nothing_is_changed_at_once(damped_search, kept):
    friction, step = with_friction(damped_search)
    assert damped_search._damped_otherwise((step,) if kept == "step" else (friction,)) == []
