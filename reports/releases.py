"""What `tumble releases` prints and writes: the changes of each release, as text and as Markdown."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from rich.console import RenderableType
from rich.constrain import Constrain

from tumble.compare.releases.ledger import Ledger
from tumble.compare.releases.schemas import ReleaseChangeRow, ReleaseRow
from tumble.reports.terminal import LIST_WIDTH, columns, figure, plain

# Names of changes by column, those of physics first.
KINDS = {
    "attitude_order": "attitude order",
    "translation_order": "translation order",
    "spin_energy": "spin energy",
    "contact": "law of contact",
    "law_error": "law error",
    "contact_error": "error of contact",
    "max_error_m": "largest error",
    "status": "status",
    "method": "method",
    "time": "time per step",
}
OF_SPEED = ("time",)


def answer(ledger: Ledger, changes: Sequence[ReleaseChangeRow]) -> str:
    """Return the answer in a sentence."""
    span = f"{ledger.engine}, {len(ledger.releases)} releases from {ledger.releases[0]} to {ledger.releases[-1]}"
    physics = dict.fromkeys(row.release for row in changes if row.what not in OF_SPEED)
    if not physics:
        return f"{span}: none behaves differently from the previous one."
    rest = "" if len(physics) == len(ledger.releases) - 1 else "; the others do not"
    verb = "each behave" if len(physics) > 1 else "behaves"
    return f"{span}: {', '.join(physics)} {verb} differently from the previous release{rest}."


def sentence(change: ReleaseChangeRow) -> str:
    """Return one change in words."""
    if change.what == "method":
        return "is new" if change.new.startswith("there") else "is gone"
    scenes = change.scenes.split(", ")
    pairs = zip(change.old.split("; "), change.new.split("; "), strict=False)
    values = dict.fromkeys(f"{old} -> {new}" for old, new in pairs)
    where = f" ({', '.join(scenes)})" if change.what not in OF_SPEED else ""
    return f"{KINDS[change.what]}: {'; '.join(values)}{where}"


@dataclass(frozen=True)
class Entry:
    """The changes of one release that several methods share: sentences, and the first release note about them."""

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
        changed = tuple(map(sentence, sorted(own, key=lambda change: [*KINDS].index(change.what))))
        alike.setdefault((release, changed), []).append(own[0])
    return [
        Entry(release=release, methods=tuple(row.method for row in rows), sentences=changed, notes=rows[0].notes)
        for (release, changed), rows in alike.items()
    ]


def ledger_text(ledger: Ledger, changes: Sequence[ReleaseChangeRow]) -> Iterator[RenderableType]:
    """Yield what `tumble releases` prints: the answer, what changed at which release, and figures of those releases.

    Parameters
    ----------
    ledger : the releases of an engine
    changes : what changed at each release

    Yields
    ------
    the parts of the text, from top to bottom
    """
    yield Constrain(plain(answer(ledger, changes)), LIST_WIDTH)
    quoted: set[str] = set()
    for entry in entries(changes):
        yield plain("")
        yield plain(f"{entry.release} {', '.join(entry.methods)}")
        for line in entry.sentences:
            yield Constrain(plain(f"  {line}"), LIST_WIDTH)
        if entry.notes and entry.notes not in quoted:
            yield Constrain(plain(f'  release notes: "{entry.notes}"'), LIST_WIDTH)
            quoted.add(entry.notes)
    table = columns("release", "method", "order", "max [m]", "spin", "step [ns]", "time ratio", right=(2, 3, 5, 6))
    scene = ledger.rows[0].scene
    shown = {ledger.releases[0], ledger.releases[-1], *(change.release for change in changes)}
    for row in ledger.rows:
        if row.scene == scene and row.release in shown:
            table.add_row(*map(plain, cells(row)))
    yield plain("")
    yield plain(f"{scene}:")
    yield table


def cells(row: ReleaseRow) -> tuple[str, ...]:
    """Return one row's cells; a status that is not ok replaces the error."""
    order = "" if row.attitude_order is None else f"{row.attitude_order:.1f}"
    error = figure(row.max_error_m) if row.status == "ok" and row.max_error_m is not None else row.status
    step = "" if row.step_ns is None else f"{row.step_ns:.0f}"
    ratio = ""
    if row.time_ratio is not None:
        ratio = f"{row.time_ratio:.2f} ({row.time_ratio_low:.2f}-{row.time_ratio_high:.2f})"
    return row.release, row.method, order, error, row.spin_energy, step, ratio


def ledger_markdown(ledger: Ledger, changes: Sequence[ReleaseChangeRow], command: str) -> str:
    """Return the ledger as Markdown.

    Parameters
    ----------
    ledger : the releases of an engine
    changes : what changed at each release
    command : command line that repeats the study, printed below the answer

    Returns
    -------
    the Markdown text
    """
    lines = [f"# {ledger.engine}: changes by release", "", answer(ledger, changes), "", f"    {command}", ""]
    lines += ["| release | method | measured changes | release notes |", "|---|---|---|---|"]
    for entry in entries(changes):
        changed = "<br>".join(map(cell, entry.sentences))
        lines.append(f"| {entry.release} | {', '.join(entry.methods)} | {changed} | {cell(entry.notes)} |")
    for scene in dict.fromkeys(row.scene for row in ledger.rows):
        lines += ["", f"## {scene}", ""]
        lines += [
            "| release | method | order | max [m] | spin | step [ns] | time ratio to newest |",
            "|---|---|--:|--:|---|--:|--:|",
        ]
        lines += [f"| {' | '.join(map(cell, cells(row)))} |" for row in ledger.rows if row.scene == scene]
    return "\n".join(lines) + "\n"


def cell(text: str) -> str:
    """Return text as a cell of a Markdown table, with its markup escaped."""
    return text.replace("|", "\\|").replace("<", "&lt;").replace("\n", " ")
