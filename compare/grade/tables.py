"""The tables that `tumble grade -o` writes."""

from collections.abc import Iterator

import numpy as np
import pandas as pd

from tumble.compare.grade.file_grade import FileGrade
from tumble.compare.grade.grade import Grade
from tumble.compare.grade.measure.errors import BINS
from tumble.compare.grade.measure.readings import MOST_ROWS
from tumble.compare.grade.results import (
    contact_diagnosis_rows,
    contact_rows,
    diagnosis_rows,
    sensor_diagnosis_rows,
    sensor_grade_rows,
)
from tumble.compare.grade.schemas import (
    CONTACT_DIAGNOSIS,
    CONTACT_GRADE,
    DIAGNOSIS,
    EXPLANATIONS,
    GRADE,
    PARTS,
    READINGS,
    SENSOR_DIAGNOSIS,
    SENSOR_GRADE,
    VERTICES,
    ExplanationRow,
    GradeRow,
    PartRow,
    ReadingRow,
    SampleRow,
)
from tumble.compare.grade.sensor_grade import SensorGrade
from tumble.compare.run.provenance import conditions
from tumble.compare.tables.frames import frame
from tumble.compare.tables.runs import vector_columns
from tumble.compare.tables.shared import CONDITIONS


def grade_row(grade: Grade) -> GradeRow:
    """Return the row of one file."""
    m = grade.measured
    energy, momentum, angular_momentum = m.drifts or (None, None, None)
    return GradeRow(
        file=grade.file,
        scene=grade.scene.name,
        read_as=m.description.kind,
        rows=m.rows,
        members=m.throws,
        verdict=grade.verdict,
        max_error_m=m.worst_m,
        at_t_s=m.worst_t_s,
        at_vertex=m.worst_vertex,
        rms_error_m=m.rms_m,
        final_error_m=m.final_m,
        resolution_m=m.resolution_m,
        print_precision_m=m.half_m,
        energy_drift=energy,
        momentum_drift=momentum,
        angular_momentum_drift=angular_momentum,
        by_differences=m.by_differences,
    )


def explanation_rows(grade: Grade) -> Iterator[ExplanationRow]:
    """Yield the best explanation with more and more of its mistakes, and then those that fit equally well."""
    if grade.diagnosis is None:
        return
    named = [("best", each) for each in grade.diagnosis.steps] + [("alike", each) for each in grade.diagnosis.alike]
    for name, each in named:
        yield ExplanationRow(
            file=grade.file,
            explanation=name,
            mistakes=len(each.mistakes),
            what="; ".join(mistake.text for mistake in each.mistakes) or "nothing wrong",
            max_residual_m=each.max_m,
            rms_residual_m=each.rms_m,
            weight=each.weight,
        )


def part_rows(grade: Grade) -> Iterator[PartRow]:
    """Yield the parts of the duration that have rows."""
    edges = np.linspace(0, grade.scene.duration, BINS + 1)
    for begin, end, error_m in zip(edges, edges[1:], grade.measured.over_time_m, strict=False):
        if np.isfinite(error_m):
            yield PartRow(file=grade.file, from_s=float(begin), to_s=float(end), max_error_m=float(error_m))


def sample_rows(grade: Grade) -> Iterator[SampleRow]:
    """Yield the sampled rows, by time and vertex."""
    sample, vertices = grade.measured.sample, grade.measured.description.vertices
    for (row, number), distance in np.ndenumerate(np.linalg.norm(sample.vertices - sample.true, axis=-1)):
        true, seen = sample.true[row, number], sample.vertices[row, number]
        yield SampleRow(
            file=grade.file,
            scene=grade.scene.name,
            member=grade.measured.throw,
            t_s=float(sample.times[row]),
            vertex=vertices[number],
            **vector_columns(true, "true_x_m", "true_y_m", "true_z_m"),
            **vector_columns(seen, "x_m", "y_m", "z_m"),
            **vector_columns(seen - true, "error_x_m", "error_y_m", "error_z_m"),
            error_m=float(distance),
        )


def reading_rows(grade: SensorGrade) -> Iterator[ReadingRow]:
    """Yield the readings of each device, by time."""
    for device in grade.devices:
        m = device.measured
        for row in np.unique(np.linspace(0, len(m.readings) - 1, MOST_ROWS).round().astype(int)).tolist():
            true, seen = m.true[row], m.readings.values[row]
            yield ReadingRow(
                file=grade.file,
                scene=grade.scene.name,
                sensor=grade.sensor.name,
                device=m.device,
                unit=m.unit,
                t_s=float(m.readings.times[row]),
                **vector_columns(true, "true_x", "true_y", "true_z"),
                **vector_columns(seen, "x", "y", "z"),
                error=float(np.linalg.norm(seen - true)),
            )


def grade_tables(found: FileGrade, command: str) -> dict[str, pd.DataFrame]:
    """Return every table of a grade: those of poses, and those of readings, as far as the file has them.

    Parameters
    ----------
    found : the grades of a file
    command : the command line, for `conditions.csv`

    Returns
    -------
    file name -> table
    """
    tables: dict[str, pd.DataFrame] = {}
    if found.pose:
        tables |= {
            "grade.csv": frame(GRADE, [grade_row(found.pose)]),
            "diagnosis.csv": frame(DIAGNOSIS, diagnosis_rows(found.pose)),
            "explanations.csv": frame(EXPLANATIONS, explanation_rows(found.pose)),
            "grade-parts.csv": frame(PARTS, part_rows(found.pose)),
            "grade-vertices.csv": frame(VERTICES, sample_rows(found.pose)),
        }
    if found.pose and found.pose.contact:
        tables |= {
            "contact-grade.csv": frame(CONTACT_GRADE, contact_rows(found.pose)),
            "contact-diagnosis.csv": frame(CONTACT_DIAGNOSIS, contact_diagnosis_rows(found.pose)),
        }
    if found.sensor:
        tables |= {
            "sensor-grade.csv": frame(SENSOR_GRADE, sensor_grade_rows(found.sensor)),
            "sensor-diagnosis.csv": frame(SENSOR_DIAGNOSIS, sensor_diagnosis_rows(found.sensor)),
            "grade-readings.csv": frame(READINGS, reading_rows(found.sensor)),
        }
    return {**tables, "conditions.csv": frame(CONDITIONS, conditions(command))}
