"""The tables of a grade: what `tumble grade -o` writes."""

from collections.abc import Iterator

import numpy as np
import pandas as pd

from tumble.compare.grade.grade import Grade
from tumble.compare.grade.measure.errors import BINS
from tumble.compare.grade.results import diagnosis_rows
from tumble.compare.grade.schemas import (
    DIAGNOSIS,
    EXPLANATIONS,
    GRADE,
    PARTS,
    VERTICES,
    ExplanationRow,
    GradeRow,
    KeptRow,
    PartRow,
)
from tumble.compare.run.provenance import conditions
from tumble.compare.tables.frames import frame
from tumble.compare.tables.runs import xyz
from tumble.compare.tables.shared import CONDITIONS


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
        m.resolution_m,
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


def grade_tables(grade: Grade, command: str) -> dict[str, pd.DataFrame]:
    """Return every table of a grade by file name."""
    return {
        "grade.csv": frame(GRADE, [grade_row(grade)]),
        "diagnosis.csv": frame(DIAGNOSIS, diagnosis_rows(grade)),
        "explanations.csv": frame(EXPLANATIONS, explanation_rows(grade)),
        "grade-parts.csv": frame(PARTS, part_rows(grade)),
        "grade-vertices.csv": frame(VERTICES, kept_rows(grade)),
        "conditions.csv": frame(CONDITIONS, conditions(command)),
    }
