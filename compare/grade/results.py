"""The diagnosis for machines: one row for each number of each mistake, of the best explanation and of those alike."""

from collections.abc import Iterator
from dataclasses import asdict

from tumble.compare.grade.grade import Grade
from tumble.compare.grade.hypotheses.explanation import Explanation, Mistake
from tumble.compare.grade.hypotheses.hypothesis import Hypothesis
from tumble.compare.grade.schemas import DiagnosisRow

# What a value stands for, of mistakes by the beginning of their unit or by name.
STEP, RATE, FACTOR, CHOICE, SECONDS = "step", "rate", "factor", "choice", "time"


def diagnosis_rows(grade: Grade) -> Iterator[DiagnosisRow]:
    """Yield the rows of `diagnosis.csv`; of a file without a diagnosis one that says the verdict."""
    diagnosis = grade.diagnosis
    best = () if diagnosis is None or not diagnosis.best.mistakes else (diagnosis.best, *diagnosis.alike)
    if diagnosis is None or not best:
        yield DiagnosisRow(grade.file, grade.verdict, 1, 1, "", "", "", "", "", grade.measured.worst_m)
        return
    engines = " | ".join(diagnosis.engines)
    for rank, explanation in enumerate(best, 1):
        for mistake, parameter, value, unit in _numbers(explanation):
            key = grade.file, grade.verdict, rank, 1, engines if rank == 1 else ""
            yield DiagnosisRow(*key, mistake, parameter, value, unit, explanation.max_m)


def stable_name(hypothesis: Hypothesis) -> str:
    """Return what tables call a mistake."""
    return hypothesis.name.replace(" ", "-").replace("'", "")


def parameters(hypothesis: Hypothesis) -> Iterator[tuple[str, str]]:
    """Yield each parameter of a mistake in tables and its unit; a mistake without a number has one called ""."""
    yield _parameter(hypothesis), hypothesis.unit
    for detail, word in hypothesis.details:
        if word:
            yield detail, ""


def _numbers(explanation: Explanation) -> Iterator[tuple[str, str, str, str]]:
    """Yield mistake, parameter, value and unit."""
    for mistake in explanation.mistakes:
        hypothesis = mistake.hypothesis
        words = [word for _, word in hypothesis.details if word]
        for (parameter, unit), value in zip(parameters(hypothesis), (_value(mistake), *words), strict=True):
            yield stable_name(hypothesis), parameter, value, unit


def _parameter(hypothesis: Hypothesis) -> str:
    if hypothesis.choices:
        return CHOICE
    if "{}" not in hypothesis.says:
        return ""
    if hypothesis.unit == "s":
        return STEP if hypothesis.part in ("steps", "clock tick") else SECONDS
    return RATE if hypothesis.unit else FACTOR


def _value(mistake: Mistake) -> str:
    hypothesis = mistake.hypothesis
    if hypothesis.choices:
        return hypothesis.choices[int(mistake.value)]
    return f"{mistake.value:.9g}" if "{}" in hypothesis.says else ""


def answer(grade: Grade) -> dict[str, object]:
    """Return the same for JSON, with the figures of the file."""
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
        "seen": list(grade.seen),
        "diagnosis": [asdict(row) for row in diagnosis_rows(grade)],
    }
