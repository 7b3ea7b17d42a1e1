"""The tables of a comparison alone."""

from compare.comparison.table_4_1 import BudgetRow, PublishedRow
from compare.judge.agreement import AgreementRow
from compare.tables.schema import Table
from compare.tables.shared import CONTESTANT

AGREEMENT = Table("agreement.csv", AgreementRow, ("scene", "engine_a", "method_a", "engine_b", "method_b"))
PUBLISHED = Table("table-4-1.csv", PublishedRow, (*CONTESTANT, "t_s"))
BUDGET = Table("table-4-1-budget.csv", BudgetRow, CONTESTANT)
TABLES = (AGREEMENT, PUBLISHED, BUDGET)
