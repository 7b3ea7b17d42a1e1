"""The cells of a CSV file that any program wrote, a part at a time; an error is one line for the user."""

import csv
import os
import re
import stat
from collections import Counter
from collections.abc import Iterator, Sequence
from io import BufferedReader
from itertools import islice
from pathlib import Path

import numpy as np

from tumble.compare.grade.read.columns import AmbiguousFile, BadTrajectory, Column, Suggestion
from tumble.scenarios.files import why_unread
from tumble.scenarios.format import printable, short, visible
from tumble.scenarios.frames import Array

# What follows a decimal comma.
DECIMALS = re.compile(r"\d+(?:[eE][+-]?\d+)?\s*", re.ASCII)
# Bytes read at a time; a longer line is not a row of a trajectory.
LONGEST_LINE = 1_000_000
# Rows that show how numbers are printed: this many at the beginning, and as many from this many places.
LOOKED_AT, PLACES = 200, 20
SEPARATORS = ",;\t"
# No position, time or quaternion is larger; products of squares of larger numbers overflow.
LARGEST = 1e50


class Cells:
    """A file whose separator and header are known.

    header: names of its columns; first_line: number of the first row's line in messages; share: of its bytes that have
    been read.  Raises BadTrajectory if it cannot be read.
    """

    def __init__(self, path: Path, name: str, decimal: str, first_line: int) -> None:
        self._path, self.name, self._decimal, self._first_line = path, name, decimal, first_line
        self.header: list[str] = []
        self.share = 0.0
        with self._open() as file:
            first = next(self._lines(file, 0), "")
        self._separator = self._separator_of(first)
        self.header = [name.strip() for _, cells in self._rows(iter([first]), 0) for name in cells]
        self._check_header()

    def sampled_rows(self) -> tuple[list[list[str]], list[list[str]]]:
        """Return the first rows, and rows from all over the file, where growing numbers show their last digits."""
        with self._open() as file:
            next(self._lines(file, 0), None)
            first = [row for _, row in islice(self._rows(self._lines(file, 1), 1), LOOKED_AT)]
            return first, list(self._here_and_there(file))

    def tables(self, columns: Sequence[Column], most_rows: int) -> Iterator[tuple[np.ndarray, Array]]:
        """Yield line numbers, (n,), and the given columns in their own units, (n, columns).

        Parts of plain numbers are read at once.  From the first other part on, rows are read one by one, which handles
        quotes and blank lines and can report the line of an error.  most_rows: of a table read row by row.
        """
        self.share = 0.0
        with self._open() as file:
            size = max(os.fstat(file.fileno()).st_size, 1)
            next(self._lines(file, 0), None)
            before = self._first_line - 1
            while part := file.read(LONGEST_LINE) + file.readline(LONGEST_LINE + 1):
                is_whole = len(part) <= 2 * LONGEST_LINE
                table = self._plain(part, columns) if is_whole else None
                if table is None:
                    file.seek(-len(part), os.SEEK_CUR)
                    for rows in self._row_by_row(self._rows(self._lines(file, before), before), columns, most_rows):
                        self.share = file.tell() / size
                        yield rows
                    break
                self.share = file.tell() / size
                yield np.arange(before + 1, before + 1 + len(table)), table
                before += len(table)
        self.share = 1.0

    def _here_and_there(self, file: BufferedReader) -> Iterator[list[str]]:
        """Yield rows from all over the file."""
        size = file.seek(0, os.SEEK_END)
        for part in range(1, PLACES):
            file.seek(size * part // PLACES)
            file.readline(LONGEST_LINE)  # the rest of a row
            for _ in range(LOOKED_AT // PLACES):
                cells = self._joined(file.readline(LONGEST_LINE).decode(errors="replace").split(self._separator))
                if len(cells) == len(self.header):
                    yield cells

    def _plain(self, part: bytes, columns: Sequence[Column]) -> Array | None:
        """Return the columns of lines that hold plain numbers, in as many cells as the header, or None."""
        if b'"' in part or b"\0" in part or (self._decimal == "," and (b"." in part or self._separator == ",")):
            return None
        try:
            lines = self.with_decimal_point(part.decode()).removesuffix("\n").split("\n")
            if {line.count(self._separator) for line in lines} != {len(self.header) - 1}:
                return None
            places = [column.place for column in columns]
            table = np.loadtxt(lines, delimiter=self._separator, comments=None, usecols=places, ndmin=2)
        except ValueError:
            return None
        return table if len(table) == len(lines) and (np.abs(table) <= LARGEST).all() else None

    def _row_by_row(
        self, rows: Iterator[tuple[int, list[str]]], columns: Sequence[Column], most_rows: int
    ) -> Iterator[tuple[np.ndarray, Array]]:
        while part := list(islice(rows, most_rows)):
            yield np.array([line for line, _ in part]), np.array([self._numbers(*row, columns) for row in part])

    def _open(self) -> BufferedReader:
        try:
            if not stat.S_ISREG(self._path.stat().st_mode):
                raise OSError(0, "not a plain file")
            return self._path.open("rb")
        except (OSError, ValueError) as error:
            why = why_unread(error) if isinstance(error, OSError) else printable(str(error))
            raise BadTrajectory(f"{self.name}: {why}") from None

    def _lines(self, file: BufferedReader, number: int) -> Iterator[str]:
        """Yield the lines of a file as text; number: of lines already read."""
        while raw := file.readline(LONGEST_LINE + 1):
            number += 1
            if len(raw) > LONGEST_LINE:
                raise BadTrajectory(f"{self.name}: line {number}: longer than {LONGEST_LINE} bytes: not a trajectory")
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
        """Yield line numbers and cells, without empty lines and comments; before: number of lines already read."""
        reader = csv.reader(lines, delimiter=self._separator, strict=True)
        try:
            for cells in reader:
                is_comment = before + reader.line_num > 1 and cells and cells[0].lstrip().startswith("#")
                if any(map(str.strip, cells)) and not is_comment:
                    yield before + reader.line_num, self._joined(cells)
        except csv.Error as error:
            raise BadTrajectory(
                f"{self.name}: line {before + reader.line_num}: not CSV: {visible(str(error))}"
            ) from None

    def _are_halves(self, cells: Sequence[str]) -> bool:
        """Whether the decimal comma is also the separator: 0,02,1,5 is 0.02 and 1.5."""
        return (
            self._separator == "," and len(cells) == 2 * len(self.header) and all(map(DECIMALS.fullmatch, cells[1::2]))
        )

    def _joined(self, cells: list[str]) -> list[str]:
        """Return the cells of a row, with numbers joined that a decimal comma split."""
        if self._decimal != "," or not self._are_halves(cells):
            return cells
        return [f"{whole},{part}" for whole, part in zip(cells[::2], cells[1::2], strict=True)]

    def _separator_of(self, first: str) -> str:
        if not first.strip():
            raise BadTrajectory(f"{self.name}: empty" if not first else f"{self.name}: line 1: no header")
        # Names may be quoted, and a comma may be followed by blanks, of which a tab is one.
        bare = re.sub(r'"[^"]*"', "", first.strip())
        found = [separator for separator in SEPARATORS if separator in re.sub(r",\s+", ",", bare)]
        if not found:
            raise BadTrajectory(f"{self.name}: line 1: only one column: cells must be separated by , ; or tabs")
        # A header separated by semicolons or tabs may have commas within a name, but not the reverse.
        return found[-1]

    def _check_header(self) -> None:
        if not self.header:
            raise BadTrajectory(f"{self.name}: line 1: no header")
        if not self.header[-1]:
            self.header.pop()  # a separator after every cell
        if all(self.number(name) is not None for name in self.header if name):
            raise BadTrajectory(f"{self.name}: line 1 has numbers: it must be a header that names the columns")
        doubled = [name for name, count in Counter(filter(None, self.header)).items() if count > 1]
        if doubled:
            raise BadTrajectory(f"{self.name}: two columns are called {short(doubled[0])}")

    def with_decimal_point(self, text: str) -> str:
        """Return text with decimal points."""
        return text.replace(",", ".") if self._decimal == "," else text

    def _numbers(self, line: int, cells: list[str], columns: Sequence[Column]) -> list[float]:
        """Return the numbers of a row in the given columns.  Raises BadTrajectory."""
        width = len(self.header)
        if len(cells) == width + 1 and not cells[-1].strip():
            cells.pop()  # a separator after every cell
        if self._decimal != "," and self._are_halves(cells):
            raise self._decimal_question(f"line {line}: {len(cells)} cells, but the header has {width}")
        if len(cells) != width:
            commas = self._separator == "," and len(cells) > width
            why = " (decimal commas need cells in quotes, or separated by ; or tabs)" if commas else ""
            raise BadTrajectory(f"{self.name}: line {line}: {len(cells)} cells, but the header has {width}{why}")
        numbers = [self.number(cells[column.place]) for column in columns]
        for number, column in zip(numbers, columns, strict=True):
            if number is None or not abs(number) <= LARGEST:
                self._refuse_cell(line, column.place, cells[column.place])
        return numbers  # type: ignore[return-value]

    def number(self, cell: str) -> float | None:
        """Return the number in a cell, or None; `_` between digits is Python syntax, not a number."""
        if "_" in cell or (self._decimal == "," and "." in cell):
            return None
        try:
            return float(self.with_decimal_point(cell))
        except ValueError:
            return None

    def _refuse_cell(self, line: int, place: int, cell: str) -> None:
        why = f"must be a finite number of at most {LARGEST:g}"
        where = f"line {line}, {printable(self.header[place])} = {short(cell)}"
        if self._decimal == "," and "." in cell:
            why = "has a decimal point, but --decimal , asks for commas"
        elif "," in cell:
            raise self._decimal_question(f"{where}: {why}")
        raise BadTrajectory(f"{self.name}: {where}: {why}")

    def _decimal_question(self, message: str) -> AmbiguousFile:
        """Return the question whether commas are decimal signs."""
        return AmbiguousFile(
            f"{self.name}: {message}; if commas are decimal signs, give --decimal ,",
            "whether commas are decimal signs",
            Suggestion(decimal=","),
        )
