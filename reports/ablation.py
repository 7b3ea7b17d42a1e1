"""What `tumble ablate` prints: the cost of features that a scene does not need."""

import math
from collections.abc import Iterator, Sequence

from rich.console import RenderableType
from rich.constrain import Constrain
from rich.text import Text

from tumble.compare.ablation.optional_features import EVERYTHING, Ablation, AblationRow
from tumble.reports.rows import contestant
from tumble.reports.terminal import columns, plain, reasons_text


def others(rows: Sequence[AblationRow]) -> Iterator[Constrain]:
    """Yield the contestants without figures, with the features and the reason."""
    features: dict[tuple[str, str], list[str]] = {}
    for row in rows:
        if row.ratio is None:
            features.setdefault((contestant(row), row.why), []).extend(filter(None, [row.feature]))
    return reasons_text((name, f"{', '.join(own)}: {why}" if own else why) for (name, why), own in features.items())


def motion(row: AblationRow) -> str:
    """Return the difference of the two motions."""
    if row.max_difference_m is None:
        return ""
    return f"{row.max_difference_m:.1e} m apart" if row.max_difference_m else "identical"


def times(ratio: float | None) -> str:
    """Return a ratio in few digits."""
    if ratio is None:
        return ""
    return f"{ratio:.0f}" if ratio >= 100 else f"{ratio:.2f}"


def band(row: AblationRow) -> str:
    """Return the confidence interval of a ratio."""
    return "" if row.ratio is None else f"{times(row.ratio_low)}-{times(row.ratio_high)}"


def ablation_text(ablation: Ablation) -> Iterator[RenderableType]:
    """Yield what `tumble ablate` prints of one scene.

    Parameters
    ----------
    ablation : the results of the scene

    Yields
    ------
    title, table of times per step [ns], contestants without figures, contestants whose motions differ
    """
    yield plain(f"{ablation.scene.name}: {ablation.scene.title}")
    limit = "no reference solution" if ablation.resolution_m is None else f"resolution {ablation.resolution_m:.1e} m"
    yield plain(f"time per step with and without features the scene does not need; {limit}")
    table = columns("contestant", "with [ns]", "without", "ratio", "95 % interval", "motion", right=range(1, 4))
    named = {contestant(row) for row in ablation.rows if row.feature == EVERYTHING}
    for row in ablation.rows:
        if row.max_difference_m is not None:
            whose = "  with" if contestant(row) in named else f"{contestant(row)} with"
            table.add_row(
                plain(contestant(row) if row.feature == EVERYTHING else f"{whose} {row.feature}"),
                step_ns(row.cpu_ns_per_step_with),
                step_ns(row.cpu_ns_per_step_without),
                times(row.ratio),
                band(row),
                motion(row),
            )
    if table.row_count:
        yield table
    yield from others(ablation.rows)
    if ablation.inexact:
        names = ", ".join(dict.fromkeys(map(contestant, ablation.inexact)))
        yield plain(f"motions differ by more than the resolution, with equal errors: {names}")
    yield Text()


def step_ns(ns: float | None) -> str:
    """Return the time of a step in whole nanoseconds, or in as many digits as a shorter one needs."""
    if ns is None:
        return ""
    return f"{ns:.0f}" if ns >= 100 or ns == 0 else f"{ns:.{max(0, 2 - math.floor(math.log10(ns)))}f}"
