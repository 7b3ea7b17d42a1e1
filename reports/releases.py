"""What changed between an engine's releases, as text and as Markdown."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from rich.console import RenderableType
from rich.constrain import Constrain

from tumble.compare.releases.ledger import Ledger
from tumble.compare.releases.schemas import ReleaseChangeRow, ReleaseRow
from tumble.reports.terminal import LIST_WIDTH, columns, figure, plain

# What a change is called, by its column; of those of physics first.
KINDS = {
    "attitude_order": "order of the attitude",
    "translation_order": "order of the fall",
    "spin_energy": "energy of the spin",
    "max_error_m": "largest error",
    "status": "status",
    "method": "the method",
    "time": "time of a step",
}
OF_SPEED = ("time",)


def answer(ledger: Ledger, changes: Sequence[ReleaseChangeRow]) -> str:
    """Return what there is to be said, in a sentence."""
    span = f"{ledger.engine}, {len(ledger.releases)} releases from {ledger.releases[0]} to {ledger.releases[-1]}"
    physics = dict.fromkeys(row.release for row in changes if row.what not in OF_SPEED)
    if not physics:
        return f"{span}: none flies otherwise than the one before it."
    rest = "" if len(physics) == len(ledger.releases) - 1 else "; the others do not"
    return f"{span}: {', '.join(physics)} fl{'y' if len(physics) > 1 else 'ies'} otherwise than the one before{rest}."


def sentence(change: ReleaseChangeRow) -> str:
    """Return one change in words."""
    if change.what == "method":
        return "is new" if change.new.startswith("there") else "is gone"
    scenes = change.scenes.split(", ")
    pairs = zip(change.old.split("; "), change.new.split("; "), strict=False)
    told = dict.fromkeys(f"{old} -> {new}" for old, new in pairs)
    where = f" ({', '.join(scenes)})" if change.what not in OF_SPEED else ""
    return f"{KINDS[change.what]}: {'; '.join(told)}{where}"


@dataclass(frozen=True)
class Entry:
    """What the same changes of one release or more methods are: sentences, and the first of the notes about them."""

    release: str
    methods: tuple[str, ...]
    sentences: tuple[str, ...]
    notes: str


def entries(changes: Sequence[ReleaseChangeRow]) -> list[Entry]:
    """Return what changed in the order of the releases, physics first, methods that changed alike together."""
    found: dict[tuple[str, str], list[ReleaseChangeRow]] = {}
    for change in changes:
        found.setdefault((change.release, change.method), []).append(change)
    alike: dict[tuple[str, tuple[str, ...]], list[ReleaseChangeRow]] = {}
    for (release, _), own in found.items():
        told = tuple(map(sentence, sorted(own, key=lambda change: [*KINDS].index(change.what))))
        alike.setdefault((release, told), []).append(own[0])
    return [
        Entry(release=release, methods=tuple(row.method for row in rows), sentences=told, notes=rows[0].notes)
        for (release, told), rows in alike.items()
    ]


def ledger_text(ledger: Ledger, changes: Sequence[ReleaseChangeRow]) -> Iterator[RenderableType]:
    """Yield what `tumble releases` prints: the answer, what changed at which release, and figures of those releases."""
    yield Constrain(plain(answer(ledger, changes)), LIST_WIDTH)
    quoted: set[str] = set()
    for entry in entries(changes):
        yield plain("")
        yield plain(f"{entry.release} {', '.join(entry.methods)}")
        for told in entry.sentences:
            yield Constrain(plain(f"  {told}"), LIST_WIDTH)
        if entry.notes and entry.notes not in quoted:
            yield Constrain(plain(f'  its notes: "{entry.notes}"'), LIST_WIDTH)
            quoted.add(entry.notes)
    table = columns("release", "method", "order", "max [m]", "spin", "step [ns]", "of the newest", right=(2, 3, 5, 6))
    scene = ledger.rows[0].scene
    shown = {ledger.releases[0], ledger.releases[-1], *(change.release for change in changes)}
    for row in ledger.rows:
        if row.scene == scene and row.release in shown:
            table.add_row(*map(plain, cells(row)))
    yield plain("")
    yield plain(f"{scene}:")
    yield table


def cells(row: ReleaseRow) -> tuple[str, ...]:
    """Return one row's cells as they are shown; a status that is not ok stands in place of the error."""
    order = "" if row.attitude_order is None else f"{row.attitude_order:.1f}"
    error = figure(row.max_error_m) if row.status == "ok" and row.max_error_m is not None else row.status
    step = "" if row.step_ns is None else f"{row.step_ns:.0f}"
    ratio = ""
    if row.time_ratio is not None:
        ratio = f"{row.time_ratio:.2f} ({row.time_ratio_low:.2f}-{row.time_ratio_high:.2f})"
    return row.release, row.method, order, error, row.spin_energy, step, ratio


def ledger_markdown(ledger: Ledger, changes: Sequence[ReleaseChangeRow], command: str) -> str:
    """Return the ledger as Markdown; command made it."""
    lines = [f"# {ledger.engine}: what changed at which release", "", answer(ledger, changes), "", f"    {command}", ""]
    lines += ["| release | method | what changed, by the numbers | the release's own notes |", "|---|---|---|---|"]
    for entry in entries(changes):
        told = "<br>".join(map(cell, entry.sentences))
        lines.append(f"| {entry.release} | {', '.join(entry.methods)} | {told} | {cell(entry.notes)} |")
    for scene in dict.fromkeys(row.scene for row in ledger.rows):
        lines += ["", f"## {scene}", ""]
        lines += [
            "| release | method | order | max [m] | spin | step [ns] | of the newest |",
            "|---|---|--:|--:|---|--:|--:|",
        ]
        lines += [f"| {' | '.join(map(cell, cells(row)))} |" for row in ledger.rows if row.scene == scene]
    return "\n".join(lines) + "\n"


def cell(text: str) -> str:
    """Return foreign words as a cell, in which they do nothing."""
    return text.replace("|", "\\|").replace("<", "&lt;").replace("\n", " ")
