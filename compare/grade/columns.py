"""What a column of somebody's trajectory is: a quantity and its unit, said by its name or by the user.

A name is QUANTITY_UNIT, as in our own trajectories: t_s, x_m, qw, vx_m_s, wx_rad_s, v0x_m; also r11 ... r33 for a
matrix body to world, row then column, and `throw`.  Other units have names too: t_ms, x_cm, wx_deg_s.  Nothing is
guessed.
"""

import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import pi
from pathlib import Path
from typing import NamedTuple

from scenarios.files import plain_bytes, why_unread
from scenarios.format import nearest, printable, short

IGNORED = "ignore"
UNITS: dict[str, dict[str, float]] = {
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0},
    "length": {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "km": 1e3, "in": 0.0254, "ft": 0.3048},
    "speed": {"m_s": 1.0, "cm_s": 1e-2, "mm_s": 1e-3, "km_h": 1 / 3.6, "ft_s": 0.3048},
    "rate": {"rad_s": 1.0, "deg_s": pi / 180, "rpm": pi / 30},
    "none": {"": 1.0},
}
CENTRE = ("x", "y", "z")
QUATERNION = ("qw", "qx", "qy", "qz")
MATRIX = tuple(f"r{row}{column}" for row in "123" for column in "123")
VELOCITY = ("vx", "vy", "vz")
SPIN = ("wx", "wy", "wz")
TIME, THROW = "t", "throw"
VERTEX = re.compile(r"v(\d{1,6})[xyz]", re.ASCII)
# Names that say that something is there but not what: which of four numbers is the scalar.
UNORDERED = re.compile(r"(q|quat|quaternion|orientation)[_.]?[0-4]", re.ASCII | re.IGNORECASE)


class BadTrajectory(ValueError):
    """A trajectory that cannot be graded as it is; the message is the one line for the user."""


class Column(NamedTuple):
    """Where a quantity is found in a row, and its unit in SI."""

    place: int
    factor: float


def dimension(quantity: str) -> str | None:
    """Return what a quantity is measured in, or None where there is no such quantity."""
    if quantity == TIME:
        return "time"
    if quantity in CENTRE or VERTEX.fullmatch(quantity):
        return "length"
    if quantity in VELOCITY:
        return "speed"
    if quantity in SPIN:
        return "rate"
    return "none" if quantity in (*QUATERNION, *MATRIX, THROW) else None


def parsed(name: str) -> tuple[str, float] | None:
    """Return the quantity a name stands for and its unit in SI, or None."""
    quantity, _, unit = name.partition("_")
    measured = dimension(quantity)
    if measured is None or unit not in UNITS[measured]:
        return None
    return quantity, UNITS[measured][unit]


def layout(file: str, header: Sequence[str], mapping: Mapping[str, str]) -> dict[str, Column]:
    """Return where each quantity is.

    mapping: column -> name, or `ignore`.  Raises BadTrajectory for names nobody knows and for what is ambiguous.
    """
    for column, name in mapping.items():
        if column not in header:
            raise BadTrajectory(f"{file}: no column {short(column)} to map: {nearest(column, list(header))}")
        if name != IGNORED and parsed(name) is None:
            raise BadTrajectory(f"{file}: {short(column)} = {short(name)}: {_allowed(name)}")
    found: dict[str, Column] = {}
    for index, column in enumerate(header):
        name = mapping.get(column, column)
        meaning = parsed(name)
        if meaning is None:
            if name != IGNORED:
                _ask(file, column)
            continue
        quantity, factor = meaning
        if quantity in found:
            first = header[found[quantity].place]
            raise BadTrajectory(
                f"{file}: columns {short(first)} and {short(column)} both say {quantity}: which one? "
                f"e.g. --map {printable(column)}={IGNORED}"
            )
        found[quantity] = Column(index, factor)
    return found


def _ask(file: str, column: str) -> None:
    """Raise BadTrajectory where a column is likely meant for something that its name does not say."""
    quantity = column.strip().lower()
    measured = dimension(quantity)
    if measured not in (None, "none"):
        units = ", ".join(f"{quantity}_{unit}" for unit in UNITS[measured])
        raise BadTrajectory(
            f"{file}: column {short(column)} does not say its unit: --map {printable(column)}=NAME with one of {units}"
        )
    if UNORDERED.fullmatch(quantity):
        raise BadTrajectory(
            f"{file}: column {short(column)} does not say which number of the quaternion it is: "
            f"--map {printable(column)}=NAME with one of qw, qx, qy, qz, the same for the other three"
        )


def _allowed(name: str) -> str:
    quantity = name.partition("_")[0]
    measured = dimension(quantity)
    if measured is None:
        return f"no such name; there are t_s, x_m .., qw .., r11 .., vx_m_s .., wx_rad_s .., v0x_m .., and {IGNORED}"
    units = [f"{quantity}_{unit}" if unit else quantity for unit in UNITS[measured]]
    return f"must be one of {', '.join(units)}"


def mapping_of(pairs: Sequence[str]) -> dict[str, str]:
    """Return column -> name from COLUMN=NAME ...; a column's name may contain `=`.  Raises BadTrajectory."""
    mapping: dict[str, str] = {}
    for pair in pairs:
        column, equals, name = pair.rpartition("=")
        if not equals or not column or not name:
            raise BadTrajectory(f"--map {short(pair)}: must be COLUMN=NAME, e.g. --map Time=t_s")
        if column in mapping:
            raise BadTrajectory(f"--map {short(column)}: given twice")
        mapping[column] = name
    return mapping


def mapping_file(path: Path) -> dict[str, str]:
    """Return column -> name from the table [columns] of a TOML file.  Raises BadTrajectory."""
    shown = printable(str(path))
    try:
        document = tomllib.loads(plain_bytes(path).decode("utf-8-sig"))
    except OSError as error:
        raise BadTrajectory(f"{shown}: {why_unread(error)}") from None
    except UnicodeDecodeError:
        raise BadTrajectory(f"{shown}: not UTF-8 text") from None
    except (ValueError, RecursionError) as error:
        raise BadTrajectory(f"{shown}: not TOML: {printable(str(error))[:200]}") from None
    for key in document:
        if key != "columns":
            raise BadTrajectory(f"{shown}: {short(key)}: unknown key; there is only the table [columns]")
    columns = document.get("columns")
    if not isinstance(columns, dict):
        raise BadTrajectory(f"{shown}: columns: must be a table of column = name, e.g. Time = 't_s'")
    for column, name in columns.items():
        if not isinstance(name, str):
            raise BadTrajectory(f"{shown}: columns.{printable(column)} = {short(name)}: must be a name, e.g. 't_s'")
    return columns


@dataclass(frozen=True)
class Shown:
    """What a trajectory shows of the body: which description of its place, and what else."""

    kind: str
    vertices: tuple[int, ...]
    velocities: bool
    spin: bool


def shown(file: str, columns: Mapping[str, Column], points: int, by: str | None) -> list[Shown]:
    """Return the descriptions of the body's place in a file, the one to grade first.

    points: how many the body has; by: the one that the user wants, or None.  Raises BadTrajectory where a description
    has a part missing, a vertex does not exist, or nothing says where the body is.
    """
    if TIME not in columns:
        raise BadTrajectory(f"{file}: no column says the time: name it t_s, or say which, e.g. --map COLUMN=t_s")
    for group in (CENTRE, QUATERNION, MATRIX, VELOCITY, SPIN):
        _whole(file, columns, group)
    numbers = sorted({int(match[1]) for name in columns if (match := VERTEX.fullmatch(name))})
    for number in numbers:
        if number >= points:
            raise BadTrajectory(f"{file}: v{number}: the body has vertices 0 to {points - 1}")
        _whole(file, columns, tuple(f"v{number}{axis}" for axis in "xyz"))
    velocities = all(name in columns for name in (*VELOCITY, *SPIN))
    turned = CENTRE[0] in columns
    has = {
        "vertices": bool(numbers),
        "pose": turned and QUATERNION[0] in columns,
        "matrix": turned and MATRIX[0] in columns,
    }
    if not any(has.values()):
        raise BadTrajectory(
            f"{file}: nothing says where the body is: x_m, y_m, z_m with qw, qx, qy, qz or r11 ... r33, or v0x_m, "
            "v0y_m, v0z_m, ...; name foreign columns with --map COLUMN=NAME"
        )
    if by and not has[by]:
        raise BadTrajectory(f"{file}: --by {by}: the file has {' and '.join(kind for kind in has if has[kind])} only")
    order = [by] if by else [kind for kind in has if has[kind]]
    everything = tuple(range(points))
    return [
        Shown(kind, tuple(numbers) if kind == "vertices" else everything, velocities, SPIN[0] in columns)
        for kind in order
    ]


def _whole(file: str, columns: Mapping[str, Column], group: Sequence[str]) -> None:
    missing = [name for name in group if name not in columns]
    if missing and len(missing) < len(group):
        raise BadTrajectory(f"{file}: {', '.join(missing)} missing beside {_rest(columns, group)}")


def _rest(columns: Mapping[str, Column], group: Sequence[str]) -> str:
    return ", ".join(name for name in group if name in columns)
