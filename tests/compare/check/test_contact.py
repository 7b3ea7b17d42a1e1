"""A record of a scene with a plane has the observables of contact, and finds a law that changed by a few per cent."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest

from tests.support import planted_contact
from tests.support.planted_contact import BALL, SLIDE
from tumble.compare.check.changes import compare_records
from tumble.compare.check.record import read_record
from tumble.compare.check.study import Measuring, accept_record, measure_record
from tumble.compare.check.tolerances import Tolerances
from tumble.compare.check.words import sentence
from tumble.compare.run.local import LocalEngine
from tumble.scenarios.read import scene_of

SCENES = [scene_of(text, Path(f"{name}.toml"), name) for name, text in (("ball", BALL), ("slide", SLIDE))]


def measured(monkeypatch, e=1.0, mu=1.0):
    """Return the record of an engine that follows the law, but for factors of restitution and friction."""
    with monkeypatch.context() as patch:
        restitution, slowed = planted_contact.restitution, planted_contact.slowed
        patch.setattr(planted_contact, "restitution", lambda *given: e * restitution(*given))
        patch.setattr(planted_contact, "slowed", lambda world, v, weight: slowed(world, v, mu * weight))
        mine = LocalEngine("mine", SimpleNamespace(**{**vars(planted_contact), "METHODS": ["right"]}))
        return measure_record(Measuring(scenes=SCENES, contestants=[mine], timed=False))


def said(old, new):
    """Return what the comparison says of contact, by verdict and scene."""
    changes = compare_records(old, new, Tolerances()).changes
    contact = {"contact", "law_error", "contact_error"}
    return {(change.verdict, change.scene, sentence(change)) for change in changes if change.column in contact}


@pytest.fixture(scope="module")
def right():
    with pytest.MonkeyPatch.context() as patch:
        return measured(patch)


def test_a_record_of_contact_comes_back_and_the_same_is_no_change(right, tmp_path):
    assert accept_record(tmp_path, right) == {}
    again = read_record(tmp_path)
    assert len(again.contact) == len(right.contact) > 20
    assert compare_records(again, right, Tolerances()).changes == ()
    accept_record(tmp_path, replace(right, contact=None))
    assert read_record(tmp_path).contact is None, "a record without a plane leaves no table of an older one"


def test_restitution_of_3_per_cent_less_and_friction_of_10_more_are_worse_and_back_is_better(right, monkeypatch):
    """Within what two steps of 4 ms make, the verdict on the rebound stays; its law error does not."""
    wrong = measured(monkeypatch, e=0.97, mu=1.1)
    found = said(right, wrong)
    assert {verdict for verdict, _, _ in found} == {"worse"}
    words = {scene: " | ".join(text for _, where, text in found if where == scene) for scene in ("ball", "slide")}
    assert words["ball"].startswith("law error, velocity after impact, y ")
    assert "law of contact: Coulomb and Newton -> another law: friction of 0.44" in words["slide"]
    assert "law error, " in words["slide"]
    assert {verdict for verdict, _, _ in said(wrong, right)} == {"better"}
