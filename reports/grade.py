"""What `tumble grade` prints: the error of a trajectory, and its most likely cause with the evidence."""

from collections.abc import Iterator, Sequence

import numpy as np
from rich.console import RenderableType
from rich.constrain import Constrain
from rich.text import Text

from tumble.compare.grade.grade import Grade
from tumble.compare.grade.measure.errors import Measured
from tumble.compare.grade.search.diagnosis import Diagnosis
from tumble.compare.grade.verdicts import (
    CORRECT_TO_DIGITS,
    CORRECT_TO_NOISE,
    CORRECT_TO_RESOLUTION,
    CORRECT_TO_SINGLE,
    EXPLAINED_PARTLY,
    EXPLAINED_WHOLLY,
    TOO_COARSE,
    TOO_FEW,
    TOO_LITTLE,
    UNEXPLAINED,
)
from tumble.reports.grade_progress import mistakes_text
from tumble.reports.lengths import LENGTHS, length, ruler
from tumble.reports.terminal import LIST_WIDTH, columns, figure, plain, thinned, vector

BARS = "▁▂▃▄▅▆▇█"
READ_AS = {
    "pose": "centre and quaternion",
    "matrix": "centre and matrix",
    "vertices": "vertices",
}
SHOWN_ALIKE, SHOWN_ENGINES = 5, 4


def grade_text(grade: Grade) -> Iterator[RenderableType]:
    """Yield what `tumble grade` prints.

    Parameters
    ----------
    grade : the grade of a file

    Returns
    -------
    the headline, the vertex table, the error over time, conserved quantities, and the diagnosis
    """
    m = grade.measured
    yield Constrain(plain(headline(grade)), LIST_WIDTH)
    yield Text()
    throws = f" of {m.throws} throws" if m.throws > 1 else ""
    yield plain(f"{grade.file} compared with {grade.scene.name}: {grade.scene.title}")
    rows = "1 row" if m.rows == 1 else f"{m.rows} rows"
    yield plain(f"{rows}{throws}, read as {read_as(m)}; {resolution(m)}")
    yield Text()
    if grade.contact is not None and grade.contact.observables:
        from tumble.reports.contact_grade import contact_table

        yield contact_table(grade.contact)
        yield Text()
    yield plain(f"vertex {m.worst_vertex}" + (f" of throw {m.throw}" if m.throws > 1 else ""))
    yield vertex_table(m)
    yield Text()
    where = f"t = {m.worst_t_s:g} s, vertex {m.worst_vertex}" + (f", throw {m.worst_throw}" if m.throws > 1 else "")
    yield plain(f"error: largest {length(m.worst_m)} at {where}; rms {length(m.rms_m)}; at the end {length(m.final_m)}")
    yield from over_time(m)
    yield from conserved_quantities(grade)
    yield Text()
    yield from map(plain, verdict_lines(grade))


def headline(grade: Grade) -> str:
    """Return in a sentence whether the file is right, how large its error is, and the most likely cause.

    Parameters
    ----------
    grade : the grade of a file

    Returns
    -------
    one line of text; with a second sentence if later rows are not graded
    """
    return " ".join(filter(None, (answer(grade), grade.measured.ends)))


def answer(grade: Grade) -> str:
    """Return `headline` without what it says of later rows."""
    if grade.contact is not None:
        from tumble.reports.contact_grade import contact_headline  # with all that contact needs, 40 ms

        found = grade.diagnosis if grade.verdict == EXPLAINED_PARTLY else None
        return contact_headline(grade.file, grade.contact, mistakes_text(found.best) if found else "")
    m, diagnosis = grade.measured, grade.diagnosis
    largest = f"the largest error is {length(m.worst_m)}"
    right = {
        CORRECT_TO_RESOLUTION: "within the resolution of the reference",
        CORRECT_TO_DIGITS: f"to its printed digits: {largest}, and they allow {length(m.half_m)}",
        CORRECT_TO_SINGLE: f"to single precision{decided(grade)}: {largest}",
        CORRECT_TO_NOISE: f"to its noise of {length(m.rms_m)}: {largest}",
    }
    if grade.verdict in right:
        return f"{grade.file} is right, {right[grade.verdict]}."
    if grade.verdict == TOO_COARSE:
        return f"{grade.file} is too coarse to grade: {coarse(grade)}. Print more digits."
    wrong = f"{grade.file} is wrong: {largest}."
    if grade.verdict == TOO_LITTLE and diagnosis is not None and diagnosis.is_open:
        how = "that rounds in the same direction in every step" if diagnosis.best.drift else "in short steps"
        return f"{wrong} Single precision {how} would explain that, and so may a mistake."
    if grade.verdict == TOO_LITTLE and diagnosis is not None and diagnosis.null.within_floor:
        digits, reference = (
            ("its printed digits allow", m.half_m),
            ("the resolution of the reference allows", m.resolution_m),
        )
        what, most_m = max(digits, reference, key=lambda each: each[1])
        return (
            f"{grade.file} is nearly right: {largest}, and {what} about as much, {length(most_m)}. "
            "What is beyond that is too little to find a cause."
        )
    if grade.verdict == TOO_LITTLE and grade.hidden_by_single:
        return f"{wrong} If the program uses single precision, that is why; print 9 digits to show it."
    if diagnosis is None or grade.verdict == TOO_LITTLE:
        return f"{wrong} That is too little to find the cause."
    best = mistakes_text(diagnosis.best)
    if grade.verdict == UNEXPLAINED or not diagnosis.best.mistakes:
        return f"{wrong} No known mistake explains it."
    if grade.verdict == EXPLAINED_PARTLY:
        return f"{wrong} Best partial explanation: {best}."
    if diagnosis.engines:
        return f"{wrong} Most likely cause: {best}. That is {defaults_of(diagnosis.engines)}."
    return f"{wrong} {'One of several equally good explanations' if diagnosis.alike else 'Most likely cause'}: {best}."


def decided(grade: Grade) -> str:
    """Return until when a file of single precision can be judged, in words; empty if that is its end."""
    all_s = float(grade.measured.sample.times[-1])
    return f" until t = {grade.decided_s:.4g} s, after which rounding alone could explain any error" * (
        grade.decided_s < all_s
    )


def coarse(grade: Grade) -> str:
    """Return the largest error, the error that the printed digits allow, and the body's size, in words."""
    m = grade.measured
    return (
        f"the largest error is {length(m.worst_m)}, but its printed digits allow {length(m.half_m)}, and the body is "
        f"{length(grade.scale.size_m)} long"
    )


def read_as(m: Measured) -> str:
    """Return the description of the pose that was graded, in words."""
    kind = READ_AS[m.description.kind]
    return kind if m.description.has_centre else f"{kind.partition(' and ')[2]}, attitude only"


def resolution(m: Measured) -> str:
    """Return in words which errors cannot be distinguished from zero."""
    rounding = f"the file's rounding allows {length(m.half_m)}"
    digits = rounding if m.half_m > m.resolution_m else "full precision in the file"
    return f"{digits}; reference solution accurate to {length(m.resolution_m)}"


def vertex_table(m: Measured) -> Constrain:
    """Return one vertex over time: reference, file, error, in three digits of the largest number, and distance."""
    sample = m.sample
    number = m.description.vertices.index(m.worst_vertex)
    true, seen = sample.true[:, number], sample.vertices[:, number]
    error = seen - true
    kinds = ("true", true), ("file", seen), ("error", error)
    rulers = ruler(true), ruler(seen), ruler(error, LENGTHS)
    heads = [f"{name} x, y, z [{unit}]" for (name, _), (unit, _, _) in zip(kinds, rulers, strict=True)]
    columns_of = [
        [vector(row / size, places)[1:-1] for row in values]
        for (_, values), (_, size, places) in zip(kinds, rulers, strict=True)
    ]
    table = columns("t [s]", *heads, f"distance [{rulers[0][0]}]", right=range(5))
    for row in thinned(len(sample)):
        table.add_row(
            f"{sample.times[row]:.4g}",
            *(column[row] for column in columns_of),
            figure(float(np.linalg.norm(error[row])) / rulers[0][1]),
        )
    return Constrain(table, LIST_WIDTH)


def over_time(m: Measured) -> Iterator[Text]:
    """Yield the error over time as a line of bars, on a log scale; a part without rows is as the part before."""
    errors = np.maximum(m.over_time_m, m.resolution_m)
    most_empty = int(np.ceil(len(errors) * m.throws / m.rows))
    for place in np.flatnonzero(np.isnan(errors)):
        before = errors[max(place - most_empty, 0) : place][::-1]
        errors[place] = next(iter(e for e in before if np.isfinite(e)), np.nan)
    low, high = np.log10(np.nanmin(errors)), np.log10(np.nanmax(errors))
    if low == high:
        return
    heights = (np.log10(errors) - low) / (high - low) * (len(BARS) - 1)
    line = "".join(BARS[round(height)] if np.isfinite(height) else " " for height in heights.tolist())
    yield plain(f"over time {line} (log scale, {figure(10**low)} to {figure(10**high)} m)")


def conserved_quantities(grade: Grade) -> Iterator[Text]:
    """Yield the drifts of conserved quantities; none if the angular velocity in the file is wrong."""
    m = grade.measured
    if m.drifts is not None and not grade.spin:
        energy, momentum, angular = m.drifts
        how = "from differences of poses, which amplify noise" if m.by_differences else "from its velocities"
        yield plain(
            f"largest relative errors: energy {energy:+.1e}, momentum {momentum:.1e}, angular momentum {angular:.1e} "
            f"({how})"
        )


def verdict_lines(grade: Grade) -> Iterator[str]:
    """Yield the verdict, its evidence, equally good explanations, and other observations.

    Parameters
    ----------
    grade : the grade of a file

    Returns
    -------
    lines of text
    """
    if grade.contact is not None:
        from tumble.reports.contact_grade import contact_lines

        yield from contact_lines(grade.contact)
        return
    m, diagnosis = grade.measured, grade.diagnosis
    match grade.verdict:
        case verdict if verdict == CORRECT_TO_RESOLUTION:
            yield f"Correct: every error is within the resolution of the reference ({length(m.resolution_m)})."
        case verdict if verdict == CORRECT_TO_DIGITS:
            yield f"Correct to the printed digits: every error is within the {length(m.half_m)} that they allow."
        case verdict if verdict == CORRECT_TO_SINGLE:
            yield (
                f"Correct to single precision{decided(grade)}: every number in the file is of single precision, which "
                f"explains errors of {length(m.worst_m)}."
            )
        case verdict if verdict == CORRECT_TO_NOISE:
            yield (
                f"Correct to its noise: the errors are {length(m.rms_m)} rms, uncorrelated between rows, and no known "
                "mistake explains them."
            )
        case verdict if verdict == TOO_LITTLE and grade.hidden_by_single:
            yield (
                "Single precision would explain the errors, but the file has too few digits to show that its program "
                "uses it, and no known mistake explains them completely."
            )
        case verdict if verdict == TOO_LITTLE and diagnosis is not None and diagnosis.best.drift:
            yield f"What fits is {'; and '.join(rate.text for rate in diagnosis.best.drift)}."
            yield (
                "That is so slow that single precision may do it, if it rounds in the same direction in every step. "
                "The same program in double precision shows whether it does."
            )
        case verdict if verdict == TOO_LITTLE and diagnosis is not None and diagnosis.is_open:
            yield (
                f"Single precision would explain the errors{decided(grade)} if the program takes several steps a row. "
                "Otherwise it has a mistake: write a row in every step to show which."
            )
        case verdict if verdict == TOO_LITTLE:
            yield (
                f"The largest error is {length(m.worst_m)}, {figure(m.worst_m / grade.scale.size_m)} of the body's "
                "size: too little to distinguish mistakes."
            )
        case verdict if verdict == TOO_COARSE:
            yield f"Too coarse to grade: {coarse(grade)}."
        case verdict if verdict == TOO_FEW:
            yield f"The largest error is {length(m.worst_m)}; one row is too few to find the cause."
        case _ if diagnosis is not None:
            yield from (f"Observed: {sentence}" for sentence in grade.observations)
            yield from diagnosis_lines(grade, diagnosis)
    yield from other_findings(grade)


def diagnosis_lines(grade: Grade, diagnosis: Diagnosis) -> Iterator[str]:
    """Yield the best explanation step by step, or that there is none."""
    best = diagnosis.best
    if grade.verdict == UNEXPLAINED:
        yield (
            f"Not explained: {diagnosis.trials} programs with mistakes were simulated, and none explains most of the "
            "error."
        )
        if not best.mistakes:
            yield from stopped(grade, diagnosis)
            return
        yield "The best of them, which is not reliable:"
    elif grade.verdict == EXPLAINED_PARTLY:
        yield "The best partial explanation:"
    elif diagnosis.engines:
        yield f"This is {defaults_of(diagnosis.engines)}:"
    elif diagnosis.alike:
        yield "The first of several equally good explanations:"
    else:
        yield "The most likely cause:"
    yield from evidence(diagnosis)
    for rate in best.drift:
        yield f"Also fitted: {rate.text}. So slow a change is taken for rounding in the same direction in every step."
    left = length(best.max_m)
    if grade.verdict == EXPLAINED_WHOLLY:
        is_single = grade.measured.may_be_single and not grade.hidden_by_single
        floor = "within the effect of single precision" if is_single else "within the file's print precision"
        yield f"The remaining {left} is {floor if best.within_floor else 'noise and rounding'}."
        if diagnosis.engines and not any(mistake.hypothesis.part == "steps" for mistake in best.mistakes):
            yield "The file does not determine the length of the step."
    elif best.is_whole:
        yield f"The remaining {left} looks like noise or rounding, but other mistakes may explain as much."
    else:
        yield f"The remaining {left} is neither noise nor rounding: something else is wrong as well."
    for other in diagnosis.alike[:SHOWN_ALIKE]:
        yield f"Equally good: {mistakes_text(other)} ({length(other.max_m)} left)"
    yield from stopped(grade, diagnosis)


def stopped(grade: Grade, diagnosis: Diagnosis) -> Iterator[str]:
    """Yield that the search was stopped before it explained the file, and how it takes longer."""
    if diagnosis.stopped_s and grade.verdict != EXPLAINED_WHOLLY:
        longer = f"--search {10 * diagnosis.stopped_s:.2g}"
        yield f"The search stopped after {diagnosis.stopped_s:.2g} s of processor time; {longer} makes it longer."


def defaults_of(engines: Sequence[str]) -> str:
    """Return in words that a file is of engines with one scheme; of many engines, the first and how many more."""
    if len(engines) == 1:
        return f"the default of {engines[0]}"
    shown, more = engines[:SHOWN_ENGINES], len(engines) - SHOWN_ENGINES
    *first, last = [*shown, f"{more} more engines"] if more > 0 else shown
    return f"the default of {', '.join(first)} and {last}, which have the same scheme here"


def evidence(diagnosis: Diagnosis) -> Iterator[str]:
    """Yield a line for each mistake of the best explanation: its text, and the error before and after it.

    Of mistakes that help only together, the last one says so.
    """
    before, number = diagnosis.steps[0], 0
    for step in diagnosis.steps[1:]:
        new = step.names - before.names
        *first, last = (each.text for each in diagnosis.best.mistakes if each.hypothesis.name in new)
        for text in first:
            number += 1
            yield f"  {number}. {text}"
        number += 1
        others = f" (with {' and '.join(map(str, range(number - len(first), number)))})" if first else ""
        yield f"  {number}. {last}: {length(before.max_m)} -> {length(step.max_m)}{others}"
        before = step


def other_findings(grade: Grade) -> Iterator[str]:
    """Yield other findings: quaternions of a wrong length, a shape that changes, a wrong angular velocity."""
    m = grade.measured
    if m.throws > 1 and grade.diagnosis is not None:
        yield f"Of {m.throws} throws, only throw {m.throw} was diagnosed, which has the largest error."
    if m.lengths is not None and max(abs(length - 1) for length in m.lengths) > 1e-3:
        least, most = m.lengths
        yield f"Also: the length of the quaternion is {least:.4g} to {most:.4g}, not 1."
    if m.description.kind != "pose" and grade.strain > 0:
        yield f"Also: the shape is not rigid; distances between vertices change by up to {grade.strain:.2g}."
    if grade.spin:
        yield f"Also: the angular velocity in the file {grade.spin}."
    if m.single and grade.verdict != CORRECT_TO_SINGLE:
        yield "Also: every number in the file is of single precision."
