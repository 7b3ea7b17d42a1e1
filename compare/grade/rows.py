"""The tables of a grade, one row type a table: what `tumble grade -o` writes."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from compare.grade.residual import BINS
from compare.grade.verdict import Grade
from compare.run.provenance import ConditionRow, conditions
from compare.tables.rows import table_text, xyz


@dataclass(frozen=True)
class GradeRow:
    """One file: errors over all rows and vertices, what they are held against, drifts where known, and the verdict."""

    file: str
    scene: str
    read_as: str
    rows: int
    throws: int
    verdict: str
    max_error_m: float
    at_t_s: float
    at_vertex: int
    rms_error_m: float
    final_error_m: float
    limit_m: float
    digits_m: float
    energy_drift: float | None
    momentum_drift: float | None
    angular_momentum_drift: float | None
    by_differences: bool


@dataclass(frozen=True)
class ExplanationRow:
    """One explanation: `best` by so many of its mistakes, or one that fits alike; what it leaves of the rows kept."""

    file: str
    explanation: str
    mistakes: int
    what: str
    max_left_m: float
    rms_left_m: float
    weight: float


@dataclass(frozen=True)
class PartRow:
    """The largest error in one of equal parts of the duration, over all rows, throws and vertices."""

    file: str
    from_s: float
    to_s: float
    max_error_m: float


@dataclass(frozen=True)
class KeptRow:
    """One vertex at one of the rows kept of the throw that is diagnosed."""

    file: str
    scene: str
    throw: int
    t_s: float
    vertex: int
    true_x_m: float
    true_y_m: float
    true_z_m: float
    x_m: float
    y_m: float
    z_m: float
    error_x_m: float
    error_y_m: float
    error_z_m: float
    error_m: float


def grade_row(grade: Grade) -> GradeRow:
    """Return the row of one file."""
    m = grade.measured
    return GradeRow(
        grade.file,
        grade.scene.name,
        m.shown.kind,
        m.rows,
        m.throws,
        grade.verdict,
        m.worst_m,
        m.worst_t_s,
        m.worst_vertex,
        m.rms_m,
        m.final_m,
        m.limit_m,
        m.half_m,
        *(m.drifts or (None, None, None)),
        m.by_differences,
    )


def explanation_rows(grade: Grade) -> Iterator[ExplanationRow]:
    """Yield how the best explanation comes about, and then those that fit alike."""
    if grade.diagnosis is None:
        return
    named = [("best", each) for each in grade.diagnosis.steps] + [("alike", each) for each in grade.diagnosis.alike]
    for name, each in named:
        what = "; ".join(mistake.said for mistake in each.mistakes) or "nothing wrong"
        yield ExplanationRow(grade.file, name, len(each.mistakes), what, each.max_m, each.rms_m, each.weight)


def part_rows(grade: Grade) -> Iterator[PartRow]:
    """Yield the parts of the duration that have rows."""
    edges = np.linspace(0, grade.scene.duration, BINS + 1)
    for begin, end, error_m in zip(edges, edges[1:], grade.measured.over_time_m, strict=False):
        if np.isfinite(error_m):
            yield PartRow(grade.file, float(begin), float(end), float(error_m))


def kept_rows(grade: Grade) -> Iterator[KeptRow]:
    """Yield the rows kept, by instant and vertex."""
    kept, vertices = grade.measured.kept, grade.measured.shown.vertices
    for (row, number), distance in np.ndenumerate(np.linalg.norm(kept.vertices - kept.true, axis=-1)):
        true, seen = kept.true[row, number], kept.vertices[row, number]
        key = grade.file, grade.scene.name, grade.measured.throw, float(kept.times[row]), vertices[number]
        yield KeptRow(*key, *xyz(true), *xyz(seen), *xyz(seen - true), float(distance))


def grade_tables(grade: Grade, command: str) -> dict[str, str]:
    """Return file name -> CSV text of every table of a grade."""
    return {
        "grade.csv": table_text(GradeRow, [grade_row(grade)]),
        "explanations.csv": table_text(ExplanationRow, explanation_rows(grade)),
        "error-over-time.csv": table_text(PartRow, part_rows(grade)),
        "vertex-errors.csv": table_text(KeptRow, kept_rows(grade)),
        "conditions.csv": table_text(ConditionRow, conditions(command)),
    }
