"""The tables that several studies write."""

from compare.run.provenance import ConditionRow
from compare.tables.rows import RunRow, VertexErrorRow
from compare.tables.schema import Table

CONTESTANT = ("scene", "engine", "method")
RUNS = Table("runs.csv", RunRow, (*CONTESTANT, "dt_s"))
VERTEX_ERRORS = Table("vertex-errors.csv", VertexErrorRow, (*CONTESTANT, "dt_s", "t_s", "vertex"))
CONDITIONS = Table("conditions.csv", ConditionRow, ("what",))
TABLES = (RUNS, VERTEX_ERRORS, CONDITIONS)
