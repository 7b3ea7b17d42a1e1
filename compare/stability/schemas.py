"""The tables of a map of stability and of the extreme cases."""

from compare.stability.extremes import ExtremeRow
from compare.stability.stability import LimitRow, StabilityRow
from compare.tables.schema import Table
from compare.tables.shared import CONTESTANT

CELLS = Table("stability.csv", StabilityRow, (*CONTESTANT, "value", "dt_s"))
LIMITS = Table("limits.csv", LimitRow, CONTESTANT)
EXTREMES = Table("extremes.csv", ExtremeRow, CONTESTANT)
TABLES = (CELLS, LIMITS, EXTREMES)
