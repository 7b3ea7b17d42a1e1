"""The contact methods, each with what it claims: the tests ask for every claim, and deny what is not claimed."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tumble.solver.contact.compliant import COMPLIANT_WIDTH, compliant
from tumble.solver.contact.events import events
from tumble.solver.contact.ground import Ground
from tumble.solver.contact.moreau import UNSOLVED, moreau, moreau_width
from tumble.solver.contact.throw import AT_ONCE, GAINED, REASONS, SINCE, WHY, WIDTH

Rows = NDArray[np.float64]


def _nothing(rows: Rows) -> list[str]:
    return []


def _none(rows: Rows) -> float:
    return 0.0


def unsolved_steps(rows: Rows) -> list[str]:
    """Return in how many steps the impulses of several contacts did not settle."""
    steps = int(rows[:, UNSOLVED].sum())
    return [f"Gauss-Seidel did not settle in {steps} steps"] if steps else []


def why_events_end(rows: Rows) -> list[str]:
    """Return from when on throws go by time steps, and why, and how many of these did not settle."""
    whys = [f"from {row[SINCE]:.6g} s on by Moreau's time steps: {REASONS[int(row[WHY])]}" for row in rows if row[WHY]]
    return whys + unsolved_steps(rows[:, WIDTH:])


@dataclass(frozen=True)
class ContactMethod:
    """A contact method and its claims.

    steps: the kernel.  width: how many numbers its row has above a ground.
    order: by which power of the step the error of what a contact does falls; None where it does not depend on the step.
    dense: it goes to an instant and not by steps.
    restitution: a point leaves the plane at e times the speed of its approach, wherever on the body, as dt -> 0.
    follows_slip: friction of an impact is against the slip at every moment of it, as dt -> 0.
    holds: a body at rest on an incline below the critical angle stays where it is, to rounding.
    findings: of its rows, what the states do not show.  gained: of its rows, energy that impacts gained [J].
    at_once: of its rows, how often several points struck at once.
    """

    steps: Callable
    width: Callable[[Ground], int]
    order: int | None
    dense: bool = False
    restitution: bool = False
    follows_slip: bool = False
    holds: bool = False
    findings: Callable[[Rows], list[str]] = _nothing
    gained: Callable[[Rows], float] = _none
    at_once: Callable[[Rows], float] = _none


CONTACT_METHODS = {
    "events": ContactMethod(
        events,
        lambda ground: WIDTH + moreau_width(ground),
        order=None,
        dense=True,
        restitution=True,
        follows_slip=True,
        holds=True,
        findings=why_events_end,
        gained=lambda rows: float(rows[:, GAINED].sum()),
        at_once=lambda rows: float(rows[:, AT_ONCE].sum()),
    ),
    "moreau": ContactMethod(moreau, moreau_width, order=1, restitution=True, holds=True, findings=unsolved_steps),
    "compliant": ContactMethod(compliant, lambda ground: COMPLIANT_WIDTH, order=None),
}


def find(name: str) -> ContactMethod:
    """Return the contact method of a name.

    Parameters
    ----------
    name

    Returns
    -------
    method

    Raises
    ------
    ValueError
        No contact method has that name.
    """
    if name not in CONTACT_METHODS:
        raise ValueError(f"no contact method {name!r}; there are {', '.join(CONTACT_METHODS)}")
    return CONTACT_METHODS[name]
