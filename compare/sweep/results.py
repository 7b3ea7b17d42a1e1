"""All tables of a sweep, by file name."""

from collections.abc import Sequence

import pandas as pd

from tumble.compare.run.participants import Participant
from tumble.compare.run.provenance import conditions
from tumble.compare.sweep.findings import sweep_findings
from tumble.compare.sweep.frontier import (
    clock_rows,
    digit_rows,
    order_rows,
    same_rows,
    throws_rows,
    work_precision_rows,
)
from tumble.compare.sweep.schemas import CLOCK, DIGITS, ORDERS, SAME, THROWS, WORK_PRECISION
from tumble.compare.sweep.work_precision import Sweep
from tumble.compare.tables.engines import engine_row
from tumble.compare.tables.frames import frame
from tumble.compare.tables.runs import run_row
from tumble.compare.tables.shared import CONDITIONS, ENGINES, FINDINGS, RUNS

MEASURED = (RUNS, WORK_PRECISION, DIGITS, ORDERS, THROWS, SAME, CLOCK, FINDINGS)


def measured(sweeps: Sequence[Sweep], reference: str) -> dict[str, pd.DataFrame]:
    """Return what was measured; ratios are over the reference contestant's times."""
    return {
        "runs.csv": frame(RUNS, (run_row(run) for sweep in sweeps for run in sweep.runs)),
        "work-precision.csv": frame(WORK_PRECISION, (row for sweep in sweeps for row in work_precision_rows(sweep))),
        "digits.csv": frame(DIGITS, (row for sweep in sweeps for row in digit_rows(sweep, reference))),
        "orders.csv": frame(ORDERS, (row for sweep in sweeps for row in order_rows(sweep))),
        "throws.csv": frame(THROWS, (row for sweep in sweeps for row in throws_rows(sweep))),
        "same.csv": frame(SAME, (row for sweep in sweeps for row in same_rows(sweep))),
        "clock.csv": frame(CLOCK, (row for sweep in sweeps for row in clock_rows(sweep))),
        "findings.csv": frame(FINDINGS, (row for sweep in sweeps for row in sweep_findings(sweep))),
    }


def sweep_tables(
    sweeps: Sequence[Sweep], participants: Sequence[Participant], reference: str, command: str
) -> dict[str, pd.DataFrame]:
    """Return every table: what was measured, the engines, and on what machine."""
    return {
        **measured(sweeps, reference),
        "engines.csv": frame(ENGINES, map(engine_row, participants)),
        "conditions.csv": frame(CONDITIONS, conditions(command)),
    }
