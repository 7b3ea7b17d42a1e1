"""The page's section on stability: who is stable where, how long a step each bears, what becomes of extreme cases."""

import math
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from compare.judge.verdict import WORDS
from compare.stability.extremes import BEST, FLOORS, ExtremeRow, missed
from compare.stability.schemas import LimitRow, StabilityRow
from reports.numerals import counted, figure, given, listed
from reports.rows import Tables, contestant

# What stands in a cell, so that nobody needs the colour: the worse, the heavier.
SIGNS = {
    "stable": "",
    "damped": "\N{DOWNWARDS ARROW}",
    "drifting": "\N{UPWARDS ARROW}",
    "under-rotated": "\N{ANTICLOCKWISE OPEN CIRCLE ARROW}",
    "lost-torque": "\N{EMPTY SET}",
    "diverged": "\N{MULTIPLICATION SIGN}",
    "clamped": "\N{BLACK SQUARE}",
    "frozen": "\N{BLACK DIAMOND}",
    "reset": "\N{LEFTWARDS ARROW}",
    "no-return": "?",
    "refused": "\N{EN DASH}",
}
MEANING = {
    "stable": "stable",
    "damped": "damped: loses energy that physics keeps",
    "drifting": "drifting: energy or momentum leaves its band",
    "under-rotated": "turns less than its angular velocity says",
    "lost-torque": "lost its torque",
    "diverged": "diverged",
    "clamped": "clamped: a limit hides the blow-up",
    "frozen": "frozen",
    "reset": "reset to a start",
    "no-return": "no return in the time given",
    "refused": "refused",
}
# Steps of a map are powers of two: one cell is one of them wide, in units of the drawing.
CELL, LEFT, TOP = 12.0, 4.0, 4.0


@dataclass(frozen=True)
class Square:
    """One cell of a map: its corner and width in the drawing, its verdict, its sign, and what to say of it."""

    x: float
    y: float
    width: float
    word: str
    sign: str
    told: str


@dataclass(frozen=True)
class Map:
    """Contestants that have one map in common; theory: x and y of where their limit should be, if anywhere."""

    contestants: list[str]
    squares: list[Square]
    theory: tuple[float, float] | None
    limit: str


@dataclass(frozen=True)
class Ticks:
    """Ticks of w dt along a map, place and number, and the map's values, place and number."""

    steps: list[tuple[float, str]]
    values: list[tuple[float, str]]
    width: float
    height: float


@dataclass(frozen=True)
class LimitLine:
    """One line of the limits: contestant, limit, theory, what comes then, three steps, and the note."""

    contestant: str
    w_dt: str
    theory: str
    then: str
    steps: list[str]


@dataclass(frozen=True)
class SceneMaps:
    """One scene's maps and limits."""

    scene: str
    title: str
    parameter: str
    value: str
    rate: str
    maps: list[Map]
    ticks: Ticks
    words: list[str]
    lines: list[LimitLine]
    sources: str
    absent: list[str]


@dataclass(frozen=True)
class Outcome:
    """One contestant in one extreme case."""

    word: str
    sign: str
    told: str


@dataclass(frozen=True)
class Extremes:
    """The extreme cases: their names, and each contestant's outcomes in that order; None where there is none."""

    finding: str
    cases: list[tuple[str, str]]
    lines: list[tuple[str, list[Outcome | None]]]
    words: list[str]


@dataclass(frozen=True)
class Section:
    """The whole section; extremes None where there were none."""

    scenes: list[SceneMaps]
    extremes: Extremes | None
    signs: dict[str, str]
    meaning: dict[str, str]


def section(tables: Tables) -> Section | None:
    """Return the section, or None where nothing was mapped."""
    if not tables.stability_limits and not tables.extremes:
        return None
    titles = {row.scene: row.title for row in tables.scenes}
    names = dict.fromkeys(row.scene for row in tables.stability_limits)
    scenes = [scene_maps(tables, name, titles.get(name) or name) for name in names]
    return Section(scenes, extremes(tables.extremes) if tables.extremes else None, SIGNS, MEANING)


def scene_maps(tables: Tables, name: str, title: str) -> SceneMaps:
    """Return one scene's maps and limits."""
    limits = [row for row in tables.stability_limits if row.scene == name]
    cells: dict[str, list[StabilityRow]] = {}
    for row in tables.stability_cells:
        if row.scene == name:
            cells.setdefault(contestant(row), []).append(row)
    flown = [row for row in limits if len(cells[contestant(row)]) > 1]
    stepped = [row for row in flown if row.w_dt_limit is not None]
    grid = Grid([row for limit in stepped for row in cells[contestant(limit)]], limits[0])
    return SceneMaps(
        name,
        title,
        limits[0].parameter,
        given(limits[0].value),
        figure(limits[0].w_rad_s, 4),
        maps(stepped, cells, grid),
        grid.ticks(),
        words_seen(row.verdict for limit in stepped for row in cells[contestant(limit)]),
        [limit_line(row, cells[contestant(row)]) for row in flown],
        "; ".join(dict.fromkeys(row.theory for row in stepped if row.theory)),
        [f"{listed(names)}: {why}" for why, names in absent(limits, flown).items()],
    )


class Grid:
    """Where the cells of a scene's maps are drawn: steps to the right, as w dt, values upwards."""

    def __init__(self, cells: Sequence[StabilityRow], limit: LimitRow) -> None:
        self._values = sorted({row.value for row in cells}, reverse=True)
        self._rate, self._own = limit.w_rad_s, limit.value
        own = [row.dt_s * self._rate for row in cells if row.value == limit.value]
        self._least, self._most = min(own, default=1.0), max(own, default=1.0)
        # At another value the mode turns at another rate, and its longest step is as many radians.
        self._longest = {value: max(row.dt_s for row in cells if row.value == value) for value in self._values}

    def place(self, w_dt: float) -> float:
        """Return where a step is drawn, one of the ladder at the left edge of its cell."""
        return LEFT + CELL * math.log2(w_dt / self._least)

    def w_dt(self, row: StabilityRow) -> float:
        """Return a cell's step in radians of the stiffest mode."""
        return self._most * row.dt_s / self._longest[row.value]

    def squares(self, cells: Sequence[StabilityRow]) -> list[Square]:
        """Return the cells of one contestant: where a step was left out between two, the longer of them is wider."""
        made = []
        for row, value in enumerate(self._values):
            right = self.place(2 * self._most)
            for cell in sorted((each for each in cells if each.value == value), key=lambda each: -each.dt_s):
                left = self.place(self.w_dt(cell))
                made.append(Square(left, TOP + CELL * row, right - left, cell.verdict, SIGNS[cell.verdict], told(cell)))
                right = left
        return made

    def ticks(self) -> Ticks:
        """Return the numbers along the edges."""
        steps = [(self.place(10.0**power) + CELL / 2, f"{10.0**power:g}") for power in range(-3, 4)]
        right = self.place(2 * self._most)
        return Ticks(
            [(place, text) for place, text in steps if LEFT < place < right],
            [(TOP + CELL * (row + 0.5), figure(value, 2)) for row, value in enumerate(self._values)],
            right + LEFT,
            TOP + CELL * len(self._values),
        )

    def limit(self, w_dt: float | None) -> tuple[float, float] | None:
        """Return where a limit is drawn, across the row of the scene's own value, None where it is not on the map."""
        if w_dt is None or not self._least < w_dt < 2 * self._most:
            return None
        return self.place(w_dt) + CELL / 2, TOP + CELL * self._values.index(self._own)


def maps(limits: Sequence[LimitRow], cells: dict[str, list[StabilityRow]], grid: Grid) -> list[Map]:
    """Return the maps, one for all contestants whose verdicts are the same in every cell; who bears most is first."""
    groups: dict[tuple, list[LimitRow]] = {}
    for limit in limits:
        own = cells[contestant(limit)]
        groups.setdefault(tuple((row.value, row.dt_s, row.verdict) for row in own), []).append(limit)
    ranked = sorted(groups.values(), key=lambda group: -(group[0].w_dt_limit or 0.0))
    return [
        Map(
            [contestant(limit) for limit in group],
            grid.squares(cells[contestant(group[0])]),
            grid.limit(group[0].theory_w_dt),
            bound(group[0].w_dt_limit),
        )
        for group in ranked
    ]


def told(row: StabilityRow) -> str:
    """Return what is said of one cell."""
    error = (
        "" if row.max_error_m is None or not math.isfinite(row.max_error_m) else f", {figure(row.max_error_m)} m off"
    )
    return f"{row.verdict} at {figure(row.value, 2)}, step {figure(row.dt_s, 2)} s{error}"


def bound(w_dt: float | None) -> str:
    """Return a limit in words."""
    if w_dt is None:
        return ""
    if math.isinf(w_dt):
        return "no limit"
    return figure(w_dt) if w_dt else "none: grows at every step"


def limit_line(row: LimitRow, cells: Sequence[StabilityRow]) -> LimitLine:
    """Return one line of the table of limits."""
    own_steps = row.w_dt_limit is None
    mostly = Counter(cell.verdict for cell in cells).most_common(1)[0][0]
    return LimitLine(
        contestant(row),
        "steps of its own" if own_steps else bound(row.w_dt_limit),
        "" if own_steps else bound(row.theory_w_dt),
        mostly if own_steps else row.beyond,
        ["" if dt is None else figure(dt) for dt in (row.dt_stable_s, row.dt_1pct_s, row.dt_1mm_s)],
    )


def absent(limits: Sequence[LimitRow], flown: Sequence[LimitRow]) -> dict[str, list[str]]:
    """Return who did not fly, by the reason."""
    reasons: dict[str, list[str]] = {}
    for row in limits:
        if row not in flown:
            reasons.setdefault(row.note.removeprefix(f"{row.method} "), []).append(contestant(row))
    return reasons


def words_seen(verdicts: Iterable[str]) -> list[str]:
    """Return the verdicts that are there, from good to bad."""
    seen = set(verdicts)
    return [word for word in SIGNS if word in seen]


def extremes(rows: Sequence[ExtremeRow]) -> Extremes:
    """Return the table of extreme cases."""
    cases = {row.scene: row.title for row in rows}
    found: dict[str, dict[str, Outcome]] = {}
    for row in rows:
        found.setdefault(contestant(row), {})[row.scene] = Outcome(row.verdict, SIGNS[row.verdict], told_extreme(row))
    folded: dict[str, list[str]] = {}
    for name, own in found.items():
        # The methods of an engine that refuse everything are one line.
        refused = {outcome.word for outcome in own.values()} == {"refused"}
        folded.setdefault(name.partition(":")[0] if refused else name, []).append(name)
    return Extremes(
        best(rows, len(cases)),
        list(cases.items()),
        [
            (
                names[0] if len(names) == 1 else f"{key}: {len(names)} methods",
                [found[names[0]].get(case) for case in cases],
            )
            for key, names in folded.items()
        ],
        words_seen(row.verdict for row in rows),
    )


def told_extreme(row: ExtremeRow) -> str:
    """Return what is said of one contestant in one case."""
    parts = [row.verdict]
    if row.max_error_m is not None and math.isfinite(row.max_error_m):
        parts.append(f"{figure(row.max_error_m)} m off, {figure(row.times_limit or 0.0)} times what the truth can tell")
    return "; ".join((*parts, row.why) if row.why else parts)


def best(rows: Sequence[ExtremeRow], cases: int) -> str:
    """Return how our own best method did."""
    if not any(contestant(row) == BEST for row in rows):
        return ""
    failed = missed(rows)
    if not failed:
        return f"{BEST} is within {given(FLOORS)} times what the truth can tell in all {counted(cases, 'case')}."
    where = listed([row.scene for row in failed])
    return f"{BEST} is further off than {given(FLOORS)} times what the truth can tell in {where}."


assert set(SIGNS) == set(MEANING) == set(WORDS)
