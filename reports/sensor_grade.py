"""What `tumble grade` prints of a sensor's readings: their errors, and the most likely cause with the evidence."""

from collections.abc import Iterator, Sequence

import numpy as np
from rich.console import RenderableType
from rich.table import Table
from rich.text import Text

from tumble.compare.grade.measure.readings import MeasuredReadings
from tumble.compare.grade.search.sensor_search import SensorExplanation, SensorMistake
from tumble.compare.grade.sensor_grade import DeviceGrade, SensorGrade
from tumble.compare.grade.verdicts import (
    CORRECT_TO_DIGITS,
    CORRECT_TO_NOISE,
    CORRECT_TO_RESOLUTION,
    CORRECT_TO_SINGLE,
    EXPLAINED_PARTLY,
    EXPLAINED_WHOLLY,
    FOLLOWS_MOTION,
    NO_MISTAKE_SEEN,
    TOO_COARSE,
    TOO_FEW,
    UNEXPLAINED,
)
from tumble.reports.grade_progress import size
from tumble.reports.terminal import columns, plain, thinned, vector

# Significant digits of a vector's largest component.
DIGITS = 4


def sensor_text(grade: SensorGrade) -> Iterator[RenderableType]:
    """Yield for each device a table of readings unless they are right, the errors and the diagnosis."""
    yield plain(f"{grade.file} compared with sensor {grade.sensor.name} of {grade.scene.name}: {grade.scene.title}")
    for device in grade.devices:
        m = device.measured
        yield Text()
        yield plain(f"{m.device}, {m.unit}, in the sensor's axes")
        if not device.is_right:
            yield reading_table(m)
        yield plain(f"error: largest {size(m, m.worst)} at t = {m.worst_t_s:g} s; rms {size(m, m.rms)}")
        if m.left_out:
            rows = "1 row" if m.left_out == 1 else f"{m.left_out} rows"
            yield plain(f"{rows} next to an impulse left out, where the reading is not defined")
        yield from map(plain, device_lines(device))


def sensor_headline(grade: SensorGrade) -> str:
    """Return in a sentence which readings are right or wrong, and the most likely cause.

    Parameters
    ----------
    grade : the grade of a sensor's readings

    Returns
    -------
    one line of text
    """
    wrong = [d for d in grade.devices if d.verdict in (EXPLAINED_WHOLLY, EXPLAINED_PARTLY, UNEXPLAINED)]
    rest = "".join(f" The {d.measured.device} {in_words(d)}." for d in grade.devices if d not in wrong)
    if not wrong:
        if len({d.verdict for d in grade.devices}) > 1 or grade.verdict == NO_MISTAKE_SEEN:
            return f"{grade.file}:{rest}"
        names, verb = " and ".join(d.measured.device for d in grade.devices), "are" if len(grade.devices) > 1 else "is"
        judged = (d.own or d.measured for d in grade.devices)
        sizes = "; ".join(f"{m.device} {size(m, m.rms)} rms" for m in judged)
        return f"{grade.file}: {names} {verb} {RIGHTLY.get(grade.verdict, grade.verdict)} ({sizes})."
    causes = causes_text(wrong)
    largest = " and ".join(f"{size(d.measured, d.measured.worst)} ({d.measured.device})" for d in wrong)
    off = f"The largest error is {largest}."
    if not causes:
        return f"{grade.file} is wrong, and no known mistake explains it. {off}{rest}"
    hedge = "compared with the file's own motion, " if any(d.own for d in wrong) else ""
    if grade.verdict == EXPLAINED_PARTLY:
        hedge += "best partial explanation: "
    elif any(d.diagnosis and d.diagnosis.alike for d in wrong):
        hedge += "one of several equally good explanations: "
    return f"{grade.file} is wrong: {hedge}{causes}. {off}{rest}"


RIGHTLY = {
    CORRECT_TO_RESOLUTION: "right, within the resolution of the reference",
    CORRECT_TO_DIGITS: "right to the printed digits",
    CORRECT_TO_SINGLE: "right to single precision",
    CORRECT_TO_NOISE: "right to the noise",
    FOLLOWS_MOTION: "right for the motion in the file, which is wrong",
}


def causes_text(devices: Sequence[DeviceGrade]) -> str:
    """Return the mistakes of devices in words; those that both have once."""
    by_text: dict[str, list[str]] = {}
    for device in devices:
        for mistake in device.mistakes:
            by_text.setdefault(mistake.text, []).append(device.measured.device)
    by_names: dict[str, list[str]] = {}
    for text, names in by_text.items():
        by_names.setdefault(" and ".join(names), []).append(text)
    return "; ".join(f"{'; and '.join(texts)} ({names})" for names, texts in by_names.items())


def in_words(device: DeviceGrade) -> str:
    """Return what a device that is not known to be wrong is, as the end of a sentence."""
    m = device.measured
    if device.verdict == NO_MISTAKE_SEEN:
        return f"shows no mistake above its noise of {size(m, m.rms)}, which would hide {hidden_text(device.hidden)}"
    if device.verdict == FOLLOWS_MOTION and device.own is not None:
        own = size(m, device.own.rms)
        return f"is off by up to {size(m, m.worst)}, but follows the file's own motion to {own}: the motion is wrong"
    if device.verdict == CORRECT_TO_NOISE:
        return f"is right to its noise of {size(m, m.rms)}"
    if device.verdict in RIGHTLY:
        return f"is {RIGHTLY[device.verdict]}"
    if device.verdict == TOO_COARSE:
        return f"is too coarse to grade: its digits allow {size(m, m.half)}"
    if device.verdict == TOO_FEW:
        return f"has too few rows to explain its error of {size(m, m.worst)}"
    return f"is off by up to {size(m, m.worst)}, too little to find the cause"


def hidden_text(hidden: Sequence[SensorMistake]) -> str:
    """Return mistakes in quotation marks, of many the first ones."""
    texts = list(dict.fromkeys(f'"{mistake.text}"' for mistake in hidden))
    more = f" and {len(texts) - 3} more" if len(texts) > 3 else ""
    return ", ".join(texts[:3]) + more


def device_lines(device: DeviceGrade) -> Iterator[str]:
    """Yield the verdict on a device, its evidence, and equally good explanations."""
    m, diagnosis = device.measured, device.diagnosis
    if not device.mistakes or diagnosis is None:
        if device.verdict == UNEXPLAINED and diagnosis is not None:
            yield f"Not explained: {diagnosis.trials} sensors with mistakes were computed, and none explains the error."
        else:
            yield f"The {m.device} {in_words(device)}."
        return
    yield (
        "The best partial explanation:"
        if device.verdict == EXPLAINED_PARTLY
        else ("The first of several equally good explanations:" if diagnosis.alike else "The most likely cause:")
    )
    for number, mistake in enumerate(diagnosis.best.mistakes, 1):
        yield f"  {number}. {mistake.text}"
    left, before = size(m, diagnosis.best.rms), size(m, diagnosis.null.rms)
    kind = "within the file's print precision" if diagnosis.best.within_floor else "noise"
    if device.verdict == EXPLAINED_WHOLLY:
        yield f"The rms error falls from {before} to {left}, which is {kind}."
    else:
        yield f"The rms error falls from {before} to {left}, which is neither noise nor rounding."
    for other in diagnosis.alike:
        yield f"Equally good: {explanation_text(other)} ({size(m, other.rms)} left)"


def explanation_text(explanation: SensorExplanation) -> str:
    """Return the mistakes of an explanation in one line."""
    return "; and ".join(mistake.text for mistake in explanation.mistakes)


def reading_table(m: MeasuredReadings) -> Table:
    """Return some readings over time: reference, file, and the size of the difference."""
    largest = float(np.abs(m.true).max())
    places = int(np.clip(DIGITS - 1 - np.floor(np.log10(largest)), 0, 9)) if largest > 0 else DIGITS
    table = columns("t [s]", "true", "file", "error", right=range(4))
    for row in thinned(len(m.readings)):
        true, seen = m.true[row], m.readings.values[row]
        error = f"{np.linalg.norm(seen - true):.2g}"
        table.add_row(f"{m.readings.times[row]:g}", vector(true, places), vector(seen, places), error)
    return table
