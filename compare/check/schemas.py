"""The tables of a record."""

from compare.check.record import CellRow, QuestionRow, TimeRow
from compare.tables.schema import Table
from compare.tables.shared import CONTESTANT

QUESTIONS = Table("questions.csv", QuestionRow, ("scene",))
CELLS = Table("cells.csv", CellRow, CONTESTANT)
TIMES = Table("times.csv", TimeRow, (*CONTESTANT, "reference"))
TABLES = (QUESTIONS, CELLS, TIMES)
