"""All tables of a comparison, by file name."""

from collections.abc import Sequence

import pandas as pd

from tumble.compare.comparison.against_truth import Comparison
from tumble.compare.comparison.findings import agreement_findings, error_findings
from tumble.compare.comparison.schemas import AGREEMENT
from tumble.compare.comparison.sensor_tables import sensor_tables
from tumble.compare.judge.agreement import agreements
from tumble.compare.run.provenance import conditions
from tumble.compare.tables.frames import frame
from tumble.compare.tables.runs import run_row
from tumble.compare.tables.shared import CONDITIONS, ENGINES, FINDINGS, RUNS, SCENES, EngineRow, SceneRow
from tumble.compare.tables.vertices import error_over_time_table, member_table, vertex_error_table
from tumble.scenarios.needs import needs


def scene_row(comparison: Comparison) -> SceneRow:
    """Return the row of one scene."""
    scene, whole = comparison.scene, comparison.truth
    truth = None if whole is None else whole.until_horizon()
    return SceneRow(
        scene=scene.name,
        title=scene.title,
        source=scene.source,
        needs=", ".join(needs(scene)),
        shape=scene.body.shape,
        vertices=len(scene.body.points),
        duration_s=scene.duration,
        step_s=scene.step,
        samples=len(scene.times),
        truth=comparison.why_no_truth or (f"{truth.how}{truth.ends}" if truth else ""),
        bound_m=None if truth is None else float(truth.bound.max()),
        input_error_m=None if truth is None else float(truth.input_error.max()),
        horizon_s=whole.horizon if whole and whole.known < len(whole.times) else None,
        rounding_inputs_m=None if truth is None else comparison.lost_m,
    )


def comparison_tables(
    comparisons: Sequence[Comparison], engines: Sequence[EngineRow], command: str
) -> dict[str, pd.DataFrame]:
    """Return all tables of a comparison.

    Parameters
    ----------
    comparisons : of the scenes
    engines : that took part
    command : the command line that repeats the study, for conditions.csv

    Returns
    -------
    table by file name
    """
    runs = [run for comparison in comparisons for run in comparison.runs]
    rows = [run_row(run) for run in runs]
    pairs = [row for each in comparisons for row in agreements(each.runs)]
    defaults = frozenset().union(*(each.defaults for each in comparisons))
    named = frozenset().union(*(each.named for each in comparisons))
    findings = [*error_findings(rows, defaults, named), *agreement_findings(pairs)]
    return {
        "scenes.csv": frame(SCENES, map(scene_row, comparisons)),
        "engines.csv": frame(ENGINES, engines),
        "runs.csv": frame(RUNS, rows),
        "vertex-errors.csv": vertex_error_table(runs),
        "error-over-time.csv": error_over_time_table(runs),
        "members.csv": member_table(runs),
        "agreement.csv": frame(AGREEMENT, pairs),
        "findings.csv": frame(FINDINGS, findings),
        **sensor_tables([run for comparison in comparisons for run in comparison.sensors]),
        "conditions.csv": frame(CONDITIONS, conditions(command)),
    }
