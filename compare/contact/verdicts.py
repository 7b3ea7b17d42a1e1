"""The verdict on each observable: which law it follows, in words of `schemas.VERDICT_WORDS`.

An observable is right where the interval of its limit has the true value in it; the width of that comes from the
ladder, from the truth's own bound, and from what one step of the finest level can change.  No engine has a rule of
its own.
"""

import math

from tumble.compare.contact.asked import BY_OWN_LAW, CREEP
from tumble.compare.contact.directions import DIAMOND, DISTANCE, ROLLS, Law, axis_names, is_round, law_of, slid
from tumble.compare.contact.findings import RIGHT
from tumble.compare.contact.impacts import DEEPEST, GAP, REBOUND
from tumble.compare.contact.study import Contact, Observation
from tumble.compare.contact.whole_impulse import after_whole_impulse
from tumble.compare.contact.whole_run import LOST, REST

ITS_LAW, NOT_ITS_LAW = "its own law", "not its own law"
VISCOUS = "friction viscous below v_s"
WHOLE_IMPULSE = "another law: Coulomb on the whole impulse"
OF_A_STOP = ("instant it stops", DISTANCE, "turn of the path until it stops")
OF_ROLLING = ("instant it begins to roll", ROLLS, "turn of the path until it begins to roll")


def verdicts(contact: Contact) -> list[str]:
    """Return the verdict on each of a contestant's observations, in their order."""
    found = [own_verdict(contact, one) for one in contact.observations]
    law = stop_verdict(contact)
    for number, (one, said) in enumerate(zip(contact.observations, found, strict=True)):
        if said in ("another law", "depends on the step") or (
            said == RIGHT and law and one.asked.observable in (DISTANCE, ROLLS)
        ):
            if law and one.asked.observable in OF_A_STOP + OF_ROLLING:
                found[number] = law
            elif follows_from_rebound(contact, one):
                found[number] = of_the_rebound(contact, found, one.asked.impact or 1) or said
            elif said == "another law" and is_of_whole_impulse(contact, one.asked.impact):
                found[number] = WHOLE_IMPULSE
    return found


def is_of_whole_impulse(contact: Contact, number: int | None) -> bool:
    """Whether the limits of velocity and spin after an impact are those of friction of the whole impulse."""
    impact = next((each for each in contact.question.impacts if each.number == number), None)
    plane = contact.scene.plane
    if impact is None or plane is None:
        return False
    v, w = after_whole_impulse(contact.scene.body, plane, impact.event)
    own = {one.asked.observable: one for one in contact.observations if one.asked.impact == number}
    known = [
        (own[f"{name} after impact, {axis}"], value)
        for name, vector in (("velocity", v), ("spin", w))
        for axis, value in zip("xyz", vector, strict=True)
    ]
    return all(
        one.limit.low - one.asked.one_step <= value <= one.limit.high + one.asked.one_step for one, value in known
    )


def follows_from_rebound(contact: Contact, one: Observation) -> bool:
    """Whether a wrong rebound alone makes an observable wrong: without friction every one."""
    plane = contact.scene.plane
    return bool(contact.question.impacts) and plane is not None and plane.friction == 0


def of_the_rebound(contact: Contact, said: list[str], impact: int) -> str:
    """Return what is wrong with the rebound of an impact; or nothing."""
    for one, verdict in zip(contact.observations, said, strict=True):
        if one.asked.key == (REBOUND, impact) and verdict not in (RIGHT, "another law"):
            return verdict
    return ""


def own_verdict(contact: Contact, one: Observation) -> str:
    """Return the verdict on one observation by its own ladder."""
    name, limit, seen = one.asked.observable, one.limit, contact.readings
    if name.endswith(BY_OWN_LAW):
        return own_law_verdict(contact, one)
    if one.asked.impact in seen.through:
        return "tunnels"
    if math.isnan(limit.value):
        if one.asked.impact in seen.unfinished:
            return "soft: the impact is not over when the next is due"
        rests = name in (*OF_A_STOP, REST, "height at rest") or "begins to roll" in name
        return "does not come to rest" if rests else "depends on the step"
    if name == REBOUND:
        return rebound_verdict(contact, one)
    if one.is_right:
        return RIGHT
    if name.startswith("energy lost") and limit.high < min(0.0, one.asked.true):
        return f"gains energy {'as it rolls' if name == LOST else 'in an impact'}: {-limit.value:.3g} J"
    error = limit.value - one.asked.true
    if name == DEEPEST or (name == "height at rest" and error < 0):
        return f"sinks by {abs(error) * 1e3:.3g} mm"
    if one.scatters:
        return "depends on the step"
    if name.startswith(CREEP):
        return f"creeps at {limit.value * 1e3:.3g} mm/s"
    if name in (GAP, "height at rest"):
        return f"contact without touching, from {error * 1e3:.3g} mm"
    return "another law"


def own_law_verdict(contact: Contact, one: Observation) -> str:
    """Return whether a soft engine follows the law that it states, and how far that law is from the rigid one."""
    law = VISCOUS if one.asked.observable.startswith(CREEP) else contact.readings.own_law
    if not one.is_right:
        return "depends on the step" if one.scatters else f"{NOT_ITS_LAW} ({law})"
    key = one.asked.observable.removesuffix(BY_OWN_LAW), one.asked.impact
    rigid = next(each.asked.true for each in contact.observations if each.asked.key == key)
    return f"{ITS_LAW} ({law}): {one.asked.true - rigid:+.3g} {one.asked.unit} from the rigid one"


def rebound_verdict(contact: Contact, one: Observation) -> str:
    """Return the verdict on the speed with which a point leaves the plane, as a coefficient of restitution."""
    impact = next(each for each in contact.question.impacts if each.number == one.asked.impact)
    plane, limit = contact.scene.plane, one.limit
    assert plane is not None
    approach = -float(impact.event.velocity_before @ plane.normal)
    if one.is_right:
        return RIGHT
    stays = one.asked.impact in contact.readings.stays or max(-limit.low, limit.high) <= one.asked.one_step
    if impact.flies and stays:
        return "no restitution"
    if one.scatters:
        low, high = limit.low / approach, limit.high / approach
        return f"restitution that depends on the step: e = {low:.2g} to {high:.2g}"
    return f"another law: restitution of {limit.value / approach:.3g}"


def stop_verdict(contact: Contact) -> str:
    """Return which law of friction stops a body, by its distances in all directions; empty where that is Coulomb's."""
    rose, plane = contact.rose, contact.scene.plane
    if rose is None or plane is None:
        return ""
    law = law_of(rose)
    if law is not None:
        return f"another law: pyramid {along(contact, law)}, {law.factor:.3g} times as far"
    own = next(one for one in contact.observations if one.asked.observable == slid(contact.scene))
    if is_round(rose) and not own.is_right:
        return f"another law: friction of {plane.friction * own.asked.true / own.limit.value:.3g}"
    return "" if is_round(rose) else "another law"


def along(contact: Contact, law: Law) -> str:
    """Return the axes of a pyramid in words: those along which friction is greatest, or, of a square, its edges."""
    plane = contact.scene.plane
    assert plane is not None
    first, second = axis_names(plane.normal)
    turned = f" turned by {math.degrees(law.axes):.3g} degrees" if law.axes else ""
    kind = "" if law.kind == DIAMOND else " (each axis alone)"
    return f"along {first} and {second}{turned}{kind}"
