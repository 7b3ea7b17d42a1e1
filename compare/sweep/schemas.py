"""The tables of a sweep, beside its runs."""

from compare.sweep.frontier import ClockRow, DigitRow, OrderRow, SameRow, ThrowsRow
from compare.tables.schema import Table
from compare.tables.shared import CONTESTANT

DIGITS = Table("digits.csv", DigitRow, (*CONTESTANT, "target_m"))
ORDERS = Table("orders.csv", OrderRow, CONTESTANT)
THROWS = Table("throws.csv", ThrowsRow, (*CONTESTANT, "dt_s"))
SAME = Table("same.csv", SameRow)
CLOCK = Table("clock.csv", ClockRow, CONTESTANT)
TABLES = (DIGITS, ORDERS, THROWS, SAME, CLOCK)
