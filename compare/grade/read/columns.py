"""What a column of a trajectory is: a quantity and its unit, given by its name or by the user.

A name is QUANTITY_UNIT, as in our own trajectories: t_s, x_m, qw, vx_m_s, wx_rad_s, v0x_m; also r11 ... r33 for a
matrix body to world, row then column, ax_m_s2 and gx_rad_s for the readings of a sensor, and `throw`.  Other units are
named alike: t_ms, x_cm, wx_deg_s.  Nothing is guessed.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from math import pi
from typing import NamedTuple

from tumble.scenarios.refusal import UserError

IGNORED = "ignore"
STANDARD_GRAVITY = 9.80665  # m/s2, of the unit g
UNITS: dict[str, dict[str, float]] = {
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0},
    "length": {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "km": 1e3, "in": 0.0254, "ft": 0.3048},
    "speed": {"m_s": 1.0, "cm_s": 1e-2, "mm_s": 1e-3, "km_h": 1 / 3.6, "ft_s": 0.3048},
    "acceleration": {"m_s2": 1.0, "cm_s2": 1e-2, "ft_s2": 0.3048, "g": STANDARD_GRAVITY, "mg": 1e-3 * STANDARD_GRAVITY},
    "angle": {"rad": 1.0, "deg": pi / 180},
    "rate": {"rad_s": 1.0, "deg_s": pi / 180, "rpm": pi / 30},
    "none": {"": 1.0},
}
CENTRE = ("x", "y", "z")
QUATERNION = ("qw", "qx", "qy", "qz")
MATRIX = tuple(f"r{row}{column}" for row in "123" for column in "123")
VELOCITY = ("vx", "vy", "vz")
SPIN = ("wx", "wy", "wz")
# Readings of a sensor, in its own axes: specific force and angular velocity.
ACCELEROMETER, GYRO = ("ax", "ay", "az"), ("gx", "gy", "gz")
READINGS = (*ACCELEROMETER, *GYRO)
# Euler angles about each axis, whose order --euler gives; roll, pitch, yaw are other names of them.
ANGLES = ("rx", "ry", "rz")
PILOTS = {"roll": "rx", "pitch": "ry", "yaw": "rz"}
ALIASES = {**PILOTS, "throw": "member"}  # `throw`: its name in format 2
TIME, THROW = "t", "member"
VERTEX = re.compile(r"v(0|[1-9]\d{0,5})[xyz]", re.ASCII)


class BadTrajectory(UserError):
    """A trajectory that cannot be graded as it is; the message is the one line for the user."""


@dataclass(frozen=True)
class Suggestion:
    """A suggested answer to a question about a file: mapping column -> name; decimal sign; start of the clock [s]."""

    mapping: Mapping[str, str] = field(default_factory=dict)
    decimal: str | None = None
    start: float | None = None


class AmbiguousFile(BadTrajectory):
    """A trajectory that can be read in several ways.

    topic: what is ambiguous, in few words; suggestion: the likely answer, empty if there is none.
    """

    def __init__(self, message: str, topic: str, suggestion: Suggestion | None = None) -> None:
        super().__init__(message)
        self.topic, self.suggestion = topic, suggestion or Suggestion()


class AmbiguousAngles(AmbiguousFile):
    """The attitude is given by angles only; named: column -> its angle, rx, ry or rz, and its unit or ''."""

    def __init__(self, message: str, named: dict[str, tuple[str, str]]) -> None:
        super().__init__(message, f"the convention of the angles {', '.join(named)}")
        self.named = named


class Column(NamedTuple):
    """Index of a quantity's cell in a row, and its unit in SI."""

    place: int
    factor: float


def dimension(quantity: str) -> str | None:
    """Return the dimension of a quantity, or None if there is no such quantity."""
    if quantity == TIME:
        return "time"
    if quantity in CENTRE or VERTEX.fullmatch(quantity):
        return "length"
    if quantity in VELOCITY:
        return "speed"
    if quantity in ACCELEROMETER:
        return "acceleration"
    if quantity in (*SPIN, *GYRO):
        return "rate"
    if quantity in ANGLES:
        return "angle"
    return "none" if quantity in (*QUATERNION, *MATRIX, THROW) else None


def parsed(name: str) -> tuple[str, float] | None:
    """Return the quantity that a name stands for and its unit in SI, or None."""
    quantity, _, unit = name.partition("_")
    quantity = ALIASES.get(quantity, quantity)
    measured = dimension(quantity)
    if measured is None or unit not in UNITS[measured]:
        return None
    return quantity, UNITS[measured][unit]


def is_reading(name: str) -> bool:
    """Whether a name is that of a sensor's reading, with or without its unit."""
    found = parsed(name)
    return (found[0] if found else name.lower()) in READINGS


@dataclass(frozen=True)
class Description:
    """How a trajectory describes the body's pose.

    kind: pose, matrix or vertices; vertices: numbers of those that are given, or all; velocities, spin: whether both
    velocities, or the angular one, are given as well; has_centre: whether the position is given.
    """

    kind: str
    vertices: tuple[int, ...]
    velocities: bool
    spin: bool
    has_centre: bool = True
