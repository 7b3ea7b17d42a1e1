"""Reads a trajectory that any program wrote, a block of rows at a time; what is bad in it is one line for the user."""

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from pathlib import Path

import numpy as np

from compare.grade.block import Block
from compare.grade.cells import LARGEST, Cells
from compare.grade.columns import (
    ANGLES,
    CENTRE,
    MATRIX,
    QUATERNION,
    THROW,
    TIME,
    VERTEX,
    BadTrajectory,
    Column,
    Shown,
)
from compare.grade.conventions import Reading, matrix_of, order_of, quaternion_digits, quaternions, renamed
from compare.grade.digits import Digits, alike, digits, rounded_times
from compare.grade.header import layout, shown
from compare.grade.offers import angles_of, map_option
from scenarios.format import printable
from scenarios.frames import Array
from scenarios.scene import Scene

# Vertices of a block of rows: what measuring one takes is some hundred bytes each.
BLOCK = 200_000
# A clock that is ahead goes past the end; more than this share of the duration is another scene.
BEYOND = 0.1
# Rows past the end that are further apart than this share of the duration are those of a clock in other units.
SPARSEST = 0.1


class Trajectory:
    """A file that has been opened and whose header is understood.

    shown: what it shows of the body, the description to grade first; digits: quantity -> how it is printed.
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
        clock = self.columns[TIME].place
        times = (self._cells.number(row[clock]) for row in first_rows if clock < len(row))
        self._first_times = [time for time in times if time is not None and abs(time) <= LARGEST]

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
            offers = " ".join(
                map_option(column, f"{angle}_{unit or 'deg'}")
                for column, (angle, unit) in angles_of(self.header).items()
                if angle in missing
            )
            raise BadTrajectory(
                f"{self.name}: --euler: {', '.join(missing)} missing: it takes rx_deg, ry_deg, rz_deg or rx_rad, ..."
                + (f"; in degrees: {offers}" if offers else "")
            )
        return self.columns | dict.fromkeys(QUATERNION, Column(self.columns[ANGLES[0]].place, 1.0))

    def half_times(self, times: Array) -> Array:
        """Return half a unit of the last printed place of instants [s], 0 where the file's do not show rounding."""
        times = times + (self._reading.start or 0.0)
        return self.half_digits(TIME, times) if self._rounded_times else np.zeros(len(times))

    @cached_property
    def _rounded_times(self) -> bool:
        times = np.array(self._first_times)
        times = times[: 1 + int(np.argmax(np.append(np.diff(times) <= 0, True)))]
        return rounded_times(times, 2 * float(self.digits[TIME].half(times[-1:]).max(initial=0.0)))

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
        throws = self._throws(values.pop(THROW, None), lines)
        times = values.pop(TIME) - (self._reading.start or 0.0)
        block = self._within(Block(lines, throws, times, values))
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
                f"{self.name}: line {lines[row]}, throw = {column[row]:g}: must be a whole number from 0 to {count - 1}"
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
        kept = ~beyond
        values = {name: column[kept] for name, column in block.values.items()}
        return Block(block.lines[kept], block.throws[kept], block.times[kept], values)

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
            if 0 < self._interval <= SPARSEST * duration and self._reading.start is None:
                raise BadTrajectory(
                    f"{self.name}: line {block.lines[row]}, t = {block.times[row]:g} s: must be from 0 to "
                    f"{latest:g} s: {self._scene.name} lasts {duration:g} s; "
                    "where its clock starts at its first row: --start "
                    f"{self._first_time!r} (other units: --map COLUMN=t_ms, ...)"
                )
            raise BadTrajectory(
                f"{self.name}: line {block.lines[row]}, t = {block.times[row]:g} s: must be from 0 to {latest:g} s: "
                f"{self._scene.name} lasts {duration:g} s (other units: --map COLUMN=t_ms, ...)"
            )
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

    def _throws_unsaid(self) -> str:
        several = len(self._scene.start) > 1 and THROW not in self.columns
        return f": {self._scene.name} has many throws, and a column `throw` says which one a row is of" * several

    def _check_attitude(self, block: Block) -> None:
        if QUATERNION[0] in block.values:
            empty = ~(block.of(QUATERNION) != 0).any(axis=1)
            if empty.any():
                line = block.lines[int(np.argmax(empty))]
                raise BadTrajectory(f"{self.name}: line {line}: the quaternion is zero: no attitude")
