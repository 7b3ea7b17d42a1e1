"""All tables of a comparison, by file name."""

from collections.abc import Sequence

import pandas as pd

from tumble.compare.comparison.against_truth import Comparison
from tumble.compare.comparison.ensemble_rows import (
    ensemble_error_row,
    ensembles_of,
    over_time_rows,
    run_rows,
    worst_rows,
)
from tumble.compare.comparison.findings import agreement_findings, error_findings
from tumble.compare.comparison.schemas import AGREEMENT, ENSEMBLE_ERRORS
from tumble.compare.comparison.sensor_tables import sensor_tables
from tumble.compare.judge.agreement import agreements
from tumble.compare.run.provenance import conditions
from tumble.compare.tables.frames import frame
from tumble.compare.tables.shared import (
    CONDITIONS,
    ENGINES,
    ERROR_OVER_TIME,
    FINDINGS,
    MEMBERS,
    RUNS,
    SCENES,
    EngineRow,
    SceneRow,
)
from tumble.compare.tables.vertices import error_over_time_table, member_table, vertex_error_table
from tumble.scenarios.needs import needs


def scene_row(comparison: Comparison) -> SceneRow:
    """Return the row of one scene."""
    scene, whole = comparison.scene, comparison.truth
    truth = None if whole is None else whole.until_horizon()
    spreads = [one.spread for one in comparison.ensemble if one.spread.known]
    return SceneRow(
        scene=scene.name,
        title=scene.title,
        source=scene.source,
        needs=", ".join([*needs(scene), *(["throws"] if comparison.ensemble else [])]),
        shape=scene.body.shape,
        vertices=len(scene.body.points),
        duration_s=scene.duration,
        step_s=scene.step,
        samples=len(scene.times),
        truth=comparison.why_no_truth or (f"{truth.how}{truth.ends}" if truth else ""),
        bound_m=None if truth is None else max([float(truth.bound.max()), *(one.bound_m for one in spreads)]),
        input_error_m=None
        if truth is None
        else max([float(truth.input_error.max()), *(one.input_error_m for one in spreads)]),
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
    rows = [row for each in comparisons for row in run_rows(each)]
    alone = [run for each in comparisons if not each.ensemble for run in each.runs]
    ensembles = [one for each in comparisons for one in ensembles_of(each)]
    over_time = [row for one in ensembles for row in over_time_rows(one)]
    worst = [row for one in ensembles for row in worst_rows(one)]
    pairs = [row for each in comparisons for row in agreements(each.runs)]
    defaults = frozenset().union(*(each.defaults for each in comparisons))
    named = frozenset().union(*(each.named for each in comparisons))
    findings = [*error_findings(rows, defaults, named), *agreement_findings(pairs)]
    return {
        "scenes.csv": frame(SCENES, map(scene_row, comparisons)),
        "engines.csv": frame(ENGINES, engines),
        "runs.csv": frame(RUNS, rows),
        "vertex-errors.csv": vertex_error_table(runs),
        "error-over-time.csv": with_more(error_over_time_table(alone), frame(ERROR_OVER_TIME, over_time)),
        "members.csv": with_more(member_table(alone), frame(MEMBERS, worst)),
        "ensemble-errors.csv": frame(ENSEMBLE_ERRORS, map(ensemble_error_row, ensembles)),
        "agreement.csv": frame(AGREEMENT, pairs),
        "findings.csv": frame(FINDINGS, findings),
        **sensor_tables([run for comparison in comparisons for run in comparison.sensors]),
        "conditions.csv": frame(CONDITIONS, conditions(command)),
    }


def with_more(table: pd.DataFrame, more: pd.DataFrame) -> pd.DataFrame:
    """Return a table with more rows, if there are any."""
    return pd.concat([one for one in (table, more) if len(one)], ignore_index=True) if len(more) else table
