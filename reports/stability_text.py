"""What `tumble stability` prints: the stability limits of every scene beside theory, and the extreme cases."""

import math
from collections import Counter
from collections.abc import Iterator, Sequence

from rich.console import RenderableType
from rich.constrain import Constrain
from rich.text import Text

from tumble.compare.judge.verdict import WORDS
from tumble.compare.stability.extremes import BEST, FLOORS, ExtremeRow, missed
from tumble.compare.stability.schemas import CREEPS, HOLDS, ContactMapRow, ContactStepRow
from tumble.compare.stability.trials import Piece
from tumble.reports.charts import coloured, limit_chart
from tumble.reports.numerals import listed
from tumble.reports.rows import contestant
from tumble.reports.terminal import LIST_WIDTH, columns, figure, plain, reasons_text

OF_THE_MAP = (
    "off: cells that differ from Coulomb's law; creep: largest steady speed [m/s]; step: largest one that neither "
    "passes the plane nor gains energy [s]"
)
FULL = 6  # contestants up to which each has a line in an extreme case


def stability_text(
    pieces: Sequence[Piece],
    extremes: Sequence[ExtremeRow],
    contact_map: Sequence[ContactMapRow] = (),
    contact_steps: Sequence[ContactStepRow] = (),
    charts: bool = False,
) -> Iterator[RenderableType]:
    """Yield what `tumble stability` prints: the text of each scene, then that of the extreme cases.

    Parameters
    ----------
    pieces : results of each contestant in each scene without a plane
    extremes : runs of the extreme cases; may be empty
    contact_map : cells of the maps of the scenes with a plane; may be empty
    contact_steps : largest steps in the scenes with a plane; may be empty
    charts : draw a chart of each scene without a plane

    Yields
    ------
    the parts of the text, from top to bottom
    """
    scenes: dict[str, list[Piece]] = {}
    for piece in pieces:
        scenes.setdefault(piece.limit.scene, []).append(piece)
    for name, own in scenes.items():
        yield from scene_text(name, own, charts)
        yield Text()
    for name in dict.fromkeys(row.scene for row in contact_steps):
        cells = [row for row in contact_map if row.scene == name]
        yield from contact_scene_text(name, cells, [row for row in contact_steps if row.scene == name])
        yield Text()
    if extremes:
        yield from extremes_text(extremes)


def scene_text(name: str, pieces: Sequence[Piece], charts: bool) -> Iterator[RenderableType]:
    """Yield one scene's limits, and why a contestant has none."""
    first = pieces[0].limit
    yield plain(f"{name}: stiffest mode w = {first.w_rad_s:.4g} rad/s")
    if charts:
        yield from limit_chart([piece.limit for piece in pieces])
    yield plain(f"largest steps [s] at {first.parameter} = {first.value:g}")
    finished = [piece for piece in pieces if len(piece.rows) > 1]
    table = columns("contestant", "w dt", "theory", "beyond", "stable", "err 1 %", "err 1 mm", right=(1, 2, 4, 5, 6))
    for piece in finished:
        limit = piece.limit
        own_steps = limit.w_dt_limit is None
        worst = Counter(row.verdict for row in piece.rows).most_common(1)[0][0]
        table.add_row(
            plain(contestant(limit)),
            "own steps" if own_steps else bound(limit.w_dt_limit),
            "" if own_steps else bound(limit.theory_w_dt),
            coloured(worst if own_steps else limit.beyond),
            *("" if dt is None else figure(dt) for dt in (limit.dt_stable_s, limit.dt_1pct_s, limit.dt_1mm_s)),
        )
    if finished:
        yield table
    yield from notes(pieces, finished)


def contact_scene_text(
    name: str, cells: Sequence[ContactMapRow], steps: Sequence[ContactStepRow]
) -> Iterator[RenderableType]:
    """Yield one scene with a plane: up to which slope each contestant holds, and its largest step."""
    yield Constrain(plain(contact_answer(name, cells, steps)), LIST_WIDTH)
    frictions = list(dict.fromkeys(row.friction for row in cells))
    tail = ["largest step [s]", "beyond"]
    if cells:
        tried = ", ".join(sorted({f"{slope(row):.3g}" for row in cells}, key=float))
        yield Constrain(
            plain(f"largest tan(angle) / mu at which it holds, by mu; tried: {tried}; {OF_THE_MAP}"), LIST_WIDTH
        )
        tail = ["off", "creep", "step", "beyond"]
    heads = [f"{mu:.3g}" for mu in frictions]
    table = columns("contestant", *heads, *tail, right=range(1, len(heads) + len(tail)))
    finished = [row for row in steps if row.status in ("ok", "flagged")]
    for row in finished:
        own = [cell for cell in cells if contestant(cell) == contestant(row)]
        off = sum(cell.verdict != cell.true_verdict for cell in own)
        creeps = max((cell.speed_m_s or 0.0 for cell in own if cell.verdict == CREEPS), default=None)
        found = [f"{off}/{len(own)}", "" if creeps is None else figure(creeps)] if cells else []
        held = [holds_to([cell for cell in own if cell.friction == mu]) for mu in frictions]
        table.add_row(plain(contestant(row)), *held, *found, step_limit(row), row.beyond)
    if finished:
        yield table
    if any(row.dt_max_s == math.inf for row in finished):
        yield plain(f"no limit: at no step tried, up to {max(row.dt_to_s or 0.0 for row in finished):.3g} s")
    yield from reasons_text((contestant(row), row.why or row.status) for row in steps if row not in finished)


def contact_answer(name: str, cells: Sequence[ContactMapRow], steps: Sequence[ContactStepRow]) -> str:
    """Return the answer in words: who holds and slides by Coulomb's law, and the smallest of the largest steps."""
    off = dict.fromkeys(contestant(row) for row in cells if row.verdict != row.true_verdict)
    right = [each for each in dict.fromkeys(map(contestant, cells)) if each not in off]
    said = []
    if cells:
        who = listed(right) if right else "no contestant"
        ends = "" if len(right) > 1 else "s"
        said.append(f"{who} hold{ends} below the critical angle and slide{ends} above it")
    limited = [row for row in steps if row.beyond and row.status in ("ok", "flagged")]
    if limited:
        worst = min(limited, key=lambda row: row.dt_max_s or 0.0)
        within = f"beyond a step of {worst.dt_max_s:.2g} s" if worst.dt_max_s else "at the smallest step tried"
        said.append(f"{contestant(worst)} is the first with a limit: {worst.beyond} {within}")
    else:
        said.append("no contestant passes the plane or gains energy at any step tried")
    return f"{name}: {'; '.join(said)}."


def slope(row: ContactMapRow) -> float:
    """Return the slope of a cell over the critical one."""
    return math.tan(row.angle_rad) / row.friction


def holds_to(cells: Sequence[ContactMapRow]) -> str:
    """Return the largest slope, over the critical one, up to which a contestant holds at every one tried."""
    held = 0.0
    for cell in sorted(cells, key=slope):
        if cell.verdict != HOLDS:
            return f"{held:.3g}" if held else "none"
        held = slope(cell)
    return f">={held:.3g}"


def step_limit(row: ContactStepRow) -> str:
    """Return the largest step in words."""
    if row.dt_from_s is None:
        return "own steps"
    if row.dt_max_s is None:
        return "none"
    return "no limit" if math.isinf(row.dt_max_s) else f"{row.dt_max_s:.2g}"


def bound(w_dt: float | None) -> str:
    """Return a limit: a number, none (no step is stable) or no limit (every step tried is)."""
    if w_dt is None:
        return "?"
    if math.isinf(w_dt):
        return "no limit"
    return f"{w_dt:.3g}" if w_dt else "none"


def notes(pieces: Sequence[Piece], finished: Sequence[Piece]) -> Iterator[RenderableType]:
    """Yield the legend, and why contestants have no limits."""
    limits = [piece.limit for piece in finished]
    if any(limit.w_dt_limit == 0.0 for limit in limits):
        yield plain(f"none: unstable at every step tried, down to w dt = {smallest(finished):.2g}")
    if any(limit.w_dt_limit == math.inf for limit in limits):
        yield plain(f"no limit: stable at every step tried, up to w dt = {largest(finished):.2g}")
    if any(limit.theory_w_dt is None and limit.w_dt_limit is not None for limit in limits):
        yield plain("?: no theoretical limit known")
    if any("no reference solution" in limit.note for limit in limits):
        yield plain("no reference solution: verdicts rest on the energy balance alone, and errors are unknown")
    yield from reasons_text((contestant(piece.limit), piece.limit.note) for piece in pieces if piece not in finished)


def smallest(finished: Sequence[Piece]) -> float:
    """Return the smallest w dt that was run."""
    return min(row.dt_s * piece.limit.w_rad_s for piece in finished for row in own_cells(piece))


def largest(finished: Sequence[Piece]) -> float:
    """Return the largest w dt that was run."""
    return max(row.dt_s * piece.limit.w_rad_s for piece in finished for row in own_cells(piece))


def own_cells(piece: Piece) -> list:
    """Return the cells at the scene's own value."""
    return [row for row in piece.rows if row.value == piece.limit.value]


def extremes_text(rows: Sequence[ExtremeRow]) -> Iterator[RenderableType]:
    """Yield one line per extreme case, or per contestant if those are few; then the result of our best method."""
    cases: dict[str, list[ExtremeRow]] = {}
    for row in rows:
        cases.setdefault(row.scene, []).append(row)
    if max(map(len, cases.values())) <= FULL:
        table = columns("case", "contestant", "verdict", "error [m]", "x resolution", "why", right=(3, 4))
        for row in rows:
            error = "" if row.max_error_m is None else figure(row.max_error_m)
            limits = "" if row.error_over_resolution is None else figure(row.error_over_resolution)
            table.add_row(plain(row.scene), plain(contestant(row)), row.verdict, error, limits, plain(row.why))
    else:
        table = columns("extreme case", "resolution [m]", BEST, "verdicts", right=(1, 2))
        for name, own in cases.items():
            limit = next((row.resolution_m for row in own if row.resolution_m is not None), None)
            best = next((row.error_over_resolution for row in own if contestant(row) == BEST), None)
            words = Counter(row.verdict for row in own)
            verdicts = ", ".join(f"{words[word]} {word}" for word in reversed(WORDS) if words[word])
            table.add_row(
                plain(name), "" if limit is None else figure(limit), "" if best is None else f"{best:.2g} x", verdicts
            )
    yield table
    yield from best_text(rows, len(cases))


def best_text(rows: Sequence[ExtremeRow], cases: int) -> Iterator[Text]:
    """Yield whether our best method is as accurate as it must be."""
    if not any(contestant(row) == BEST for row in rows):
        return
    failed = missed(rows)
    if not failed:
        yield plain(f"{BEST} is within {FLOORS:g} times the resolution in all {cases} cases")
    for row in failed:
        yield plain(
            f"{BEST} is not within {FLOORS:g} times the resolution in {row.scene}: {row.verdict}, "
            f"{row.error_over_resolution} times"
        )
