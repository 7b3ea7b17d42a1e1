"""What a column of somebody's trajectory is: a quantity and its unit, said by its name or by the user.

A name is QUANTITY_UNIT, as in our own trajectories: t_s, x_m, qw, vx_m_s, wx_rad_s, v0x_m; also r11 ... r33 for a
matrix body to world, row then column, and `throw`.  Other units have names too: t_ms, x_cm, wx_deg_s.  Nothing is
guessed.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from math import pi
from typing import NamedTuple

from tumble.scenarios.refusal import UserError

IGNORED = "ignore"
UNITS: dict[str, dict[str, float]] = {
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0},
    "length": {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "km": 1e3, "in": 0.0254, "ft": 0.3048},
    "speed": {"m_s": 1.0, "cm_s": 1e-2, "mm_s": 1e-3, "km_h": 1 / 3.6, "ft_s": 0.3048},
    "angle": {"rad": 1.0, "deg": pi / 180},
    "rate": {"rad_s": 1.0, "deg_s": pi / 180, "rpm": pi / 30},
    "none": {"": 1.0},
}
CENTRE = ("x", "y", "z")
QUATERNION = ("qw", "qx", "qy", "qz")
MATRIX = tuple(f"r{row}{column}" for row in "123" for column in "123")
VELOCITY = ("vx", "vy", "vz")
SPIN = ("wx", "wy", "wz")
# Euler angles about each axis, which --euler says the order of; as pilots call them they are the same.
ANGLES = ("rx", "ry", "rz")
PILOTS = {"roll": "rx", "pitch": "ry", "yaw": "rz"}
ALIASES = {**PILOTS, "throw": "member"}  # `throw`: its name in format 2
TIME, THROW = "t", "member"
VERTEX = re.compile(r"v(0|[1-9]\d{0,5})[xyz]", re.ASCII)


class BadTrajectory(UserError):
    """A trajectory that cannot be graded as it is; the message is the one line for the user."""


@dataclass(frozen=True)
class Answer:
    """What would answer a question about a file: names of columns, column -> name; its decimal sign; its start [s]."""

    mapping: Mapping[str, str] = field(default_factory=dict)
    decimal: str | None = None
    start: float | None = None


class Unsaid(BadTrajectory):
    """A trajectory that does not say how it is to be read.

    asks: what is not said, in few words; answer: what is likely meant, empty where nothing is likelier than the rest.
    """

    def __init__(self, message: str, asks: str, answer: Answer | None = None) -> None:
        super().__init__(message)
        self.asks, self.answer = asks, answer or Answer()


class AnglesUnread(Unsaid):
    """Only angles say how the body is turned; named: column -> the angle it is, rx, ry or rz, and its unit or ''."""

    def __init__(self, message: str, named: dict[str, tuple[str, str]]) -> None:
        super().__init__(message, f"what turns {', '.join(named)} are")
        self.named = named


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
    if quantity in ANGLES:
        return "angle"
    return "none" if quantity in (*QUATERNION, *MATRIX, THROW) else None


def parsed(name: str) -> tuple[str, float] | None:
    """Return the quantity a name stands for and its unit in SI, or None."""
    quantity, _, unit = name.partition("_")
    quantity = ALIASES.get(quantity, quantity)
    measured = dimension(quantity)
    if measured is None or unit not in UNITS[measured]:
        return None
    return quantity, UNITS[measured][unit]


@dataclass(frozen=True)
class Shown:
    """What a trajectory shows of the body: which description of its place, and what else; centred: where it is too."""

    kind: str
    vertices: tuple[int, ...]
    velocities: bool
    spin: bool
    centred: bool = True
