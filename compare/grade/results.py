"""The results of a grade for scripts: the rows of `diagnosis.csv`, and the JSON document."""

from collections.abc import Iterator
from dataclasses import asdict

from tumble.compare.grade.grade import Grade
from tumble.compare.grade.hypotheses.explanation import Explanation, Mistake
from tumble.compare.grade.hypotheses.hypothesis import Hypothesis
from tumble.compare.grade.schemas import DiagnosisRow

# Names of values in tables.
STEP, RATE, FACTOR, CHOICE, SECONDS = "step", "rate", "factor", "choice", "time"


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
        for mistake, parameter, value, unit in _values(explanation):
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


def _values(explanation: Explanation) -> Iterator[tuple[str, str, str, str]]:
    """Yield mistake, parameter, value and unit."""
    for mistake in explanation.mistakes:
        hypothesis = mistake.hypothesis
        words = [word for _, word in hypothesis.details if word]
        for (parameter, unit), value in zip(parameters(hypothesis), (_value(mistake), *words), strict=True):
            yield hypothesis.name, parameter, value, unit


def _parameter(hypothesis: Hypothesis) -> str:
    if hypothesis.choices:
        return CHOICE
    if "{}" not in hypothesis.text:
        return ""
    if hypothesis.unit == "s":
        return STEP if hypothesis.part in ("steps", "clock tick") else SECONDS
    return RATE if hypothesis.unit else FACTOR


def _value(mistake: Mistake) -> str:
    hypothesis = mistake.hypothesis
    if hypothesis.choices:
        return hypothesis.choices[int(mistake.value)]
    return f"{mistake.value:.9g}" if "{}" in hypothesis.text else ""


def json_document(grade: Grade) -> dict[str, object]:
    """Return the grade as `tumble grade --json` prints it.

    Parameters
    ----------
    grade : the grade of one file

    Returns
    -------
    value by key
    """
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
        "seen": list(grade.observations),
        "diagnosis": [asdict(row) for row in diagnosis_rows(grade)],
    }
