"""Changes in words: a sentence for each, the changes of behaviour, and the command that reruns one cell."""

import math
import shlex
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from tumble.compare.check.changes import Change, Outcome, Verdict
from tumble.compare.check.record import Record
from tumble.compare.check.schemas import ERRORS
from tumble.compare.run.asked import engine_files, titles
from tumble.compare.run.status import described

FIGURES = {
    "max_error_m": ("largest error", " m"),
    "rms_error_m": ("rms error", " m"),
    "final_error_m": ("final error", " m"),
    "energy_drift": ("energy drift", ""),
    "momentum_drift": ("momentum drift", ""),
    "angular_momentum_drift": ("angular momentum drift", ""),
}
KINDS = {
    "attitude_order": "attitude order",
    "translation_order": "translation order",
    "spin_energy": "spin energy:",
    "status": "status:",
    "contact": "law of contact:",
}
OBSERVED = {"law_error": "law error", "contact_error": "error at the scene's step"}
SETTINGS = {"step_s": "step [s]", "samples": "samples"}
# An order this near to a whole number is shown as that number.
WHOLE = 1 / 3


@dataclass(frozen=True)
class Behaviour:
    """A change of order, energy or status that one contestant has on these scenes; or it is new or gone."""

    verdict: Verdict
    contestant: str
    column: str
    words: str
    scenes: tuple[str, ...]


def sentence(change: Change) -> str:
    """Return one change in words, with old and new."""
    if change.verdict == "gone":
        return f"no longer measured; its status was {change.old}"
    if change.verdict == "new":
        return f"new; its status is {change.new}"
    if change.column == "answer":
        return f"the scene changed: its reference solution moved by {figure(change.new)} m; not compared"
    if change.column in SETTINGS:
        return f"the scene changed: {SETTINGS[change.column]} {change.old} -> {change.new}; not compared"
    if change.column == "truth":
        return f"reference solution: {change.old} -> {change.new}"
    if change.column == "time_ratio":
        return f"run time {figure(change.old)} -> {figure(change.new)} times that of {change.reference}"
    if change.column in KINDS:
        old, new = kind(change.old), kind(change.new)
        if old == new:  # two orders that round to one number
            old, new = figure(change.old), figure(change.new)
        return f"{KINDS[change.column]} {old} -> {new}"
    if change.observable:
        named, unit = f"{OBSERVED[change.column]}, {change.observable}", f" {change.unit}"
        return f"{named}: {figure(change.old)}{unit} -> {figure(change.new)}{unit}"
    name, unit = FIGURES[change.column]
    return f"{name} {figure(change.old)}{unit} -> {figure(change.new)}{unit}{factor(change)}"


def sentences(changes: Sequence[Change]) -> Iterator[Change]:
    """Yield the changes of one cell worth a sentence: of three errors with one verdict only the largest."""
    seen = {(change.column, change.verdict) for change in changes}
    for change in changes:
        if change.column not in ERRORS[1:] or (ERRORS[0], change.verdict) not in seen:
            yield change


def figure(value: object) -> str:
    """Return a number in two digits."""
    return f"{value:.2g}" if isinstance(value, float) else str(value)


def factor(change: Change) -> str:
    """Return the factor by which a figure grew or shrank, if both values are positive and finite."""
    old, new = change.old, change.new
    if not (isinstance(old, float) and isinstance(new, float) and 0 < old < math.inf and 0 < new < math.inf):
        return ""
    ratio = max(old, new) / min(old, new)
    shown = f"{ratio:.2g}" if ratio < 100 or ratio >= 1e9 else f"{float(f'{ratio:.2g}'):,.0f}"
    return f" ({shown} x {'more' if new > old else 'less'})"


def kind(value: float | str | None) -> str:
    """Return an order, a trend or a status as a word."""
    if value is None:
        return "cannot be determined"
    if isinstance(value, str):
        return value
    return f"{value:.0f}" if abs(value - round(value)) <= WHOLE else f"{value:.1f}"


def behaviours(changes: Sequence[Change]) -> Iterator[Behaviour]:
    """Yield the changes of behaviour, each once with its scenes."""
    scenes: dict[tuple[Verdict, str, str, str], list[str]] = {}
    for change in changes:
        if change.column in KINDS:
            key = change.verdict, change.contestant, change.column, sentence(change)
            scenes.setdefault(key, []).append(change.scene)
    for key, where in scenes.items():
        yield Behaviour(*key, tuple(where))


def by_cell(changes: Sequence[Change]) -> dict[tuple[str, str, str], list[Change]]:
    """Return the changes of each cell together, the worst cell first."""
    found: dict[tuple[str, str, str], list[Change]] = {}
    for change in changes:
        found.setdefault(change.key, []).append(change)
    return found


def versions(outcome: Outcome) -> Iterator[str]:
    """Yield the engines whose version changed, or that are missing from one of the records."""
    old, new = (
        {
            row["engine"]: row["version"] or described(row["status"], row["why"])
            for row in record.engines.to_dict("records")
        }
        for record in (outcome.baseline, outcome.candidate)
    )
    for engine, version in new.items():
        if old.get(engine, version) != version:
            yield f"{engine} {old[engine]} -> {version}"


def rerun(record: Record, change: Change, against: Sequence[str]) -> str:
    """Return the command that reruns one cell; against: the options that name baseline and tolerances."""
    return shlex.join(["tumble", "check", scene_word(record, change.scene), *engine_words(record, change), *against])


def scene_word(record: Record, name: str) -> str:
    """Return the word for a scene on the command line: its name or its file."""
    return next((word for word in record.scenes if Path(word).stem == name), name)


def engine_words(record: Record, change: Change) -> list[str]:
    """Return the options for a contestant, a user's own engine by its file; none for a whole scene."""
    if not change.engine:
        return []
    named = titles(engine_files(record.contestants))
    engine = next((file for file, title in named.items() if title == change.engine), change.engine)
    return ["-e", f"{engine}:{change.method}" if change.method else engine]
