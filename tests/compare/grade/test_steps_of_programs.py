"""Programs in steps: a slow clock has steps of its own time, rows may be a step late, and a step may be very long."""

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from explained import evaluator_of, explained
from pose_files import SKEWED, write_poses
from programs import Program, fly, read, write

from tumble.compare.grade.grade import grade
from tumble.compare.grade.hypotheses.explanation import Mistake
from tumble.compare.grade.hypotheses.names import SPIN_RECOVERED
from tumble.compare.grade.hypotheses.scheme_hypotheses import Step
from tumble.compare.grade.model.kernel.dynamics import (
    AXIS_BY_AXIS,
    BEFORE_FORCES,
    CONVERGED,
    EXPONENTIAL,
    IMPLICIT,
    Scheme,
)
from tumble.compare.grade.model.program_model import FINE, correct_program
from tumble.compare.grade.search.causal import CausalSearch
from tumble.compare.grade.search.closing import Closing
from tumble.compare.grade.search.proposals import STEPS, Proposals
from tumble.compare.grade.verdicts import EXPLAINED_WHOLLY
from tumble.scenarios.read import read_scene, scene_of, scene_path

# Struck far from the origin: with levers from there it turns by radians in a row interval.
STRUCK = """
title = "Heavy body that is struck far from the origin"
duration = 1.0
samples = 20
step = 0.001
gravity = [0.0, 0.0, -9.8]
[body]
shape = "rigid"
mass = 12.0
inertia = [[0.069, -0.008, -0.011], [-0.008, 0.058, -0.0076], [-0.011, -0.0076, 0.024]]
points = [[-0.04, 0.09, 0.02], [0.07, 0.03, -0.02], [0.02, -0.04, -0.02], [0.07, 0.03, 0.01], [0.02, -0.08, 0.01]]
position = [-0.6, -0.1, 0.9]
orientation = [0.57, -0.72, -0.25, 0.29]
velocity = [4.0, 0.1, -4.6]
[[impulse]]
time = 0.0
value = [1.2, 6.2, 4.2]
vertex = 4
"""
LOOP = {"method": "symplectic", "axes": "world", "turn": "quaternion", "until": 1.5}


def named(folder, scene, rewritten=lambda rows: rows, **program):
    """Return the mistakes of a file of nine decimals by name: their values."""
    path = scene_path(scene)
    rows = rewritten(list(fly(path, Program(**LOOP | program))))
    file = write(folder / "loop.csv", rows, read(path).vertices, form=lambda number: f"{number:.9f}")
    return explained(file, read_scene(scene))


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


def test_a_method_of_high_order_is_named_where_the_motion_amplifies_its_errors(tmp_path):
    """In long steps the handle flips at other times: their errors do not show which step leaves those of the file."""
    path = scene_path("dzhanibekov")
    rows = fly(path, Program(dt=0.002, every=10, until=8.0))
    file = write(tmp_path / "flips.csv", rows, read(path).vertices, form="{:.9f}".format)
    assert explained(file, read_scene("dzhanibekov")) == {"runge-kutta-4": pytest.approx(0.002)}


def test_a_quaternion_that_is_never_normalised_shows_in_the_vertices_of_one_face(tmp_path):
    """They are a plane: a rotation alone would take their scale for an error of something else."""
    path = scene_path("two-hits")
    program = Program(dt=0.00125, every=4, until=2.0, method="symplectic", axes="body", normalised=False)
    rows = fly(path, program)
    file = write(tmp_path / "face.csv", rows, read(path).vertices, kind=(0, 1, 2, 3), form="{:.4f}".format)
    found = grade(Path(file), read_scene("two-hits"), {})
    assert found.verdict == EXPLAINED_WHOLLY
    [step] = found.diagnosis.best.mistakes
    assert step.value == pytest.approx(0.00125)
    assert dict(step.hypothesis.details)["normalised"] == "never"


def test_a_scheme_is_looked_for_again_once_its_damping_is_fitted(tmp_path):
    """The damping leaves far more than any scheme, and not in proportion to its rate."""
    scene, times = read_scene("nesc-brick"), np.linspace(0.0, 5.0, 601)
    scheme = Scheme(1 / 240, AXIS_BY_AXIS, CONVERGED, True, 1.0)
    program = correct_program(scene, 0).but(
        scheme=scheme, damping=(0.0, 0.0, 1.0, 0.0, 0.0), damping_place=BEFORE_FORCES
    )
    pose = program.output(times, FINE)
    found = grade(write_poses(tmp_path / "damped.csv", times, pose.x, pose.q, form="%.7g"), scene, {})
    assert found.verdict == EXPLAINED_WHOLLY
    values = {m.hypothesis.name: m.value for m in found.diagnosis.best.mistakes}
    assert values == {"angular-damping": pytest.approx(1.0), "symplectic-euler": pytest.approx(1 / 240)}


def test_a_mistake_that_spins_a_body_up_is_named_although_its_steps_hide_it(tmp_path):
    """The rotation is wrong with any single change; and with this one, in steps that a slow body may well take."""
    scene, times = scene_of(STRUCK, Path("struck.toml"), "struck"), np.arange(73) / 72
    right = correct_program(scene, 0).output(times, FINE)
    _, every = evaluator_of(write_poses(tmp_path / "right.csv", times, right.x, right.q), scene)
    lever = next(each for each in every if each.name == "impulse-lever-from-origin")
    program = lever.change(correct_program(scene, 0), 0.0).but(scheme=Scheme(1 / 72, EXPONENTIAL, IMPLICIT, True, 1.0))
    pose = program.output(times, FINE)
    file = write_poses(tmp_path / "origin.csv", times, pose.x, pose.q, form="%.7g")
    assert explained(file, scene) == {"impulse-lever-from-origin": 0.0, "symplectic-euler": pytest.approx(1 / 72)}
    slow, fast = (CausalSearch(evaluator_of(each, scene)[0])._spun_up() for each in (tmp_path / "right.csv", file))
    assert slow == []
    assert "impulse-lever-from-origin" in {m.hypothesis.name for [m] in fast}


@pytest.mark.parametrize(("scene", "are_tried"), [("spin-fast", True), ("brick-tumble", False)])
def test_every_scheme_is_tried_in_steps_in_which_the_body_turns_far(tmp_path, scene, are_tried):
    """One that seems to make the error larger in short steps, or to do what another one does, may be right in those."""
    path, spacing_s = scene_path(scene), 0.024
    rows = fly(path, Program(dt=spacing_s / 10, every=10, until=0.3))
    file = write(tmp_path / "right.csv", rows, read(path).vertices)
    search = CausalSearch(evaluator_of(file, read_scene(scene))[0])
    kinds, programs = list(search.proposals.with_other_schemes(())), search._upon_steps(())
    kinds = [kind for kind in kinds if not search.proposals.recovers(kind.others)]
    for step_s in (spacing_s, spacing_s / 2):
        lengths = [(kind, next(m.value for m in made if m.hypothesis.part == STEPS)) for kind, made in programs]
        tried = {kind.key for kind, length in lengths if length == pytest.approx(step_s)}
        assert ({kind.key for kind in kinds} <= tried) == are_tried


def test_w_in_world_axes_that_turns_the_body_as_if_in_body_axes_is_named_upon_a_scheme(tmp_path):
    values = named(tmp_path, "two-hits", dt=1 / 240, every=4, wrong_side=True)
    assert values.keys() == {"angular-velocity-in-wrong-frame", "symplectic-euler"}
    assert values["symplectic-euler"] == pytest.approx(1 / 240)


@pytest.mark.parametrize("axes", ["world", "momentum"])
@pytest.mark.parametrize("stages", ["raw", "raw with R I^-1 R^T"])
def test_the_matrix_of_a_stage_is_of_the_files_axes(tmp_path, stages, axes):
    """Of a quaternion that is not normalised, it is not that of the principal axes times a rotation."""
    (tmp_path / "skewed.toml").write_text(SKEWED)
    values = named(
        tmp_path, str(tmp_path / "skewed.toml"), method="rk4", stages=stages, axes=axes, dt=0.1, every=1, until=1.0
    )
    assert values == {"runge-kutta-4": pytest.approx(0.1)}


def test_rows_too_dense_for_any_step_are_diagnosed(tmp_path):
    """Of 12,001 rows, one of which is a tenth of a step of a program that is simulated: its spin is reversed."""
    scene = read_scene("brick-tumble")
    program = correct_program(scene, 0)
    start = program.start.copy()
    start[10:13] *= -1
    pose = program.but(start=start).output(np.linspace(0.0, 3.0, 12_001), FINE)
    found = grade(write_poses(tmp_path / "dense.csv", pose.times, pose.x, pose.q, form="%.8g"), scene, {}, search_s=0.1)
    assert found.verdict == EXPLAINED_WHOLLY
    assert "start-spin-reversed" in found.diagnosis.best.names


@pytest.fixture
def proposals(tmp_path, request):
    """What is tried for rows of a program without a mistake, of the scene that a test asks for."""
    return proposals_for(tmp_path, read_scene(request.param))


def proposals_for(folder, scene):
    """Return what is tried for rows of a program without a mistake, 100 in a second."""
    pose = correct_program(scene, 0).output(np.arange(101) * 0.01, FINE)
    file = write_poses(folder / "right.csv", pose.times, pose.x, pose.q)
    evaluator, every = evaluator_of(file, scene)
    return Proposals(evaluator.context, every)


def symplectic(proposals, step_s, steps_a_tick=1):
    """Return the mistake of steps of symplectic Euler [s]."""
    return Mistake(proposals.schemes.step(Step("explicit", "exponential", steps_a_tick=steps_a_tick)), step_s)


@pytest.mark.parametrize("proposals", ["dzhanibekov"], indirect=True)
@pytest.mark.parametrize("rotation", ["half angle", "exponential"])
def test_longer_steps_are_tried_in_which_the_centre_moves_as_before(proposals, rotation):
    """With any rotation, which the short steps may not have shown."""
    short = Mistake(proposals.schemes.step(Step("implicit", "half angle")), 0.0025)
    longer = Mistake(proposals.schemes.step(Step("implicit", rotation, substeps=4)), 0.01)
    steps = [mistake for _, [mistake] in proposals._with_other_details((short,))]
    assert any(each.hypothesis is longer.hypothesis and each.value == pytest.approx(0.01) for each in steps)
    assert all(each.value < 0.011 for each in steps), "none is longer than a row interval"


@pytest.mark.parametrize("proposals", ["dzhanibekov"], indirect=True)
def test_a_quaternion_that_is_normalised_rarely_is_tried_with_its_update(proposals):
    """Only of one that is updated to first order does that show, so both are tried together, once."""
    step = Mistake(proposals.schemes.step(Step("explicit", "exponential", explicit=True)), 0.01)
    every_ten = "quaternion normalised only every 10 steps"
    [rarely] = [program for program in proposals.with_details((step,)) if every_ten in (m.text for m in program)]
    [euler] = [m.text for m in rarely if m.text != every_ten]
    assert euler.startswith("explicit Euler with a step of 0.01 s")
    assert "quaternion updated to first order" in euler
    assert all("only every" not in m.text for program in proposals.with_details(rarely) for m in {*program} - {*rarely})


@pytest.mark.parametrize("proposals", ["dzhanibekov"], indirect=True)
@pytest.mark.parametrize("details", [{"substeps": 4}, {"steps_a_tick": 2}], ids=["substeps", "ticks"])
@pytest.mark.parametrize("other", [{"rotation": "second order"}, {"gyroscopic": "implicit"}], ids=["rotation", "term"])
def test_details_of_a_step_are_kept_with_another_rotation_or_gyroscopic_term(proposals, details, other):
    """A kind of scheme has none."""
    own = Step("explicit", "exponential", **details)
    wanted = proposals.schemes.step(replace(own, **other))
    step = Mistake(proposals.schemes.step(own), 0.01)
    assert (Mistake(wanted, 0.01),) in [program for _, program in proposals._with_other_details((step,))]
    assert (Mistake(wanted, 0.01),) in list(proposals.with_same_step((step,)))


@pytest.mark.parametrize("proposals", ["dzhanibekov"], indirect=True)
def test_a_step_without_a_gyroscopic_term_has_no_other_one(proposals):
    step = symplectic(proposals, 0.01)
    with_term = {m.text for _, program in proposals._with_other_details((step,)) for m in program}
    without = proposals.ordered((step, proposals.schemes.gyroscopic_term_missing()))
    found = {m.text for _, program in proposals._with_other_details(without) for m in program}
    assert any("implicit gyroscopic term" in text for text in with_term)
    assert not any("implicit gyroscopic term" in text for text in found)


@pytest.mark.parametrize("proposals", ["dzhanibekov"], indirect=True)
def test_the_centre_of_an_explicit_step_may_move_as_in_a_symplectic_one(proposals):
    """Where the rotation has no gyroscopic term, it is the same in both."""
    own = Step("none", "first order", explicit=True, other_axes=True)
    wanted = proposals.schemes.step(Step("none", "first order", substeps=4))
    step = Mistake(proposals.schemes.step(own), 0.01)
    assert (Mistake(wanted, 0.01),) in [program for _, program in proposals._with_other_details((step,))]


def falling(folder):
    """Return the scene of a body that falls and does not rotate."""
    text = SKEWED.replace("[body]", "gravity = [0.0, -9.81, 0.0]\n[body]").replace("[1.0, 2.0, -0.5]", "[0, 0, 0]")
    (folder / "falling.toml").write_text(text)
    return read_scene(str(folder / "falling.toml"))


def fallen(folder, scene, dt, slowed):
    """Return the file of a program whose steps are exact but for what it does to the velocity at the end of each."""
    x, v, gravity = scene.start[0, 0:3], scene.start[0, 7:10], np.array(scene.gravity)
    places = []
    for _ in range(round(1 / dt) + 1):
        places.append(x)
        x, v = x + dt * v + 0.5 * dt * dt * gravity, slowed(v + dt * gravity)
    rows = np.array(places[::10])
    q = np.tile(correct_program(scene, 0).output(np.zeros(1)).q, (len(rows), 1))
    return write_poses(folder / "fallen.csv", np.arange(len(rows)) * 10 * dt, rows, q)


def test_friction_that_acts_at_the_end_of_each_step_is_named_with_the_step(tmp_path):
    """In a step of any exact method, which only the friction shows."""
    scene, dt, friction = falling(tmp_path), 0.002, 0.3
    file = fallen(tmp_path, scene, dt, lambda v: v * (1 - friction * dt / np.linalg.norm(v)))
    assert explained(file, scene) == {"dry-friction": pytest.approx(friction), "runge-kutta-4": pytest.approx(dt)}


@pytest.mark.parametrize("proposals", ["dzhanibekov"], indirect=True)
def test_rows_may_be_late_by_several_steps(proposals):
    """A program of several steps a tick logs the tick before."""
    programs = proposals.with_details((symplectic(proposals, 0.005),))
    late = [m.value for program in programs for m in program if m.hypothesis.name == "log-lag"]
    assert set(late) == {0.005, 0.01, 0.02, 0.04}


@pytest.mark.parametrize("proposals", ["two-hits"], indirect=True)
@pytest.mark.parametrize(
    ("step_s", "others"),
    [(0.01, {(0.01, 2), (0.01, 4), (0.01, 8)}), (0.02, {(0.02, 4), (0.02, 8), (0.01, 2), (0.005, 4), (0.0025, 8)})],
)
def test_steps_of_other_ticks_are_tried_if_an_impulse_acts_at_another_instant_then(proposals, step_s, others):
    """The second impulse is at 0.75 s: a step of 10 ms is there, one of 20 ms or two of 10 ms 10 ms later."""
    tried = proposals.with_other_ticks((symplectic(proposals, step_s),))
    made = {symplectic(proposals, *each).text: each for each in others}
    assert {made[step.text] for [step] in tried} == others


@pytest.mark.parametrize(
    ("hit_s", "until", "first"), [(0.75, 1.0, 0.01), (0.755, 1.0, 0.005), (0.755, 0.5, 0.01), (0.75123, 1.0, 0.01)]
)
def test_the_length_of_a_step_is_estimated_with_one_that_has_the_events_at_its_ticks(tmp_path, hit_s, until, first):
    """An impulse at 0.755 s would be 5 ms late with steps of 10 ms; at 0.75123 s it is late with any."""
    scene = read_scene("two-hits")
    hits = tuple(replace(hit, time=hit_s if hit.time == 0.75 else hit.time) for hit in scene.impulses)
    assert hit_s in [hit.time for hit in hits]
    proposals = proposals_for(tmp_path, replace(scene, impulses=hits))
    assert proposals.first_step((), until, 1.0) == pytest.approx(first)


@pytest.mark.parametrize("proposals", ["two-hits"], indirect=True)
@pytest.mark.parametrize(("until", "steps"), [(1.0, [1 / 30, 0.02]), (0.5, [])])
def test_usual_steps_are_tried_with_which_an_impulse_acts_at_another_instant(proposals, until, steps):
    """No estimate leads from a step of 10 ms to those; before the impulse they need not be tried."""
    assert proposals.event_steps((), 0.01, until) == pytest.approx(steps)


def test_classical_steps_are_tried_that_delay_an_impulse(tmp_path):
    """No other effect of them is seen; the second impulse is at 0.75 s, 10 ms before a tick of 20 ms."""
    path = scene_path("two-hits")
    file = write(tmp_path / "right.csv", fly(path, Program(every=5, until=1.0)), read(path).vertices)
    search = CausalSearch(evaluator_of(file, read_scene("two-hits"))[0])
    classical = [
        program for kind, program in search._upon_steps(()) if kind.hypothesis in search.proposals.classical(())
    ]
    assert 0.02 in [m.value for program in classical for m in program if m.hypothesis.part == STEPS]


def test_a_limit_is_refined_with_the_step_by_which_it_is_exceeded(tmp_path):
    """A fall at a limit is faster by what gravity adds in a step: a larger one in shorter steps is nearly the same."""
    scene, dt, cap = falling(tmp_path), 0.004, 3.1
    file = fallen(tmp_path, scene, dt, lambda v: v * min(1.0, cap / np.linalg.norm(v)))
    evaluator, every = evaluator_of(file, scene)
    limit, method = (next(h for h in every if h.name == name) for name in ("speed-cap", "runge-kutta-4"))
    nearly = evaluator.explain((Mistake(limit, 3.1005), Mistake(method, 0.001)))
    refined = Closing(evaluator, CausalSearch(evaluator)).refined(nearly)
    assert not nearly.is_whole
    assert refined.is_whole
    assert [mistake.value for mistake in refined.mistakes] == pytest.approx([cap, dt])


def test_a_limit_is_refined_in_classical_steps(tmp_path):
    """Symplectic steps and a limit elsewhere leave nearly as little, and no fit leads from these to others."""
    scene, dt, cap = falling(tmp_path), 0.004, 3.1
    file = fallen(tmp_path, scene, dt, lambda v: v * min(1.0, cap / np.linalg.norm(v)))
    evaluator, every = evaluator_of(file, scene)
    limit = next(h for h in every if h.name == "speed-cap" and h.needs_steps)
    search = CausalSearch(evaluator)
    step = search.proposals.schemes.step(Step("explicit", "exponential"))
    nearly = evaluator.explain(search.proposals.ordered((Mistake(limit, 3.1005), Mistake(step, 0.001))))
    refined = Closing(evaluator, search).refined(nearly)
    assert not nearly.is_whole
    assert refined.is_whole
    values = {mistake.hypothesis.name: mistake.value for mistake in refined.mistakes}
    assert values == pytest.approx({"speed-cap": cap, "runge-kutta-4": dt})


@pytest.mark.parametrize(("name", "is_placed"), [("speed-cap", False), ("dry-friction", True)])
def test_what_shows_a_step_is_tried_in_classical_steps_of_every_length(tmp_path, name, is_placed):
    """Nothing else shows those of this method: a limit acts by leaps, and forces may hide what friction does there."""
    scene = falling(tmp_path)
    evaluator, every = evaluator_of(fallen(tmp_path, scene, 0.004, lambda v: v), scene)
    mistake = Mistake(next(h for h in every if h.name == name and not h.needs_steps), 3.1)
    search = CausalSearch(evaluator)
    [method] = search.proposals.classical(())
    tried = [one for kind, one in search._upon_steps((mistake,)) if kind.hypothesis is method]
    placed = [one for one in tried if any(m.hypothesis.needs_steps for m in one)]
    lengths = {m.value for one in (placed if is_placed else tried) for m in one if m.hypothesis is method}
    assert lengths >= set(evaluator.context.parts)
    assert any(length == pytest.approx(0.004) for length in lengths)


@pytest.mark.parametrize("proposals", ["dzhanibekov"], indirect=True)
@pytest.mark.parametrize(
    ("name", "stored"),
    [("quaternion-rate-halved", {"", ", w in world axes", ", angular momentum stored"}), ("spherical-inertia", {""})],
)
def test_a_wrong_rotation_is_tried_in_classical_steps_of_each_kind_of_spin(proposals, name, stored):
    """What turns the body wrongly does something else to w in body axes, to w in world axes and to L."""
    wrong = next(h for h in proposals.hypotheses if h.name == name)
    texts = [method.text for method in proposals.classical((Mistake(wrong, 0.5),))]
    assert {text.removeprefix("Runge-Kutta of order 4 with a step of {} s") for text in texts} == stored
    assert len(texts) == len(stored)


def test_schemes_that_differ_little_beside_what_is_left_are_one(tmp_path):
    rows = list(fly(scene_path("brick-tumble"), Program(**LOOP, dt=0.01, every=1)))
    file = write(tmp_path / "loop.csv", rows, None, form="{:.6f}".format)
    evaluator, _ = evaluator_of(file, read_scene("brick-tumble"))
    search = CausalSearch(evaluator)
    search._look_at(search._horizons()[0])
    programs = [search._upon(kind, 0.01) for kind in search.proposals.with_other_schemes(())]
    found = search._simulations.errors(programs)
    nothing, much = np.zeros_like(found[:1]), np.full_like(found[:1], 1e9)
    known, (only,) = search._distinct(programs, found, nothing), search._distinct(programs, found, much)
    assert evaluator.cost(programs[only]) == min(map(evaluator.cost, programs)), "the most likely one is tried"
    assert len(programs) / 2 < len(known) < len(programs), "some have the same effect, others differ"


def test_other_methods_of_the_same_step_are_tried(tmp_path):
    """In short steps two methods of order 4 do nearly the same, so only one of them is tried there."""
    rows = list(fly(scene_path("brick-tumble"), Program(**LOOP, dt=0.01, every=1)))
    file = write(tmp_path / "loop.csv", rows, None, form="{:.6f}".format)
    search = CausalSearch(evaluator_of(file, read_scene("brick-tumble"))[0])
    proposals = search.proposals
    others = dict(proposals.with_others((Mistake(proposals.classical(())[0], 0.01),), search._run(())))
    found = {m.hypothesis.name: m.value for each in others.values() for m in each if m.hypothesis.part == STEPS}
    assert found["runge-kutta-4-three-eighths"] == found["heun"] == 0.01


def test_a_spin_taken_from_attitudes_is_tried_with_each_plain_scheme(tmp_path):
    rows = list(fly(scene_path("brick-tumble"), Program(**LOOP, dt=0.01, every=1)))
    file = write(tmp_path / "loop.csv", rows, None, form="{:.6f}".format)
    evaluator, every = evaluator_of(file, read_scene("brick-tumble"))
    recovered = Mistake(next(h for h in every if h.name == SPIN_RECOVERED))
    schemes = CausalSearch(evaluator).proposals.with_other_schemes
    counts = [sum(recovered in kind.others for kind in schemes(mistakes)) for mistakes in ((), (recovered,))]
    kinds = [kind.key for kind in schemes(())]
    assert 4 < counts[0] < counts[1]
    assert len(kinds) == len(set(kinds)), "none is tried twice"
    assert all(kind.others.count(recovered) <= 1 for kind in schemes((recovered,)))


def test_schemes_leave_a_rotation_right_that_is_right(tmp_path):
    """Only the centre is wrong: it is moved by the old velocity."""
    explicit = Program(dt=0.01, every=2, method="explicit", axes="body", turn="exponential", until=1.5)
    rows = list(fly(scene_path("two-hits"), explicit))
    file = write(tmp_path / "explicit.csv", rows, None, form="{:.7f}".format)
    search = CausalSearch(evaluator_of(file, read_scene("two-hits"))[0])
    step = search.proposals.schemes.step(Step("explicit", "exponential", explicit=True))
    other = (Mistake(search.proposals.classical(())[0], 0.01),)
    assert search._turns_right([(Mistake(step, 0.01),), other]) == [True, False]
    found = search._schemes((Mistake(step, 0.01),))
    assert found
    assert all(search._turns_right(found))
    assert not all(search._turns_right(search._schemes(other)))
