"""What `tumble grade` prints of the contact in a file: its observables beside the law's, and the mistake."""

from collections.abc import Iterator

from rich.table import Table

from tumble.compare.grade.contact_grade import ContactGrade
from tumble.compare.grade.search.contact_search import ContactExplanation
from tumble.compare.grade.verdicts import (
    CORRECT_TO_DIGITS,
    CORRECT_TO_RESOLUTION,
    CORRECT_TO_STEP,
    EXPLAINED_PARTLY,
    NOTHING_SEEN,
    TOO_COARSE,
    UNEXPLAINED,
)
from tumble.reports.lengths import length
from tumble.reports.terminal import columns, figure

# Observables in the table, at most, and equally good explanations.
SHOWN, SHOWN_ALIKE = 12, 3


def contact_headline(file: str, grade: ContactGrade, flight: str = "") -> str:
    """Return in a sentence whether the contact in a file is right, and the most likely mistake.

    Parameters
    ----------
    file : name of the file
    grade : the grade of its contact
    flight : what is wrong with the flight before it, in words; empty if that is not known

    Returns
    -------
    one line of text
    """
    cause = f": {flight}" if flight else ""
    m, verdict = grade.measured, grade.verdict
    largest = f"the largest error is {length(m.worst_m)}"
    if verdict == CORRECT_TO_RESOLUTION:
        return f"{file} is right, within the resolution of the reference."
    if verdict == CORRECT_TO_DIGITS:
        return f"{file} is right to its printed digits: {largest}, and they allow {length(m.half_m)}."
    if verdict == CORRECT_TO_STEP:
        step = f"up to {figure(grade.search.step)} s" if grade.search.judged else "a row or less"
        return (
            f"{file} is right to its step: it follows the scene's restitution and friction. Positions are off by up to "
            f"{length(m.worst_m)}, as contacts are late by {step}."
        )
    if verdict == TOO_COARSE:
        return f"{file} is too coarse to grade: its step and digits would hide a restitution or a friction squared."
    if verdict == NOTHING_SEEN:
        return (
            f"{file}: {largest}, but it shows no contact that can be graded: no impact of one corner between two "
            "flights, and no motion along the plane on a face or as a sphere."
        )
    wrong = f"{file} is wrong"
    if grade.is_wrong_before:
        return f"{wrong} before it first touches the plane{cause}. Its contact is not graded."
    if verdict == UNEXPLAINED:
        return f"{wrong}: {worst(grade)}. No known mistake explains it."
    best = explanation_text(grade.explanations[0])
    if verdict == EXPLAINED_PARTLY:
        return f"{wrong}: {worst(grade)}. Best partial explanation: {best}."
    return f"{wrong}: {best}."


def explanation_text(explanation: ContactExplanation) -> str:
    """Return the mistakes of an explanation in one line."""
    return "; and ".join(mistake.text for mistake in explanation.mistakes)


def worst(grade: ContactGrade) -> str:
    """Return the observable that is furthest off, in words."""
    rows = [row for row in grade.observables if row.value != row.expected]
    if not rows:
        return f"the largest error is {length(grade.measured.worst_m)}"
    row = max(rows, key=lambda one: abs(one.value - one.expected) / max(abs(one.value), abs(one.expected)))
    unit = f" {row.unit}" if row.unit else ""
    return f"at t = {row.time:.4g} s the {row.name} is {row.value:.3g}{unit}, not {row.expected:.3g}{unit}"


def contact_table(grade: ContactGrade) -> Table:
    """Return the observables of the first impacts and motions along the plane, in the file and by the law."""
    table = columns("t [s]", "observable", "file", "law", "unit", right=(0, 2, 3))
    for row in grade.observables[:SHOWN]:
        table.add_row(f"{row.time:.4g}", row.name, f"{row.value:.4g}", f"{row.expected:.4g}", row.unit)
    return table


def contact_lines(grade: ContactGrade) -> Iterator[str]:
    """Yield the evidence for the verdict on contact, a line each.

    Parameters
    ----------
    grade : the grade of a file's contact

    Returns
    -------
    lines of text
    """
    search, more = grade.search, len(grade.observables) - SHOWN
    if more > 0:
        yield f"... and {more} more."
    counted = f"{len(search.judged)} impacts and {len(search.slid)} motions along the plane"
    null = search.null.misses
    if null:
        yield (
            f"{counted} are compared with the law from the file's own state before them. Errors are in units of what "
            f"a step of {figure(search.step)} s and the printed digits allow; the largest is {figure(max(null))}."
        )
    if grade.explanations and grade.explanations[0].misses:
        best, *others = grade.explanations
        left = figure(max(best.misses))
        yield f"With {explanation_text(best)}: {figure(max(null))} -> {left} units ({search.trials} laws tried)."
        for other in others[:SHOWN_ALIKE]:
            yield f"Equally good: {explanation_text(other)}"
    elif grade.verdict == UNEXPLAINED and not grade.is_wrong_before:
        yield f"Not explained: {search.trials} laws with mistakes were tried, and none explains most of the error."
