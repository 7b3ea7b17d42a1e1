"""The one line above the controls: what is seen, and what can be done now."""

from collections.abc import Sequence

import numpy as np

from reports.numerals import figure
from scenarios.published import VERTEX, table_4_1
from tumble.lab.readings import ErrorRow, wrong
from tumble.lab.session import Session, Shown


def sentence(session: Session, shown: Shown, rows: Sequence[ErrorRow], *, is_table_4_1: bool) -> str:
    """Return it; rows: the error table at the time shown; is_table_4_1: whether the coursework's throw is replayed."""
    throw = session.throw
    if session.aiming:
        return "Click the body: another impulse at this instant."
    if throw is None:
        if not len(session.draft.scene.body.faces):
            return "This body is points without a surface to click: As written flies it."
        own = " As written flies the scene's own throw." if session.draft.brings_a_throw else ""
        return f"Click the body to throw it.{own}"
    if is_table_4_1:
        return printed(shown)
    if throw.why_no_truth:
        return f"No truth here: {throw.why_no_truth}"
    furthest = wrong(rows)
    if furthest is not None:
        return f"Furthest off now: {furthest.contestant.name}, {figure(furthest.off_m)} m."
    return "Nobody is off by more than the truth's own limit." if throw.is_complete else "Flying."


def printed(shown: Shown) -> str:
    """Return how far the printed positions are from what is shown, at one of the five times, or what marks them."""
    table = table_4_1()
    row = int(np.argmin(np.abs(table.physics_times - shown.time)))
    if abs(table.physics_times[row] - shown.time) > 1e-9:
        return "Table 4.1, vertex 5 at five times: green the application's printed positions, violet the calculated."
    place = shown.vertices[VERTEX]
    application = figure(float(np.linalg.norm(place - table.application[row])))
    calculated = figure(float(np.linalg.norm(place - table.calculated[row])))
    return (
        f"Vertex 5 as printed, when the screen's clock showed {table.clock[row]:g} s: the application (green) "
        f"{application} m from the truth, the calculation (violet) {calculated} m."
    )
