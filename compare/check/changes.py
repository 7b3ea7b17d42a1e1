"""Two records joined by the keys of their tables: what is worse, better, changed, new or gone beyond tolerance."""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pandas as pd

from tumble.compare.check.record import Record
from tumble.compare.check.schemas import CELLS, DRIFTS, ERRORS, QUESTIONS, STATUSES, TIMES
from tumble.compare.check.tolerances import Tolerances
from tumble.compare.contact.differences import contact_differences
from tumble.compare.contact.schemas import CONTACT, ContactRow
from tumble.compare.judge.trend import TRENDS
from tumble.compare.run.asked import engine_files, titles
from tumble.compare.run.precision import DOUBLE, rounding
from tumble.compare.run.status import described
from tumble.compare.tables.frames import rows
from tumble.compare.tables.schema import Table
from tumble.compare.tables.shared import CONTESTANT

Verdict = Literal["incomparable", "worse", "gone", "better", "changed", "new"]
VERDICTS: tuple[Verdict, ...] = ("incomparable", "worse", "gone", "better", "changed", "new")
FAILING = VERDICTS[:3]

ORDERS = ("attitude_order", "translation_order")
NO_ANSWER = 4
# What the rounding of one step may add to a drift, in roundings of a number.
ROUNDINGS = 2.0
# A reference solution that moved by more than this share of the body, beyond its resolution, is of another scene.
SAME_ANSWER = 1e-9
ANSWER = ["x_m", "y_m", "z_m"]

# A DataFrame and a Series, whose types pandas states too loosely for a checker.
Frame = Any
Column = Any


@dataclass(frozen=True)
class Change:
    """One column of one cell that differs.

    Parameters
    ----------
    verdict : one of VERDICTS
    scene : name of the scene
    engine : name of the engine; empty if the whole scene changed
    method : name of the method; empty if the whole scene changed
    column : name of the column that differs
    old : value in the baseline, in the unit of the column; None: there is none
    new : value in the candidate, in the unit of the column; None: there is none
    reference : ENGINE:METHOD that run times are divided by; empty in other columns
    observable : observable of contact, with the number of its impact; empty in other columns
    unit : unit of an observable; empty in other columns
    """

    verdict: Verdict
    scene: str
    engine: str
    method: str
    column: str
    old: float | str | None
    new: float | str | None
    reference: str = ""
    observable: str = ""
    unit: str = ""

    @property
    def key(self) -> tuple[str, str, str]:
        """Scene, engine and method."""
        return self.scene, self.engine, self.method

    @property
    def contestant(self) -> str:
        """ENGINE:METHOD."""
        return f"{self.engine}:{self.method}" if self.method else self.engine


@dataclass(frozen=True)
class Outcome:
    """The comparison of two records.

    Parameters
    ----------
    baseline : the record that is compared with
    candidate : the record that is compared
    changes : all changes, the bad ones first
    unchanged : number of cells without a change
    """

    baseline: Record
    candidate: Record
    changes: tuple[Change, ...]
    unchanged: int

    @property
    def failed(self) -> bool:
        """Whether anything is worse or gone, or a scene changed."""
        return any(change.verdict in FAILING for change in self.changes)


def within(
    record: Record, scenes: Sequence[str], engines: Mapping[str, Sequence[str]], beside: Sequence[str] = ()
) -> Record:
    """Return the part of a record on these scenes (names or files) and engines; empty: all.

    engines: the methods of each, '' for all of them; beside: contestants from which the titles in the record
    distinguish its engines.
    """
    names = {Path(scene).stem for scene in scenes}
    named_as = titles((*engines, *engine_files(beside)))
    methods = {named_as[engine]: named for engine, named in engines.items()}

    def of_scenes(table: Frame) -> Frame:
        return table[table.scene.isin(names)] if names else table

    def selected(table: Frame) -> Frame:
        if not methods:
            return of_scenes(table)
        wanted = [
            engine in methods and not {"", method}.isdisjoint(methods[engine])
            for engine, method in zip(table.engine, table.method, strict=True)
        ]
        return of_scenes(table[np.array(wanted, dtype=bool)])

    times, contact = (None if own is None else selected(own) for own in (record.times, record.contact))
    cells = selected(record.cells)
    return replace(record, questions=of_scenes(record.questions), cells=cells, times=times, contact=contact)


def compare_records(baseline: Record, candidate: Record, tolerances: Tolerances) -> Outcome:
    """Return what changed from one record to another.

    Parameters
    ----------
    baseline : the accepted record
    candidate : the new record
    tolerances : how much each column may change

    Returns
    -------
    the changes beyond the tolerances, the worst first, and the number of unchanged cells
    """
    questions = joined(QUESTIONS, baseline.questions, candidate.questions)
    cells = joined(CELLS, baseline.cells, each_method(candidate.cells, baseline.cells))
    cells = cells.merge(baseline.questions[["scene", "size_m"]], how="left", on="scene")
    engines = pd.concat([baseline.engines, candidate.engines]).drop_duplicates("engine", keep="last")
    share = dict(zip(engines.engine, engines.precision.map(rounding), strict=True))
    cells["rounding"] = cells.engine.map(share).fillna(DOUBLE)
    of_scenes = scene_changes(questions[questions.side == "both"])
    others = cells.scene.isin([change.scene for change in of_scenes if change.verdict == "incomparable"])
    # An engine that was missing had one row for all methods that it has now.
    found_again = (cells.method == "") & cells.duplicated(["scene", "engine"], keep=False)
    found = [
        *of_scenes,
        *presence(cells[(cells.side == "left_only") & ~found_again], "gone"),
        *cell_changes(cells[(cells.side == "both") & ~others], tolerances),
        *presence(cells[cells.side == "right_only"], "new"),
        *(
            each
            for changes in (contact_changes, time_changes)
            for each in changes(baseline, candidate, tolerances)
            if each.scene not in set(cells.scene[others])
        ),
    ]
    touched = {change.key for change in found}
    compared = cells.loc[(cells.side != "right_only") & ~others, list(CONTESTANT)]
    unchanged = sum(key not in touched for key in compared.itertuples(index=False, name=None))
    worst_first = sorted(found, key=lambda change: VERDICTS.index(change.verdict))
    return Outcome(baseline=baseline, candidate=candidate, changes=tuple(worst_first), unchanged=unchanged)


def joined(table: Table, old: Frame, new: Frame) -> Frame:
    """Return the rows of both by the table's key, those of the old first, with columns X_old and X_new.

    side: both, left_only (gone) or right_only (new).
    """
    old, new = (each.assign(place=np.arange(len(each))) for each in (old, new))
    pairs = old.merge(new, how="outer", on=list(table.key), suffixes=("_old", "_new"), indicator="side")
    return pairs.sort_values(["place_old", "place_new"], ignore_index=True)


def each_method(cells: Frame, other: Frame) -> Frame:
    """Return cells with the row of a missing engine repeated for each method that the other record has."""
    engine = ["scene", "engine"]
    missing = cells[cells.method == ""]
    missing = missing[pd.MultiIndex.from_frame(missing[engine]).isin(pd.MultiIndex.from_frame(other[engine]))]
    instead = other[[*engine, "method"]].merge(missing.drop(columns="method"), on=engine)
    return pd.concat([cells.drop(missing.index), instead], ignore_index=True)[CELLS.names]


def changed(pairs: Frame, column: str, verdicts: Column, old: Column, new: Column) -> list[Change]:
    """Return the changes of one column with a verdict; old, new: its values, or None if it has none."""
    rows = np.flatnonzero(np.asarray(verdicts, dtype=object) != "")
    keys = pairs.reindex(columns=[*CONTESTANT, "reference"], fill_value="").to_numpy(dtype=object)[rows]
    before, now = (np.broadcast_to(np.asarray(each, dtype=object), len(pairs))[rows] for each in (old, new))
    return [
        Change(
            verdict=verdicts[row],
            scene=scene,
            engine=engine,
            method=method,
            column=column,
            old=known(was),
            new=known(is_),
            reference=reference,
        )
        for row, (scene, engine, method, reference), was, is_ in zip(rows, keys, before, now, strict=True)
    ]


def known(value: Any) -> Any:
    """Return a cell's value, None if it is empty."""
    return None if pd.isna(value) else value


def in_order(pairs: Frame, changes: Iterable[Change]) -> list[Change]:
    """Return changes in the order of the pairs."""
    keys = pairs.reindex(columns=list(CONTESTANT), fill_value="").itertuples(index=False, name=None)
    rows = {key: row for row, key in enumerate(keys)}
    return sorted(changes, key=lambda change: rows[change.key])


def presence(pairs: Frame, verdict: Verdict) -> list[Change]:
    """Return the cells that only one of the records has, as changes of their status."""
    old, new = (statuses(pairs, "old"), None) if verdict == "gone" else (None, statuses(pairs, "new"))
    return changed(pairs, "status", [verdict] * len(pairs), old, new)


def statuses(pairs: Frame, which: str) -> list[str]:
    """Return the statuses with their reasons."""
    return [described(*each) for each in zip(pairs[f"status_{which}"], pairs[f"why_{which}"], strict=True)]


def failures(record: Record) -> dict[str, str]:
    """Return the status of each contestant that crashed, timed out or is missing, by its name and scenes."""
    failed: Frame = record.cells[rank(record.cells.status) == NO_ANSWER]
    return {
        f"{engine}:{method}".strip(":") + f" on {', '.join(own.scene)}": described(status, why)
        for (engine, method, status, why), own in failed.groupby(["engine", "method", "status", "why"], sort=False)
    }


def scene_changes(pairs: Frame) -> list[Change]:
    """Return the scenes that changed, or gained or lost their reference solution."""
    made: list[Change] = []
    for column in ("step_s", "samples"):
        old, new = both(pairs, column)
        made += changed(pairs, column, np.where(old != new, "incomparable", ""), old, new)
    before, now = (pairs[[f"{each}_{which}" for each in ANSWER]].to_numpy() for which in ("old", "new"))
    had, has = (~np.isnan(each).any(axis=1) for each in (before, now))
    lost = np.select([had & ~has, has & ~had], ["worse", "better"], "")
    made += changed(pairs, "truth", lost, *both(pairs, "truth"))
    with np.errstate(over="ignore"):  # of a record with absurd numbers
        moved = np.linalg.norm(now - before, axis=1)
    known = SAME_ANSWER * pairs.size_m_old + pairs.resolution_m_old.fillna(0.0) + pairs.resolution_m_new.fillna(0.0)
    other = np.where(had & has & ~(moved <= known), "incomparable", "")
    return in_order(pairs, [*made, *changed(pairs, "answer", other, None, moved)])


def cell_changes(pairs: Frame, tolerances: Tolerances) -> list[Change]:
    """Return what differs beyond the tolerances between two cells.

    pairs: with size_m of the body, and rounding, the relative rounding error of the engine's precision.
    """
    made = changed(pairs, "status", status_verdicts(pairs), statuses(pairs, "old"), statuses(pairs, "new"))
    comparable = pairs[pairs.max_error_m_old.notna() & pairs.max_error_m_new.notna()]
    rounding_m, resolution_m, steps = (larger(comparable, column) for column in ("rounding_m", "resolution_m", "steps"))
    drift = ROUNDINGS * comparable.rounding * steps + (rounding_m / comparable.size_m).where(comparable.size_m > 0, 0.0)
    for columns, least, slack in ((ERRORS, resolution_m, rounding_m), (DRIFTS, 0.0, drift)):
        for column in columns:
            old, new = (each.abs().clip(lower=least) for each in both(comparable, column))
            made += changed(comparable, column, growth(old, new, getattr(tolerances, column), slack), old, new)
    for column in ORDERS:
        old, new = both(comparable, column)
        made += changed(comparable, column, order_verdicts(old, new, getattr(tolerances, column)), old, new)
    old, new = both(comparable, "spin_energy")
    kinds = np.where((old != "") & (new != "") & (old != new), ranked(old.map(TRENDS), new.map(TRENDS)), "")
    return in_order(pairs, [*made, *changed(comparable, "spin_energy", kinds, old, new)])


def both(pairs: Frame, column: str) -> tuple[Column, Column]:
    """Return the old and the new values of a column."""
    return pairs[f"{column}_old"], pairs[f"{column}_new"]


def larger(pairs: Frame, column: str) -> Column:
    """Return the larger of the old and the new value, 0 for a missing one."""
    return pairs[[f"{column}_old", f"{column}_new"]].astype(float).fillna(0.0).max(axis=1)


def status_verdicts(pairs: Frame) -> np.ndarray:
    """Return the verdicts on changes of status, or of the reasons for a flag; numbers in those are ignored."""
    old, new = both(pairs, "status")
    verdicts = np.where(old != new, ranked(rank(old), rank(new)), "").astype(object)
    for row in np.flatnonzero((old == new) & (new == "flagged")):
        before, now = reasons(pairs.why_old.iloc[row]), reasons(pairs.why_new.iloc[row])
        verdicts[row] = "" if before == now else "worse" if now - before else "better"
    return verdicts


def rank(statuses: Column) -> Column:
    """Return the ranks of statuses from good to bad."""
    return statuses.map(STATUSES)


def reasons(why: str) -> set[str]:
    """Return the reasons for which a run was flagged, without numbers."""
    return set(re.sub(r"[-+]?\d[\d.e+-]*", "#", why).split("; "))


def ranked(old: Column, new: Column) -> np.ndarray:
    """Return the verdicts on pairs of ranks, the lower the better."""
    return np.select([new > old, old > new], ["worse", "better"], "changed")


def growth(old: Column, new: Column, share: float, slack: Column | float = 0.0) -> np.ndarray:
    """Return the verdicts on sizes that grew or shrank by more than a share and beyond rounding."""
    grew, shrank = new > old * (1 + share) + slack, old > new * (1 + share) + slack
    return np.select([old == new, grew, shrank], ["", "worse", "better"], "")


def order_verdicts(old: Column, new: Column, tolerance: float) -> np.ndarray:
    """Return the verdicts on orders; one that becomes undeterminable, or determinable, is `changed`."""
    lost, moved = old.isna() != new.isna(), (new - old).abs() > tolerance
    return np.select([lost, ~moved, new < old], ["changed", "", "worse"], "better")


def contact_changes(baseline: Record, candidate: Record, tolerances: Tolerances) -> Iterator[Change]:
    """Yield the changes of contact in the cells that both records have observables of."""
    old, new = baseline.contact, candidate.contact
    if old is None or new is None:
        return
    before, now = (by_cell(rows(CONTACT, table)) for table in (old, new))
    for cell, own in now.items():
        for found in contact_differences(before.get(cell, ()), own, tolerances.law_error, tolerances.contact_error):
            yield Change(
                found.verdict, *cell, found.what, found.old, found.new, observable=found.observable, unit=found.unit
            )


def by_cell(found: Iterable[ContactRow]) -> dict[tuple[str, str, str], list[ContactRow]]:
    """Return the rows of contact.csv by scene, engine and method."""
    cells: dict[tuple[str, str, str], list[ContactRow]] = {}
    for row in found:
        cells.setdefault((row.scene, row.engine, row.method), []).append(row)
    return cells


def time_changes(baseline: Record, candidate: Record, tolerances: Tolerances) -> list[Change]:
    """Return the run time ratios whose confidence intervals are further apart than the tolerance."""
    if baseline.times is None or candidate.times is None:
        return []
    pairs = candidate.times.merge(baseline.times, on=list(TIMES.key), suffixes=("_new", "_old"))
    slower = growth(pairs.time_ratio_high_old, pairs.time_ratio_low_new, tolerances.time_ratio) == "worse"
    faster = growth(pairs.time_ratio_low_old, pairs.time_ratio_high_new, tolerances.time_ratio) == "better"
    return changed(
        pairs, "time_ratio", np.select([slower, faster], ["worse", "better"], ""), *both(pairs, "time_ratio")
    )
