"""Changes by release: neighbours in the ledger that differ by more than rounding and timing noise."""

import math
from collections.abc import Iterator

from tumble.compare.contact.differences import contact_differences
from tumble.compare.judge.orders import FLOOR
from tumble.compare.releases.ledger import Ledger, neighbours
from tumble.compare.releases.notes import Notes
from tumble.compare.releases.schemas import ReleaseChangeRow, ReleaseRow
from tumble.compare.run.status import described
from tumble.compare.run.timing.readings import Reading, ratio

# A measured order is accurate to about a tenth; those of integrators are whole numbers.
ORDER = 0.5
# The same integrator has the same errors up to rounding; another has different ones, mostly at coarse steps.
ERROR = 0.01
# Of an observable of contact, beyond its intervals.
CONTACT = 0.01
# Recompiling a loop makes it a few per cent faster or slower by chance.
TIME = 0.15

Cells = dict[tuple[str, str, str], ReleaseRow]  # by release, scene and method


def changes(ledger: Ledger, notes: Notes) -> Iterator[ReleaseChangeRow]:
    """Yield the changes of every release from the one before it, the oldest first."""
    cells = {(row.release, row.scene, row.method): row for row in ledger.rows}
    scenes = list(dict.fromkeys(row.scene for row in ledger.rows))
    for release, before in neighbours(ledger):
        methods = dict.fromkeys(row.method for row in ledger.rows if row.release in (before, release))
        for method in methods:
            for what, found in (
                *between(cells, scenes, before, release, method),
                *of_contact(ledger, scenes, before, release, method),
            ):
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
            if speeds := of_time(ledger.speeds.get((before, method)), ledger.speeds.get((release, method))):
                old, new = speeds
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
    """Yield each kind of change of one method with the scenes that show it."""
    kinds: dict[str, Found] = {}
    for scene in scenes:
        old, new = cells.get((before, scene, method)), cells.get((release, scene, method))
        for what, was, now in differences(old, new):
            kinds.setdefault(what, []).append((scene, was, now))
    yield from kinds.items()


def of_contact(
    ledger: Ledger, scenes: list[str], before: str, release: str, method: str
) -> Iterator[tuple[str, Found]]:
    """Yield each kind of change above a plane with the scenes that show it."""
    kinds: dict[str, Found] = {}
    for scene in scenes:
        old, new = (ledger.contact.get((each, scene, method), ()) for each in (before, release))
        for one in contact_differences(old, new, CONTACT, CONTACT):
            was, now = (each if isinstance(each, str) else f"{each:.2g} {one.unit}" for each in (one.old, one.new))
            kinds.setdefault(one.what, []).append((scene, f"{one.observable} {was}".strip(), now))
    yield from kinds.items()


def differences(old: ReleaseRow | None, new: ReleaseRow | None) -> Iterator[tuple[str, str, str]]:
    """Yield the differences between two rows of one method and scene: column, old and new value."""
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
        and differ(was, now, FLOOR * max(old.resolution_m or 0.0, new.resolution_m or 0.0))
    ):
        yield "max_error_m", f"{was:.2g} m", f"{now:.2g} m"


def differ(was: float, now: float, least: float) -> bool:
    """Whether two errors differ by more than rounding, and one is above the resolution."""
    if not (math.isfinite(was) and math.isfinite(now)):
        return math.isfinite(was) != math.isfinite(now)
    return max(was, now) > least and abs(was - now) > ERROR * max(was, now)


def of_time(old: Reading | None, new: Reading | None) -> tuple[str, str] | None:
    """Return the time per step before and now, if their ratio is significant."""
    if old is None or new is None:
        return None
    found = ratio(new, old)
    if found.refusal or not (found.low > 1 + TIME or found.high < 1 / (1 + TIME)):
        return None
    return f"{old.ns:.4g} ns", f"{new.ns:.4g} ns, ratio {found.low:.2f} to {found.high:.2f}"
