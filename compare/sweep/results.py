"""All tables of a sweep, by file name."""

from collections.abc import Sequence

import pandas as pd

from tumble.compare.sweep.findings import sweep_findings
from tumble.compare.sweep.pareto_front import (
    accuracy_cost_rows,
    ensemble_rows,
    equivalent_rows,
    order_rows,
    timing_rows,
    work_precision_rows,
)
from tumble.compare.sweep.schemas import CLOCK, DIGITS, ENSEMBLES, OBSERVABLES, ORDERS, SAME, WORK_PRECISION
from tumble.compare.sweep.work_precision import Sweep
from tumble.compare.tables.frames import frame
from tumble.compare.tables.runs import run_row
from tumble.compare.tables.shared import FINDINGS, RUNS


def measured(sweeps: Sequence[Sweep], reference: str) -> dict[str, pd.DataFrame]:
    """Return all tables of sweeps.

    Parameters
    ----------
    sweeps : of the scenes
    reference : ENGINE:METHOD that run times are divided by

    Returns
    -------
    table by file name
    """
    return {
        "runs.csv": frame(RUNS, (run_row(run) for sweep in sweeps for run in sweep.runs)),
        "work-precision.csv": frame(WORK_PRECISION, (row for sweep in sweeps for row in work_precision_rows(sweep))),
        "accuracy-cost.csv": frame(DIGITS, (row for sweep in sweeps for row in accuracy_cost_rows(sweep, reference))),
        "orders.csv": frame(ORDERS, (row for sweep in sweeps for row in order_rows(sweep))),
        "ensembles.csv": frame(ENSEMBLES, (row for sweep in sweeps for row in ensemble_rows(sweep))),
        "equivalent.csv": frame(SAME, (row for sweep in sweeps for row in equivalent_rows(sweep))),
        "timing.csv": frame(CLOCK, (row for sweep in sweeps for row in timing_rows(sweep))),
        OBSERVABLES.file: frame(OBSERVABLES, (row for sweep in sweeps for row in sweep.observed)),
        "findings.csv": frame(FINDINGS, (row for sweep in sweeps for row in sweep_findings(sweep))),
    }
