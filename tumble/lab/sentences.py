"""The one line above the controls: what the picture shows, and what the user can do now."""

from collections.abc import Sequence

import numpy as np

from tumble.lab.magnify import times
from tumble.lab.markup import metres
from tumble.lab.readings import ErrorRow, wrong
from tumble.lab.refusals import OWN_THROW
from tumble.lab.session import Session, Shown
from tumble.scenarios.published import VERTEX, table_4_1


def sentence(
    session: Session, shown: Shown, rows: Sequence[ErrorRow], factor: float = 1.0, *, is_table_4_1: bool = False
) -> str:
    """Return it.

    rows: the error table at the time shown; factor: magnification of errors; is_table_4_1: whether the coursework's
    throw is replayed.
    """
    throw = session.throw
    if session.aiming:
        return "Click the body to apply another impulse at this time."
    if throw is None:
        body = session.draft.scene.body
        if not body.has_surface:
            return f"This body has no surface to click: press {OWN_THROW}."
        own = f" Or press {OWN_THROW}." if session.draft.brings_a_throw else ""
        return f"Click the body to throw it.{own}"
    if is_table_4_1:
        return printed(shown)
    if throw.why_no_truth:
        return f"No truth for this throw: {throw.why_no_truth}"
    if shown.time > throw.truth_ends:
        return f"The truth is known until {throw.truth_ends:.3g} s: {throw.why_truth_ends}. Shown now: {shown.whose}."
    largest = wrong(rows)
    if largest is not None:
        drawn = f", magnified {times(factor)} times" if factor > 1 else ""
        return f"Largest error now: {largest.contestant.name}, {metres(largest.off_m)}{drawn}.{outside(rows)}"
    if not shown.is_true and throw.trajectories():
        return "Computing the truth."
    if not throw.is_complete:
        return "Running."
    if not throw.trajectories():
        return "No contestant supports this scene."
    return "All contestants are indistinguishable from the truth."


def outside(rows: Sequence[ErrorRow]) -> str:
    """Return a sentence on the contestants that are outside the view."""
    names = [row.contestant.name for row in rows if not row.is_in_view]
    return f" Outside the view: {', '.join(names)}." if names else ""


def printed(shown: Shown) -> str:
    """Return the errors of the printed positions at one of the five times, or the legend at any other."""
    table = table_4_1()
    row = int(np.argmin(np.abs(table.physics_times - shown.time)))
    if abs(table.physics_times[row] - shown.time) > 1e-9:
        return (
            f"Table 4.1, vertex {VERTEX} at five times: printed positions of the application in black, "
            "of the calculation in red, truth in grey."
        )
    place = shown.vertices[VERTEX]
    application = metres(float(np.linalg.norm(place - table.application[row])))
    calculated = metres(float(np.linalg.norm(place - table.calculated[row])))
    return (
        f"Printed positions of vertex {VERTEX} at {table.clock[row]:g} s on the screen: the application (black) "
        f"{application} from the truth, the calculation (red) {calculated}."
    )
