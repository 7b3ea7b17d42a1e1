"""Reads a trajectory that any program wrote, a block of rows at a time; what is bad in it is one line for the user."""

import csv
import stat
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from io import BufferedReader
from itertools import islice
from pathlib import Path

import numpy as np

from compare.grade.columns import CENTRE, MATRIX, QUATERNION, THROW, TIME, BadTrajectory, Column, Shown, layout, shown
from compare.grade.digits import Digits, digits, rounded_times
from scenarios.files import why_unread
from scenarios.format import printable, short
from scenarios.frames import Array, rotation_matrix
from scenarios.scene import Scene

BLOCK = 20_000
# A line of more bytes than this is no row of a trajectory.
LONGEST_LINE = 1_000_000
# Rows whose text is looked at for how numbers are printed.
LOOKED_AT = 200
# A clock that is ahead goes past the end; more than this share of the duration is another scene.
BEYOND = 0.1
SEPARATORS = ",;\t"
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
        self, path: Path, scene: Scene, mapping: Mapping[str, str], by: str | None = None, decimal: str = "."
    ) -> None:
        self.path, self.name, self._scene, self._decimal = path, printable(str(path)), scene, decimal
        with self._open() as file:
            lines = self._lines(file)
            first = next(lines, "")
            self._separator = self._separator_of(first)
            self.header = next(iter(self._rows(iter([first]))), (1, []))[1]
            self._check_header()
            self.columns: dict[str, Column] = layout(self.name, self.header, mapping)
            self.shown: list[Shown] = shown(self.name, self.columns, len(scene.body.points), by)
            looked_at = [row for _, row in islice(self._rows(lines), LOOKED_AT)]
        self.digits: dict[str, Digits] = {
            name: digits(self._pointed(row[column.place]) for row in looked_at if column.place < len(row))
            for name, column in self.columns.items()
        }

    @cached_property
    def half_time(self) -> float:
        """Half a unit of the last printed place of the times, where they show that they are rounded, else 0 [s]."""
        column, printed = self.columns[TIME], self.digits[TIME]
        with self._open() as file:
            lines = self._lines(file)
            next(lines, None)
            cells = [row[column.place] for _, row in islice(self._rows(lines), LOOKED_AT) if len(row) > column.place]
        times = np.array([float(self._pointed(cell)) for cell in cells if _is_number(self._pointed(cell))])
        times = times[: 1 + int(np.argmax(np.append(np.diff(times) <= 0, True)))]
        return column.factor * printed.place / 2 if rounded_times(times, printed.place) else 0.0

    def half_digits(self, name: str, values: Array) -> Array:
        """Return half a unit of the last printed place of a quantity's values, SI."""
        factor = self.columns[name].factor
        return factor * self.digits[name].half(values / factor)

    def blocks(self) -> Iterator[Block]:
        """Yield all rows, at most BLOCK at a time.  Raises BadTrajectory."""
        last: dict[int, float] = {}
        some = False
        with self._open() as file:
            lines = self._lines(file)
            next(lines, None)
            rows = self._rows(lines)
            while part := list(islice(rows, BLOCK)):
                some = True
                yield self._block(part, last)
        if not some:
            raise BadTrajectory(f"{self.name}: no rows below the header")

    def _open(self) -> BufferedReader:
        try:
            if not stat.S_ISREG(self.path.stat().st_mode):
                raise OSError(0, "not a plain file")
            return self.path.open("rb")
        except (OSError, ValueError) as error:
            why = why_unread(error) if isinstance(error, OSError) else printable(str(error))
            raise BadTrajectory(f"{self.name}: {why}") from None

    def _lines(self, file: BufferedReader) -> Iterator[str]:
        number = 0
        while raw := file.readline(LONGEST_LINE + 1):
            number += 1
            if len(raw) > LONGEST_LINE:
                raise BadTrajectory(f"{self.name}: line {number}: longer than {LONGEST_LINE} bytes: no trajectory")
            if number == 1:
                if raw.startswith((b"\xff\xfe", b"\xfe\xff")):
                    raise BadTrajectory(f"{self.name}: is UTF-16 text: save it as UTF-8")
                raw = raw.removeprefix(b"\xef\xbb\xbf")
            if b"\0" in raw:
                raise BadTrajectory(f"{self.name}: line {number}: a null byte: not a text file")
            try:
                yield raw.decode("utf-8")
            except UnicodeDecodeError:
                raise BadTrajectory(f"{self.name}: line {number}: not UTF-8 text") from None

    def _rows(self, lines: Iterator[str]) -> Iterator[tuple[int, list[str]]]:
        """Yield the number of a line and its cells, blank lines left out."""
        reader = csv.reader(lines, delimiter=self._separator, strict=True)
        # The header is line 1 and is read on its own, by a reader that counts for itself.
        before = 0 if not hasattr(self, "header") else 1
        try:
            for cells in reader:
                if cells:
                    yield before + reader.line_num, cells
        except csv.Error as error:
            raise BadTrajectory(f"{self.name}: line {before + reader.line_num}: not CSV: {error}") from None

    def _separator_of(self, first: str) -> str:
        if not first.strip():
            raise BadTrajectory(f"{self.name}: empty" if not first else f"{self.name}: line 1: no header")
        found = [separator for separator in SEPARATORS if separator in first]
        if not found:
            raise BadTrajectory(f"{self.name}: line 1: one column only: cells must be separated by , ; or tabs")
        # A header of semicolons or tabs may have commas within a name; the other way round it may not.
        return found[-1]

    def _check_header(self) -> None:
        self.header = [name.strip() for name in self.header]
        if all(_is_number(self._pointed(name)) for name in self.header if name):
            raise BadTrajectory(f"{self.name}: line 1 holds numbers: it must be a header that names the columns")
        doubled = [name for name in self.header if name and self.header.count(name) > 1]
        if doubled:
            raise BadTrajectory(f"{self.name}: two columns are called {short(doubled[0])}")

    def _pointed(self, cell: str) -> str:
        return cell.replace(",", ".") if self._decimal == "," and self._separator != "," else cell

    def _block(self, part: list[tuple[int, list[str]]], last: dict[int, float]) -> Block:
        width = len(self.header)
        for line, cells in part:
            if len(cells) != width:
                raise BadTrajectory(f"{self.name}: line {line}: {len(cells)} cells, but the header has {width}")
        picked = list(self.columns.items())
        try:
            table = np.array(
                [[self._number(cells[column.place]) for _, column in picked] for _, cells in part], dtype=float
            )
        except ValueError:
            self._refuse_cell(part)
            raise
        if not np.isfinite(table).all():
            self._refuse_cell(part)
        values = {name: table[:, k] * column.factor for k, (name, column) in enumerate(picked)}
        lines = np.array([line for line, _ in part])
        throws = self._throws(values.pop(THROW, None), lines)
        block = Block(lines, throws, values.pop(TIME), values)
        self._check_times(block, last)
        self._check_attitude(block)
        return block

    def _number(self, cell: str) -> float:
        if "_" in cell:  # a digit separator of Python's, not of a number's
            raise ValueError
        return float(self._pointed(cell))

    def _refuse_cell(self, part: list[tuple[int, list[str]]]) -> None:
        """Raise BadTrajectory for the first cell that is no finite number."""
        for line, cells in part:
            for column in self.columns.values():
                cell = cells[column.place]
                try:
                    if np.isfinite(self._number(cell)):
                        continue
                except ValueError:
                    pass
                name = printable(self.header[column.place])
                comma = ", or give --decimal , where commas are decimal points" if "," in cell else ""
                raise BadTrajectory(f"{self.name}: line {line}, {name} = {short(cell)}: must be a finite number{comma}")

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

    def _check_times(self, block: Block, last: dict[int, float]) -> None:
        duration = self._scene.duration
        latest = duration * (1 + BEYOND)
        outside = (block.times < 0) | (block.times > latest)
        if outside.any():
            row = int(np.argmax(outside))
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
                f"before of the same throw, {before[row]:.9g} s"
            )
        ends = np.flatnonzero(np.append(fresh[1:], True))
        last.update(zip(throws[ends].tolist(), times[ends].tolist(), strict=True))

    def _check_attitude(self, block: Block) -> None:
        if QUATERNION[0] in block.values:
            empty = ~(block.of(QUATERNION) != 0).any(axis=1)
            if empty.any():
                line = block.lines[int(np.argmax(empty))]
                raise BadTrajectory(f"{self.name}: line {line}: the quaternion is zero: no attitude")


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


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
    """Return where the file has the vertices [m], (n, K, 3)."""
    if what.kind == "vertices":
        names = [f"v{number}{axis}" for number in what.vertices for axis in "xyz"]
        return block.of(names).reshape(len(block.times), -1, 3)
    axes = axes_of(block, what.kind, scene.body.file_axes, stretched)
    return block.of(CENTRE)[:, None] + np.einsum("nij,kj->nki", axes, scene.body.points)
