"""What changed at which release: neighbours in the ledger that differ by more than rounding and the clock explain."""

import math
from collections.abc import Iterator

from tumble.compare.judge.orders import FLOOR
from tumble.compare.releases.ledger import Ledger, neighbours
from tumble.compare.releases.notes import Notes
from tumble.compare.releases.schemas import ReleaseChangeRow, ReleaseRow
from tumble.compare.run.status import described
from tumble.compare.run.timing.readings import Reading, ratio

# An order of a ladder is known to about a tenth; an integrator's are whole numbers.
ORDER = 0.5
# The same integrator has the same errors to rounding; another has others, the more so the coarser the step.
ERROR = 0.01
# A loop that was compiled anew is a few per cent faster or slower by chance.
TIME = 0.15

Cells = dict[tuple[str, str, str], ReleaseRow]  # by release, scene and method


def changes(ledger: Ledger, notes: Notes) -> Iterator[ReleaseChangeRow]:
    """Yield what every release does otherwise than the one before it, the oldest first."""
    cells = {(row.release, row.scene, row.method): row for row in ledger.rows}
    scenes = list(dict.fromkeys(row.scene for row in ledger.rows))
    for release, before in neighbours(ledger):
        methods = dict.fromkeys(row.method for row in ledger.rows if row.release in (before, release))
        for method in methods:
            for what, found in between(cells, scenes, before, release, method):
                yield ReleaseChangeRow(
                    engine=ledger.engine,
                    release=release,
                    before=before,
                    method=method,
                    what=what,
                    old="; ".join(old for _, old, _ in found),
                    new="; ".join(new for _, _, new in found),
                    scenes=", ".join(scene for scene, _, _ in found),
                    notes=notes.about(release, method),
                )
            if said := of_time(ledger.speeds.get((before, method)), ledger.speeds.get((release, method))):
                old, new = said
                yield ReleaseChangeRow(
                    engine=ledger.engine,
                    release=release,
                    before=before,
                    method=method,
                    what="time",
                    old=old,
                    new=new,
                    scenes=scenes[0],
                )


Found = list[tuple[str, str, str]]  # scene, old, new


def between(cells: Cells, scenes: list[str], before: str, release: str, method: str) -> Iterator[tuple[str, Found]]:
    """Yield each kind of change of one method with the scenes on which it shows."""
    kinds: dict[str, Found] = {}
    for scene in scenes:
        old, new = cells.get((before, scene, method)), cells.get((release, scene, method))
        for what, was, now in differences(old, new):
            kinds.setdefault(what, []).append((scene, was, now))
    yield from kinds.items()


def differences(old: ReleaseRow | None, new: ReleaseRow | None) -> Iterator[tuple[str, str, str]]:
    """Yield what differs between two rows of one method and scene: column, old and new in words."""
    if old is None or new is None:
        if old is not new:
            yield "method", "there" if old else "not there", "there" if new else "not there"
        return
    if old.status != new.status:
        yield "status", described(old.status, old.why), described(new.status, new.why)
    for column in ("attitude_order", "translation_order"):
        was, now = getattr(old, column), getattr(new, column)
        if was is not None and now is not None and abs(was - now) > ORDER:
            yield column, f"{was:.1f}", f"{now:.1f}"
    if old.spin_energy and new.spin_energy and old.spin_energy != new.spin_energy:
        yield "spin_energy", old.spin_energy, new.spin_energy
    was, now = old.max_error_m, new.max_error_m
    if (
        was is not None
        and now is not None
        and others(was, now, FLOOR * max(old.resolution_m or 0.0, new.resolution_m or 0.0))
    ):
        yield "max_error_m", f"{was:.2g} m", f"{now:.2g} m"


def others(was: float, now: float, least: float) -> bool:
    """Whether two errors are further apart than rounding leaves them, and one stands clear of what can be told."""
    if not (math.isfinite(was) and math.isfinite(now)):
        return math.isfinite(was) != math.isfinite(now)
    return max(was, now) > least and abs(was - now) > ERROR * max(was, now)


def of_time(old: Reading | None, new: Reading | None) -> tuple[str, str] | None:
    """Return the time of a step before and now, where the interval of their ratio leaves no doubt."""
    if old is None or new is None:
        return None
    found = ratio(new, old)
    if found.refusal or not (found.low > 1 + TIME or found.high < 1 / (1 + TIME)):
        return None
    return f"{old.ns:.3g} ns a step", f"{new.ns:.3g} ns, {found.low:.2f} to {found.high:.2f} times as long"
