"""The tables of a comparison."""

from compare.comparison.results import EngineRow, ErrorOverTimeRow, SceneRow
from compare.comparison.table_4_1 import BudgetRow, PublishedRow
from compare.judge.agreement import AgreementRow
from compare.tables.schema import Table
from compare.tables.shared import CONTESTANT

SCENES = Table("scenes.csv", SceneRow, ("scene",))
ENGINES = Table("engines.csv", EngineRow, ("engine",))
ERROR_OVER_TIME = Table("error-over-time.csv", ErrorOverTimeRow, (*CONTESTANT, "dt_s", "t_s"))
AGREEMENT = Table("agreement.csv", AgreementRow)
PUBLISHED = Table("table-4-1.csv", PublishedRow, (*CONTESTANT, "t_s"))
BUDGET = Table("table-4-1-budget.csv", BudgetRow, CONTESTANT)
TABLES = (SCENES, ENGINES, ERROR_OVER_TIME, AGREEMENT, PUBLISHED, BUDGET)
