"""Folders of tables that a command wrote, as the tables of a page; and what changed from one folder to another."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pandas as pd

from tumble.compare.comparison.findings import error_findings
from tumble.compare.releases.schemas import RELEASES
from tumble.compare.stability.findings import extreme_findings, limit_findings
from tumble.compare.stability.schemas import EXTREMES, LIMITS
from tumble.compare.tables.frames import frame, read_tables, rows
from tumble.compare.tables.known import SWEEP
from tumble.compare.tables.schema import BadTable
from tumble.compare.tables.shared import FINDINGS, RUNS

CONTESTANT = ["scene", "engine", "method"]
# Tables of a sweep, which has many runs of a contestant: its runs are kept apart from those at the scenes' own steps.
SWEPT = ("work-precision.csv", "accuracy-cost.csv", "orders.csv", "ensembles.csv", "equivalent.csv", "timing.csv")
ERRORS = ["max_error_m", "resolution_m", "status"]


def gathered(folder: Path) -> dict[str, pd.DataFrame]:
    """Return the tables in a folder, whichever command wrote them.

    Parameters
    ----------
    folder : folder that `-o` wrote

    Returns
    -------
    table by file name

    Raises
    ------
    BadTable : the folder does not exist, or its tables are not Tumble's
    OSError : a file cannot be read
    """
    if not folder.is_dir():
        raise BadTable(f"{folder}: no such folder; give --from a folder that -o wrote")
    return completed(read_tables(folder), str(folder))


def completed(tables: Mapping[str, pd.DataFrame], shown: str = "these tables") -> dict[str, pd.DataFrame]:
    """Return a command's tables as those of a page.

    Parameters
    ----------
    tables : table by file name
    shown : what refusals call them

    Returns
    -------
    table by file name, with findings

    Raises
    ------
    BadTable : the page shows none of them
    """
    found = dict(tables)
    if found.keys() & {*SWEPT}:
        return {(SWEEP if name in (*SWEPT, "runs.csv") else "") + name: table for name, table in found.items()}
    if "cells.csv" in found:
        found |= of_record(found["cells.csv"], found["questions.csv"])
    if FINDINGS.file not in found:  # a record of check, unfinished maps, or tables of an older release
        findings = list(error_findings(rows(RUNS, found["runs.csv"]))) if RUNS.file in found else []
        findings += limit_findings(rows(LIMITS, found[LIMITS.file])) if LIMITS.file in found else []
        findings += extreme_findings(rows(EXTREMES, found[EXTREMES.file])) if EXTREMES.file in found else []
        found[FINDINGS.file] = frame(FINDINGS, findings)
    if not found.keys() & {RUNS.file, LIMITS.file, EXTREMES.file, RELEASES.file}:
        raise BadTable(f"{shown}: has no tables of report, compare, sweep, stability, releases or check")
    return found


def of_record(cells: pd.DataFrame, questions: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """Return the runs and scenes of a record of `tumble check`."""
    steps = questions.filter(["scene", "step_s"]).rename(columns={"step_s": "dt_s"})
    scenes = questions.filter(["scene", "step_s", "samples", "truth"]).assign(
        title="",
        source="",
        needs="",
        duration_s=np.nan,
        bound_m=questions["resolution_m"],
        input_error_m=questions["resolution_m"],
        horizon_s=np.nan,
    )
    runs = cells.merge(steps, on="scene").reindex(columns=RUNS.names)  # a record has no tolerance and no wall time
    return {"runs.csv": runs, "scenes.csv": scenes}


def changes(before: Mapping[str, pd.DataFrame], after: Mapping[str, pd.DataFrame]) -> dict[str, pd.DataFrame]:
    """Return the runs whose status or error changed, and the conditions that changed.

    Parameters
    ----------
    before : earlier tables, by file name
    after : later tables, by file name

    Returns
    -------
    changed-runs.csv and changed-conditions.csv, by file name

    Raises
    ------
    BadTable : runs.csv is missing before or after
    """
    if not all("runs.csv" in tables for tables in (before, after)):
        raise BadTable("both folders must have runs.csv, as `tumble report` and `tumble compare -o` write it")
    runs = pd.merge(
        before["runs.csv"].filter([*CONTESTANT, *ERRORS]),
        after["runs.csv"].filter([*CONTESTANT, *ERRORS]),
        on=CONTESTANT,
        how="outer",
        suffixes=("_before", "_after"),
        sort=False,
    ).fillna({"status_before": "not there", "status_after": "not there"})
    errors = runs.filter(["max_error_m_before", "max_error_m_after"]).to_numpy(dtype=float)
    limit = np.nan_to_num(runs.filter(["resolution_m_before", "resolution_m_after"]).to_numpy(dtype=float)).max(axis=1)
    lifted = np.fmax(errors, limit[:, None])
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(np.isnan(errors).any(axis=1), np.nan, lifted[:, 1] / lifted[:, 0])
    other = (runs["status_before"] != runs["status_after"]).to_numpy() | (~np.isnan(ratio) & (ratio != 1.0))
    found = runs.assign(ratio=ratio).loc[other]
    conditions = pd.merge(
        before.get("conditions.csv", NOTHING), after.get("conditions.csv", NOTHING),
        on="what", how="outer", suffixes=("_before", "_after"), sort=False,
    ).fillna("")  # fmt: skip
    return {
        "changed-runs.csv": found,
        "changed-conditions.csv": conditions.loc[(conditions["value_before"] != conditions["value_after"]).to_numpy()],
    }


NOTHING = pd.DataFrame({"what": pd.Series(dtype="str"), "value": pd.Series(dtype="str")})
