"""What leaving out pays, as text and as a short section of the page."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from rich.table import Table
from rich.text import Text

from compare.ablation.ablation import EVERYTHING, Ablation, AblationRow
from compare.comparison.results import SceneRow
from reports.numerals import TIMES, figure, listed
from reports.rows import Tables, contestant
from reports.terminal import columns, plain


@dataclass(frozen=True)
class Line:
    """One contestant: a step with everything and with only what is needed [ns], their ratio, its band, and the motion.

    features: what each is worth by itself, those that can be told from nothing.
    """

    contestant: str
    with_ns: str
    without_ns: str
    ratio: str
    band: str
    motion: str
    features: list[str]


@dataclass(frozen=True)
class Section:
    """One scene's ablation; others: who has no figures, and why."""

    scene: SceneRow
    finding: str
    lines: list[Line]
    others: list[str]


def section(tables: Tables) -> Section | None:
    """Return the section, or None where nothing was left out by anybody."""
    rows = tables.ablation
    if not any(row.feature == EVERYTHING for row in rows):
        return None
    scene = next(scene for scene in tables.scenes if scene.scene == rows[0].scene)
    lines = [line(row, rows) for row in rows if row.feature == EVERYTHING and row.ratio is not None]
    return Section(scene, finding(rows), lines, others(rows))


def line(row: AblationRow, rows: Sequence[AblationRow]) -> Line:
    """Return the line of one contestant, whose row of everything this is."""
    own = [each for each in rows if contestant(each) == contestant(row) and each.feature != EVERYTHING]
    told = sorted((each for each in own if tells(each)), key=lambda each: -(each.ratio or 0.0))
    return Line(
        contestant(row),
        figure(row.cpu_ns_per_step_with or 0.0),
        figure(row.cpu_ns_per_step_without or 0.0),
        times(row.ratio),
        band(row),
        motion(row),
        [f"{each.feature} {TIMES} {times(each.ratio)}" for each in told],
    )


def tells(row: AblationRow) -> bool:
    """Whether the feature costs something, as 95 runs in 100 say."""
    return row.ratio_low is not None and row.ratio_low > 1


def finding(rows: Sequence[AblationRow]) -> str:
    """Return who saves most by leaving everything out."""
    told = [row for row in rows if row.feature == EVERYTHING and tells(row)]
    most = max(told, key=lambda row: row.ratio or 0.0, default=None)
    if most is None:
        return "Nobody's step is measurably cheaper for what is left out."
    return f"{contestant(most)} saves most: with everything its step takes {times(most.ratio)} times as long."


def others(rows: Sequence[AblationRow]) -> list[str]:
    """Return who has no figures, by reason."""
    reasons: dict[str, list[str]] = {}
    for row in rows:
        if row.ratio is None:
            reasons.setdefault(": ".join(filter(None, (row.feature, row.why))), []).append(contestant(row))
    return [f"{listed(names)}: {why}" for why, names in reasons.items()]


def motion(row: AblationRow) -> str:
    """Return how far the two motions are apart."""
    if row.max_difference_m is None:
        return ""
    return f"{figure(row.max_difference_m, 2)} m apart" if row.max_difference_m else "same bits"


def times(ratio: float | None) -> str:
    """Return a ratio as people say it."""
    if ratio is None:
        return ""
    return f"{ratio:.0f}" if ratio >= 100 else f"{ratio:.2f}"


def band(row: AblationRow) -> str:
    """Return the spread of a ratio."""
    return "" if row.ratio is None else f"{times(row.ratio_low)}-{times(row.ratio_high)}"


def ablation_text(ablation: Ablation) -> Iterator[Table | Text]:
    """Yield what `tumble ablate` prints of one scene."""
    yield plain(f"{ablation.scene.name}: {ablation.scene.title}")
    limit = "the scene has no truth" if ablation.limit_m is None else f"the truth's limit is {ablation.limit_m:.1e} m"
    yield plain(f"time of a step with what the scene has no use for, and without; {limit}")
    table = columns("contestant", "with [ns]", "without", "ratio", "95 in 100", "motion", right=range(1, 4))
    for row in ablation.rows:
        if row.ratio is not None:
            table.add_row(
                plain(contestant(row) if row.feature == EVERYTHING else f"  with {row.feature}"),
                step_ns(row.cpu_ns_per_step_with),
                step_ns(row.cpu_ns_per_step_without),
                times(row.ratio),
                band(row),
                motion(row),
            )
    if table.row_count:
        yield table
    yield from map(plain, others(ablation.rows))
    if ablation.inexact:
        names = listed(list(dict.fromkeys(map(contestant, ablation.inexact))))
        yield plain(f"further apart than that, but no further from the truth: {names}")
    yield Text()


def step_ns(ns: float | None) -> str:
    """Return the time of a step in whole nanoseconds, or in as many digits as a shorter one needs."""
    if ns is None:
        return ""
    return f"{ns:.0f}" if ns >= 100 or ns == 0 else f"{ns:.{max(0, 2 - math.floor(math.log10(ns)))}f}"
