"""Two records held against each other: what is worse, better, changed, new or gone, and beyond which tolerance."""

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

from compare.check.energy import TRENDS
from compare.check.record import Record
from compare.check.schemas import CellRow, QuestionRow, TimeRow
from compare.check.tolerances import Tolerances
from compare.run.participants import engine_files, titles
from compare.run.precision import DOUBLE, rounding

Verdict = Literal["incomparable", "worse", "gone", "better", "changed", "new"]
VERDICTS: tuple[Verdict, ...] = ("incomparable", "worse", "gone", "better", "changed", "new")
FAILING = VERDICTS[:3]

ERRORS = ("max_error_m", "rms_error_m", "final_error_m")
DRIFTS = ("energy_drift", "momentum_drift", "angular_momentum_drift")
ORDERS = ("attitude_order", "translation_order")
# From good to bad: a flight that was flagged is better than one that diverged, and that than none.
STATUSES = {"ok": 0, "flagged": 1, "diverged": 2, "skipped": 3, "missing": 4, "timeout": 4, "crashed": 4}
NO_ANSWER = 4
# What the rounding of one step may add to a drift, in roundings of a number.
ROUNDINGS = 2.0
# A true answer that moved by more than this share of the body, beyond the truth's limit, is that to another question.
SAME_ANSWER = 1e-9

Key = tuple[str, str, str]


@dataclass(frozen=True)
class Change:
    """One column of one cell that differs: its values in both records, None where it has none.

    A change of a whole scene has neither engine nor method.  reference: the contestant that a ratio of times is over.
    """

    verdict: Verdict
    scene: str
    engine: str
    method: str
    column: str
    old: float | str | None
    new: float | str | None
    reference: str = ""

    @property
    def key(self) -> Key:
        """Scene, engine and method."""
        return self.scene, self.engine, self.method

    @property
    def contestant(self) -> str:
        """ENGINE:METHOD."""
        return f"{self.engine}:{self.method}" if self.method else self.engine


@dataclass(frozen=True)
class Outcome:
    """What a candidate held against a baseline shows: all changes, the bad ones first, and how many cells have none."""

    baseline: Record
    candidate: Record
    changes: tuple[Change, ...]
    unchanged: int

    @property
    def failed(self) -> bool:
        """Whether anything is worse, gone, or not the same question any more."""
        return any(change.verdict in FAILING for change in self.changes)


def within(
    record: Record, scenes: Sequence[str], engines: Mapping[str, Sequence[str]], beside: Sequence[str] = ()
) -> Record:
    """Return what a record says of these scenes (names or files) and engines with these methods; empty means all.

    beside: words for contestants from which the titles in the record tell its engines.
    """
    names = {Path(scene).stem for scene in scenes}
    named_as = titles((*engines, *engine_files(beside)))
    methods = {named_as[engine]: named for engine, named in engines.items()}

    def asked(row: CellRow | TimeRow) -> bool:
        named = methods.get(row.engine, () if not methods else None)
        return (not names or row.scene in names) and named is not None and (not named or row.method in named)

    return replace(
        record,
        questions=tuple(row for row in record.questions if not names or row.scene in names),
        cells=tuple(filter(asked, record.cells)),
        times=None if record.times is None else tuple(filter(asked, record.times)),
    )


def hold_against(baseline: Record, candidate: Record, tolerances: Tolerances) -> Outcome:
    """Return what changed from the baseline to the candidate."""
    old, new = cells(baseline), cells(candidate)
    questions = {row.scene: row for row in candidate.questions}
    found = [
        change
        for row in baseline.questions
        if row.scene in questions
        for change in question_changes(row, questions[row.scene])
    ]
    incomparable = {change.scene for change in found if change.verdict == "incomparable"}
    sizes = {row.scene: row.size_m for row in baseline.questions}
    roundings = {row.engine: rounding(row.precision) for row in (*baseline.engines, *candidate.engines)}
    for key, cell in old.items():
        now = counterpart(key, new)
        if now is None:
            if not any(other[:2] == key[:2] for other in new if not key[2]):
                found.append(Change("gone", *key, "status", cell.told, None))
        elif key[0] not in incomparable:
            found += cell_changes(cell, now, sizes[cell.scene], roundings.get(cell.engine, DOUBLE), tolerances)
    found += [
        Change("new", *key, "status", None, cell.told)
        for key, cell in new.items()
        if key not in old and (key[2] or not any(other[:2] == key[:2] for other in old))
    ]
    found += [change for change in time_changes(baseline, candidate, tolerances) if change.scene not in incomparable]
    touched = {change.key for change in found}
    unchanged = sum(key not in touched and key[0] not in incomparable for key in old)
    return Outcome(
        baseline, candidate, tuple(sorted(found, key=lambda change: VERDICTS.index(change.verdict))), unchanged
    )


def cells(record: Record) -> dict[Key, CellRow]:
    """Return the cells by scene, engine and method."""
    return {(cell.scene, cell.engine, cell.method): cell for cell in record.cells}


def failures(record: Record) -> dict[str, str]:
    """Return the status of each contestant that crashed, hung or is missing, by its name and its scenes."""
    scenes: dict[tuple[str, str], list[str]] = {}
    for cell in record.cells:
        if rank(cell.status) == NO_ANSWER:
            name = f"{cell.engine}:{cell.method}" if cell.method else cell.engine
            scenes.setdefault((name, cell.told), []).append(cell.scene)
    return {f"{name} on {', '.join(its)}": status for (name, status), its in scenes.items()}


def counterpart(key: Key, new: Mapping[Key, CellRow]) -> CellRow | None:
    """Return the candidate's cell; an engine that is missing has one cell, which stands for all of its methods."""
    return new.get(key) or new.get((*key[:2], ""))


def question_changes(old: QuestionRow, new: QuestionRow) -> Iterator[Change]:
    """Yield where a scene does not ask any more what it asked."""
    key = old.scene, "", ""
    for column in ("step_s", "samples"):
        before, now = getattr(old, column), getattr(new, column)
        if before != now:
            yield Change("incomparable", *key, column, before, now)
    before, now = answer(old), answer(new)
    if before is None or now is None:
        if before is not None:
            yield Change("worse", *key, "truth", old.truth, new.truth)
        elif now is not None:
            yield Change("better", *key, "truth", old.truth, new.truth)
    else:
        moved, told = math.dist(before, now), SAME_ANSWER * old.size_m + (old.limit_m or 0) + (new.limit_m or 0)
        if not moved <= told:
            yield Change("incomparable", *key, "answer", None, moved)


def answer(question: QuestionRow) -> tuple[float, float, float] | None:
    """Return where the last vertex truly is at the last sample [m], None where there is no truth."""
    if question.x_m is None or question.y_m is None or question.z_m is None:
        return None
    return question.x_m, question.y_m, question.z_m


def cell_changes(
    old: CellRow, new: CellRow, size_m: float, rounding: float, tolerances: Tolerances
) -> Iterator[Change]:
    """Yield what differs beyond the tolerances between two cells.

    size_m: the body's; rounding: what one moves a number of size 1 in the engine's precision.
    """
    key = old.scene, old.engine, old.method
    if verdict := status_verdict(old, new):
        yield Change(verdict, *key, "status", old.told, new.told)
    if old.max_error_m is None or new.max_error_m is None:
        return
    rounding_m = max(old.rounding_m or 0.0, new.rounding_m or 0.0)
    limit_m = max(old.limit_m or 0.0, new.limit_m or 0.0)
    drift = ROUNDINGS * rounding * max(old.steps or 0, new.steps or 0) + (rounding_m / size_m if size_m else 0.0)
    for columns, least, slack in ((ERRORS, limit_m, rounding_m), (DRIFTS, 0.0, drift)):
        for column in columns:
            before, now = magnitude(getattr(old, column), least), magnitude(getattr(new, column), least)
            if verdict := growth(before, now, getattr(tolerances, column), slack):
                yield Change(verdict, *key, column, before, now)
    for column in ORDERS:
        before, now = getattr(old, column), getattr(new, column)
        if verdict := order_verdict(before, now, getattr(tolerances, column)):
            yield Change(verdict, *key, column, before, now)
    if old.spin_energy and new.spin_energy and old.spin_energy != new.spin_energy:
        verdict = ranked(TRENDS[old.spin_energy], TRENDS[new.spin_energy])
        yield Change(verdict, *key, "spin_energy", old.spin_energy, new.spin_energy)


def status_verdict(old: CellRow, new: CellRow) -> Verdict | None:
    """Return how a status changed in kind, or in the reasons it was flagged for; their numbers do not count."""
    if old.status != new.status:
        return ranked(rank(old.status), rank(new.status))
    if new.status == "flagged" and reasons(old.why) != reasons(new.why):
        return "worse" if reasons(new.why) - reasons(old.why) else "better"
    return None


def rank(status: str) -> int:
    """Return the place of a status from good to bad."""
    return STATUSES.get(status, NO_ANSWER)


def reasons(why: str) -> set[str]:
    """Return what a flight was flagged for, without the numbers."""
    return set(re.sub(r"[-+]?\d[\d.e+-]*", "#", why).split("; "))


def ranked(old: int, new: int) -> Verdict:
    """Return the verdict on two ranks, the lower the better."""
    return "changed" if old == new else "worse" if new > old else "better"


def magnitude(value: float | None, least: float) -> float | None:
    """Return the size of a value, no less than what can be told from none; not a number is without bound."""
    if value is None:
        return None
    return math.inf if math.isnan(value) else max(abs(value), least)


def growth(old: float | None, new: float | None, share: float, slack: float = 0.0) -> Verdict | None:
    """Return whether a size grew or shrank by more than a share and what rounding explains."""
    if old is None or new is None or old == new:
        return None
    if new > old * (1 + share) + slack:
        return "worse"
    return "better" if old > new * (1 + share) + slack else None


def order_verdict(old: float | None, new: float | None, tolerance: float) -> Verdict | None:
    """Return whether an order fell or rose; one that cannot be read any more, or now can, is neither good nor bad."""
    if old is None or new is None:
        return None if old == new else "changed"
    if abs(new - old) <= tolerance:
        return None
    return "worse" if new < old else "better"


def time_changes(baseline: Record, candidate: Record, tolerances: Tolerances) -> Iterator[Change]:
    """Yield the ratios of run time that changed: their intervals are further apart than the tolerance."""
    before = {row.key: row for row in baseline.times or ()}
    for row in candidate.times or ():
        if (old := before.get(row.key)) is None:
            continue
        verdict = None
        if growth(old.time_ratio_high, row.time_ratio_low, tolerances.time_ratio) == "worse":
            verdict = "worse"
        elif growth(old.time_ratio_low, row.time_ratio_high, tolerances.time_ratio) == "better":
            verdict = "better"
        if verdict:
            figures = old.time_ratio, row.time_ratio
            yield Change(verdict, row.scene, row.engine, row.method, "time_ratio", *figures, row.reference)
