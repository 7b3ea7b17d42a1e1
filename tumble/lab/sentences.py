"""The one line above the controls: what is seen, and what can be done now."""

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
    """Return it; rows: the error table at the time shown; factor: how many times larger errors are drawn;
    is_table_4_1: whether the coursework's throw is replayed."""
    throw = session.throw
    if session.aiming:
        return "Click the body: another impulse at this instant."
    if throw is None:
        if not len(session.draft.scene.body.faces):
            return f"This body is points without a surface to click: press {OWN_THROW}."
        own = f" Or press {OWN_THROW}." if session.draft.brings_a_throw else ""
        return f"Click the body to throw it.{own}"
    if is_table_4_1:
        return printed(shown)
    if throw.why_no_truth:
        return f"No reference solution here: {throw.why_no_truth}"
    largest = wrong(rows)
    if largest is not None:
        drawn = f", drawn {times(factor)} times larger" if factor > 1 else ""
        return f"Largest error now: {largest.contestant.name}, {metres(largest.off_m)}{drawn}.{outside(rows)}"
    if not shown.is_true and throw.flights():
        return "Waiting for the reference solution."
    if not throw.is_complete:
        return "Running."
    return "All that run here are indistinguishable from the truth." if throw.flights() else "No contestant runs here."


def outside(rows: Sequence[ErrorRow]) -> str:
    """Return who is drawn where it cannot be seen."""
    names = [row.contestant.name for row in rows if not row.is_in_view]
    return f" Outside the view: {', '.join(names)}." if names else ""


def printed(shown: Shown) -> str:
    """Return how far the printed positions are from what is shown, at one of the five times, or what marks them."""
    table = table_4_1()
    row = int(np.argmin(np.abs(table.physics_times - shown.time)))
    if abs(table.physics_times[row] - shown.time) > 1e-9:
        return (
            f"Table 4.1, vertex {VERTEX} at five times: black the application's printed positions, red the "
            "calculation's, grey the truth."
        )
    place = shown.vertices[VERTEX]
    application = metres(float(np.linalg.norm(place - table.application[row])))
    calculated = metres(float(np.linalg.norm(place - table.calculated[row])))
    return (
        f"Vertex {VERTEX} as printed, when the screen's clock showed {table.clock[row]:g} s: the application (black) "
        f"{application} from the truth, the calculation (red) {calculated}."
    )
