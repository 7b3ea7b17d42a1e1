"""Engines with a planted law of contact: each wrong one is named, the right one never."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from tests.support import planted_contact
from tests.support.planted_contact import BALL, ROLL, SLIDE
from tumble.compare.contact.asked import BY_OWN_LAW
from tumble.compare.contact.directions import true_slide
from tumble.compare.contact.findings import contestant_laws, worst_verdict
from tumble.compare.contact.own_law import own_creep
from tumble.compare.contact.rows import contact_rows
from tumble.compare.contact.study import BRIEF, contacts, question
from tumble.compare.engines import tumble
from tumble.compare.engines.parts.soft_law import SPRING, SoftLaw
from tumble.compare.run.local import LocalEngine
from tumble.compare.run.running_engines import launched
from tumble.compare.run.truths import Answered
from tumble.report_tables import LANDING
from tumble.scenarios.read import read_scene, scene_of
from tumble.scenarios.truth import truth


def laws(scene, *methods, module=planted_contact):
    """The verdict and rows of each planted law, or of each method of an engine's module."""
    engine = LocalEngine("planted", SimpleNamespace(**{**vars(module), "METHODS": methods}))
    answered = SimpleNamespace(scene=scene, truth=truth(scene))
    with launched([engine]) as running_engines:
        found = contacts(running_engines, [answered])
    rows = {one.method: list(contact_rows(one)) for one in found}
    return {one.method: (one, rows[one.method]) for each in rows.values() for one in contestant_laws(each)}


FRICTION = {
    "right": "Coulomb and Newton",
    "diamond": "another law: pyramid along x and z, 1.41 times as far",
    "square": "another law: pyramid along x and z (each axis alone), 0.707 times as far",
    "another-friction": "another law: friction of 0.5",
    "creeps": "creeps at 2 mm/s",
}
# Of the others a number follows that the planted law does not say.
RESTITUTION = {
    "right": "Coulomb and Newton",
    "e-squared": "another law: restitution of 0.36",
    "dead": "no restitution",
    "by-the-step": "restitution that depends on the step: e = 0.",
    "early": "contact without touching, from ",
    "tunnels": "tunnels",
    "gains": "gains energy in an impact: ",
}


def test_who_sinks_besides_is_not_right():
    assert worst_verdict(["Coulomb and Newton", "another law", "sinks by 0.06 mm"]) == "another law"
    assert worst_verdict(["sinks by 0.06 mm", "Coulomb and Newton"]) == "sinks by 0.06 mm"
    assert worst_verdict(["another law: friction of 0.5", "another law"]) == "another law: friction of 0.5"


def test_each_law_of_friction_is_named():
    """Semi-implicit Euler is of order 1; a wrong law stays, whatever the step."""
    found = laws(scene_of(SLIDE, Path("slide.toml"), "slide"), *FRICTION)
    assert {method: law.verdict for method, (law, _) in found.items()} == FRICTION
    for method, factor in (("right", 1.0), ("another-friction", 0.8)):
        (stop,) = (row for row in found[method][1] if row.observable == "distance until it stops")
        assert stop.law_error_low <= (factor - 1) * stop.true <= stop.law_error_high
        assert stop.order == pytest.approx(1.0, abs=0.2)
    early = "contact without touching, from 0.1 mm"
    law, rows = found["diamond"]
    (said,) = contestant_laws([*rows, replace(rows[0], observable="height at rest", verdict=early)])
    assert said.verdict == f"{early}; {law.verdict}", "a graver verdict does not hide the pyramid"


def test_a_pyramid_under_a_ball_is_named_by_the_slip_until_it_rolls():
    scene = scene_of(ROLL, Path("roll.toml"), "roll")
    found = laws(scene, "right", "diamond", "square", "another-friction")
    assert {method: law.verdict for method, (law, _) in found.items()} == {
        **{method: FRICTION[method] for method in ("right", "diamond", "square")},
        "another-friction": "another law: friction of 0.375",
    }
    asked = question(scene, truth(scene))
    assert asked is not None
    assert asked.turned is not None
    slips = asked.turned[1].start[:, 7:10] - 0.1 * np.cross(asked.turned[1].start[:, 10:13], (0.0, 1.0, 0.0))
    # The contact point goes u^2 / (7 mu g) in every direction.
    assert np.hypot(slips[:, 0], slips[:, 2]) ** 2 / (7 * 0.3 * 9.81) == pytest.approx(true_slide(scene, asked.whole))


def test_each_law_of_restitution_is_named():
    found = laws(scene_of(BALL, Path("ball.toml"), "ball"), *RESTITUTION)
    said = {method: law.verdict[: len(RESTITUTION[method])] for method, (law, _) in found.items()}
    assert said == RESTITUTION
    assert found["right"][0].verdict == RESTITUTION["right"]
    rows = {row.observable: row for row in found["e-squared"][1] if row.blow == 1}
    rebound = rows["rebound speed after impact"]
    assert rebound.law_error_low <= (0.36 / 0.6 - 1) * rebound.true <= rebound.law_error_high
    assert rebound.error == pytest.approx(rebound.law_error + rebound.step_error)


def test_friction_of_the_whole_impulse_is_another_law_than_friction_at_each_instant():
    """Moreau's time stepping follows the one, events the other: in this scene a corner's slip turns round."""
    scene = read_scene("die-corner-planar")
    with launched(["tumble:events", "tumble:moreau"]) as running_engines:
        found = contacts(running_engines, [SimpleNamespace(scene=scene, truth=truth(scene))])
    said = [law.verdict for one in found for law in contestant_laws(list(contact_rows(one)))]
    assert said == ["Coulomb and Newton", "another law: Coulomb on the whole impulse"]


def test_the_page_of_the_catalogue_has_each_scan_and_each_kind_of_question_once():
    """What it costs is counted in steps: at most 80 000 a contestant, which is 0.4 s at 5 us each."""
    scans, kinds, steps = [], [], 0.0
    for scene in map(read_scene, LANDING):
        asked = question(scene, truth(scene), extent=BRIEF)
        assert asked is not None
        assert not (asked.whole and asked.impacts), f"{scene.name}: a whole run where an impact answers"
        assert len(asked.impacts) <= 1
        scans += {"direction"} if asked.turned else {one.scan for one in asked.scans}
        kinds += [one.observable for one in asked.asked]
        turned = (asked.turned[1],) * len(asked.turned[0]) if asked.turned else ()
        of_impacts = (run.scene for one in asked.impacts for runs in one.runs.values() for run in runs)
        whole = asked.whole.scenes.values() if asked.whole else ()
        for run in (*turned, *whole, *of_impacts, *(one.scene for one in asked.scans)):
            steps += run.duration / run.step
    assert sorted(scans) == ["direction", "drop height", "tilt"]
    assert {"distance until it stops", "creep speed", "rebound speed after impact"} <= set(kinds)
    assert steps < 80_000


def test_the_page_of_the_catalogue_has_one_method_for_each_contact_law_and_those_that_were_named():
    scene = read_scene("ball-drop-dead")
    with launched(["mujoco", "mujoco:rk4", "tumble", "scipy"], few=True) as running_engines:
        took_part = {f"{one.title}:{name}" for one in running_engines for name in BRIEF.methods(one, scene)}
        found = contacts(running_engines, [Answered(scene, truth(scene))], extent=BRIEF)
    laws = {"mujoco:euler", "mujoco:euler+elliptic", "mujoco:euler+noslip", "tumble:moreau"}
    assert took_part == {*laws, "mujoco:rk4", "scipy:dop853"}
    assert {one.name for one in found if one.observations} == {*laws, "mujoco:rk4"}
    assert {one.asked.impact for each in found for one in each.observations} == {1}


@pytest.mark.parametrize(
    ("name", "wrong"),
    [
        ("tip-over", {"angle it has tipped by", "spin at that angle, z"}),
        ("rocking-block", {"angle it has tipped by", "spin after impact, z", "energy lost in impact"}),
        ("top", {"mean precession"}),
        ("disc-rolls", {"mean precession", "greatest tilt of the axis"}),
    ],
)
def test_a_body_that_turns_about_an_edge_its_tip_or_its_rim_has_observables(name, wrong):
    """Each number that follows from the moments is another law where those are wrong, and no other number is."""
    scene = read_scene(name)
    body = replace(scene.body, moments=1.3 * scene.body.moments)
    heavier = SimpleNamespace(**vars(tumble))
    heavier.build = lambda scene, method: tumble.build(replace(scene, body=body), method)
    right, _ = laws(scene, "events", module=tumble)["events"]
    assert right.verdict == "Coulomb and Newton"
    said, rows = laws(scene, "events", module=heavier)["events"]
    assert said.verdict.startswith("gains energy as it rolls" if name == "disc-rolls" else "another law")
    assert {row.observable for row in rows if row.verdict != "Coulomb and Newton"} >= wrong
    stays = {row.observable: row for row in rows if row.observable.startswith("creep speed")}
    assert all(row.verdict == "Coulomb and Newton" for row in stays.values())


def test_an_edge_that_yields_creeps():
    said, rows = laws(read_scene("tip-over"), "compliant", module=tumble)["compliant"]
    assert said.verdict.startswith("creeps at 0.5")
    (row,) = (row for row in rows if row.observable == "creep speed of the edge")
    assert row.law_error_low > 0


def test_a_soft_engine_is_compared_with_the_law_that_it_states():
    """The compliant method follows its spring and damper; the same motion does not follow another damper."""
    scene = scene_of(BALL.replace("duration = 0.9", "duration = 0.4"), Path("ball.toml"), "ball")
    other = SimpleNamespace(**vars(tumble))
    other.soft_law = lambda world: replace(tumble.soft_law(world), damping=2 * tumble.soft_law(world).damping)
    for module, rebound in ((tumble, "its own law (spring and damper): +"), (other, "not its own law (spring")):
        law, rows = laws(scene, "compliant", module=module)["compliant"]
        said = {row.observable: row.verdict for row in rows if row.observable.endswith(BY_OWN_LAW)}
        assert said["rebound speed after impact, by its own law"].startswith(rebound)
        assert "its own law" not in law.verdict, "the rigid law's verdict stands apart"
    assert not any(row.observable.endswith(BY_OWN_LAW) for row in laws(scene, "events", module=tumble)["events"][1])


def test_a_soft_engine_creeps_as_its_own_friction_has_it():
    """Its creep is that of the v_s that it states to 1e-6, and not that of one that is a hundredth more."""
    scene = read_scene("box-incline-holds")
    other = SimpleNamespace(**vars(tumble))
    other.soft_law = lambda world: replace(tumble.soft_law(world), slow=1.01 * tumble.soft_law(world).slow)
    for module, said in ((tumble, "its own law (friction viscous below v_s): +0.0025"), (other, "not its own law")):
        law, rows = laws(scene, "compliant", module=module)["compliant"]
        (row,) = (row for row in rows if row.observable == "creep speed, by its own law")
        assert row.verdict.startswith(said)
        assert law.verdict.startswith("creeps at 2.5")
        if module is tumble:
            assert row.law_error == pytest.approx(0.0, abs=1e-6 * row.true)


def test_there_is_no_creep_on_a_level_plane_nor_where_friction_does_not_hold():
    law = SoftLaw(SPRING, 1e4, 0.0, slow=1e-3)
    assert own_creep(law, read_scene("box-slide-0")) == {}
    assert own_creep(law, read_scene("box-incline-slides")) == {}
    assert own_creep(replace(law, slow=0.0), read_scene("box-incline-holds")) == {}
