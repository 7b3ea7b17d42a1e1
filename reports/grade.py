"""What `tumble grade` prints: the error of a trajectory, and the likeliest mistakes with the evidence."""

from collections.abc import Iterator, Sequence

import numpy as np
from rich.console import RenderableType
from rich.constrain import Constrain
from rich.table import Table
from rich.text import Text

from tumble.compare.grade.grade import (
    CORRECT_TO_DIGITS,
    CORRECT_TO_LIMIT,
    CORRECT_TO_NOISE,
    CORRECT_TO_SINGLE,
    EXPLAINED_PARTLY,
    EXPLAINED_WHOLLY,
    TOO_COARSE,
    TOO_FEW,
    TOO_LITTLE,
    UNEXPLAINED,
    Grade,
)
from tumble.compare.grade.hypotheses.explanation import Explanation
from tumble.compare.grade.measure.errors import Measured
from tumble.compare.grade.search.diagnosis import Diagnosis
from tumble.reports.terminal import LIST_WIDTH, columns, figure, length, plain, ruler, thinned, unit_of, vector

BARS = "▁▂▃▄▅▆▇█"
READ_AS = {
    "pose": "centre and quaternion",
    "matrix": "centre and matrix",
    "vertices": "vertices",
}


def grade_text(grade: Grade) -> Iterator[RenderableType]:
    """Yield the answer, the header, the vertex table, error over time, drifts, and the diagnosis."""
    m = grade.measured
    yield Constrain(plain(answer(grade)), LIST_WIDTH)
    yield Text()
    throws = f" of {m.throws} throws" if m.throws > 1 else ""
    yield plain(f"{grade.file} compared with {grade.scene.name}: {grade.scene.title}")
    rows = "1 row" if m.rows == 1 else f"{m.rows} rows"
    yield plain(f"{rows}{throws}, read as {read_as(m)}; {resolution(m)}")
    yield Text()
    yield plain(f"vertex {m.worst_vertex}" + (f" of throw {m.throw}" if m.throws > 1 else ""))
    yield vertex_table(m)
    yield Text()
    where = f"t = {m.worst_t_s:g} s, vertex {m.worst_vertex}" + (f", throw {m.worst_throw}" if m.throws > 1 else "")
    yield plain(f"error: largest {length(m.worst_m)} at {where}; rms {length(m.rms_m)}; final {length(m.final_m)}")
    yield from over_time(m)
    yield from drift_lines(grade)
    yield Text()
    yield from map(plain, verdict_lines(grade))


def answer(grade: Grade) -> str:
    """Return whether the file is right, its error, and the likeliest mistake."""
    m, diagnosis = grade.measured, grade.diagnosis
    error = f"largest error {length(m.worst_m)}"
    right = {
        CORRECT_TO_LIMIT: "within the resolution of the reference solution",
        CORRECT_TO_DIGITS: f"within its print precision: {error}, and the file's rounding allows {length(m.half_m)}",
        CORRECT_TO_SINGLE: f"within single precision: {error}, and its numbers are of single precision",
        CORRECT_TO_NOISE: f"within its noise of {length(m.rms_m)}: {error}",
    }
    if grade.verdict in right:
        return f"{grade.file} is right, {right[grade.verdict]}."
    if grade.verdict == TOO_COARSE:
        return f"{grade.file} is too coarse to judge: {coarse(grade)}. Print more digits."
    wrong = f"{grade.file} is wrong: errors up to {length(m.worst_m)}."
    if grade.verdict == TOO_LITTLE and diagnosis is not None and diagnosis.nothing.nothing:
        return f"{wrong} The file's rounding alone allows {length(m.half_m)}, so the error is too small to explain."
    if diagnosis is None or grade.verdict == TOO_LITTLE:
        return f"{wrong} The error is too small to explain."
    best = in_words(diagnosis.best)
    if grade.verdict == UNEXPLAINED or not diagnosis.best.mistakes:
        return f"{wrong} No mistake that was tried explains it."
    if grade.verdict == EXPLAINED_PARTLY:
        return f"{wrong} Best partial explanation: {best}."
    if diagnosis.engines:
        return f"{wrong} This is the default behaviour of {listed(diagnosis.engines)}."
    return f"{wrong} {'One of several equally good explanations' if diagnosis.alike else 'Likeliest mistake'}: {best}."


def coarse(grade: Grade) -> str:
    """Return the error beside the print precision and the size of the body."""
    m = grade.measured
    return (
        f"errors up to {length(m.worst_m)}, but the file's rounding allows {length(m.half_m)}, and the body's size is "
        f"{length(grade.scale.size_m)}"
    )


def read_as(m: Measured) -> str:
    """Return what was graded, in words."""
    return READ_AS[m.shown.kind] if m.shown.centred else f"{READ_AS[m.shown.kind].partition(' and ')[2]}, attitude only"


def off_by(file: str, m: Measured, seen: Sequence[str] = ()) -> Iterator[str]:
    """Yield what is known before the search, a line each."""
    yield f"{file}: errors up to {length(m.worst_m)}, at t = {m.worst_t_s:g} s; searching for the cause"
    yield from (f"observed: {sentence}" for sentence in seen)


def so_far(nearest: Explanation) -> str:
    """Return the closest engine scheme, where none explains the file."""
    return (
        f"no engine's default explains it; closest so far: {in_words(nearest)}, {length(nearest.max_m)} left; searching"
    )


def resolution(m: Measured) -> str:
    """Return the print precision and the accuracy of the reference solution."""
    digits = (
        f"the file's rounding allows {length(m.half_m)}" if m.half_m > m.resolution_m else "full precision in the file"
    )
    return f"{digits}; reference solution accurate to {length(m.resolution_m)}"


def vertex_table(m: Measured) -> Table:
    """Return one vertex over time: true position, position in the file, error vector, its norm."""
    kept = m.kept
    number = m.shown.vertices.index(m.worst_vertex)
    true, seen = kept.true[:, number], kept.vertices[:, number]
    unit, size, places = ruler(true)
    off = np.linalg.norm(seen - true, axis=1) / size
    small, part = unit_of(float(off.max()) * size) if off.max() > 0.0 else (unit, size)
    heads = f"true [{unit}]", f"file [{unit}]", f"error [{small}]", f"norm [{unit}]"
    table = columns("t [s]", *heads, right=range(5))
    for row in thinned(len(kept)):
        error = seen[row] - true[row]
        table.add_row(
            f"{kept.times[row]:g}",
            vector(true[row] / size, places),
            vector(seen[row] / size, places),
            vector(error / part, 2),
            figure(float(off[row])),
        )
    return table


def over_time(m: Measured) -> Iterator[Text]:
    """Yield the logarithm of the error over time as one line of bars; a gap has the bar of the row before."""
    errors = np.maximum(m.over_time_m, m.resolution_m)
    bare = int(np.ceil(len(errors) * m.throws / m.rows))
    for place in np.flatnonzero(np.isnan(errors)):
        errors[place] = next(iter(e for e in errors[max(place - bare, 0) : place][::-1] if np.isfinite(e)), np.nan)
    low, high = np.log10(np.nanmin(errors)), np.log10(np.nanmax(errors))
    if low == high:
        return
    heights = (np.log10(errors) - low) / (high - low) * (len(BARS) - 1)
    line = "".join(BARS[round(height)] if np.isfinite(height) else " " for height in heights.tolist())
    yield plain(f"over time {line} (log scale, {figure(10**low)} to {figure(10**high)} m)")


def drift_lines(grade: Grade) -> Iterator[Text]:
    """Yield the drifts, unless the file has another convention for its angular velocity."""
    m = grade.measured
    if m.drifts is not None and not grade.spin:
        energy, momentum, angular = m.drifts
        how = "from differences of its poses, which amplifies noise" if m.by_differences else "from its velocities"
        yield plain(
            f"largest relative drift: energy {energy:+.1e}, momentum {momentum:.1e}, angular momentum {angular:.1e} "
            f"({how})"
        )


def verdict_lines(grade: Grade) -> Iterator[str]:
    """Yield the verdict, the evidence for it, equally good explanations, and further observations."""
    m, diagnosis = grade.measured, grade.diagnosis
    match grade.verdict:
        case verdict if verdict == CORRECT_TO_LIMIT:
            yield f"Correct: no error above the resolution of the reference ({length(m.resolution_m)})."
        case verdict if verdict == CORRECT_TO_DIGITS:
            yield f"Correct: every error is within the file's print precision ({length(m.half_m)})."
        case verdict if verdict == CORRECT_TO_SINGLE:
            yield (f"Correct to single precision: every number in the file has it, which explains {length(m.worst_m)}.")
        case verdict if verdict == CORRECT_TO_NOISE:
            yield (
                f"Correct within its noise: rms error {length(m.rms_m)}, uncorrelated between rows, and no mistake "
                "that was tried explains it."
            )
        case verdict if verdict == TOO_LITTLE:
            yield (
                f"Largest error {length(m.worst_m)}, {figure(m.worst_m / grade.scale.size_m)} of the body's size: too "
                "small to distinguish mistakes."
            )
        case verdict if verdict == TOO_COARSE:
            yield f"Too coarse to judge: {coarse(grade)}."
        case verdict if verdict == TOO_FEW:
            yield f"Largest error {length(m.worst_m)}: one row is too few to find the cause."
        case _ if diagnosis is not None:
            yield from (f"Observed: {sentence}" for sentence in grade.seen)
            yield from diagnosis_lines(grade, diagnosis)
    yield from other_findings(grade)


def diagnosis_lines(grade: Grade, diagnosis: Diagnosis) -> Iterator[str]:
    """Yield the best explanation step by step, or that there is none."""
    best = diagnosis.best
    tried = f"{diagnosis.tried} simulations with mistakes, alone and combined"
    if grade.verdict == UNEXPLAINED:
        yield f"Not explained: none of {tried}, explains most of the error."
        if not best.mistakes:
            return
        yield "The best of them, which is not reliable:"
    elif grade.verdict == EXPLAINED_PARTLY:
        yield "Best partial explanation:"
    elif diagnosis.engines:
        yield f"This is the default behaviour of {listed(diagnosis.engines)}:"
    elif diagnosis.alike:
        yield "One of several equally good explanations:"
    else:
        yield "Likeliest mistakes:"
    yield from evidence(diagnosis)
    left = length(best.max_m)
    if grade.verdict == EXPLAINED_WHOLLY:
        floor = "within single precision" if grade.measured.single else "within the file's print precision"
        yield f"The remaining {left} is {floor if best.nothing else 'noise'}."
        if diagnosis.engines and not any(mistake.hypothesis.part == "steps" for mistake in best.mistakes):
            yield "The step cannot be determined: every step fits equally well here."
    else:
        yield f"The remaining {left} is neither noise nor rounding: there is another mistake."
    for number, other in enumerate(diagnosis.alike[:SHOWN_ALIKE]):
        yield f"{'Equally good' if not number else 'and'}: {in_words(other)}: {length(other.max_m)} left."


SHOWN_ALIKE, SHOWN_ENGINES = 5, 4


def listed(engines: Sequence[str]) -> str:
    """Return the names of engines that share a scheme; of many some, and how many more."""
    if len(engines) == 1:
        return engines[0]
    shown, more = engines[:SHOWN_ENGINES], len(engines) - SHOWN_ENGINES
    *first, last = [*shown, f"{more} more engines"] if more > 0 else shown
    return f"{', '.join(first)} and {last}, which are one scheme here"


def evidence(diagnosis: Diagnosis) -> Iterator[str]:
    """Yield one line for each mistake of the best explanation, with the error before and after it.

    Of mistakes that help only together the last line says so.
    """
    before, number = diagnosis.steps[0], 0
    for step in diagnosis.steps[1:]:
        new = step.names - before.names
        *first, last = (each.said for each in diagnosis.best.mistakes if each.hypothesis.name in new)
        for said in first:
            number += 1
            yield f"  {number}. {said}"
        number += 1
        others = f" (with {' and '.join(map(str, range(number - len(first), number)))})" if first else ""
        yield f"  {number}. {last}: {length(before.max_m)} -> {length(step.max_m)}{others}"
        before = step


def in_words(explanation: Explanation) -> str:
    """Return an explanation in one line."""
    return "; and ".join(mistake.said for mistake in explanation.mistakes) or "nothing wrong"


def other_findings(grade: Grade) -> Iterator[str]:
    """Yield further observations: quaternions that are not unit, a shape that changes, another spin convention."""
    m = grade.measured
    if m.throws > 1 and grade.diagnosis is not None:
        yield f"Of {m.throws} throws only throw {m.throw}, the one with the largest error, was diagnosed."
    if m.lengths is not None and max(abs(length - 1) for length in m.lengths) > 1e-3:
        least, most = m.lengths
        yield f"Also observed: the norm of the quaternion is {least:.4g} to {most:.4g}, not 1."
    if m.shown.kind != "pose" and grade.strain > 0:
        yield f"Also observed: the shape is not rigid: distances between vertices change by up to {grade.strain:.2g}."
    if grade.spin:
        yield f"Also observed: the angular velocity in the file {grade.spin}."
    if m.single and grade.verdict != CORRECT_TO_SINGLE:
        yield "Also observed: every number has single precision."
