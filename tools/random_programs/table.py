"""The table of a run as CSV and as Markdown."""

import csv
import io
import json
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass, fields
from itertools import pairwise

import numpy as np

from tools.random_programs.program import SIGNIFICANT
from tools.random_programs.score import (
    CLASSES,
    FALSE_CORRECT,
    HITS,
    HONEST,
    NAMED,
    NOTHING,
    RIGHT,
    UNNAMED,
    WRONG,
)

SLOW_S = 3.0
# Two measurements of one error differ by less than this share of it and the rounding of the file.
NEAR = 0.02
WIDTHS = ((3, 10), (10, 100), (100, 1e3), (1e3, 1e4), (1e4, np.inf))
BINS = (0.0, 0.5, 0.7, 0.8, 0.85, 0.95, 1.0000001)


@dataclass(frozen=True)
class Row:
    """One program and its answer."""

    number: int
    scene: str
    kind: str
    assessed: str
    verdict: str
    true: str
    said: str
    alike: str
    engines: str
    error_over_noise: float
    max_error_m: float
    graded_error_m: float
    left_over_noise: float | None
    confidence: float | None
    cpu_s: float
    rows: int
    digits: int
    precision: str
    file: str
    method: str
    gyroscopic: str
    turning: str
    damping: str
    reading: str
    mistakes: str
    failure: str


def csv_text(rows: Iterable[Row]) -> str:
    """Return the rows as CSV."""
    out = io.StringIO()
    writer = csv.DictWriter(out, [field.name for field in fields(Row)], lineterminator="\n")
    writer.writeheader()
    writer.writerows({key: _cell(value) for key, value in asdict(row).items()} for row in rows)
    return out.getvalue()


def _cell(value: object) -> object:
    return f"{value:.6g}" if isinstance(value, float) else value


def read(text: str) -> list[Row]:
    """Return the rows of such a CSV."""
    kinds = {field.name: field.type for field in fields(Row)}

    def value(name: str, cell: str) -> object:
        kind = str(kinds[name])
        if "float" in kind:
            return float(cell) if cell else None
        return int(cell) if "int" in kind else cell

    return [Row(**{n: value(n, c) for n, c in row.items()}) for row in csv.DictReader(io.StringIO(text))]  # type: ignore[arg-type]


def markdown(rows: Sequence[Row], seed: int) -> str:
    """Return the page."""
    lines = [
        "# Random programs, and how `tumble grade` reads their files",
        "",
        f"{len(rows)} programs, seed {seed}: `python -m tools.random_programs --count {len(rows)} --seed {seed}`.",
        "Each is drawn from a grammar of schemes, mistakes, scenes and files that shares no code with Tumble.",
        "An effect is *visible* above 3 times the noise of its file (digits and precision), and *significant* above",
        "10 times.",
        "",
        *_summary(rows),
        "",
        "## By kind of file",
        "",
        *_classes(rows, "file", lambda row: [row.kind], (NOTHING, "faint", NAMED, UNNAMED)),
        "",
        "## By number of significant mistakes, in files where all have names",
        "",
        *_classes(_named(rows), "significant", lambda row: [str(len(_labels(row)))]),
        "",
        "## By mistake",
        "",
        "Files in which the mistake is significant; files with two mistakes count for both.",
        "",
        *_classes(_seen(rows), "mistake", lambda row: [label for label in _labels(row) if label in _planted(row)]),
        "",
        "## By scheme",
        "",
        "Files with a significant mistake.",
        "",
    ]
    for what in ("method", "gyroscopic", "turning", "damping", "reading"):
        lines += [*_classes(_seen(rows), what, lambda row, what=what: [getattr(row, what) or "none"]), ""]
    lines += ["## By file", ""]
    for what in ("digits", "precision", "file"):
        lines += [*_classes(_seen(rows), what, lambda row, what=what: [str(getattr(row, what))]), ""]
    lines += [*_classes(_seen(rows), "error over noise", lambda row: [_width(row)]), ""]
    lines += ["## Processor time", "", *_times(rows), ""]
    lines += ["## Confidence", "", *_reliability(rows), ""]
    lines += ["## Firmly wrong, and falsely correct", ""]
    lines += ["An explanation with a residual below the noise makes the same motion for another reason.", ""]
    lines += [*_listed(rows), "", "## Errors measured differently", "", *_measured_otherwise(rows)]
    return "\n".join(lines).rstrip() + "\n"


# --- parts of the page ----------------------------------------------------------------------------------------------


def _named(rows: Sequence[Row]) -> list[Row]:
    return [row for row in rows if row.kind == NAMED]


def _seen(rows: Sequence[Row]) -> list[Row]:
    return [row for row in rows if row.kind in (NAMED, UNNAMED)]


def _labels(row: Row) -> list[str]:
    """Return the significant mistakes of a file."""
    return json.loads(row.true)


def _planted(row: Row) -> list[str]:
    return json.loads(row.mistakes)


def _share(part: int, whole: int) -> str:
    return f"{part} of {whole} ({100 * part / whole:.1f} %)" if whole else "none drawn"


def _summary(rows: Sequence[Row]) -> list[str]:
    named, unnamed = _named(rows), [row for row in rows if row.kind == UNNAMED]
    right = sum(row.assessed == RIGHT for row in named)
    hits = sum(row.assessed in HITS for row in named)
    honest = sum(row.assessed in (HONEST, *HITS) for row in unnamed)
    nothing = [row for row in rows if row.kind == NOTHING]
    wrong = sum(row.assessed == WRONG for row in rows)
    fast = sum(row.cpu_s <= SLOW_S for row in rows)
    return [
        "| | measured | target |",
        "|---|---|---|",
        f"| with names: right | {_share(right, len(named))} | 90 % |",
        f"| with names: right, or among equally good explanations, or the same motion | {_share(hits, len(named))} | |",
        f"| without a name: honest (or the same motion) | {_share(honest, len(unnamed))} | 90 % |",
        f"| no visible mistake: called correct | {_share(sum(r.assessed == RIGHT for r in nothing), len(nothing))} | |",
        f'| false "correct" | {sum(row.assessed == FALSE_CORRECT for row in rows)} | 0 |',
        f"| firmly wrong | {_share(wrong, len(rows))} | at most 1 % |",
        f"| answers within {SLOW_S:g} s of processor time | {_share(fast, len(rows))} | 95 % |",
    ]


def _classes(
    rows: Sequence[Row], what: str, groups: Callable[[Row], list[str]], order: Sequence[str] = ()
) -> list[str]:
    """Return a table of the number of answers in each class, for each group."""
    counts: dict[str, Counter[str]] = {}
    for row in rows:
        for group in groups(row):
            counts.setdefault(group, Counter())[row.assessed] += 1
    used = [name for name in CLASSES if any(name in count for count in counts.values())]
    lines = [f"| {what} | files | " + " | ".join(used) + " |", "|---" * (2 + len(used)) + "|"]
    for group in [name for name in order if name in counts] or sorted(counts):
        cells = [str(counts[group][name] or "") for name in used]
        lines.append(f"| {group} | {sum(counts[group].values())} | " + " | ".join(cells) + " |")
    return lines


def _width(row: Row) -> str:
    low, high = next((pair for pair in WIDTHS if pair[0] <= row.error_over_noise < pair[1]), (0, 3))
    return f"{low:g} to {high:g}"


def _times(rows: Sequence[Row]) -> list[str]:
    lines = [
        "| answers | files | median [s] | 95 % within [s] | longest [s] | within 3 s |",
        "|---|---|---|---|---|---|",
    ]
    groups: dict[str, list[float]] = {"all": [row.cpu_s for row in rows]}
    for row in rows:
        groups.setdefault(row.assessed, []).append(row.cpu_s)
    for name in ("all", *(name for name in CLASSES if name in groups)):
        times = np.array(groups[name])
        figures = f"{np.median(times):.1f} | {np.quantile(times, 0.95):.1f} | {times.max():.1f}"
        lines.append(f"| {name} | {len(times)} | {figures} | {100 * (times <= SLOW_S).mean():.0f} % |")
    return lines


def _reliability(rows: Sequence[Row]) -> list[str]:
    """Return how often answers are right, by their confidence."""
    given = [(row.confidence, row) for row in rows if row.confidence is not None]
    if not given:
        return ["Answers have no `confidence`."]
    lines = ["| confidence | answers | mean | right |", "|---|---|---|---|"]
    for low, high in pairwise(BINS):
        some = [(confidence, row.assessed in HITS) for confidence, row in given if low <= confidence < high]
        if some:
            mean, hits = np.mean(some, axis=0)
            lines.append(f"| {low:g} to {min(high, 1):g} | {len(some)} | {mean:.2f} | {100 * hits:.0f} % |")
    return lines


def _listed(rows: Sequence[Row]) -> list[str]:
    lines = ["| program | scene | answer | true | said | residual over noise |", "|---|---|---|---|---|---|"]
    for row in rows:
        if row.assessed in (WRONG, FALSE_CORRECT):
            true = "; ".join(_labels(row)) or row.kind
            left = "" if row.left_over_noise is None else f"{row.left_over_noise:.2g}"
            said = row.said or row.verdict
            lines.append(f"| {row.number} | {row.scene} | {row.assessed} | {true} | {said} | {left} |")
    return lines


def _measured_otherwise(rows: Sequence[Row]) -> list[str]:
    """Return the files for which the command and this package measure different largest errors."""
    lines = []
    for row in rows:
        noise = row.max_error_m / row.error_over_noise if row.error_over_noise else 0.0
        if not row.failure and abs(row.graded_error_m - row.max_error_m) > NEAR * row.max_error_m + SIGNIFICANT * noise:
            lines.append(f"- program {row.number}, {row.scene}: {row.graded_error_m:.3g} m for {row.max_error_m:.3g} m")
    return lines or ["None: `tumble grade` and this package agree on the error of every file."]
