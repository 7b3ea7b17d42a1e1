"""Engines with a planted law of contact: each wrong one is named, the right one never."""

from pathlib import Path
from types import SimpleNamespace

import pytest

from tests.support import planted_contact
from tests.support.planted_contact import BALL, SLIDE
from tumble.compare.contact.findings import contestant_laws, worst_verdict
from tumble.compare.contact.rows import contact_rows
from tumble.compare.contact.study import BRIEF, contacts
from tumble.compare.run.local import LocalEngine
from tumble.compare.run.running_engines import launched
from tumble.scenarios.read import read_scene, scene_of
from tumble.scenarios.truth import truth


def laws(scene, *methods):
    """The verdict and rows of each planted law."""
    engine = LocalEngine("planted", SimpleNamespace(**{**vars(planted_contact), "METHODS": methods}))
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
        found = contacts(running_engines, [SimpleNamespace(scene=scene, truth=truth(scene))], ladder=BRIEF)
    said = [law.verdict for one in found for law in contestant_laws(list(contact_rows(one)))]
    assert said == ["Coulomb and Newton", "another law: Coulomb on the whole impulse"]
