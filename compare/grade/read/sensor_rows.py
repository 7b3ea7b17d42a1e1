"""The rows of one sensor in a table of several, such as `sensors.csv`."""

import csv
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

from tumble.compare.grade.read.columns import ACCELEROMETER, GYRO, SPIN, TIME, BadTrajectory, parsed
from tumble.compare.grade.read.formats import draft_file
from tumble.scenarios.format import printable, short
from tumble.scenarios.scene import Sensor

# The column that names a row's sensor, and those that name what simulated it.
SENSOR, CONTESTANT = "sensor", ("scene", "engine", "method", "dt_s", "tolerance")


def rows_of_sensor(path: Path, name: str, sensor: Sensor, stack: ExitStack) -> Path:
    """Return the file, with the rows of one sensor alone if a column names each row's sensor.

    Rows without a reading, as at an impulse, are left out; the others keep their line numbers.

    Parameters
    ----------
    path, name : the CSV file, and its name in messages
    sensor : the sensor
    stack : removes temporary files

    Returns
    -------
    the file, or a temporary one

    Raises
    ------
    BadTrajectory : no row is of that sensor, or rows are of several contestants
    """
    try:
        with path.open(encoding="utf-8", newline="") as text:
            rows = csv.reader(text)
            header = next(rows, [])
            if SENSOR not in header:
                return path
            return _written(name, header, rows, sensor, stack)
    except (OSError, UnicodeDecodeError, csv.Error):
        return path  # the reader reports what is wrong


def _written(file: str, header: list[str], rows: Iterator[list[str]], sensor: Sensor, stack: ExitStack) -> Path:
    place = header.index(SENSOR)
    who = [header.index(name) for name in CONTESTANT if name in header]
    quantities = [(parsed(name) or ("",))[0] for name in header]
    unread = (*ACCELEROMETER * (not sensor.reads_force), *(*GYRO, *SPIN) * (not sensor.reads_spin))
    needed = [
        k for k, name in enumerate(quantities) if name in (TIME, *ACCELEROMETER, *GYRO, *SPIN) and name not in unread
    ]
    names: dict[str, None] = {}
    contestants: dict[tuple[str, ...], None] = {}
    path: Path = draft_file(stack)
    with path.open("w", encoding="utf-8", newline="") as out:
        write = csv.writer(out, lineterminator="\n").writerow
        write(["" if quantity in unread else name for name, quantity in zip(header, quantities, strict=True)])
        for cells in rows:
            whole = len(cells) == len(header)
            if whole:
                names[cells[place]] = None
            if whole and (cells[place] != sensor.name or not all(cells[k].strip() for k in needed)):
                out.write("\n")  # lines keep their numbers
                continue
            if whole:
                contestants[tuple(cells[k] for k in who)] = None
            write(cells)
    if sensor.name not in names:
        raise BadTrajectory(
            f"{file}: column sensor: no row is of {short(sensor.name)}, only of {', '.join(map(short, names))}"
        )
    if len(contestants) > 1:
        several = "; ".join(" ".join(filter(None, map(printable, each))) for each in list(contestants)[:3])
        raise BadTrajectory(f"{file}: has readings of {len(contestants)} contestants ({several}, ...): keep one")
    return path
