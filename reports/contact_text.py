"""What `tumble compare` prints above a plane: the largest law error, the law of each contestant, its observables."""

from collections.abc import Iterator, Sequence

from rich.console import RenderableType
from rich.constrain import Constrain
from rich.table import Table
from rich.text import Text

from tumble.compare.contact.findings import ContestantLaw, contestant_laws, largest, law_share, step_share
from tumble.compare.contact.schemas import ContactRow
from tumble.compare.engines import OWN
from tumble.reports.charts import GOOD
from tumble.reports.numerals import listed
from tumble.reports.terminal import LIST_WIDTH, columns, figure, length, plain

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
    impact = f" {law.worst.blow}" if law.worst.blow else ""
    return f"{law.worst.observable}{impact} {percent(share)}"


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
    found = [(share, row.observable) for row in rows if (share := step_share(row, rows)) is not None]
    share, observable = max(found, key=lambda one: abs(one[0]), default=(0.0, ""))
    said = f"{observable} {percent(share)}" if abs(share) >= LEAST_SHARE else ""
    creeps = [row.step_error for row in rows if row.observable == "creep speed" and row.step_error is not None]
    return "; ".join(filter(None, (said, *(f"creeps at {length(abs(one))}/s" for one in creeps if abs(one) > 1e-4))))


def is_worth_showing(row: ContactRow) -> bool:
    """Whether a row is more than a zero that is one."""
    return row.verdict != "Coulomb and Newton" or row.true != 0


def observable_table(rows: Sequence[ContactRow]) -> Table:
    """Return observables with the error of the law, its interval, and that of the step."""
    table = columns("observable", "impact", "true", "unit", "law error", "interval", "step error", "order", "verdict",
                    right=(2, 4, 5, 6, 7))  # fmt: skip
    for row in rows:
        table.add_row(
            row.observable,
            "" if row.blow is None else str(row.blow),
            f"{row.true:.4g}",
            row.unit,
            number(row.law_error),
            "" if row.law_error_low is None else f"{number(row.law_error_low)} to {number(row.law_error_high)}",
            number(row.step_error),
            "" if row.order is None else f"{row.order:.1f}",
            plain(row.verdict),
        )
    return table


def number(value: float | None) -> str:
    """Return a figure, nothing for none."""
    return "" if value is None else figure(value)
