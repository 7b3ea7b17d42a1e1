"""The table of a run as CSV and as Markdown."""

import csv
import io
import json
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass, fields
from itertools import pairwise

import numpy as np

from tools.random_programs.program import DIGITS, MEASUREMENT
from tools.random_programs.score import (
    CLASSES,
    FAINT,
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
NOISES = ("none", "1e-05 to 0.0001", "0.0001 to 0.001")
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
    noise: float
    noise_m: float
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
        f"An effect is *visible* above {DIGITS.seen:g} times what digits and precision leave open, and *significant*",
        f"above {DIGITS.significant:g} times. Files with noise are measured as by motion capture, with a standard",
        "deviation of 1e-5 to 1e-3 of the body's size; there a mistake is significant, and counts as planted, if it",
        f"moves the vertices by more than {MEASUREMENT.significant:g} times the noise (root mean square).",
        "",
        *summary(rows),
        "",
        "## By kind of file",
        "",
        *_classes(rows, "file", lambda row: [row.kind], (NOTHING, FAINT, NAMED, UNNAMED)),
        "",
        "With noise:",
        "",
        *_classes(of_noise(rows, True), "file", lambda row: [row.kind], (NOTHING, FAINT, NAMED, UNNAMED)),
        "",
        "## By number of significant mistakes, in files where all have names",
        "",
        *_classes(named(rows), "significant", lambda row: [str(len(labels(row)))]),
        "",
        "## By mistake",
        "",
        "Files in which the mistake is significant; files with two mistakes count for both.",
        "",
        *_classes(_seen(rows), "mistake", lambda row: [label for label in labels(row) if label in _planted(row)]),
        "",
        "## By scheme",
        "",
        "Files with a significant mistake.",
        "",
    ]
    for what in ("method", "gyroscopic", "turning", "damping", "reading"):
        lines += [*_classes(_seen(rows), what, lambda row, what=what: [getattr(row, what) or "none"]), ""]
    lines += ["## By file", ""]
    lines += [*_classes(_seen(rows), "noise over size", lambda row: [_noise(row)], NOISES), ""]
    for what in ("digits", "precision", "file"):
        lines += [*_classes(_seen(rows), what, lambda row, what=what: [str(getattr(row, what))]), ""]
    lines += [*_classes(_seen(rows), "error over noise", lambda row: [_width(row)]), ""]
    lines += ["## Processor time", "", *_times(rows), ""]
    lines += ["## Confidence", "", *reliability(rows), ""]
    lines += ["## Firmly wrong, and falsely correct", ""]
    lines += ["An explanation with a residual below the noise makes the same motion for another reason.", ""]
    lines += [*listed(rows), "", "## Errors measured differently", "", *_measured_otherwise(rows)]
    return "\n".join(lines).rstrip() + "\n"


# --- parts of the page ----------------------------------------------------------------------------------------------


def named(rows: Sequence[Row]) -> list[Row]:
    """Return the files whose significant mistakes all have names."""
    return [row for row in rows if row.kind == NAMED]


def _seen(rows: Sequence[Row]) -> list[Row]:
    return [row for row in rows if row.kind in (NAMED, UNNAMED)]


def labels(row: Row) -> list[str]:
    """Return the significant mistakes of a file."""
    return json.loads(row.true)


def _planted(row: Row) -> list[str]:
    return json.loads(row.mistakes)


def share(part: int, whole: int) -> str:
    """Return a number of files, and which share they are."""
    return f"{part} of {whole} ({100 * part / whole:.1f} %)" if whole else "none drawn"


def of_noise(rows: Sequence[Row], is_measured: bool) -> list[Row]:
    """Return the files with measurement noise, or those without."""
    return [row for row in rows if bool(row.noise) == is_measured]


def summary(rows: Sequence[Row]) -> list[str]:
    """Return the figures of files with digits alone, of those with noise, and of all."""
    groups = (of_noise(rows, False), of_noise(rows, True), rows)
    lines = ["| | digits alone | with noise | all | target |", "|---|---|---|---|---|"]
    for (what, target), *cells in zip(FIGURES, *map(_figures, groups), strict=True):
        lines.append(f"| {what} | {' | '.join(cells)} | {target} |")
    return lines


FIGURES = (
    ("programs", ""),
    ("with names: right", "90 %"),
    ("with names: right, or among equally good explanations, or the same motion", ""),
    ("without a name: honest (or the same motion)", "90 %"),
    ("no visible mistake: called correct", ""),
    ('false "correct"', "0"),
    ("firmly wrong", "at most 1 %"),
    (f"answers within {SLOW_S:g} s of processor time", "95 %"),
)


def _figures(rows: Sequence[Row]) -> list[str]:
    known, unnamed = named(rows), [row for row in rows if row.kind == UNNAMED]
    nothing = [row for row in rows if row.kind == NOTHING]
    return [
        str(len(rows)),
        share(sum(row.assessed == RIGHT for row in known), len(known)),
        share(sum(row.assessed in HITS for row in known), len(known)),
        share(sum(row.assessed in (HONEST, *HITS) for row in unnamed), len(unnamed)),
        share(sum(row.assessed == RIGHT for row in nothing), len(nothing)),
        str(sum(row.assessed == FALSE_CORRECT for row in rows)),
        share(sum(row.assessed == WRONG for row in rows), len(rows)),
        share(sum(row.cpu_s <= SLOW_S for row in rows), len(rows)),
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


def _noise(row: Row) -> str:
    if not row.noise:
        return NOISES[0]
    return NOISES[1] if row.noise < 1e-4 else NOISES[2]


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


def reliability(rows: Sequence[Row]) -> list[str]:
    """Return how often answers are right, by their confidence."""
    lines = ["| files | confidence | answers | mean | right |", "|---|---|---|---|---|"]
    for what, is_measured in (("digits alone", False), ("with noise", True)):
        given = [(row.confidence, row) for row in of_noise(rows, is_measured) if row.confidence is not None]
        for low, high in pairwise(BINS):
            some = [(confidence, row.assessed in HITS) for confidence, row in given if low <= confidence < high]
            if some:
                mean, hits = np.mean(some, axis=0)
                figures = f"{len(some)} | {mean:.2f} | {100 * hits:.0f} %"
                lines.append(f"| {what} | {low:g} to {min(high, 1):g} | {figures} |")
    return lines if len(lines) > 2 else ["Answers have no `confidence`."]


def listed(rows: Sequence[Row]) -> list[str]:
    """Return the answers that are firmly wrong, and the wrong files called correct."""
    heads = ("program", "scene", "noise", "answer", "true", "said", "residual over noise")
    lines = ["| " + " | ".join(heads) + " |", "|---" * len(heads) + "|"]
    for row in rows:
        if row.assessed in (WRONG, FALSE_CORRECT):
            true = "; ".join(labels(row)) or row.kind
            left = "" if row.left_over_noise is None else f"{row.left_over_noise:.2g}"
            said = row.said or row.verdict
            noise = f"{row.noise:g}" if row.noise else "none"
            lines.append(f"| {row.number} | {row.scene} | {noise} | {row.assessed} | {true} | {said} | {left} |")
    return lines


def _measured_otherwise(rows: Sequence[Row]) -> list[str]:
    """Return the files for which the command and this package measure different largest errors."""
    lines = []
    for row in rows:
        allowed_m = NEAR * row.max_error_m + DIGITS.significant * row.noise_m
        if not row.failure and abs(row.graded_error_m - row.max_error_m) > allowed_m:
            lines.append(f"- program {row.number}, {row.scene}: {row.graded_error_m:.3g} m for {row.max_error_m:.3g} m")
    return lines or ["None: `tumble grade` and this package agree on the error of every file."]
