"""Lists and tables as text, 80 columns wide if possible."""

import re
from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING

from rich import box
from rich.console import Console
from rich.constrain import Constrain
from rich.table import Table
from rich.text import Text

from tumble.compare.run.contestant import Contestant
from tumble.reports.output import drop_output
from tumble.scenarios.format import visible
from tumble.scenarios.frames import Array

if TYPE_CHECKING:  # 10 ms, and most lists are of something else
    from tumble.compare.tables.shared import EngineRow

# In a pipe tables are not wrapped, because programs cut them into columns; lists are.
PIPE_WIDTH, LIST_WIDTH = 160, 80
SHOWN_SAMPLES = 10


class Results(Console):
    """A console whose reader may stop early, as `head` does: the command continues and has its own exit code."""

    def on_broken_pipe(self) -> None:
        """Discard further output."""
        drop_output()


def console(**settings: object) -> Console:
    """Return a console for results: as wide as the terminal, or in a pipe wide enough not to wrap.

    Parameters
    ----------
    **settings : arguments of `rich.console.Console`

    Returns
    -------
    the console
    """
    # In a notebook rich would otherwise display what is printed there, also where it goes to a file.
    found = Results(highlight=False, markup=False, emoji=False, force_jupyter=False, **settings)  # type: ignore[arg-type]
    if not found.is_terminal:
        found.width = PIPE_WIDTH
    return found


def plain(text: str) -> Text:
    """Return text with control characters made visible and no markup.

    Parameters
    ----------
    text : the text

    Returns
    -------
    the text for `rich`
    """
    return Text(visible(text))


def columns(*heads: str, right: Sequence[int] = ()) -> Table:
    """Return an empty table; right: the columns that hold numbers."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, padding=0, show_edge=False)
    for number, head in enumerate(heads):
        table.add_column(head, justify="right" if number in right else "left", no_wrap=number == 0)
    return table


def reasons_text(reasons: Iterable[tuple[str, str]]) -> Iterator[Constrain]:
    """Yield every reason once, after its contestants; reasons: contestant and reason."""
    names: dict[str, dict[str, None]] = {}
    for contestant, reason in reasons:
        method = str(Contestant.of_name(contestant).method)
        # Reasons that differ only in the name of the method are one.
        names.setdefault(re.sub(f"(^|: ){re.escape(method)} ", r"\1", reason), {})[contestant] = None
    for reason, own in names.items():
        yield Constrain(plain(f"{', '.join(own)}: {reason}"), LIST_WIDTH)


def engine_list(rows: "Sequence[EngineRow]") -> Table:
    """Return the engines: version, precision, methods and features switched off, or why one is missing.

    Parameters
    ----------
    rows : the engines

    Returns
    -------
    the table, one line for each engine
    """
    table = columns("engine", "version", "precision", "methods", "switched off")
    for row in rows:
        if row.status == "ok":
            table.add_row(*map(plain, (row.engine, row.version, row.precision, row.methods, row.switched_off)))
        else:
            table.add_row(plain(row.engine), "", "", plain(row.methods), plain(row.outcome))
    return table


def figure(value: float) -> str:
    """Return a figure in two digits."""
    return f"{value:.1e}"


def thinned(samples: int) -> list[int]:
    """Return which samples are printed: all, or some at even distances that end with the last."""
    if samples <= SHOWN_SAMPLES:
        return list(range(samples))
    return sorted({round((number + 1) * samples / SHOWN_SAMPLES) - 1 for number in range(SHOWN_SAMPLES)})


def vector(values: Array, places: int) -> str:
    """Return (x, y, z)."""
    return "(" + ", ".join(f"{value:z.{places}f}" for value in values) + ")"
