"""The tables of a comparison alone."""

from tumble.compare.comparison.table_4_1 import BudgetRow, PublishedRow
from tumble.compare.judge.agreement import AgreementRow
from tumble.compare.tables.schema import Table
from tumble.compare.tables.shared import CONTESTANT

AGREEMENT = Table("agreement.csv", AgreementRow, ("scene", "engine_a", "method_a", "engine_b", "method_b"))
PUBLISHED = Table("table-4-1.csv", PublishedRow, (*CONTESTANT, "t_s"))
BUDGET = Table("table-4-1-budget.csv", BudgetRow, CONTESTANT)
TABLES = (AGREEMENT, PUBLISHED, BUDGET)
