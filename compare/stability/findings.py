"""What maps of stability and extreme cases found: the numbers of their sentences."""

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence

from tumble.compare.judge.verdict import SILENT
from tumble.compare.stability.schemas import ExtremeRow, LimitRow
from tumble.compare.tables.shared import FindingRow

NEAR = 0.05  # of theory's limit: a measured one that is not as near is another


def limit_findings(limits: Sequence[LimitRow]) -> Iterator[FindingRow]:
    """Yield, scene by scene, who of those with a limit bears the longest step and who the shortest; then theory's part.

    That is how many limits have one by theory, neither 0 nor infinite, and how many of those are near it.
    """
    scenes: dict[str, list[LimitRow]] = {}
    for row in limits:
        if row.w_dt_limit and math.isfinite(row.w_dt_limit):
            scenes.setdefault(row.scene, []).append(row)
    for scene, own in scenes.items():
        for finding, pick in (("longest step", max), ("shortest step", min)):
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
        yield FindingRow(finding="limits as in theory", value=near, unit="1")


def extreme_findings(rows: Iterable[ExtremeRow]) -> Iterator[FindingRow]:
    """Yield how many extreme cases there are, and for each contestant in how many it failed silently, if in any."""
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
