"""The tables of a comparison alone."""

from tumble.compare.judge.agreement import AgreementRow
from tumble.compare.tables.schema import Table

AGREEMENT = Table("agreement.csv", AgreementRow, ("scene", "engine_a", "method_a", "engine_b", "method_b"))
TABLES = (AGREEMENT,)
