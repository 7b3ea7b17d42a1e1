"""What a search tries together: mistakes that hide each other, steps with what writes rows between them, late rows."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from explained import evaluator_of
from explanations import explanation, hypothesis, mistakes_of
from programs import Program, Simulation, read, write

from tools.random_programs.dialect import Dialect
from tools.random_programs.program import Program as Drawn
from tools.random_programs.scene import read as drawn_scene
from tools.random_programs.scheme import Damping, Reading, Scheme
from tumble.compare.grade.hypotheses.explanation import Mistake, step_divides
from tumble.compare.grade.hypotheses.names import CLOCK_OFFSET, LOG_LAG
from tumble.compare.grade.hypotheses.scheme_hypotheses import Step
from tumble.compare.grade.model.kernel.dynamics import AS_FORCE, LAST, LINEARLY
from tumble.compare.grade.search.causal import Candidate, CausalSearch
from tumble.compare.grade.search.changes import Effects
from tumble.compare.grade.search.closing import Closing
from tumble.compare.grade.search.diagnosis import _is_padded
from tumble.compare.grade.search.proposals import first_values
from tumble.compare.grade.search.simulations import SearchStopped
from tumble.scenarios.read import read_scene, scene_path

RATE = 1 / 60


def written(folder, scene, order="wxyz", turned=None, **program):
    """Return the file of a program; turned: places of its start quaternion's numbers in the scene's."""
    throw = read(scene_path(scene))
    if turned:
        throw = replace(throw, q=throw.q[turned])
    rows = Simulation(throw, Program(**program)).rows()
    return Path(write(folder / "program.csv", rows, throw.vertices, form="{:.7f}".format, order=order))


def search_of(file, scene):
    """Return a search of a file that looks at the first part of the run."""
    search = CausalSearch(evaluator_of(file, read_scene(scene))[0])
    search._begin(search._horizons()[0])
    return search


def names_of(programs):
    return [{m.hypothesis.name for m in program} for program in programs]


def drawn_file(folder, scene, **scheme):
    """Return the file of a program that shares no code with Tumble's."""
    throw = drawn_scene(scene_path(scene).read_text(), scene)
    path = folder / "drawn.csv"
    path.write_text(Dialect(digits=7).text(Drawn(Scheme(**scheme)).rows(throw)))
    return path


def test_two_mistakes_that_hide_each_other_are_tried_together(tmp_path):
    """With other moments and no gyroscopic term: each of them alone explains hardly anything."""
    wrong = {"inertia_axes": (2, 0, 1), "gyroscopic": "still in world"}
    [pair] = names_of(search_of(written(tmp_path, "two-hits", until=1.5, **wrong), "two-hits")._pairs(()))
    assert len(pair) == 2
    assert not pair.isdisjoint({"inertia-axes-permuted", "edges-permuted"})
    assert not pair.isdisjoint({"gyroscopic-term-missing", "gyroscopic-torque-multiplied"})


@pytest.mark.parametrize("wrong", [{"gyroscopic": "still in world"}, {"inertia_axes": (2, 0, 1)}])
def test_no_pair_is_tried_where_one_mistake_explains_as_much(tmp_path, wrong):
    search = search_of(written(tmp_path, "two-hits", until=1.5, **wrong), "two-hits")
    assert names_of(search._pairs(())) == []


def test_an_own_order_of_the_quaternion_in_reading_and_writing_is_seen_though_the_first_row_is_right(tmp_path):
    file = written(tmp_path, "two-hits", order="xyzw", turned=[3, 0, 1, 2], until=1.5)
    expected = {"start-attitude-wxyz-read-as-xyzw", "quaternion-xyzw-read-as-wxyz"}
    assert names_of(search_of(file, "two-hits")._own_conventions(())) == [expected]
    assert names_of(search_of(written(tmp_path, "two-hits", until=1.5), "two-hits")._own_conventions(())) == []


def test_single_mistakes_are_sought_where_the_right_program_begins_to_be_wrong(tmp_path):
    """That is where an impulse acts: long after it, errors have grown too large to show their reason."""
    scene, throw = read_scene("two-hits"), read(scene_path("two-hits"))
    hit = replace(scene.impulses[-1], time=0.5)
    late = {**throw.impulses[-1], "time": 0.5}
    rows = Simulation(replace(throw, impulses=[late]), Program(until=2.0, lasts=0.03)).rows()
    file = write(tmp_path / "late.csv", rows, throw.vertices, form="{:.7f}".format)
    evaluator, _ = evaluator_of(file, replace(scene, impulses=(hit,)))
    search = CausalSearch(evaluator)
    search.candidates(np.inf)
    [until] = search._single
    assert hit.time < until < 1.5 * hit.time < 2.0
    assert until not in search._horizons()


def test_rows_that_are_late_by_whole_intervals_are_tried_early_though_long_steps_hide_it(tmp_path, monkeypatch):
    """Steps of 0.8 rad slow the spin, and rows seem later than they are."""
    late = {"dt": RATE, "gyroscopic": "implicit, converged", "reading": Reading(late=1)}
    search = search_of(drawn_file(tmp_path, "spin-fast", spacing=RATE, **late), "spin-fast")
    explored = []

    def seen(begun, then=()):
        explored.append(list(begun))
        raise SearchStopped

    monkeypatch.setattr(search, "_explored", seen)
    search.candidates(np.inf)
    lags = [{m.hypothesis.name: m.value for m in program} for program in explored[0]]
    assert lags[0] != {LOG_LAG: pytest.approx(RATE)}
    assert lags[1] == {LOG_LAG: pytest.approx(RATE)}


@pytest.mark.parametrize(("spacing_s", "is_written"), [(RATE, True), (0.02, False)])
def test_a_step_that_ends_between_rows_is_given_what_writes_rows_there(tmp_path, spacing_s, is_written):
    between = {"spacing": spacing_s, "reading": Reading(between="arcs")}
    file = drawn_file(tmp_path, "two-hits", dt=0.01, gyroscopic="explicit", **between)
    evaluator, _ = evaluator_of(file, read_scene("two-hits"))
    search = CausalSearch(evaluator)
    step = Mistake(search.proposals.schemes.step(Step("explicit", "exponential")), 0.01)
    best = Closing(evaluator, search)._written_between_ticks(evaluator.explain((step,)))
    assert [m.value for m in best.mistakes if m.hypothesis.part == "clock tick"] == [0.01] * is_written
    assert step in best.mistakes


def test_a_step_that_ends_between_rows_is_an_answer_as_it_is_when_time_is_up(tmp_path):
    """The search looks at all of the run again, for what is asked of it later."""
    file = drawn_file(tmp_path, "two-hits", dt=0.01, spacing=RATE, reading=Reading(between="arcs"))
    evaluator, _ = evaluator_of(file, read_scene("two-hits"))
    search = CausalSearch(evaluator)
    best = evaluator.explain((Mistake(search.proposals.schemes.step(Step("explicit", "exponential")), 0.01),))
    closing = Closing(evaluator, search)
    closing.stop_at(0.0)
    assert closing._written_between_ticks(best) is best
    assert closing.is_stopped
    assert search._until == evaluator.context.duration


@pytest.mark.parametrize(
    ("step", "values", "divides"),
    [
        (0.01, {}, False),
        (RATE / 4, {}, True),
        (2 * RATE, {}, False),
        (100 * RATE, {}, False),
        (0.01, {"clock tick": 0.02}, True),
        (0.01, {"clock rate": 1.1}, True),
        (None, {}, True),
    ],
)
def test_a_step_divides_its_tick_or_an_interval_of_rows(step, values, divides):
    values = values | ({} if step is None else {"steps": step})
    mistakes = tuple(Mistake(replace(hypothesis(part), part=part), value) for part, value in values.items())
    assert step_divides(mistakes, RATE) is divides


@pytest.mark.parametrize(("spacing_s", "is_padded"), [(RATE, False), (0.02, True)])
def test_what_writes_rows_between_ticks_is_needed_where_no_step_ends_at_a_row(spacing_s, is_padded):
    step, tick = (Mistake(replace(hypothesis(part), part=part), 0.01) for part in ("steps", "clock tick"))
    without, best = (replace(explanation("a", 1.0, nothing=True), mistakes=each) for each in ((step,), (step, tick)))
    assert _is_padded(best, [without, best], spacing_s) is is_padded


def test_what_moves_the_centre_alone_is_sought_anew_once_the_rotation_is_explained():
    """It explained fewer rows: gravity that is missing there may begin later."""
    search, tried = CausalSearch.__new__(CausalSearch), []
    centre, rotation = mistakes_of("ab")
    acts = {centre: (True, False), rotation: (True, True)}
    search._effects = {m.hypothesis: Effects(np.array(each), np.array((False, False))) for m, each in acts.items()}
    search._fit = SimpleNamespace(is_free=True)
    search._explored = lambda begun, then: tried.append((list(begun), list(then))) or []
    search._moved_otherwise = lambda mistakes: []
    search._named([Candidate((centre, rotation), 1.0, 1.0, True, 1.0, is_enough=True)], [])
    assert tried == [([(centre, rotation)], [(rotation,)])]


def test_what_explains_a_part_of_anything_is_no_longer_there_when_a_detail_changes():
    search = CausalSearch.__new__(CausalSearch)
    nothing = {name: lambda mistakes: [] for name in ("with_details", "with_other_steps", "with_same_step")}
    changed = {
        "with_others": lambda mistakes, run: [("other", mistakes)],
        "damped_anywhere": lambda mistakes: [mistakes],
    }
    search._proposals, search._run = SimpleNamespace(**nothing, **changed), lambda mistakes: None
    vague, (named,) = Mistake(replace(hypothesis("v"), vague=True)), mistakes_of("b")
    assert next(search._one_changed((vague, named))) == [(vague, named), (named,)]
    assert next(search._one_changed((named, named))) == [(named, named)]


def test_a_symplectic_step_that_damps_last_is_tried_for_an_explicit_one_with_damping_as_a_force(tmp_path):
    """They do nearly the same; neither the step nor the damping alone can change, since then v is off by a step."""
    proposals = search_of(written(tmp_path, "two-hits", until=0.5), "two-hits").proposals
    linear, last = (proposals.schemes.damping("linear", place, LINEARLY) for place in (AS_FORCE, LAST))
    explicit, symplectic = (
        Mistake(proposals.schemes.step(Step("explicit", "first order", explicit=each)), 0.005) for each in (True, False)
    )
    wanted = proposals.ordered((Mistake(last, 0.5), symplectic))
    tried = {
        step: [program for _, program in proposals._with_other_places((Mistake(linear, 0.5), step))]
        for step in (explicit, symplectic)
    }
    assert wanted in tried[explicit]
    assert tried[symplectic].count(wanted) == 1


def test_a_step_that_fewer_rows_did_not_distinguish_is_sought_again_in_more_of_them(tmp_path, monkeypatch):
    """Digits hide it at first: five steps a row do what four do."""
    file = written(tmp_path, "two-hits", dt=RATE / 4, every=4, method="symplectic", until=1.5)
    search = search_of(file, "two-hits")
    wrong, right = (
        (Mistake(search.proposals.schemes.step(Step("explicit", "first order")), RATE / parts),) for parts in (5, 4)
    )
    begun_in = {}

    def seen(begun, then=()):
        begun_in[search._until] = [search.proposals.ordered(each) for each in begun]
        if len(begun_in) == 2:
            raise SearchStopped
        return [Candidate(wrong, 1.0, 1.0, True, 1.0, is_enough=True)]

    monkeypatch.setattr(search, "_explored", seen)
    monkeypatch.setattr(search, "_alone", list)
    search.candidates(np.inf)
    first, later = begun_in.values()
    assert right not in first
    assert right in later
    assert len(later) == len(set(later))


def test_a_clock_that_is_behind_is_tried_by_row_intervals(tmp_path):
    """What a small change does shows no late rows: the first ones have not moved, and one ahead has no such rows."""
    search = search_of(written(tmp_path, "two-hits", until=1.5), "two-hits")
    [offset] = [h for h in search.proposals.hypotheses if h.name == CLOCK_OFFSET]
    tried = first_values(offset, search._run(()))
    spacing_s = search._context.spacing_s
    assert {-rows * spacing_s for rows in (0.25, 0.5, 1.0, 2.0, 4.0)} <= set(tried)
    assert len(tried) == len(set(tried)) < len(offset.values)


@pytest.mark.parametrize("name", ["spin-cap", "speed-cap", "spin-cap-of-components", "speed-cap-of-components"])
def test_a_limit_far_below_what_a_right_program_reaches_can_be_fitted(tmp_path, name):
    """An impulse makes a spin of 90 rad/s, of which a program with a limit shows nothing."""
    evaluator, every = evaluator_of(written(tmp_path, "two-hits", until=1.5), read_scene("two-hits"))
    fastest = evaluator.context.speeds[0 if name.startswith("speed") else 1].max()
    for limit in (h for h in every if h.name == name):
        least, most = limit.bounds
        assert least < 0.005 * fastest < fastest <= most * (1 + 1e-12)


@pytest.mark.parametrize(
    ("scheme", "expected"),
    [
        pytest.param({"moves": "parabola", "idle": 1}, {"wrong-position-update", "gravity-delayed"}, id="idle"),
        pytest.param(
            {"moves": "parabola", "damping": Damping(linear=0.2, where="after")},
            {"wrong-position-update", "linear-damping"},
            id="damped",
        ),
        pytest.param({"centre": 4, "idle": 1}, {"gravity-delayed"}, id="substeps"),
        pytest.param({"velocity": "body", "idle": 2}, {"velocity-in-body-axes", "gravity-delayed"}, id="axes"),
    ],
)
def test_how_steps_move_the_centre_is_sought_in_all_its_ways_at_once(tmp_path, scheme, expected):
    """One may hide the other: gravity that begins a step late undoes half of what another velocity does."""
    euler = {"dt": RATE, "spacing": RATE, "gyroscopic": "explicit", "turning": "first order"}
    search = search_of(drawn_file(tmp_path, "brick-tumble", **euler, **scheme), "brick-tumble")
    search._fit.is_free = False
    step = (Mistake(search.proposals.schemes.step(Step("explicit", "first order")), RATE),)
    best, *_ = search._moved_otherwise(step)
    assert {m.hypothesis.name for m in best} == {"symplectic-euler", *expected}
    assert search._fitted(best).is_whole
    assert not search._fitted(step).is_whole
    assert search._moved_otherwise(best) == [], "nothing is left to explain"


def test_how_steps_move_the_centre_is_told_only_where_that_explains_all(tmp_path):
    """Beside another mistake it explains a part of anything: the next change is then sought one by one."""
    throw = drawn_scene(scene_path("brick-tumble").read_text(), "brick-tumble")
    program = Drawn(Scheme(dt=RATE, spacing=RATE, gyroscopic="explicit", turning="first order", moves="parabola"))
    file = tmp_path / "faster.csv"
    file.write_text(Dialect(digits=7).text(program.rows(replace(throw, v=throw.v + np.array((0.1, 0.0, -0.05))))))
    search = search_of(file, "brick-tumble")
    search._fit.is_free = False
    step = (Mistake(search.proposals.schemes.step(Step("explicit", "first order")), RATE),)
    assert search._turns_right([step]) == [True]
    assert search._moved_otherwise(step) == []


def test_an_explicit_step_that_turns_the_body_alike_gives_way_to_a_symplectic_one(tmp_path):
    """With a stored angular momentum nothing else tells them apart: the other velocity for x is then no mistake."""
    euler = {"dt": RATE, "spacing": RATE, "keeps": "momentum"}
    search = search_of(drawn_file(tmp_path, "brick-tumble", **euler), "brick-tumble")
    search._fit.is_free = False
    schemes = search.proposals.schemes
    explicit, symplectic = (schemes.step(Step("momentum", "exponential", explicit=each)) for each in (True, False))
    best, *_ = search._moved_otherwise((Mistake(explicit, RATE),))
    assert {m.hypothesis.name for m in best} == {"symplectic-euler"}
    assert symplectic in {m.hypothesis for m in best}


def test_an_impulse_that_acts_twice_may_do_so_within_a_row_interval(tmp_path):
    """Its second one comes a step later, not a row."""
    evaluator, every = evaluator_of(written(tmp_path, "two-hits", until=1.5), read_scene("two-hits"))
    [again] = [h for h in every if h.name == "impulses-repeated"]
    search = CausalSearch(evaluator)
    search._begin(search._horizons()[0])
    spacing_s = evaluator.context.spacing_s
    assert again.bounds[0] <= 0.02 * spacing_s
    assert any(0.0 < value < 0.05 * spacing_s for value in first_values(again, search._run(())))


def test_methods_that_agree_in_short_steps_are_told_apart_in_long_ones(tmp_path):
    """In steps of more than a radian each of them does something else, also in a third or a fourth of a row."""
    file = drawn_file(tmp_path, "spin-fast", dt=0.005, spacing=0.05, method="order 4")
    search = search_of(file, "spin-fast")
    [world] = [h for h in search.proposals._methods if h.name == "runge-kutta-4" and h.text.endswith("w in world axes")]
    steps = {
        round(0.05 / m.value, 6) for _, program in search._upon_steps(()) for m in program if m.hypothesis is world
    }
    assert {1, 2, 3, 4} <= steps
