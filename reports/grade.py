"""What `tumble grade` prints: how far off a trajectory is, and what is most likely wrong, with the evidence."""

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
    """Yield the answer, the header, the vertex table, error over time, what should be kept, and the diagnosis."""
    m = grade.measured
    yield Constrain(plain(answer(grade)), LIST_WIDTH)
    yield Text()
    throws = f" of {m.throws} throws" if m.throws > 1 else ""
    yield plain(f"{grade.file} held against {grade.scene.name}: {grade.scene.title}")
    rows = "1 row" if m.rows == 1 else f"{m.rows} rows"
    yield plain(f"{rows}{throws}, read as {read_as(m)}; {resolution(m)}")
    yield Text()
    yield plain(f"vertex {m.worst_vertex}" + (f" of throw {m.throw}" if m.throws > 1 else ""))
    yield vertex_table(m)
    yield Text()
    where = f"t = {m.worst_t_s:g} s, vertex {m.worst_vertex}" + (f", throw {m.worst_throw}" if m.throws > 1 else "")
    yield plain(f"error: largest {length(m.worst_m)} at {where}; rms {length(m.rms_m)}; at the end {length(m.final_m)}")
    yield from over_time(m)
    yield from kept_quantities(grade)
    yield Text()
    yield from map(plain, verdict_lines(grade))


def answer(grade: Grade) -> str:
    """Return whether it is right, how far off it is, and what is most likely wrong, in a person's words."""
    m, diagnosis = grade.measured, grade.diagnosis
    at_most = f"{length(m.worst_m)} off at most"
    right = {
        CORRECT_TO_LIMIT: "as far as the truth can tell",
        CORRECT_TO_DIGITS: f"to its printed digits: {at_most}, they leave {length(m.half_m)} open",
        CORRECT_TO_SINGLE: f"to single precision: {at_most}, as its numbers are",
        CORRECT_TO_NOISE: f"to its noise of {length(m.rms_m)}: {at_most}",
    }
    if grade.verdict in right:
        return f"{grade.file} is right, {right[grade.verdict]}."
    if grade.verdict == TOO_COARSE:
        return f"{grade.file} is too coarse to judge: {coarse(grade)}. Print more digits."
    wrong = f"{grade.file} is wrong: up to {length(m.worst_m)} off."
    if grade.verdict == TOO_LITTLE and diagnosis is not None and diagnosis.nothing.nothing:
        return f"{wrong} That is about what its printed digits allow, {length(m.half_m)}, and too little to say why."
    if diagnosis is None or grade.verdict == TOO_LITTLE:
        return f"{wrong} That is too little to say why."
    best = said(diagnosis.best)
    if grade.verdict == UNEXPLAINED or not diagnosis.best.mistakes:
        return f"{wrong} Nothing that was tried explains it."
    if grade.verdict == EXPLAINED_PARTLY:
        return f"{wrong} Nearest, but not all: {best}."
    if diagnosis.engines:
        return f"{wrong} This is what {listed(diagnosis.engines)} at its defaults."
    return f"{wrong} {'One of several that fit alike' if diagnosis.alike else 'Most likely'}: {best}."


def coarse(grade: Grade) -> str:
    """Return what the printed digits leave open, beside the error and the body."""
    m = grade.measured
    return (
        f"up to {length(m.worst_m)} off, but its printed digits allow {length(m.half_m)}, and the body is "
        f"{length(grade.scale.size_m)} long"
    )


def read_as(m: Measured) -> str:
    """Return what was graded, in words."""
    return READ_AS[m.shown.kind] if m.shown.centred else f"{READ_AS[m.shown.kind].partition(' and ')[2]}, attitude only"


def off_by(file: str, m: Measured, seen: Sequence[str] = ()) -> Iterator[str]:
    """Yield what is known before a search, a line each."""
    yield f"{file}: off by up to {length(m.worst_m)}, at t = {m.worst_t_s:g} s; looking for what explains it"
    yield from (f"seen at once: {sentence}" for sentence in seen)


def so_far(nearest: Explanation) -> str:
    """Return which engine's law comes nearest, where none is enough."""
    return f"no engine's defaults are enough; nearest so far, {length(nearest.max_m)} left: {said(nearest)}; searching"


def resolution(m: Measured) -> str:
    """Return in words what cannot be told from nothing."""
    digits = (
        f"printed digits leave {length(m.half_m)} open" if m.half_m > m.resolution_m else "printed to the last digit"
    )
    return f"{digits}; the right motion is known to {length(m.resolution_m)}"


def vertex_table(m: Measured) -> Table:
    """Return one vertex over time: where it should be, where the file has it, the error vector, its length."""
    kept = m.kept
    number = m.shown.vertices.index(m.worst_vertex)
    true, seen = kept.true[:, number], kept.vertices[:, number]
    unit, size, places = ruler(true)
    off = np.linalg.norm(seen - true, axis=1) / size
    small, part = unit_of(float(off.max()) * size) if off.max() > 0.0 else (unit, size)
    heads = f"right [{unit}]", f"file [{unit}]", f"error [{small}]", f"off [{unit}]"
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
    """Yield the error over time in one line of bars, by its logarithm; one between two rows is as the row before."""
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


def kept_quantities(grade: Grade) -> Iterator[Text]:
    """Yield the drifts; of a spin that is written otherwise they would say nothing."""
    m = grade.measured
    if m.drifts is not None and not grade.spin:
        energy, momentum, angular = m.drifts
        how = "by differences of the poses, so noise adds to it" if m.by_differences else "from its velocities"
        yield plain(
            f"off by at most: energy {energy:+.1e}, momentum {momentum:.1e}, angular momentum {angular:.1e} of their "
            f"size ({how})"
        )


def verdict_lines(grade: Grade) -> Iterator[str]:
    """Yield the verdict, the evidence for it, what else fits alike, and what else was seen."""
    m, diagnosis = grade.measured, grade.diagnosis
    match grade.verdict:
        case verdict if verdict == CORRECT_TO_LIMIT:
            yield f"Correct: no error that could be told from none ({length(m.resolution_m)})."
        case verdict if verdict == CORRECT_TO_DIGITS:
            yield f"Correct to the printed digits: every error is within the {length(m.half_m)} that they leave open."
        case verdict if verdict == CORRECT_TO_SINGLE:
            yield (
                f"Correct to single precision: every number in the file is one, and {length(m.worst_m)} is what that "
                "leaves."
            )
        case verdict if verdict == CORRECT_TO_NOISE:
            yield (
                f"Correct to its noise: errors of {length(m.rms_m)} rms, those of neighbouring rows unrelated, and no "
                "mistake that was tried explains them."
            )
        case verdict if verdict == TOO_LITTLE:
            yield (
                f"Off by {length(m.worst_m)}, {figure(m.worst_m / grade.scale.size_m)} of the body's size: too little "
                "to tell one mistake from another."
            )
        case verdict if verdict == TOO_COARSE:
            yield f"Too coarse to judge: {coarse(grade)}."
        case verdict if verdict == TOO_FEW:
            yield f"Off by {length(m.worst_m)}: one row is too few to say why."
        case _ if diagnosis is not None:
            yield from (f"Seen at once: {sentence}" for sentence in grade.seen)
            yield from diagnosis_lines(grade, diagnosis)
    yield from other_findings(grade)


def diagnosis_lines(grade: Grade, diagnosis: Diagnosis) -> Iterator[str]:
    """Yield the best explanation step by step, or that there is none."""
    best = diagnosis.best
    tried = f"{diagnosis.tried} flights with mistakes were tried, alone and together"
    if grade.verdict == UNEXPLAINED:
        yield f"Not explained: {tried}, and none explains most of the error."
        if not best.mistakes:
            return
        yield "The best of them, not to be believed:"
    elif grade.verdict == EXPLAINED_PARTLY:
        yield "What comes nearest, though it does not explain all:"
    elif diagnosis.engines:
        yield f"This is what {listed(diagnosis.engines)} at its defaults:"
    elif diagnosis.alike:
        yield "What is wrong is one of several things that fit alike.  The first of them:"
    else:
        yield "What is most likely wrong:"
    yield from evidence(diagnosis)
    left = length(best.max_m)
    if grade.verdict == EXPLAINED_WHOLLY:
        floor = (
            "about what single precision leaves"
            if grade.measured.single
            else "about what the printed digits leave open"
        )
        yield f"The {left} that are left are {floor if best.nothing else 'noise'}."
        if diagnosis.engines and not any(mistake.hypothesis.part == "steps" for mistake in best.mistakes):
            yield "How long its step is cannot be told: any leaves as little here."
    else:
        yield f"The {left} that are left are neither noise nor rounding: something else is wrong as well."
    for number, other in enumerate(diagnosis.alike[:SHOWN_ALIKE]):
        yield f"{'Fits alike' if not number else 'and'}: {said(other)}: {length(other.max_m)} left."


SHOWN_ALIKE, SHOWN_ENGINES = 5, 4


def listed(engines: Sequence[str]) -> str:
    """Return the names of engines that do one thing, with the verb; of many some, and how many more."""
    if len(engines) == 1:
        return f"{engines[0]} does"
    shown, more = engines[:SHOWN_ENGINES], len(engines) - SHOWN_ENGINES
    *first, last = [*shown, f"{more} more engines"] if more > 0 else shown
    return f"{', '.join(first)} and {last} do, which are one scheme here, each"


def evidence(diagnosis: Diagnosis) -> Iterator[str]:
    """Yield one line for each mistake of the best explanation: what it is, and from how much to how much it helps.

    Of mistakes that help only together the last one says so.
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


def said(explanation: Explanation) -> str:
    """Return what an explanation says, in one line."""
    return "; and ".join(mistake.said for mistake in explanation.mistakes) or "nothing wrong"


def other_findings(grade: Grade) -> Iterator[str]:
    """Yield what else the file shows: quaternions of a wrong length, a shape that changes, a spin written otherwise."""
    m = grade.measured
    if m.throws > 1 and grade.diagnosis is not None:
        yield f"Of {m.throws} throws only throw {m.throw} was looked into, the one that is furthest off."
    if m.lengths is not None and max(abs(length - 1) for length in m.lengths) > 1e-3:
        least, most = m.lengths
        yield f"Seen beside: the quaternion is {least:.4g} to {most:.4g} long, not 1."
    if m.shown.kind != "pose" and grade.strain > 0:
        yield f"Seen beside: the shape is not rigid: distances between vertices change by up to {grade.strain:.2g}."
    if grade.spin:
        yield f"Seen beside: the angular velocity that is written down {grade.spin}."
    if m.single and grade.verdict != CORRECT_TO_SINGLE:
        yield "Seen beside: every number is one of single precision."
