"""What `tumble compare` prints above a plane: the largest law error, the law of each contestant, its observables."""

import re
from collections.abc import Iterator, Sequence

from rich.console import RenderableType
from rich.constrain import Constrain
from rich.table import Table
from rich.text import Text

from tumble.compare.contact.findings import RIGHT, ContestantLaw, contestant_laws, largest, law_share, step_share
from tumble.compare.contact.schemas import ContactRow
from tumble.compare.engines import OWN
from tumble.reports.charts import GOOD
from tumble.reports.lengths import length
from tumble.reports.numerals import listed
from tumble.reports.terminal import LIST_WIDTH, columns, figure, plain

IN_IMPACT = re.compile(" (after|in|of) impact")  # of an observable, below the line with the impact's number
LEAST_SHARE = 1e-4  # a smaller step error is not worth its place in the table
MOST_NAMED = 4  # contestants in one sentence
POSITIONS = (
    "Positions at samples, below, also contain the speed times the delay of a contact: an error of the order of "
    "v dt in every engine."
)


def contact_text(rows: Sequence[ContactRow], everything: bool = False) -> Iterator[RenderableType]:
    """Yield what `tumble compare` prints of the contact in one scene; nothing where there are no rows.

    Parameters
    ----------
    rows : of contact.csv, of one scene
    everything : print the observables of every contestant, not only of each engine's first method

    Yields
    ------
    the parts of the text, from top to bottom
    """
    if not rows:
        return
    laws = contestant_laws(rows)
    yield Constrain(plain(contact_answer(laws, rows)), LIST_WIDTH)
    yield Text()
    yield law_table(laws, rows)
    first = list({one.engine: one for one in reversed(laws)}.values())[::-1]
    for one in laws if everything else sorted(first, key=lambda one: one.engine == OWN):
        own = of_contestant(rows, one)
        yield Text()
        yield plain(f"{one.contestant}: observables; errors as value less truth")
        yield observable_table([row for row in own if everything or is_worth_showing(row)])
    yield Text()
    yield Constrain(plain(POSITIONS), LIST_WIDTH)
    yield Text()


def contact_answer(laws: Sequence[ContestantLaw], rows: Sequence[ContactRow]) -> str:
    """Return the answer in words: the largest law error, and who follows Coulomb and Newton."""
    scene = laws[0].scene
    right = [one.contestant for one in laws if one.is_right]
    wrong = [one for one in laws if not one.is_right]
    more = len(right) - MOST_NAMED
    named = listed(right) if more <= 0 else f"{', '.join(right[:MOST_NAMED])} and {more} more"
    follow = f"{named} follow{'s' if len(right) == 1 else ''} Coulomb and Newton."
    if not wrong:
        return f"{scene}: {follow}"
    worst = largest(wrong)
    said = f"{scene}: the largest law error is that of {worst.contestant}: {error_words(worst, rows)}."
    if worst.share:
        said += f" No smaller step removes it. Verdict: {worst.verdict}."
    if right:
        said += f" {follow}"
    return said


def error_words(law: ContestantLaw, rows: Sequence[ContactRow]) -> str:
    """Return a contestant's largest law error in words."""
    if law.worst is None:
        return ""
    share = law_share(law.worst, of_contestant(rows, law))
    if not law.share or share is None:
        return law.verdict
    return f"{observable_words(law.worst)} {percent(share)}"


def observable_words(row: ContactRow) -> str:
    """Return the name of an observable, with the number of its impact."""
    if row.blow is None:
        return row.observable
    return f"{without_impact(row)} in impact {row.blow}"


def without_impact(row: ContactRow) -> str:
    """Return the name of an observable of an impact without the words for that."""
    return IN_IMPACT.sub("", row.observable)


def of_contestant(rows: Sequence[ContactRow], law: ContestantLaw) -> list[ContactRow]:
    """Return the rows of one contestant."""
    return [row for row in rows if (row.scene, row.engine, row.method) == (law.scene, law.engine, law.method)]


def percent(share: float) -> str:
    """Return a share as a percentage with its sign."""
    return f"{100 * share:+.3g} %"


def law_table(laws: Sequence[ContestantLaw], rows: Sequence[ContactRow]) -> Table:
    """Return the verdict and the largest law error of each contestant, the smallest first."""
    table = columns("contestant", "verdict", "largest law error", "largest step error")
    for one in sorted(laws, key=lambda one: (not one.is_right, one.share)):
        verdict = Text(one.verdict, style=GOOD) if one.is_right else plain(one.verdict)
        words = error_words(one, rows) if one.share else ""
        table.add_row(plain(one.contestant), verdict, plain(words), plain(step_words(of_contestant(rows, one))))
    return table


def step_words(rows: Sequence[ContactRow]) -> str:
    """Return the largest error that the step adds, in words: a share, and what a body at rest creeps."""
    found = [(share, observable_words(row)) for row in rows if (share := step_share(row, rows)) is not None]
    share, observable = max(found, key=lambda one: abs(one[0]), default=(0.0, ""))
    said = f"{observable} {percent(share)}" if abs(share) >= LEAST_SHARE else ""
    creeps = [row.step_error for row in rows if row.observable == "creep speed" and row.step_error is not None]
    return "; ".join(filter(None, (said, *(f"creeps at {length(abs(one))}/s" for one in creeps if abs(one) > 1e-4))))


def is_worth_showing(row: ContactRow) -> bool:
    """Whether a row is more than a zero that is one."""
    return row.verdict != RIGHT or row.true != 0


def observable_table(rows: Sequence[ContactRow]) -> Table:
    """Return observables with the error of the law, half its interval, and that of the step.

    A column without a number is left out.  The rows of an impact stand below a line with its number.
    """
    cells = {
        "observable": [row.observable if row.blow is None else f"  {without_impact(row)}" for row in rows],
        "true": [f"{row.true:.4g} {row.unit}" for row in rows],
        "law error": [number(row.law_error) for row in rows],
        "±": [number(half_interval(row)) for row in rows],
        "step error": [number(row.step_error) for row in rows],
        "order": ["" if row.order is None else f"{row.order:.1f}" for row in rows],
        "as the law": [law_word(row.verdict) for row in rows],
    }
    shown = {head: column for head, column in cells.items() if any(column)}
    table = columns(*shown, right=range(1, len(shown) - 1))
    impact = None
    for row, texts in zip(rows, zip(*shown.values(), strict=True), strict=True):
        if row.blow not in (None, impact):
            table.add_row(f"impact {row.blow}")
        impact = row.blow
        table.add_row(*map(plain, texts))
    return table


def law_word(verdict: str) -> str:
    """Return whether an observable is as the law has it, in a word; the table above has the verdict."""
    return "yes" if verdict == RIGHT else "no limit" if "depends on the step" in verdict else "no"


def half_interval(row: ContactRow) -> float | None:
    """Return half the width of the interval of a law error, None where there is none."""
    if row.law_error_low is None or row.law_error_high is None:
        return None
    return (row.law_error_high - row.law_error_low) / 2


def number(value: float | None) -> str:
    """Return a figure, nothing for none."""
    return "" if value is None else figure(value)
