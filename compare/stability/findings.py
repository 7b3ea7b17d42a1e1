"""What maps of stability found: the numbers of their sentences."""

import math
from collections.abc import Iterable, Iterator

from compare.stability.schemas import LimitRow
from compare.tables.shared import FindingRow


def stability_findings(limits: Iterable[LimitRow]) -> Iterator[FindingRow]:
    """Yield, scene by scene, who of those with a limit bears the longest step and who the shortest."""
    scenes: dict[str, list[LimitRow]] = {}
    for row in limits:
        if row.w_dt_limit and math.isfinite(row.w_dt_limit):
            scenes.setdefault(row.scene, []).append(row)
    for scene, own in scenes.items():
        for finding, pick in (("longest step", max), ("shortest step", min)):
            row = pick(own, key=lambda row: row.w_dt_limit or 0.0)
            yield FindingRow(finding, scene, row.engine, row.method, "", row.w_dt_limit, "rad")
