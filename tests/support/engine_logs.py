"""Log files as six programs write them, from a right flight: little scripts that share nothing with what reads them.

Each works on plain lists and on the program's own formulas: how it gets angles from a rotation, as its source or manual
has it.  A flight is rows of t [s], x, the matrix body to world by rows, v and w, in our right-handed world with y up.
"""

import csv
import math
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

Vector = list[float]
Matrix = list[list[float]]
Row = tuple[float, Vector, Matrix, Vector, Vector]


def read(path: Path) -> list[Row]:
    """Return a trajectory of ours."""
    rows: list[Row] = []
    with path.open(newline="") as file:
        for cells in csv.DictReader(file):
            x, v, w = (
                [float(cells[f"{name}{axis}{unit}"]) for axis in "xyz"]
                for name, unit in (("", "_m"), ("v", "_m_s"), ("w", "_rad_s"))
            )
            a, b, c, d = (float(cells[name]) for name in ("qw", "qx", "qy", "qz"))
            r = [
                [1 - 2 * (c * c + d * d), 2 * (b * c - a * d), 2 * (b * d + a * c)],
                [2 * (b * c + a * d), 1 - 2 * (b * b + d * d), 2 * (c * d - a * b)],
                [2 * (b * d - a * c), 2 * (c * d + a * b), 1 - 2 * (b * b + c * c)],
            ]
            rows.append((float(cells["t_s"]), x, r, v, w))
    return rows


def multiply(a: Matrix, b: Matrix) -> Matrix:
    """Return a b."""
    return [[sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)] for i in range(3)]


def apply(a: Matrix, v: Vector) -> Vector:
    """Return a v."""
    return [sum(a[i][k] * v[k] for k in range(3)) for i in range(3)]


def transposed(a: Matrix) -> Matrix:
    """Return a's transpose."""
    return [list(column) for column in zip(*a, strict=True)]


def quaternion(r: Matrix) -> Vector:
    """Return w x y z of a rotation matrix."""
    w = math.sqrt(max(0.0, 1 + r[0][0] + r[1][1] + r[2][2])) / 2
    x = math.copysign(math.sqrt(max(0.0, 1 + r[0][0] - r[1][1] - r[2][2])) / 2, r[2][1] - r[1][2])
    y = math.copysign(math.sqrt(max(0.0, 1 - r[0][0] + r[1][1] - r[2][2])) / 2, r[0][2] - r[2][0])
    z = math.copysign(math.sqrt(max(0.0, 1 - r[0][0] - r[1][1] + r[2][2])) / 2, r[1][0] - r[0][1])
    return [w, x, y, z]


# Our vectors in a program's world: Unity turns z round; Unreal takes our z for its y, and up is z; in Blender, ROS and
# MuJoCo z is up, and -z of ours is y.
MIRRORED: Matrix = [[1, 0, 0], [0, 1, 0], [0, 0, -1]]
SWAPPED: Matrix = [[1, 0, 0], [0, 0, 1], [0, 1, 0]]
UPRIGHT: Matrix = [[1, 0, 0], [0, 0, -1], [0, 1, 0]]


def moved(row: Row, to: Matrix, handed: int = 1) -> Row:
    """Return a row in a program's world, handed: -1 where that is left-handed, where a spin is the other way round."""
    t, x, r, v, w = row
    turned = multiply(multiply(to, r), transposed(to))
    return t, apply(to, x), turned, apply(to, v), [handed * part for part in apply(to, w)]


def about_y_x_z(r: Matrix) -> Vector:
    """Return the angles [rad] about x, y, z of r = Ry Rx Rz: Unity's and Godot's."""
    return [math.asin(-r[1][2]), math.atan2(r[0][2], r[2][2]), math.atan2(r[1][0], r[1][1])]


def about_z_y_x(r: Matrix) -> Vector:
    """Return the angles [rad] about x, y, z of r = Rz Ry Rx: Blender's XYZ, and the roll, pitch, yaw of ROS."""
    return [math.atan2(r[2][1], r[2][2]), math.asin(-r[2][0]), math.atan2(r[1][0], r[0][0])]


def rotator(r: Matrix) -> Vector:
    """Return roll, pitch, yaw [deg] as Unreal's FMatrix::Rotator works them out from the axes."""
    x_axis, y_axis, z_axis = transposed(r)
    pitch = math.atan2(x_axis[2], math.hypot(x_axis[0], x_axis[1]))
    yaw = math.atan2(x_axis[1], x_axis[0])
    level_y = [-math.sin(yaw), math.cos(yaw), 0.0]
    roll = math.atan2(
        sum(a * b for a, b in zip(z_axis, level_y, strict=True)),
        sum(a * b for a, b in zip(y_axis, level_y, strict=True)),
    )
    return [math.degrees(angle) for angle in (roll, pitch, yaw)]


def unity(row: Row) -> dict[str, float]:
    """Return what a MonoBehaviour logs: transform.position and eulerAngles, from 0 to 360 degrees."""
    t, x, r, v, w = moved(row, MIRRORED, -1)
    angles = [math.degrees(angle) % 360 for angle in about_y_x_z(r)]
    return {
        "Time": t,
        **named("Position ", x),
        **named("Rotation ", angles),
        **named("Velocity ", v),
        **named("Angular Velocity ", w),
    }


def unity_quaternion(row: Row) -> dict[str, float]:
    """Return transform.rotation, x y z w."""
    t, x, r, _, _ = moved(row, MIRRORED, -1)
    w, *rest = quaternion(r)
    return {"time": t, **named("pos", x), **named("rot", rest), "rotw": w}


def unreal(row: Row) -> dict[str, float]:
    """Return what an actor logs: centimetres, GetActorRotation, GetPhysicsAngularVelocityInDegrees."""
    t, x, r, v, w = moved(row, SWAPPED, -1)
    roll, pitch, yaw = rotator(r)
    return {
        "Time": t,
        **named("Location.", [100 * part for part in x]),
        "Rotation.Roll": roll,
        "Rotation.Pitch": pitch,
        "Rotation.Yaw": yaw,
        **named("Velocity.", [100 * part for part in v]),
        **named("AngularVelocity.", [math.degrees(part) for part in w]),
    }


def blender(row: Row) -> dict[str, float]:
    """Return location and rotation_euler, radians."""
    t, x, r, _, _ = moved(row, UPRIGHT)
    return {"time": t, **named("location.", x), **named("rotation_euler.", about_z_y_x(r))}


def blender_quaternion(row: Row) -> dict[str, float]:
    """Return rotation_quaternion, w first, by number."""
    t, x, r, _, _ = moved(row, UPRIGHT)
    parts = {f"rotation_quaternion[{number}]": part for number, part in enumerate(quaternion(r))}
    return {"time": t, **named("location.", x), **parts}


def godot(row: Row) -> dict[str, float]:
    """Return global_position and rotation, radians, and a RigidBody3D's velocities."""
    t, x, r, v, w = row
    return {
        "time": t,
        **named("global_position.", x),
        **named("rotation.", about_y_x_z(r)),
        **named("linear_velocity.", v),
        **named("angular_velocity.", w),
    }


def ros(row: Row) -> dict[str, float]:
    """Return an Odometry message as a topic is printed: its twist is in the body's axes."""
    t, x, r, v, w = moved(row, UPRIGHT)
    scalar, *rest = quaternion(r)
    return {
        "time": t,
        **named("pose.pose.position.", x),
        **named("pose.pose.orientation.", rest),
        "pose.pose.orientation.w": scalar,
        **named("twist.twist.linear.", apply(transposed(r), v)),
        **named("twist.twist.angular.", apply(transposed(r), w)),
    }


def mujoco(row: Row) -> dict[str, float]:
    """Return time, qpos and qvel of a free joint: its angular velocity is in the body's axes."""
    t, x, r, v, w = moved(row, UPRIGHT)
    qpos, qvel = [*x, *quaternion(r)], [*v, *apply(transposed(r), w)]
    return {
        "time": t,
        **{f"qpos_{number}": part for number, part in enumerate(qpos)},
        **{f"qvel_{number}": part for number, part in enumerate(qvel)},
    }


def named(name: str, parts: Sequence[float]) -> dict[str, float]:
    """Return three numbers under names that end in x, y, z, as capital as the name begins."""
    letters = "XYZ" if name[0].isupper() else "xyz"
    return {f"{name}{letter}": part for letter, part in zip(letters, parts, strict=True)}


LOGS: dict[str, Callable[[Row], dict[str, float]]] = {
    "unity": unity,
    "unity quaternion": unity_quaternion,
    "unreal": unreal,
    "blender": blender,
    "blender quaternion": blender_quaternion,
    "godot": godot,
    "ros": ros,
    "mujoco": mujoco,
}


def log(
    rows: Sequence[Row], kind: str, form: str = "{:.6f}", separator: str = ",", decimal: str = "."
) -> Iterator[str]:
    """Yield the lines of a program's file."""
    for number, row in enumerate(rows):
        cells = LOGS[kind](row)
        if not number:
            yield separator.join(cells)
        yield separator.join(form.format(cell).replace(".", decimal) for cell in cells.values())
