"""Reads a trajectory that any program wrote, a block of rows at a time; what is bad in it is one line for the user."""

import csv
import os
import re
import stat
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from io import BufferedReader
from itertools import islice
from pathlib import Path

import numpy as np

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
from scenarios.files import why_unread
from scenarios.format import printable, short, visible
from scenarios.frames import Array, rotation_matrix
from scenarios.scene import Scene

# Vertices of a block of rows: what measuring one takes is some hundred bytes each.
BLOCK = 200_000
# Bytes that are read at a time; a line of more bytes than this is no row of a trajectory.
LONGEST_LINE = 1_000_000
# Rows whose text is looked at for how numbers are printed: so many first ones, and as many from so many places.
LOOKED_AT, PLACES = 200, 20
# A clock that is ahead goes past the end; more than this share of the duration is another scene.
BEYOND = 0.1
# Rows past the end that are further apart than this share of the duration are those of a clock in other units.
SPARSEST = 0.1
SEPARATORS = ",;\t"
# Neither a place nor a time nor a part of a unit quaternion: products of squares of larger ones would overflow.
LARGEST = 1e50
CONJUGATE = (1.0, -1.0, -1.0, -1.0)


@dataclass(frozen=True, eq=False)
class Block:
    """Rows of one file, each of one throw at one instant.

    lines: where in the file, (n,); throws: (n,); times [s], (n,); values: quantity -> SI, (n,).
    """

    lines: np.ndarray
    throws: np.ndarray
    times: Array
    values: dict[str, Array]

    def of(self, names: Sequence[str]) -> Array:
        """Return these quantities side by side, (n, len(names))."""
        return np.stack([self.values[name] for name in names], axis=1)

    def throw(self, throw: int) -> "Block":
        """Return the rows of one throw."""
        if (self.throws == throw).all():
            return self
        rows = self.throws == throw
        values = {name: column[rows] for name, column in self.values.items()}
        return Block(self.lines[rows], self.throws[rows], self.times[rows], values)


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
        self._reading = reading or Reading()
        self.path, self.name, self._scene, self._decimal = path, printable(str(path)), scene, decimal
        self.name = self._reading.name or self.name
        self._most_rows = max(1, BLOCK // len(scene.body.points))
        with self._open() as file:
            first = next(self._lines(file, 0), "")
            self._separator = self._separator_of(first)
            self.header = [name.strip() for _, cells in self._rows(iter([first]), 0) for name in cells]
            self._check_header()
            self._matrix = matrix_of(self._reading.axes, scene)
            self.columns: dict[str, Column] = renamed(layout(self.name, self.header, mapping), self._matrix)
            described = self._described()
            self.shown: list[Shown] = shown(self.name, self.header, mapping, described, len(scene.body.points), by)
            first_rows = [row for _, row in islice(self._rows(self._lines(file, 1), 1), LOOKED_AT)]
            looked_at = [*first_rows, *self._here_and_there(file)]
        self.digits: dict[str, Digits] = {
            name: digits(self._pointed(row[column.place]) for row in looked_at if column.place < len(row))
            for name, column in self.columns.items()
        }
        for group in (CENTRE, QUATERNION, MATRIX, ANGLES, [name for name in self.columns if VERTEX.fullmatch(name)]):
            names = [name for name in group if name in self.columns]
            self.digits |= zip(names, alike([self.digits[name] for name in names]), strict=True)
        if self._reading.euler:
            self.digits |= quaternion_digits(self.columns, self.digits)
        clock = self.columns[TIME].place
        times = (self._number(row[clock]) for row in first_rows if clock < len(row))
        self._first_times = [time for time in times if time is not None and abs(time) <= LARGEST]

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

    def _here_and_there(self, file: BufferedReader) -> Iterator[list[str]]:
        """Yield rows from all over the file: a number that grows shows its last digit further on."""
        size = file.seek(0, os.SEEK_END)
        for part in range(1, PLACES):
            file.seek(size * part // PLACES)
            file.readline(LONGEST_LINE)  # what is left of a row
            for _ in range(LOOKED_AT // PLACES):
                cells = file.readline(LONGEST_LINE).decode(errors="replace").split(self._separator)
                if len(cells) == len(self.header):
                    yield cells

    def blocks(self) -> Iterator[Block]:
        """Yield all rows, a block at a time.  Raises BadTrajectory."""
        last: dict[int, float] = {}
        some = False
        with self._open() as file:
            next(self._lines(file, 0), None)
            for lines, table in self._tables(file):
                some = True
                for begin in range(0, len(lines), self._most_rows):
                    part = slice(begin, begin + self._most_rows)
                    block = self._block(lines[part], table[part], last)
                    if len(block.lines):
                        yield block
        if not some:
            raise BadTrajectory(f"{self.name}: no rows below the header")

    def _tables(self, file: BufferedReader) -> Iterator[tuple[np.ndarray, Array]]:
        """Yield the numbers of lines and the columns that mean something, (n, columns), in their own units.

        All at once while the lines are plain numbers; from the first part that is otherwise row by row, which takes
        quotes and blank lines, and can say what is wrong in which line.
        """
        before = self._reading.first_line - 1
        while part := file.read(LONGEST_LINE) + file.readline(LONGEST_LINE + 1):
            is_whole = len(part) <= 2 * LONGEST_LINE
            table = self._plain(part) if is_whole else None
            if table is None:
                file.seek(-len(part), os.SEEK_CUR)
                yield from self._row_by_row(self._rows(self._lines(file, before), before))
                return
            yield np.arange(before + 1, before + 1 + len(table)), table
            before += len(table)

    def _plain(self, part: bytes) -> Array | None:
        """Return the columns of lines that hold plain numbers, in as many cells as the header, or None."""
        if b'"' in part or b"\0" in part or (self._decimal == "," and (b"." in part or self._separator == ",")):
            return None
        try:
            lines = self._pointed(part.decode()).removesuffix("\n").split("\n")
            if {line.count(self._separator) for line in lines} != {len(self.header) - 1}:
                return None
            places = [column.place for column in self.columns.values()]
            table = np.loadtxt(lines, delimiter=self._separator, comments=None, usecols=places, ndmin=2)
        except ValueError:
            return None
        return table if len(table) == len(lines) and (np.abs(table) <= LARGEST).all() else None

    def _row_by_row(self, rows: Iterator[tuple[int, list[str]]]) -> Iterator[tuple[np.ndarray, Array]]:
        while part := list(islice(rows, self._most_rows)):
            yield np.array([line for line, _ in part]), np.array([self._numbers(*row) for row in part])

    def _open(self) -> BufferedReader:
        try:
            if not stat.S_ISREG(self.path.stat().st_mode):
                raise OSError(0, "not a plain file")
            return self.path.open("rb")
        except (OSError, ValueError) as error:
            why = why_unread(error) if isinstance(error, OSError) else printable(str(error))
            raise BadTrajectory(f"{self.name}: {why}") from None

    def _lines(self, file: BufferedReader, number: int) -> Iterator[str]:
        """Yield the lines of a file, so many of which have been read, as text."""
        while raw := file.readline(LONGEST_LINE + 1):
            number += 1
            if len(raw) > LONGEST_LINE:
                raise BadTrajectory(f"{self.name}: line {number}: longer than {LONGEST_LINE} bytes: no trajectory")
            if number == 1:
                if raw.startswith((b"\xff\xfe", b"\xfe\xff")):
                    raise BadTrajectory(f"{self.name}: is UTF-16 text: save it as UTF-8")
                raw = raw.removeprefix(b"\xef\xbb\xbf")
            if b"\r" in raw.rstrip(b"\r\n"):
                raise BadTrajectory(f"{self.name}: line {number}: lines end in CR alone: save it with LF or CR LF")
            if b"\0" in raw:
                raise BadTrajectory(f"{self.name}: line {number}: a null byte: not a text file")
            try:
                yield raw.decode("utf-8")
            except UnicodeDecodeError:
                raise BadTrajectory(f"{self.name}: line {number}: not UTF-8 text") from None

    def _rows(self, lines: Iterator[str], before: int) -> Iterator[tuple[int, list[str]]]:
        """Yield the number of a line and its cells, empty lines and comments left out; before: how many come before."""
        reader = csv.reader(lines, delimiter=self._separator, strict=True)
        try:
            for cells in reader:
                is_comment = before + reader.line_num > 1 and cells and cells[0].lstrip().startswith("#")
                if any(map(str.strip, cells)) and not is_comment:
                    yield before + reader.line_num, cells
        except csv.Error as error:
            raise BadTrajectory(
                f"{self.name}: line {before + reader.line_num}: not CSV: {visible(str(error))}"
            ) from None

    def _separator_of(self, first: str) -> str:
        if not first.strip():
            raise BadTrajectory(f"{self.name}: empty" if not first else f"{self.name}: line 1: no header")
        # Names may be quoted, and a comma may be followed by blanks, of which a tab is one.
        bare = re.sub(r'"[^"]*"', "", first.strip())
        found = [separator for separator in SEPARATORS if separator in re.sub(r",\s+", ",", bare)]
        if not found:
            raise BadTrajectory(f"{self.name}: line 1: one column only: cells must be separated by , ; or tabs")
        # A header of semicolons or tabs may have commas within a name; the other way round it may not.
        return found[-1]

    def _check_header(self) -> None:
        if not self.header:
            raise BadTrajectory(f"{self.name}: line 1: no header")
        if not self.header[-1]:
            self.header.pop()  # a separator after every cell
        if all(self._number(name) is not None for name in self.header if name):
            raise BadTrajectory(f"{self.name}: line 1 holds numbers: it must be a header that names the columns")
        doubled = [name for name, count in Counter(filter(None, self.header)).items() if count > 1]
        if doubled:
            raise BadTrajectory(f"{self.name}: two columns are called {short(doubled[0])}")

    def _pointed(self, text: str) -> str:
        return text.replace(",", ".") if self._decimal == "," else text

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

    def _numbers(self, line: int, cells: list[str]) -> list[float]:
        """Return the cells of a row that mean something.  Raises BadTrajectory."""
        width = len(self.header)
        if len(cells) == width + 1 and not cells[-1].strip():
            cells.pop()  # a separator after every cell
        if len(cells) != width:
            commas = self._separator == "," and len(cells) > width
            why = " (decimal commas need cells in quotes, or separated by ; or tabs)" if commas else ""
            raise BadTrajectory(f"{self.name}: line {line}: {len(cells)} cells, but the header has {width}{why}")
        numbers = [self._number(cells[column.place]) for column in self.columns.values()]
        for number, column in zip(numbers, self.columns.values(), strict=True):
            if number is None or not abs(number) <= LARGEST:
                self._refuse_cell(line, column.place, cells[column.place])
        return numbers  # type: ignore[return-value]

    def _number(self, cell: str) -> float | None:
        """Return the number in a cell, or None; a _ between digits is Python's way of writing, not a number's."""
        if "_" in cell or (self._decimal == "," and "." in cell):
            return None
        try:
            return float(self._pointed(cell))
        except ValueError:
            return None

    def _refuse_cell(self, line: int, place: int, cell: str) -> None:
        why = f"must be a finite number of at most {LARGEST:g}"
        if self._decimal == "," and "." in cell:
            why = "a point, but --decimal , says that the decimal sign is a comma"
        elif "," in cell:
            why += ", or give --decimal , where commas are decimal points"
        raise BadTrajectory(f"{self.name}: line {line}, {printable(self.header[place])} = {short(cell)}: {why}")

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


def axes_of(block: Block, kind: str, file_axes: Array, stretched: bool = True) -> Array:
    """Return the matrices principal axes to world as the file has them, (n, 3, 3), rotations or not.

    stretched: a quaternion that is not of length 1 stretches them by its square, as it does where nobody normalises.
    """
    if kind == "matrix":
        axes = block.of(MATRIX).reshape(-1, 3, 3)
    else:
        q = block.of(QUATERNION)
        square = (q * q).sum(axis=1)
        axes = rotation_matrix(q / np.sqrt(square)[:, None])
        if stretched:
            axes *= square[:, None, None]
    return axes @ rotation_matrix(file_axes * CONJUGATE)


def vertices_of(block: Block, what: Shown, scene: Scene, stretched: bool = True) -> Array:
    """Return where the file has the vertices [m], (n, K, 3); from the centre of mass where it does not say that."""
    if what.kind == "vertices":
        names = [f"v{number}{axis}" for number in what.vertices for axis in "xyz"]
        return block.of(names).reshape(len(block.times), -1, 3)
    axes = axes_of(block, what.kind, scene.body.file_axes, stretched)
    turned = np.einsum("nij,kj->nki", axes, scene.body.points)
    return block.of(CENTRE)[:, None] + turned if what.centred else turned
