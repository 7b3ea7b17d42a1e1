"""The contact methods, each with what it claims: the tests ask for every claim, and deny what is not claimed."""

from collections.abc import Callable
from dataclasses import dataclass

from tumble.solver.contact.events import WIDTH, events


@dataclass(frozen=True)
class ContactMethod:
    """A contact method and its claims.

    steps: the kernel.  width: numbers in its row.
    order: by which power of the step the error of what a contact does falls; None where it does not depend on the step.
    dense: it goes to an instant and not by steps.
    """

    steps: Callable
    width: int
    order: int | None
    dense: bool = False


CONTACT_METHODS = {
    "events": ContactMethod(events, WIDTH, order=None, dense=True),
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
