"""Which printed column of Table 4.1 is right."""

from collections.abc import Iterable, Iterator

from tumble.compare.coursework.schemas import BudgetRow
from tumble.compare.coursework.table_4_1 import EXACT
from tumble.compare.tables.shared import FindingRow

# A column is called right if the exact motion is this many times nearer to it than to the other.
NEARER = 10


def column_findings(budget: Iterable[BudgetRow]) -> Iterator[FindingRow]:
    """Yield the printed column nearer to the exact motion, the other one, and both distances, if that is clear."""
    for row in budget:
        if row.engine != EXACT:
            continue
        near, far = sorted(
            (("application", row.max_to_application_m), ("calculated", row.max_to_calculated_m)), key=lambda one: one[1]
        )
        if NEARER * near[1] < far[1]:
            for finding, (column, distance) in zip(("right column", "wrong column"), (near, far), strict=True):
                yield FindingRow(
                    finding=finding,
                    scene=row.scene,
                    engine=row.engine,
                    method=row.method,
                    other=column,
                    value=distance,
                    unit="m",
                )
