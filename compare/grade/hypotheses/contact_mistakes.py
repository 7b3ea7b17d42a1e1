"""Mistakes of contact, as data: how each changes the law of one body on one plane."""

import itertools
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from tumble.compare.grade.model.contact_law import AFTER, WHOLE, ContactLaw
from tumble.compare.grade.model.kernel.sliding import DIAMOND, SQUARE
from tumble.scenarios.frames import Array

# Tilts of a wrong normal that are tried first.
TILTS = (-0.3, -0.2, -0.1, 0.0, 0.1, 0.2, 0.3)
Change = Callable[[ContactLaw, tuple[float, ...]], ContactLaw]


@dataclass(frozen=True, eq=False)
class ContactHypothesis:
    """A mistake of a contact law.

    name: for tables; part: of the law, which has at most one mistake a part; text: for people, with places for the
    values; change: makes the mistake; values: tried first, () if there are none; parameters: name and unit of each;
    is_signed: whether a value may be negative.
    """

    name: str
    part: str
    text: str
    change: Change
    values: tuple[tuple[float, ...], ...] = ()
    parameters: tuple[tuple[str, str], ...] = ()
    is_signed: bool = False

    def text_with(self, values: tuple[float, ...]) -> str:
        """Return the text with values."""
        return self.text.format(*(f"{value:.3g}" for value in values))


def _fields(**fields: object) -> Change:
    return lambda law, values: replace(law, **fields)


def _set(field: str) -> Change:
    return lambda law, values: replace(law, **{field: values[0]})


def _tilted(law: ContactLaw, values: tuple[float, ...]) -> ContactLaw:
    normal = np.array((*values, 1.0)) / np.sqrt(1 + values[0] ** 2 + values[1] ** 2)
    return replace(law, normal=(float(normal[0]), float(normal[1]), float(normal[2])))


def _grid(*values: float) -> tuple[tuple[float, ...], ...]:
    return tuple((value,) for value in values)


# Mistakes that no law of an impact or a slide has: they show in the motion itself.
TUNNELS = ContactHypothesis("contact-tunnelling", "contact", "the body passes through the plane", _fields())
HANGS = ContactHypothesis("contact-sleep", "sleep", "the body is put to sleep above the plane", _fields())
EARLY = ContactHypothesis(
    "contact-without-touching",
    "contact",
    "contact begins {} m above the plane, as with a speculative margin",
    _fields(),
    parameters=(("gap", "m"),),
)
GRAVITY_FIRST = ContactHypothesis(
    "contact-gravity-before-bounce",
    "bounce",
    "a step's gravity is added before the bounce, so that the rebound depends on the step ({} s)",
    _fields(),
    parameters=(("step", "s"),),
)
SHOWN = (TUNNELS, HANGS, EARLY, GRAVITY_FIRST)


def contact_hypotheses(law: ContactLaw, pull: Array, speeds: tuple[float, ...]) -> tuple[ContactHypothesis, ...]:
    """Return the mistakes that have an effect on some motion.

    Parameters
    ----------
    law : the scene's law
    pull : gravity, plane's frame [m/s2], (3,)
    speeds : of approach in the file, from which a bounce threshold is taken [m/s]
    """
    e, mu = law.restitution, law.friction
    found = []
    if 0 < e < 1:
        found += [
            ContactHypothesis(
                "contact-restitution-squared",
                "restitution",
                f"the restitution is e^2 = {e * e:.3g}",
                _fields(restitution=e * e),
            ),
            ContactHypothesis(
                "contact-restitution-root",
                "restitution",
                f"the restitution is the root of e, {e**0.5:.3g}: e is taken for a ratio of energies",
                _fields(restitution=e**0.5),
            ),
            ContactHypothesis(
                "contact-product-rule",
                "material",
                f"two materials are mixed by the product: restitution e^2 = {e * e:.3g}, friction mu^2 = {mu * mu:.3g}",
                _fields(restitution=e * e, friction=mu * mu),
            ),
        ]
    if e > 0:
        found.append(
            ContactHypothesis(
                "contact-no-restitution", "restitution", "there is no restitution", _fields(restitution=0.0)
            )
        )
    if e < 1:
        found.append(
            ContactHypothesis(
                "contact-elastic", "restitution", "the rebound is elastic: e = 1", _fields(restitution=1.0)
            )
        )
    if mu > 0:
        found += [
            ContactHypothesis(
                "contact-friction-squared",
                "friction",
                f"the friction is mu^2 = {mu * mu:.3g}: two materials mixed by the product",
                _fields(friction=mu * mu),
            ),
            ContactHypothesis("contact-no-friction", "friction", "there is no friction", _fields(friction=0.0)),
            ContactHypothesis(
                "contact-friction-at-centre",
                "torque",
                "friction acts at the centre of mass: it has no torque, and opposes the velocity of the centre",
                _fields(torque=False, slip_of_centre=True),
            ),
            ContactHypothesis(
                "contact-friction-at-centre",
                "torque",
                "friction acts at the centre of mass: it has no torque",
                _fields(torque=False),
            ),
            ContactHypothesis(
                "contact-friction-of-centre-velocity",
                "torque",
                "friction opposes the velocity of the centre of mass, not of the contact point",
                _fields(slip_of_centre=True),
            ),
            ContactHypothesis(
                "contact-pyramid",
                "cone",
                "friction is bounded along each axis alone: a pyramid, up to sqrt 2 too strong",
                _fields(cone=SQUARE),
            ),
            ContactHypothesis(
                "contact-pyramid",
                "cone",
                "friction is bounded by a pyramid with edges along the axes, up to sqrt 2 too weak",
                _fields(cone=DIAMOND),
            ),
            ContactHypothesis(
                "contact-whole-impulse",
                "instant",
                "friction is applied to an impulse as a whole, not at each instant of the impact",
                _fields(in_impact=WHOLE),
            ),
            ContactHypothesis(
                "contact-friction-after-normal",
                "instant",
                "friction is applied after the normal impulse, which it changes",
                _fields(in_impact=AFTER),
            ),
        ]
    up = -pull / np.linalg.norm(pull)
    if abs(up[2] - 1) > 1e-9:
        found.append(
            ContactHypothesis(
                "contact-normal-vertical",
                "normal",
                "the normal is the vertical, not the plane's",
                _fields(normal=tuple(up.tolist())),
            )
        )
    ordered = sorted({0.0, *speeds})
    middles = tuple((low + high) / 2 for low, high in itertools.pairwise(ordered))
    if e > 0 and middles:
        found.append(
            ContactHypothesis(
                "contact-bounce-threshold",
                "threshold",
                "nothing rebounds below a speed of about {} m/s",
                _set("threshold"),
                _grid(*middles),
                (("speed", "m/s"),),
            )
        )
    found += [
        ContactHypothesis(
            "contact-restitution",
            "restitution",
            "the restitution is {}",
            _set("restitution"),
            _grid(0.02, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1),
            (("factor", ""),),
        ),
        ContactHypothesis(
            "contact-friction",
            "friction",
            "the friction is {}",
            _set("friction"),
            _grid(0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0, 1.5),
            (("factor", ""),),
        ),
        *(
            ContactHypothesis(
                "contact-push-out",
                "push",
                "taking a penetration out adds velocity, {} m/s per metre",
                lambda law, values, laid=laid: replace(law, push=values[0], laid=laid),
                _grid(1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1e3, 3e3, 1e4),
                (("rate", "1/s"),),
            )
            for laid in (False, True)
        ),
        ContactHypothesis(
            "contact-sleep",
            "sleep",
            "the body is put to sleep while it still moves, below {} m/s",
            _set("asleep"),
            _grid(0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0),
            (("speed", "m/s"),),
        ),
        ContactHypothesis(
            "contact-creep",
            "viscous",
            "friction is viscous below {} m/s: the body creeps",
            _set("viscous"),
            _grid(1e-4, 1e-3, 3e-3, 0.01, 0.03, 0.1, 0.3, 1.0),
            (("speed", "m/s"),),
        ),
        ContactHypothesis(
            "contact-wrong-normal",
            "normal",
            "the normal is tilted by {}, {} (tangents, along the plane's axes)",
            _tilted,
            tuple((x, y) for x in TILTS for y in TILTS if x or y),
            (("tilt-1", ""), ("tilt-2", "")),
            is_signed=True,
        ),
    ]
    return tuple(found)
