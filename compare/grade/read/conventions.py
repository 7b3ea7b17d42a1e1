"""Other programs' axes and Euler angles, converted to a scene's right-handed world.

Axes are a signed permutation: columns get other names and signs and keep their printed digits; the body's axes change
with the world's.  Angles are converted to a quaternion row by row.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from tumble.compare.grade.read.columns import (
    ACCELEROMETER,
    ANGLES,
    CENTRE,
    GYRO,
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

# The program's axes that are our x, y, z, in a world where y is up.
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
# The rotation order in the notation of scipy.spatial.transform.Rotation, and the signs of the angles about x, y, z.
EULER = {
    "unity": ("zxy", (1, 1, 1)),  # Quaternion.Euler: about z, then x, then y
    "unreal": ("xyz", (-1, -1, 1)),  # FRotationMatrix: roll, pitch, yaw; roll and pitch have the opposite sign
    "blender": ("xyz", (1, 1, 1)),  # rotation_mode XYZ: about x first
    "godot": ("YXZ", (1, 1, 1)),  # EULER_ORDER_YXZ
    "ros": ("xyz", (1, 1, 1)),  # REP 103, fixed axes: roll, pitch, yaw
    "mujoco": ("XYZ", (1, 1, 1)),  # compiler eulerseq="xyz": small letters are axes that move with the body
}
WORLD, BODY = "world", "body"
PREFIX = re.compile(r"(intrinsic|extrinsic)[-: ]?([xyz]{3})", re.IGNORECASE)


@dataclass(frozen=True)
class Conventions:
    """The conventions of a file.

    Parameters
    ----------
    euler : name or order of its Euler angles; None: not given
    axes : its axes that are the scene's x, y, z, or the name of a program; None: the scene's
    start : what its clock shows at the scene's start [s]; None: not given
    spin : axes of its angular velocity, world or body
    name : its name in messages; None: its path
    first_line : line of its first row
    notes : remarks for the user about how it was read
    """

    euler: str | None = None
    axes: str | None = None
    start: float | None = None
    spin: str = WORLD
    name: str | None = None
    first_line: int = 2
    notes: list[str] = field(default_factory=list, compare=False)


def order_of(euler: str) -> tuple[str, tuple[int, int, int]]:
    """Return the rotation order, lower case about fixed axes and upper case about the body's, and the signs.

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
            f"--euler {short(euler)}: must be {', '.join(EULER)}, or x, y and z in the order of rotations: zxy about "
            "fixed axes, ZXY about the body's (or extrinsic-zxy, intrinsic-zxy)"
        )
    return order, (1, 1, 1)


def matrix_of(axes: str | None, scene: Scene) -> Array:
    """Return the matrix that takes a program's vectors to the scene's world, (3, 3), a signed permutation.

    Raises BadTrajectory.
    """
    if axes is None:
        return np.eye(3)
    named = axes.lower() in AXES
    cells = [cell.strip() for cell in AXES.get(axes.lower(), axes).lower().split(",")]
    matrix = np.zeros((3, 3))
    if sorted(cell.lstrip("+-") for cell in cells) != ["x", "y", "z"] or any(len(cell) > 2 for cell in cells):
        raise BadTrajectory(
            f"--axes {short(axes)}: must be {', '.join(AXES)}, or its axes that are our x, y, z, e.g. x,y,-z"
        )
    for row, cell in enumerate(cells):
        matrix[row, "xyz".index(cell[-1])] = -1.0 if cell[0] == "-" else 1.0
    gravity = scene.gravity
    z_up = gravity is not None and abs(gravity[2]) > max(abs(gravity[0]), abs(gravity[1]))
    return Z_UP @ matrix if named and z_up else matrix


def renamed(columns: Mapping[str, Column], matrix: Array) -> dict[str, Column]:
    """Return the columns of our quantities in a file with a program's axes; matrix: from `matrix_of`.

    An angular velocity and the vector of a quaternion are axial vectors: a mirror reverses them.
    """
    found = dict(columns)
    source = np.abs(matrix).argmax(axis=1)
    sign, handed = matrix.sum(axis=1), float(np.linalg.det(matrix).round())
    vertices = sorted({name[:-1] for name in columns if VERTEX.fullmatch(name)})
    vectors = [
        (CENTRE, 1.0),
        (VELOCITY, 1.0),
        (ACCELEROMETER, 1.0),
        *(((f"{v}x", f"{v}y", f"{v}z"), 1.0) for v in vertices),
    ]
    for names, factor in [*vectors, (SPIN, handed), (GYRO, handed), (QUATERNION[1:], handed)]:
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
    """Return the attitudes, (n, 4), from angles about the program's x, y, z [rad], (n, 3)."""
    order, signs = order_of(euler)
    found = np.tile([1.0, 0.0, 0.0, 0.0], (len(angles), 1))
    for letter in order:
        axis = "xyz".index(letter.lower())
        turn = np.zeros((len(angles), 4))
        half = signs[axis] * angles[:, axis] / 2
        turn[:, 0], turn[:, 1 + axis] = np.cos(half), np.sin(half)
        # Rotations about fixed axes multiply from the left, those about body axes from the right.
        found = quaternion_product(found, turn) if letter.isupper() else quaternion_product(turn, found)
    found[:, 1:] = np.linalg.det(matrix).round() * found[:, 1:] @ matrix.T
    return found


def quaternion_digits(columns: Mapping[str, Column], printed: Mapping[str, Digits]) -> dict[str, Digits]:
    """Return the print format of a quaternion that was converted from angles.

    The three rotation axes need not be orthogonal, so the attitude may be off by the sum of three half units and the
    quaternion by half of that, spread over its four components.  If the place of the last digit follows the size of an
    angle, that of half a turn is taken.
    """
    half = sum(
        columns[name].factor * float(printed[name].half(np.array([np.pi / columns[name].factor]))[0]) for name in ANGLES
    )
    return dict.fromkeys(QUATERNION, Digits(place=half / 2))
