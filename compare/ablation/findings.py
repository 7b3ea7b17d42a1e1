"""The findings of an ablation."""

from collections.abc import Iterable, Iterator

from tumble.compare.ablation.schemas import EVERYTHING, AblationRow
from tumble.compare.tables.shared import FindingRow

LEAST_NS = 1.0  # below a nanosecond per step no time is that of a step


def ablation_findings(rows: Iterable[AblationRow]) -> Iterator[FindingRow]:
    """Yield, for each scene, the contestant whose step gains most from switching features off, and the ratio.

    Parameters
    ----------
    rows : rows of ablation.csv

    Returns
    -------
    rows of findings.csv
    """
    scenes: dict[str, list[tuple[float, AblationRow]]] = {}
    for row in rows:
        steps = (row.cpu_ns_per_step_without or 0.0) >= LEAST_NS
        if row.feature == EVERYTHING and row.ratio is not None and steps:
            scenes.setdefault(row.scene, []).append((row.ratio, row))
    for scene, own in scenes.items():
        ratio, row = max(own, key=lambda one: one[0])
        yield FindingRow(
            finding="feature overhead", scene=scene, engine=row.engine, method=row.method, value=ratio, unit="1"
        )
