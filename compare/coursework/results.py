"""The tables of the coursework study, by file name."""

from collections.abc import Iterable

import pandas as pd

from tumble.compare.coursework.findings import column_findings
from tumble.compare.coursework.schemas import BUDGET, PUBLISHED
from tumble.compare.coursework.table_4_1 import Answers, budget_rows, published_rows
from tumble.compare.tables.frames import frame
from tumble.compare.tables.shared import FINDINGS


def coursework_tables(answers: Iterable[Answers]) -> dict[str, pd.DataFrame]:
    """Return the distances from the printed columns and the findings.

    Parameters
    ----------
    answers : of each scene, as a comparison has them

    Returns
    -------
    table by file name; without rows if no scene is that of Table 4.1
    """
    published = [row for each in answers for row in published_rows(each)]
    budget = list(budget_rows(published))
    return {
        PUBLISHED.file: frame(PUBLISHED, published),
        BUDGET.file: frame(BUDGET, budget),
        FINDINGS.file: frame(FINDINGS, column_findings(budget)),
    }
