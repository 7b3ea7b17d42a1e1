"""What an ablation found: the numbers of its sentences."""

from collections.abc import Iterable, Iterator

from tumble.compare.ablation.schemas import EVERYTHING, AblationRow
from tumble.compare.tables.shared import FindingRow

LEAST_NS = 1.0  # under a nanosecond a step no time is a step's


def ablation_findings(rows: Iterable[AblationRow]) -> Iterator[FindingRow]:
    """Yield, scene by scene, whose step would be longest, over its own, if it left nothing out."""
    scenes: dict[str, list[tuple[float, AblationRow]]] = {}
    for row in rows:
        steps = (row.cpu_ns_per_step_without or 0.0) >= LEAST_NS
        if row.feature == EVERYTHING and row.ratio is not None and steps:
            scenes.setdefault(row.scene, []).append((row.ratio, row))
    for scene, own in scenes.items():
        ratio, row = max(own, key=lambda one: one[0])
        yield FindingRow(finding="left out", scene=scene, engine=row.engine, method=row.method, value=ratio, unit="1")
