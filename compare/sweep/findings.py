"""The findings of a sweep that no row of its tables has."""

from collections.abc import Iterator

import numpy as np

from tumble.compare.sweep.pareto_front import order_rows
from tumble.compare.sweep.work_precision import Sweep
from tumble.compare.tables.shared import FindingRow


def sweep_findings(sweep: Sweep) -> Iterator[FindingRow]:
    """Yield the single-precision rounding of the largest coordinate, and the optimal steps of contestants."""
    true = next((run.truth for run in sweep.runs if run.truth is not None), None)
    if true is not None:
        reach = float(np.abs(true.vertices).max())
        rounding = float(np.spacing(np.float32(reach))) / 2
        yield FindingRow(
            finding="coordinate rounding",
            scene=sweep.scene.name,
            value=rounding,
            unit="m",
        )
    for row in order_rows(sweep):
        if row.worsens:
            yield FindingRow(
                finding="optimal step",
                scene=row.scene,
                engine=row.engine,
                method=row.method,
                value=row.best_dt_s,
                unit="s",
            )
