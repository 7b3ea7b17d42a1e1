"""The table of an ablation."""

from compare.ablation.ablation import AblationRow
from compare.tables.schema import Table
from compare.tables.shared import CONTESTANT

ABLATION = Table("ablation.csv", AblationRow, (*CONTESTANT, "feature"))
TABLES = (ABLATION,)
