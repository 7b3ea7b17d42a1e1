"""Reads a trajectory that any program wrote, a block of rows at a time; an error is one line for the user."""

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from pathlib import Path

import numpy as np

from tumble.compare.grade.read.block import Block
from tumble.compare.grade.read.cells import LARGEST, Cells
from tumble.compare.grade.read.columns import (
    ACCELEROMETER,
    ANGLES,
    CENTRE,
    GYRO,
    MATRIX,
    QUATERNION,
    SPIN,
    THROW,
    TIME,
    UNITS,
    VERTEX,
    AmbiguousFile,
    BadTrajectory,
    Column,
    Description,
    Suggestion,
    is_reading,
)
from tumble.compare.grade.read.conventions import (
    BODY,
    Conventions,
    matrix_of,
    order_of,
    quaternion_digits,
    quaternions,
    renamed,
)
from tumble.compare.grade.read.digits import (
    Digits,
    digits,
    rounded_times,
    shared_place,
    with_exact_numbers,
    with_shared_format,
)
from tumble.compare.grade.read.even_clock import EXACT, EvenClock, PrintedClock, even_clock
from tumble.compare.grade.read.header import descriptions, layout
from tumble.compare.grade.read.suggestions import angles_of, map_option, map_options
from tumble.scenarios.format import printable, short
from tumble.scenarios.frames import Array, rotation_matrix
from tumble.scenarios.scene import Scene

# Vertices of a block of rows: measuring takes some hundred bytes for each.
BLOCK = 200_000
# A clock that runs ahead may pass the end; by more than this share of the duration, the file is of another scene.
BEYOND = 0.1
# Rows past the end whose spacing is above this share of the duration come from a clock in another unit.
SPARSEST = 0.1


class Trajectory:
    """An open file whose header has been read.

    descriptions: how the file describes the body's pose, the one to grade first, none if it has only readings of a
    sensor; digits: quantity -> how it is printed; clock: how printed times are read.
    Raises BadTrajectory if the file cannot be read or is ambiguous.
    """

    def __init__(
        self,
        path: Path,
        scene: Scene,
        mapping: Mapping[str, str],
        by: str | None = None,
        decimal: str = ".",
        conventions: Conventions | None = None,
    ) -> None:
        self._conventions, self._scene = conventions or Conventions(), scene
        self.name = self._conventions.name or printable(str(path))
        self._cells = Cells(path, self.name, decimal, self._conventions.first_line)
        self.header = self._cells.header
        self._most_rows = max(1, BLOCK // len(scene.body.points))
        self._matrix = matrix_of(self._conventions.axes, scene)
        self.columns: dict[str, Column] = renamed(
            layout(self.name, self.header, mapping, with_readings=bool(scene.sensors)), self._matrix
        )
        described = self._described()
        points, with_readings = len(scene.body.points), bool(scene.sensors)
        try:
            self.descriptions: list[Description] = descriptions(
                self.name, self.header, mapping, described, points, by, with_readings
            )
        except BadTrajectory:
            if not with_readings and any(map(is_reading, self.header)):
                raise without_sensor(scene) from None
            raise
        if not with_readings and any(map(is_reading, mapping.values())):
            raise without_sensor(scene)
        first_rows, others = self._cells.sampled_rows()
        self.digits = self._printed(first_rows, others)
        self._first_times, self._last_times = self._instants(first_rows), self._instants(others)
        self.clock = self._printed_clock([time * self.columns[TIME].factor for time in self._last_times])

    def _instants(self, rows: Sequence[Sequence[str]]) -> list[float]:
        """Return the times of rows of cells, in the unit of the column."""
        return [time for time in self._numbers(TIME, rows) if abs(time) <= LARGEST]

    def _numbers(self, name: str, rows: Sequence[Sequence[str]]) -> list[float]:
        """Return the numbers of rows of cells in a column, in its unit."""
        place = self.columns[name].place
        numbers = (self._cells.number(row[place]) for row in rows if place < len(row))
        return [number for number in numbers if number is not None]

    def _printed(self, first_rows: Sequence[Sequence[str]], others: Sequence[Sequence[str]]) -> dict[str, Digits]:
        """Return how each quantity is printed."""
        rows = [*first_rows, *others]
        found: dict[str, Digits] = {
            name: digits(
                (self._cells.with_decimal_point(row[column.place]) for row in rows if column.place < len(row)),
                column.factor,
            )
            for name, column in self.columns.items()
        }
        for group in self.places():
            found |= zip(group, with_shared_format([found[name] for name in group]), strict=True)
        found = with_exact_numbers(found, self.places(), {name: self._numbers(name, first_rows) for name in found})
        return found | quaternion_digits(self.columns, found) if self._conventions.euler else found

    def places(self) -> list[list[str]]:
        """Return the columns of the pose in groups with one print format each: centre, attitude, vertices."""
        corners = [name for name in self.columns if VERTEX.fullmatch(name)]
        described = (CENTRE, QUATERNION, MATRIX, ANGLES, ACCELEROMETER, GYRO)
        groups = ([name for name in group if name in self.columns] for group in described)
        return [group for group in (*groups, corners) if group]

    def _described(self) -> dict[str, Column]:
        """Return the columns, with a quaternion if --euler converts angles to one.  Raises BadTrajectory."""
        if not self._conventions.euler:
            for name in ANGLES:
                self.columns.pop(name, None)
            return self.columns
        order_of(self._conventions.euler)
        if missing := [name for name in ANGLES if name not in self.columns]:
            likely = {
                column: f"{angle}_{unit or 'deg'}"
                for column, (angle, unit) in angles_of(self.header).items()
                if angle in missing
            }
            raise AmbiguousFile(
                f"{self.name}: --euler: {', '.join(missing)} missing: needed are rx_deg, ry_deg, rz_deg, or rx_rad, ..."
                + (f"; in degrees: {map_options(likely)}" if likely else ""),
                "which columns are the angles",
                Suggestion(likely),
            )
        return self.columns | dict.fromkeys(QUATERNION, Column(self.columns[ANGLES[0]].place, 1.0))

    def _printed_clock(self, later: Sequence[float]) -> EvenClock | PrintedClock:
        """Return the clock: even up to the printed digits, or as printed.  later: times from all over the file [s]."""
        first, start = self._first_run, self._conventions.start or 0.0
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
        """Return the first times [s], as long as they increase."""
        times = self.columns[TIME].factor * np.array(self._first_times)
        return times[: 1 + int(np.argmax(np.append(np.diff(times) <= 0, True)))]

    @property
    def devices(self) -> dict[str, tuple[str, str, str]]:
        """The columns of an accelerometer and of a gyro; without a pose, w is read as a gyro's."""
        found = {"accelerometer": ACCELEROMETER} if ACCELEROMETER[0] in self.columns else {}
        if GYRO[0] in self.columns:
            found["gyro"] = GYRO
        elif SPIN[0] in self.columns and not self.descriptions:
            found["gyro"] = SPIN
        return found

    @property
    def share(self) -> float:
        """The share of the file that has been read, 0 to 1."""
        return self._cells.share

    def half_digits(self, name: str, values: Array) -> Array:
        """Return half a unit in the last printed place of a quantity's values, SI."""
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
        if self._conventions.euler:
            angles = np.stack([values.pop(name) for name in ANGLES], axis=1)
            turned = quaternions(angles, self._conventions.euler, self._matrix)
            values |= dict(zip(QUATERNION, turned.T, strict=True))
        if self._conventions.spin == BODY:
            values |= _spin_in_world(values)
        throws = self._throws(values.pop(THROW, None), lines)
        printed = values.pop(TIME)
        times, rounding = self.clock.read(printed)
        block = self._until_end(Block(lines, throws, times - (self._conventions.start or 0.0), rounding, values))
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

    def _until_end(self, block: Block) -> Block:
        """Return the rows of a block up to the scene's end if the file is of a longer run, else all."""
        beyond = block.times > self._scene.duration * (1 + BEYOND)
        if not beyond.any() or not self._is_longer_run:
            return block
        note = f"rows after the end of {self._scene.name} ({self._scene.duration:g} s) are ignored"
        if note not in self._conventions.notes:
            self._conventions.notes.append(note)
        return block.some(~beyond)

    @cached_property
    def _interval(self) -> float:
        """The time between the first rows [s]."""
        times = self.columns[TIME].factor * np.array(self._first_times[:10])
        return float(np.median(np.diff(times))) if len(times) > 1 else np.inf

    @property
    def _first_time(self) -> float:
        return self.columns[TIME].factor * self._first_times[0] if self._first_times else 0.0

    @cached_property
    def _is_longer_run(self) -> bool:
        """Whether rows past the end are of a longer run: the clock starts at 0, and its unit fits."""
        if self._conventions.start is not None:
            return self._first_time - self._conventions.start <= self._scene.duration
        return 0 <= self._first_time <= 1.5 * self._interval and 0 < self._interval <= SPARSEST * self._scene.duration

    def _check_times(self, block: Block, last: dict[int, float]) -> None:
        duration = self._scene.duration
        latest = duration * (1 + BEYOND)
        outside = (block.times < 0) | (block.times > latest)
        if outside.any():
            row = int(np.argmax(outside))
            self._ask_clock(int(block.lines[row]), float(block.times[row]), latest)
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
                f"before it of the same throw, {before[row]:.9g} s{self._members_hint()}"
            )
        ends = np.flatnonzero(np.append(fresh[1:], True))
        last.update(zip(throws[ends].tolist(), times[ends].tolist(), strict=True))

    def check_clock(self) -> None:
        """Raise AmbiguousFile if the first row's time is outside the scene's duration, whatever else is wrong."""
        time, latest = self._first_time - (self._conventions.start or 0.0), self._scene.duration * (1 + BEYOND)
        if not 0 <= time <= latest:
            self._ask_clock(self._conventions.first_line, time, latest)

    def _ask_clock(self, line: int, time: float, latest: float) -> None:
        """Raise AmbiguousFile: the time [s] of a line is outside the scene's duration."""
        scene, duration = self._scene.name, self._scene.duration
        column = self.header[self.columns[TIME].place]
        where = f"{self.name}: line {line}, t = {time:g} s"
        message = f"{where}: must be from 0 to {latest:g} s, since {scene} lasts {duration:g} s"
        if self._conventions.start is None and 0 < self._interval <= SPARSEST * duration:
            start = f"whether its clock starts at {self._first_time!r} s"
            raise AmbiguousFile(
                f"{message}; if its clock starts at its first row, give --start {self._first_time!r} "
                f"(other units: {map_option(column, 't_ms')}, ...)",
                start,
                Suggestion(start=self._first_time),
            )
        unit = self._likely_unit()
        offer = map_option(column, f"t_{unit or 'ms'}")
        topic = f"the unit of {short(column)}"
        raise AmbiguousFile(
            f"{message} (other units: {offer}, ...)", topic, Suggestion({column: f"t_{unit}"} if unit else {})
        )

    def _likely_unit(self) -> str:
        """Return the unit of time in which the file lasts as long as the scene; empty if there is none."""
        times = np.array(self._first_times[:2] + self._last_times)
        span = times.max() - times.min() if len(times) > 1 else 0.0
        for unit, factor in UNITS["time"].items():
            if 0 < factor * span <= (1 + BEYOND) * self._scene.duration:
                return unit
        return ""

    def likely_starts(self) -> list[float | None]:
        """Return what the clock may show at the scene's start [s]: 0 (None), the first row's time, or a row before."""
        first = self._first_time
        starts: list[float | None] = [] if self._conventions.start is not None or first < 0 else [None]
        return [*starts, first, *([first - self._interval] if first and np.isfinite(self._interval) else [])]

    def _members_hint(self) -> str:
        several = len(self._scene.start) > 1 and THROW not in self.columns
        return (
            f": {self._scene.name} has several throws; a column `member` must give the number of each row's throw"
            * several
        )

    def _check_attitude(self, block: Block) -> None:
        if QUATERNION[0] in block.values:
            empty = ~(block.of(QUATERNION) != 0).any(axis=1)
            if empty.any():
                line = block.lines[int(np.argmax(empty))]
                raise BadTrajectory(f"{self.name}: line {line}: the quaternion is zero")


def without_sensor(scene: Scene) -> BadTrajectory:
    """Return the error for readings in a scene that has no sensor."""
    return BadTrajectory(
        f"{scene.name} has no sensor, so readings have no reference: add [[sensor]] to the scene file, "
        'with name = "imu", kind = "imu", rate = 100.0 and point = [0.1, 0.0, 0.0]'
    )


def _spin_in_world(values: Mapping[str, Array]) -> dict[str, Array]:
    """Return the angular velocity in world axes, given in body axes; empty without one, or without an attitude."""
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
