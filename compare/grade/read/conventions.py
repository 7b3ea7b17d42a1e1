"""Other programs' axes and Euler angles, brought into a scene's right-handed world.

Axes are a signed permutation, so a file's columns are only named and signed anew and keep their printed digits; body
axes go with the world's.  Angles are turned into a quaternion row by row.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from tumble.compare.grade.read.columns import (
    ANGLES,
    CENTRE,
    MATRIX,
    QUATERNION,
    SPIN,
    VELOCITY,
    VERTEX,
    BadTrajectory,
    Column,
)
from tumble.compare.grade.read.digits import Digits
from tumble.scenarios.format import short
from tumble.scenarios.frames import Array, quaternion_product
from tumble.scenarios.scene import Scene

# Which of the program's axes our x, y, z are, in a world where y is up.
AXES = {
    "unity": "x,y,-z",  # left-handed: x right, y up, z forward
    "unreal": "x,z,y",  # left-handed: x forward, y right, z up
    "godot": "x,y,z",  # right-handed, y up
    "blender": "x,z,-y",  # right-handed, z up
    "ros": "x,z,-y",  # REP 103: x forward, y left, z up
    "mujoco": "x,z,-y",  # right-handed, z up
}
# A scene whose gravity is along z has z up: (x, y, z) with y up is (x, -z, y) there.
Z_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
# The order of the turns as scipy.spatial.transform.Rotation has it, and the signs of the angles about x, y, z.
EULER = {
    "unity": ("zxy", (1, 1, 1)),  # Quaternion.Euler: about z, then x, then y
    "unreal": ("xyz", (-1, -1, 1)),  # FRotationMatrix: roll, pitch, yaw; roll and pitch turn the other way
    "blender": ("xyz", (1, 1, 1)),  # rotation_mode XYZ: about x first
    "godot": ("YXZ", (1, 1, 1)),  # EULER_ORDER_YXZ
    "ros": ("xyz", (1, 1, 1)),  # REP 103, fixed axes: roll, pitch, yaw
    "mujoco": ("XYZ", (1, 1, 1)),  # compiler eulerseq="xyz": small letters are axes that move with the body
}
WORLD, BODY = "world", "body"
PREFIX = re.compile(r"(intrinsic|extrinsic)[-: ]?([xyz]{3})", re.IGNORECASE)


@dataclass(frozen=True)
class Reading:
    """What the user says of a whole file: the order of its Euler angles, its axes, when its clock starts [s].

    spin: in whose axes its angular velocity is, world or body;
    name: how refusals call it; first_line: of its rows; notes: what is to be told once of how it was read.
    """

    euler: str | None = None
    axes: str | None = None
    start: float | None = None
    spin: str = WORLD
    name: str | None = None
    first_line: int = 2
    notes: list[str] = field(default_factory=list, compare=False)


def order_of(euler: str) -> tuple[str, tuple[int, int, int]]:
    """Return the order of turns, small letters about fixed axes and capitals about the body's, and the signs.

    Raises BadTrajectory.
    """
    if euler.lower() in EULER:
        return EULER[euler.lower()]
    prefixed = PREFIX.fullmatch(euler)
    order = euler
    if prefixed:
        order = prefixed[2].upper() if prefixed[1].lower() == "intrinsic" else prefixed[2].lower()
    if sorted(order.lower()) != ["x", "y", "z"] or order not in (order.lower(), order.upper()):
        raise BadTrajectory(
            f"--euler {short(euler)}: must be {', '.join(EULER)}, or x, y and z in the order of the turns: zxy about "
            "fixed axes, ZXY about the body's (or extrinsic-zxy, intrinsic-zxy)"
        )
    return order, (1, 1, 1)


def matrix_of(axes: str | None, scene: Scene) -> Array:
    """Return what takes a program's vectors into the scene's world, (3, 3), a signed permutation.

    Raises BadTrajectory.
    """
    if axes is None:
        return np.eye(3)
    named = axes.lower() in AXES
    cells = [cell.strip() for cell in AXES.get(axes.lower(), axes).lower().split(",")]
    matrix = np.zeros((3, 3))
    if sorted(cell.lstrip("+-") for cell in cells) != ["x", "y", "z"] or any(len(cell) > 2 for cell in cells):
        raise BadTrajectory(
            f"--axes {short(axes)}: must be {', '.join(AXES)}, or which of its axes our x, y, z are, e.g. x,y,-z"
        )
    for row, cell in enumerate(cells):
        matrix[row, "xyz".index(cell[-1])] = -1.0 if cell[0] == "-" else 1.0
    gravity = scene.gravity
    z_up = gravity is not None and abs(gravity[2]) > max(abs(gravity[0]), abs(gravity[1]))
    return Z_UP @ matrix if named and z_up else matrix


def renamed(columns: Mapping[str, Column], matrix: Array) -> dict[str, Column]:
    """Return where our quantities are in a file whose columns are the program's; matrix: as matrix_of has it.

    A spin and the vector of a quaternion are axial: a mirrored world turns them round.
    """
    found = dict(columns)
    source = np.abs(matrix).argmax(axis=1)
    sign, handed = matrix.sum(axis=1), float(np.linalg.det(matrix).round())
    vertices = sorted({name[:-1] for name in columns if VERTEX.fullmatch(name)})
    vectors = [(CENTRE, 1.0), (VELOCITY, 1.0), *(((f"{v}x", f"{v}y", f"{v}z"), 1.0) for v in vertices)]
    for names, factor in [*vectors, (SPIN, handed), (QUATERNION[1:], handed)]:
        if all(name in columns for name in names):
            for row, name in enumerate(names):
                place, unit = columns[names[source[row]]]
                found[name] = Column(place, unit * factor * sign[row])
    if all(name in columns for name in MATRIX):
        for index, name in enumerate(MATRIX):
            row, column = divmod(index, 3)
            place, unit = columns[MATRIX[3 * source[row] + source[column]]]
            found[name] = Column(place, unit * sign[row] * sign[column])
    return found


def quaternions(angles: Array, euler: str, matrix: Array) -> Array:
    """Return the attitudes, (n, 4), of angles about the program's x, y, z [rad], (n, 3)."""
    order, signs = order_of(euler)
    found = np.tile([1.0, 0.0, 0.0, 0.0], (len(angles), 1))
    for letter in order:
        axis = "xyz".index(letter.lower())
        turn = np.zeros((len(angles), 4))
        half = signs[axis] * angles[:, axis] / 2
        turn[:, 0], turn[:, 1 + axis] = np.cos(half), np.sin(half)
        # Turns about fixed axes come before what is there, those about the body's after it.
        found = quaternion_product(found, turn) if letter.isupper() else quaternion_product(turn, found)
    found[:, 1:] = np.linalg.det(matrix).round() * found[:, 1:] @ matrix.T
    return found


def quaternion_digits(columns: Mapping[str, Column], printed: Mapping[str, Digits]) -> dict[str, Digits]:
    """Return how a quaternion would be printed that angles were turned into.

    The three axes of the turns need not be at right angles, so the body is turned by up to the sum of three half units
    too much, and the quaternion off by half of that: so much in each of its four numbers as makes that length.  Where
    the place of the last digit follows the size of an angle, it is that of half a turn.
    """
    half = sum(
        columns[name].factor * float(printed[name].half(np.array([np.pi / columns[name].factor]))[0]) for name in ANGLES
    )
    return dict.fromkeys(QUATERNION, Digits(place=half / 2))
