"""Reads a trajectory that any program wrote, a block of rows at a time; what is bad in it is one line for the user."""

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from pathlib import Path

import numpy as np

from tumble.compare.grade.read.block import Block
from tumble.compare.grade.read.cells import LARGEST, Cells
from tumble.compare.grade.read.columns import (
    ANGLES,
    CENTRE,
    MATRIX,
    QUATERNION,
    SPIN,
    THROW,
    TIME,
    UNITS,
    VERTEX,
    Answer,
    BadTrajectory,
    Column,
    Shown,
    Unsaid,
)
from tumble.compare.grade.read.conventions import (
    BODY,
    Reading,
    matrix_of,
    order_of,
    quaternion_digits,
    quaternions,
    renamed,
)
from tumble.compare.grade.read.digits import Digits, alike, digits, rounded_times, shared_place
from tumble.compare.grade.read.even_clock import EXACT, EvenClock, PrintedClock, even_clock
from tumble.compare.grade.read.header import layout, shown
from tumble.compare.grade.read.suggestions import angles_of, map_option, map_options
from tumble.scenarios.format import printable, short
from tumble.scenarios.frames import Array, rotation_matrix
from tumble.scenarios.scene import Scene

# Vertices of a block of rows: what measuring one takes is some hundred bytes each.
BLOCK = 200_000
# A clock that is ahead goes past the end; more than this share of the duration is another scene.
BEYOND = 0.1
# Rows past the end that are further apart than this share of the duration are those of a clock in other units.
SPARSEST = 0.1


class Trajectory:
    """A file that has been opened and whose header is understood.

    shown: what it shows of the body, the description to grade first; digits: quantity -> how it is printed; clock: what
    its printed instants mean.
    Raises BadTrajectory for what cannot be read or is ambiguous.
    """

    def __init__(
        self,
        path: Path,
        scene: Scene,
        mapping: Mapping[str, str],
        by: str | None = None,
        decimal: str = ".",
        reading: Reading | None = None,
    ) -> None:
        self._reading, self._scene = reading or Reading(), scene
        self.name = self._reading.name or printable(str(path))
        self._cells = Cells(path, self.name, decimal, self._reading.first_line)
        self.header = self._cells.header
        self._most_rows = max(1, BLOCK // len(scene.body.points))
        self._matrix = matrix_of(self._reading.axes, scene)
        self.columns: dict[str, Column] = renamed(layout(self.name, self.header, mapping), self._matrix)
        described = self._described()
        self.shown: list[Shown] = shown(self.name, self.header, mapping, described, len(scene.body.points), by)
        first_rows, others = self._cells.looked_at()
        self.digits = self._printed([*first_rows, *others])
        self._first_times, self._last_times = self._instants(first_rows), self._instants(others)
        self.clock = self._printed_clock([time * self.columns[TIME].factor for time in self._last_times])

    def _instants(self, rows: Sequence[Sequence[str]]) -> list[float]:
        """Return what rows of cells have for the time, in its own unit."""
        place = self.columns[TIME].place
        times = (self._cells.number(row[place]) for row in rows if place < len(row))
        return [time for time in times if time is not None and abs(time) <= LARGEST]

    def _printed(self, rows: Sequence[Sequence[str]]) -> dict[str, Digits]:
        """Return how each quantity is printed."""
        found: dict[str, Digits] = {
            name: digits(self._cells.pointed(row[column.place]) for row in rows if column.place < len(row))
            for name, column in self.columns.items()
        }
        for group in self.places():
            found |= zip(group, alike([found[name] for name in group]), strict=True)
        return found | quaternion_digits(self.columns, found) if self._reading.euler else found

    def places(self) -> list[list[str]]:
        """Return the names of the columns that say where the body is: centre, attitude, corners, each printed alike."""
        corners = [name for name in self.columns if VERTEX.fullmatch(name)]
        groups = ([name for name in group if name in self.columns] for group in (CENTRE, QUATERNION, MATRIX, ANGLES))
        return [group for group in (*groups, corners) if group]

    def _described(self) -> dict[str, Column]:
        """Return the columns, those of a quaternion too where --euler makes one of angles.  Raises BadTrajectory."""
        if not self._reading.euler:
            for name in ANGLES:
                self.columns.pop(name, None)
            return self.columns
        order_of(self._reading.euler)
        if missing := [name for name in ANGLES if name not in self.columns]:
            meant = {
                column: f"{angle}_{unit or 'deg'}"
                for column, (angle, unit) in angles_of(self.header).items()
                if angle in missing
            }
            raise Unsaid(
                f"{self.name}: --euler: {', '.join(missing)} missing: it takes rx_deg, ry_deg, rz_deg or rx_rad, ..."
                + (f"; in degrees: {map_options(meant)}" if meant else ""),
                "which columns are the angles",
                Answer(meant),
            )
        return self.columns | dict.fromkeys(QUATERNION, Column(self.columns[ANGLES[0]].place, 1.0))

    def _printed_clock(self, later: Sequence[float]) -> EvenClock | PrintedClock:
        """Return the clock of the instants: even but for their printed digits, or as printed.

        later: instants from all over the file [s].
        """
        first, start = self._first_run, self._reading.start or 0.0
        # 0.01667 may be printed as 0.0166700.
        factor = self.columns[TIME].factor
        shared = factor * shared_place(first / factor)

        def half_of(times: Array) -> Array:
            return self.half_digits(TIME, times)

        for half in (half_of, lambda times: np.maximum(half_of(times), shared / 2)):
            if (found := even_clock(first, np.array(later), half, start)) is not None:
                return found
        is_rounded = rounded_times(first, 2 * float(half_of(first[-1:]).max(initial=0.0)))
        return PrintedClock(half_of) if is_rounded else EXACT

    @cached_property
    def _first_run(self) -> Array:
        """Return the first instants [s], as long as they increase."""
        times = self.columns[TIME].factor * np.array(self._first_times)
        return times[: 1 + int(np.argmax(np.append(np.diff(times) <= 0, True)))]

    @property
    def share(self) -> float:
        """How much of the file has been read by now, from 0 to 1."""
        return self._cells.share

    def half_digits(self, name: str, values: Array) -> Array:
        """Return half a unit of the last printed place of a quantity's values, SI."""
        factor = abs(self.columns[name].factor) if name in self.columns else 1.0
        return factor * self.digits[name].half(values / factor)

    def blocks(self) -> Iterator[Block]:
        """Yield all rows, a block at a time.  Raises BadTrajectory."""
        last: dict[int, float] = {}
        some = False
        for lines, table in self._cells.tables(list(self.columns.values()), self._most_rows):
            some = True
            for begin in range(0, len(lines), self._most_rows):
                part = slice(begin, begin + self._most_rows)
                block = self._block(lines[part], table[part], last)
                if len(block.lines):
                    yield block
        if not some:
            raise BadTrajectory(f"{self.name}: no rows below the header")

    def _block(self, lines: np.ndarray, table: Array, last: dict[int, float]) -> Block:
        values = {name: table[:, k] * column.factor for k, (name, column) in enumerate(self.columns.items())}
        if self._reading.euler:
            angles = np.stack([values.pop(name) for name in ANGLES], axis=1)
            turned = quaternions(angles, self._reading.euler, self._matrix)
            values |= dict(zip(QUATERNION, turned.T, strict=True))
        if self._reading.spin == BODY:
            values |= _turned_spin(values)
        throws = self._throws(values.pop(THROW, None), lines)
        printed = values.pop(TIME)
        times, rounding = self.clock.read(printed)
        block = self._within(Block(lines, throws, times - (self._reading.start or 0.0), rounding, values))
        self._check_times(block, last)
        self._check_attitude(block)
        return block

    def _throws(self, column: Array | None, lines: np.ndarray) -> np.ndarray:
        count = len(self._scene.start)
        if column is None:
            return np.zeros(len(lines), dtype=int)
        bad = (column != np.floor(column)) | (column < 0) | (column >= count)
        if bad.any():
            row = int(np.argmax(bad))
            raise BadTrajectory(
                f"{self.name}: line {lines[row]}, member = {column[row]:g}: "
                f"must be a whole number from 0 to {count - 1}"
            )
        return column.astype(int)

    def _within(self, block: Block) -> Block:
        """Return the rows of a block before the scene's end, where those after it are no sign of another clock."""
        beyond = block.times > self._scene.duration * (1 + BEYOND)
        if not beyond.any() or not self._goes_on:
            return block
        told = f"rows past the end of {self._scene.name}, {self._scene.duration:g} s, are ignored"
        if told not in self._reading.notes:
            self._reading.notes.append(told)
        return block.some(~beyond)

    @cached_property
    def _interval(self) -> float:
        """Return the time between the first rows [s]."""
        times = self.columns[TIME].factor * np.array(self._first_times[:10])
        return float(np.median(np.diff(times))) if len(times) > 1 else np.inf

    @property
    def _first_time(self) -> float:
        return self.columns[TIME].factor * self._first_times[0] if self._first_times else 0.0

    @cached_property
    def _goes_on(self) -> bool:
        """Whether rows past the end are those of a longer flight: the clock starts at 0, and its unit fits."""
        if self._reading.start is not None:
            return self._first_time - self._reading.start <= self._scene.duration
        return 0 <= self._first_time <= 1.5 * self._interval and 0 < self._interval <= SPARSEST * self._scene.duration

    def _check_times(self, block: Block, last: dict[int, float]) -> None:
        duration = self._scene.duration
        latest = duration * (1 + BEYOND)
        outside = (block.times < 0) | (block.times > latest)
        if outside.any():
            row = int(np.argmax(outside))
            self._ask_for_the_clock(int(block.lines[row]), float(block.times[row]), latest)
        order = np.argsort(block.throws, kind="stable")
        throws, times = block.throws[order], block.times[order]
        fresh = np.diff(throws, prepend=-1) != 0
        before = np.concatenate(([-np.inf], times[:-1]))
        for row in np.flatnonzero(fresh):
            before[row] = last.get(int(throws[row]), -np.inf)
        late = np.flatnonzero(times <= before)
        if len(late):
            row = late[0]
            raise BadTrajectory(
                f"{self.name}: line {block.lines[order[row]]}, t = {times[row]:.9g} s: must be later than the row "
                f"before of the same throw, {before[row]:.9g} s{self._throws_unsaid()}"
            )
        ends = np.flatnonzero(np.append(fresh[1:], True))
        last.update(zip(throws[ends].tolist(), times[ends].tolist(), strict=True))

    def check_clock(self) -> None:
        """Raise Unsaid where the first row's instant is not of the scene, whatever else is bad in the rows."""
        time, latest = self._first_time - (self._reading.start or 0.0), self._scene.duration * (1 + BEYOND)
        if not 0 <= time <= latest:
            self._ask_for_the_clock(self._reading.first_line, time, latest)

    def _ask_for_the_clock(self, line: int, time: float, latest: float) -> None:
        """Raise Unsaid: an instant [s] in a line is before the scene's start or later than any of it."""
        scene, duration = self._scene.name, self._scene.duration
        column = self.header[self.columns[TIME].place]
        message = (
            f"{self.name}: line {line}, t = {time:g} s: must be from 0 to {latest:g} s: {scene} lasts {duration:g} s"
        )
        if self._reading.start is None and 0 < self._interval <= SPARSEST * duration:
            start = f"its clock starts at {self._first_time!r} s"
            raise Unsaid(
                f"{message}; where its clock starts at its first row: --start {self._first_time!r} "
                f"(other units: {map_option(column, 't_ms')}, ...)",
                start,
                Answer(start=self._first_time),
            )
        unit = self._likely_unit()
        offer = map_option(column, f"t_{unit or 'ms'}")
        asks = f"in which unit {short(column)} is"
        raise Unsaid(f"{message} (other units: {offer}, ...)", asks, Answer({column: f"t_{unit}"} if unit else {}))

    def _likely_unit(self) -> str:
        """Return the unit of time in which rows are as dense as they are, and end with the scene; '' for none."""
        times = np.array(self._first_times[:2] + self._last_times)
        span = times.max() - times.min() if len(times) > 1 else 0.0
        for unit, factor in UNITS["time"].items():
            if 0 < factor * span <= (1 + BEYOND) * self._scene.duration:
                return unit
        return ""

    def likely_starts(self) -> list[float | None]:
        """Return what the clock may show at the start [s]: 0, which is None, the first row's time, or a row before."""
        first = self._first_time
        starts: list[float | None] = [] if self._reading.start is not None or first < 0 else [None]
        return [*starts, first, *([first - self._interval] if first and np.isfinite(self._interval) else [])]

    def _throws_unsaid(self) -> str:
        several = len(self._scene.start) > 1 and THROW not in self.columns
        return f": {self._scene.name} has many throws, and a column `member` says which one a row is of" * several

    def _check_attitude(self, block: Block) -> None:
        if QUATERNION[0] in block.values:
            empty = ~(block.of(QUATERNION) != 0).any(axis=1)
            if empty.any():
                line = block.lines[int(np.argmax(empty))]
                raise BadTrajectory(f"{self.name}: line {line}: the quaternion is zero: no attitude")


def _turned_spin(values: Mapping[str, Array]) -> dict[str, Array]:
    """Return an angular velocity in world axes that is in the body's, nothing where there is none, or no attitude."""
    if not all(name in values for name in SPIN):
        return {}
    if all(name in values for name in QUATERNION):
        q = np.stack([values[name] for name in QUATERNION], axis=1)
        lengths = np.linalg.norm(q, axis=1)[:, None]
        axes = rotation_matrix(q / np.where(lengths > 0, lengths, 1.0))
    elif all(name in values for name in MATRIX):
        axes = np.stack([values[name] for name in MATRIX], axis=1).reshape(-1, 3, 3)
    else:
        return {}
    w_body = np.stack([values[name] for name in SPIN], axis=1)
    return dict(zip(SPIN, np.einsum("nij,nj->in", axes, w_body), strict=True))
