"""The findings of stability maps and extreme cases."""

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence

from tumble.compare.judge.verdict import SILENT
from tumble.compare.stability.schemas import ExtremeRow, LimitRow
from tumble.compare.tables.shared import FindingRow

NEAR = 0.05  # relative distance from theory's limit up to which a measured one matches


def limit_findings(limits: Sequence[LimitRow]) -> Iterator[FindingRow]:
    """Yield, for each scene, the largest and the smallest stable step; then the agreement with theory.

    Parameters
    ----------
    limits : rows of limits.csv

    Returns
    -------
    rows of findings.csv; the last two are the number of limits with a finite one by theory, and of those that match it
    """
    scenes: dict[str, list[LimitRow]] = {}
    for row in limits:
        if row.w_dt_limit and math.isfinite(row.w_dt_limit):
            scenes.setdefault(row.scene, []).append(row)
    for scene, own in scenes.items():
        for finding, pick in (("largest stable step", max), ("smallest stable step", min)):
            row = pick(own, key=lambda row: row.w_dt_limit or 0.0)
            yield FindingRow(
                finding=finding,
                scene=scene,
                engine=row.engine,
                method=row.method,
                value=row.w_dt_limit,
                unit="rad",
            )
    known = [row for row in limits if row.w_dt_limit is not None and row.theory_w_dt and math.isfinite(row.theory_w_dt)]
    if known:
        near = sum(abs((row.w_dt_limit or 0.0) / (row.theory_w_dt or 1.0) - 1) <= NEAR for row in known)
        yield FindingRow(finding="limits with theory", value=len(known), unit="1")
        yield FindingRow(finding="limits matching theory", value=near, unit="1")


def extreme_findings(rows: Iterable[ExtremeRow]) -> Iterator[FindingRow]:
    """Yield the number of extreme cases, and of silent failures of each contestant that has any.

    Parameters
    ----------
    rows : rows of extremes.csv

    Returns
    -------
    rows of findings.csv
    """
    rows = list(rows)
    if rows:
        yield FindingRow(
            finding="extreme cases",
            value=len({row.scene for row in rows}),
            unit="1",
        )
    silent = Counter((row.engine, row.method) for row in rows if row.verdict in SILENT)
    for (engine, method), count in silent.most_common():
        yield FindingRow(finding="silent failures", engine=engine, method=method, value=count, unit="1")
