"""Table 4.1 in the terminal and on the page."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from rich.console import RenderableType
from rich.text import Text

from tumble.compare.coursework.table_4_1 import EXACT, Answers, budget_rows, is_table_4_1, published_rows
from tumble.compare.engines import BY_HAND
from tumble.reports.rows import contestant
from tumble.reports.terminal import columns, plain
from tumble.scenarios.published import VERTEX
from tumble.scenarios.scene import Scene

if TYPE_CHECKING:
    import pandas as pd  # the terminal's text needs none of it


def printed_vertex(scene: Scene) -> int | None:
    """Return the vertex that Table 4.1 prints; None if the scene is not its own."""
    return VERTEX if is_table_4_1(scene) else None


def coursework_text(answers: Answers) -> Iterator[RenderableType]:
    """Yield how far every contestant is from Table 4.1's two columns; nothing if the scene is not its own."""
    rows = list(budget_rows(list(published_rows(answers))))
    if not rows:
        return
    yield Text()
    yield plain("largest distance from the two columns printed in Table 4.1, over its five rows")
    table = columns("contestant", "calculated [m]", "application [m]", right=(1, 2))
    for row in rows:
        table.add_row(plain(contestant(row)), f"{row.max_to_calculated_m:.3f}", f"{row.max_to_application_m:.3f}")
    yield table


def page_rows(published: "pd.DataFrame") -> "pd.DataFrame":
    """Return the rows of table-4-1.csv that the page shows: the exact motion and the hand calculation."""
    if published.empty:
        return published
    return published.loc[published["engine"].isin([EXACT, BY_HAND]).to_numpy(dtype=bool)]
