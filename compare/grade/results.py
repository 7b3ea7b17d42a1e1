"""The results of a grade for scripts: the rows of `diagnosis.csv` and of a sensor's tables, and the JSON document."""

from collections.abc import Iterator
from dataclasses import asdict
from typing import TYPE_CHECKING

from tumble.compare.grade.file_grade import FileGrade
from tumble.compare.grade.grade import Grade
from tumble.compare.grade.hypotheses.explanation import Explanation, Mistake
from tumble.compare.grade.hypotheses.hypothesis import Hypothesis
from tumble.compare.grade.schemas import (
    ContactDiagnosisRow,
    ContactGradeRow,
    DiagnosisRow,
    SensorDiagnosisRow,
    SensorGradeRow,
)

if TYPE_CHECKING:  # most files have no readings
    from tumble.compare.grade.sensor_grade import SensorGrade

# Names of values in tables.
STEP, RATE, FACTOR, CHOICE, SECONDS, VECTOR = "step", "rate", "factor", "choice", "time", "vector"


def diagnosis_rows(grade: Grade) -> Iterator[DiagnosisRow]:
    """Yield the rows of `diagnosis.csv`: one for each value of each mistake, or one row without a mistake."""
    diagnosis = grade.diagnosis
    best = () if diagnosis is None or not diagnosis.best.mistakes else (diagnosis.best, *diagnosis.alike)
    if diagnosis is None or not best:
        yield DiagnosisRow(
            file=grade.file,
            verdict=grade.verdict,
            rank=1,
            engines="",
            mistake="",
            parameter="",
            value="",
            unit="",
            residual_m=grade.measured.worst_m,
        )
        return
    engines = " | ".join(diagnosis.engines)
    for rank, explanation in enumerate(best, 1):
        for mistake, parameter, value, unit in values(explanation):
            yield DiagnosisRow(
                file=grade.file,
                verdict=grade.verdict,
                rank=rank,
                engines=engines if rank == 1 else "",
                mistake=mistake,
                parameter=parameter,
                value=value,
                unit=unit,
                residual_m=explanation.max_m,
            )


def parameters(hypothesis: Hypothesis) -> Iterator[tuple[str, str]]:
    """Yield the name and unit of each parameter of a mistake; a mistake without a value has one with an empty name."""
    yield _parameter(hypothesis), hypothesis.unit
    for detail, word in hypothesis.details:
        if word:
            yield detail, ""


def values(explanation: Explanation) -> Iterator[tuple[str, str, str, str]]:
    """Yield mistake, parameter, value and unit."""
    for mistake in explanation.mistakes:
        hypothesis = mistake.hypothesis
        words = [word for _, word in hypothesis.details if word]
        for (parameter, unit), value in zip(parameters(hypothesis), (_value(mistake), *words), strict=True):
            yield hypothesis.name, parameter, value, unit


def _parameter(hypothesis: Hypothesis) -> str:
    if hypothesis.scale or hypothesis.value:
        return VECTOR
    if hypothesis.choices:
        return CHOICE
    if "{}" not in hypothesis.text:
        return ""
    if hypothesis.unit == "s":
        return STEP if hypothesis.part in ("steps", "clock tick") else SECONDS
    return RATE if hypothesis.unit else FACTOR


def _value(mistake: Mistake) -> str:
    hypothesis = mistake.hypothesis
    if hypothesis.scale or hypothesis.value:
        return " ".join(f"{number:.9g}" for number in hypothesis.value or mistake.value)
    if hypothesis.choices:
        return hypothesis.choices[int(mistake.value)]
    return f"{mistake.value:.9g}" if "{}" in hypothesis.text else ""


def contact_rows(grade: Grade) -> Iterator[ContactGradeRow]:
    """Yield the observables of the contact in a file."""
    if grade.contact is None:
        return
    for row in grade.contact.observables:
        yield ContactGradeRow(
            file=grade.file,
            scene=grade.scene.name,
            member=grade.measured.throw,
            t_s=row.time,
            observable=row.name,
            unit=row.unit,
            value=row.value,
            expected=row.expected,
        )


def contact_diagnosis_rows(grade: Grade) -> Iterator[ContactDiagnosisRow]:
    """Yield the rows of the explanations of contact: one for each parameter of each mistake."""
    if grade.contact is None:
        return
    for rank, explanation in enumerate(grade.contact.explanations, 1):
        for mistake in explanation.mistakes:
            values = mistake.hypothesis.parameters or (("", ""),)
            for number, (parameter, unit) in enumerate(values):
                yield ContactDiagnosisRow(
                    file=grade.file,
                    verdict=grade.verdict,
                    rank=rank,
                    mistake=mistake.hypothesis.name,
                    parameter=parameter,
                    value=f"{mistake.values[number]:.9g}" if mistake.values else "",
                    unit=unit,
                    residual=max(explanation.misses, default=0.0),
                )


def sensor_grade_rows(grade: "SensorGrade") -> Iterator[SensorGradeRow]:
    """Yield the row of each device."""
    for device in grade.devices:
        m = device.measured
        yield SensorGradeRow(
            file=grade.file,
            scene=grade.scene.name,
            sensor=grade.sensor.name,
            device=m.device,
            unit=m.unit,
            rows=len(m.readings),
            rows_at_impulses=m.left_out,
            verdict=device.verdict,
            max_error=m.worst,
            at_t_s=m.worst_t_s,
            rms_error=m.rms,
            residual=device.diagnosis.best.rms if device.diagnosis else m.rms,
            resolution=m.resolution,
            print_precision=m.half,
            hidden=" | ".join(dict.fromkeys(mistake.hypothesis.name for mistake in device.hidden)),
        )


def sensor_diagnosis_rows(grade: "SensorGrade") -> Iterator[SensorDiagnosisRow]:
    """Yield the rows of each device's explanations: one for each parameter of each mistake."""
    for device in grade.devices:
        if device.diagnosis is None or not device.mistakes:
            continue
        for rank, explanation in enumerate((device.diagnosis.best, *device.diagnosis.alike), 1):
            for mistake in explanation.mistakes:
                for parameter, value, unit in mistake.parameters or (("", "", ""),):
                    yield SensorDiagnosisRow(
                        file=grade.file,
                        sensor=grade.sensor.name,
                        device=device.measured.device,
                        rank=rank,
                        mistake=mistake.hypothesis.name,
                        parameter=parameter,
                        value=value,
                        unit=unit,
                        residual=explanation.rms,
                    )


def json_document(found: FileGrade) -> dict[str, object]:
    """Return the grades as `tumble grade --json` prints them.

    Parameters
    ----------
    found : the grades of one file

    Returns
    -------
    value by key; `sensor` is there if the file has readings, the keys of poses if it has poses
    """
    document: dict[str, object] = {"file": found.file, "scene": found.scene.name}
    if found.pose:
        document |= _of_poses(found.pose)
    document["verdict"] = found.verdict
    if found.pose and found.pose.contact:
        document["contact"] = {
            "step_s": found.pose.contact.search.step,
            "observables": [asdict(row) for row in contact_rows(found.pose)],
            "diagnosis": [asdict(row) for row in contact_diagnosis_rows(found.pose)],
        }
    if found.sensor:
        document["sensor"] = {
            "name": found.sensor.sensor.name,
            "verdict": found.sensor.verdict,
            "devices": [asdict(row) for row in sensor_grade_rows(found.sensor)],
            "diagnosis": [asdict(row) for row in sensor_diagnosis_rows(found.sensor)],
        }
    return document


def _of_poses(grade: Grade) -> dict[str, object]:
    m = grade.measured
    return {
        "file": grade.file,
        "scene": grade.scene.name,
        "verdict": grade.verdict,
        "max_error_m": m.worst_m,
        "at_t_s": m.worst_t_s,
        "vertex": m.worst_vertex,
        "rms_error_m": m.rms_m,
        "resolution_m": m.resolution_m,
        "print_precision_m": m.half_m,
        "engines": list(grade.diagnosis.engines) if grade.diagnosis else [],
        "confidence": grade.confidence,
        "seen": [*filter(None, (m.ends,)), *grade.observations],
        "search_stopped": grade.diagnosis is not None and grade.diagnosis.stopped_s > 0,
        "diagnosis": [asdict(row) for row in diagnosis_rows(grade)],
    }
