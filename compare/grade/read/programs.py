"""What the files of well-known programs are like: their axes, angles, units, and how they write a quaternion.

Sources: Unity, Quaternion.Euler and Rigidbody.angularVelocity; Unreal, TRotator ("positive yaw is left-handed, pitch
and roll right-handed"), centimetres and degrees; Godot, Node3D.rotation, radians, EULER_ORDER_YXZ; Blender,
rotation_mode XYZ, radians, and WXYZ; ROS, REP 103, geometry_msgs/Quaternion x y z w, and nav_msgs/Odometry, whose twist
is in the child's axes; MuJoCo, qpos w x y z, and qvel of a free joint, whose rotation is in the body's axes
(google-deepmind/mujoco#691).
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

from tumble.compare.grade.model.reference import Reference
from tumble.compare.grade.read.cells import Cells
from tumble.compare.grade.read.columns import MATRIX, QUATERNION, VERTEX, BadTrajectory, parsed
from tumble.compare.grade.read.convention_fit import FITS, misfit, off
from tumble.compare.grade.read.conventions import BODY, WORLD
from tumble.compare.grade.read.reading_options import Said, inquire
from tumble.compare.grade.read.suggestions import SI, Habits, likely_meant, unordered
from tumble.scenarios.scene import Scene

# A way to read a file is as good as a better one where it is not twice as far off, but for rounding.
ALIKE, ROUNDING = 2.0, 1e-6


@dataclass(frozen=True)
class Program:
    """How one program writes a file.

    convention: of its axes and Euler angles; angle: their unit; habits: what its columns mean; spin: whose axes its
    angular velocity is in; leaves_out: how columns begin that are in axes which cannot be read.
    """

    convention: str
    angle: str
    habits: Habits
    spin: str = WORLD
    leaves_out: str | None = None


def _habits(last: bool, **units: str) -> Habits:
    """Return what a program means by its columns: SI but for some units, by dimension."""
    return Habits({**SI.units, **units}, last)


PROGRAMS = {
    "unity": Program("unity", "deg", _habits(last=True)),
    "unreal": Program("unreal", "deg", _habits(last=True, length="cm", speed="cm_s", rate="deg_s")),
    "blender": Program("blender", "rad", _habits(last=False)),
    "godot": Program("godot", "rad", _habits(last=True)),
    "ros": Program("ros", "rad", _habits(last=True), leaves_out="twist.twist"),
    "mujoco": Program("mujoco", "rad", _habits(last=False), spin=BODY),
}


def as_program(path: Path, scene: Scene, said: Said, name: str) -> tuple[Said, float]:
    """Return how a program's file is to be read, beyond what is said, and how far its first rows are off then.

    That is of the body's size, the nearest of: in the program's axes or with the scene's own numbers; the scene's start
    at 0, at the first row, or a row before it; in the program's unit of angles or the other.
    Raises BadTrajectory where something is left to be asked.
    """
    program = PROGRAMS[name]
    found = inquire(path, scene, _named(path, said, program))
    whole = found.said
    if found.angles is not None:
        whole = whole.read_as(euler=said.reading.euler or program.convention)
    trajectory, _ = whole.first_rows(path, scene)  # raises what is left to be asked
    if program.spin != WORLD:
        whole = whole.read_as(spin=program.spin)
    axes = [said.reading.axes] if said.reading.axes else [program.convention, None]
    starts = [said.reading.start] if said.reading.start is not None else trajectory.likely_starts()
    units = [program.angle, *({"deg", "rad"} - {program.angle})]
    reference = Reference(scene)
    ways: list[tuple[float, Said]] = []
    for start in starts:
        for own_axes in axes:
            for unit in units if found.angles is not None else units[:1]:
                way = whole.read_as(axes=own_axes, start=start)
                if found.angles is not None:
                    way = way.with_angles(found.angles.named, unit)
                if (error := misfit(path, scene, way, reference)) is not None:
                    ways.append((error, way))
    least = min(error for error, _ in ways)
    error, way = next(each for each in ways if each[0] <= ALIKE * least + ROUNDING)
    return way, error


def fitting(path: Path, scene: Scene, said: Said) -> list[str]:
    """Return the programs whose way to write a file makes its first rows right."""
    found = []
    for name in PROGRAMS:
        try:
            _, error = as_program(path, scene, said, name)
        except BadTrajectory:
            continue
        if error <= FITS:
            found.append(name)
    return found


def _named(path: Path, said: Said, program: Program) -> Said:
    """Return what is said with the columns that a program's habits name."""
    cells = Cells(path, said.reading.name or str(path), said.decimal, said.reading.first_line)
    header = [name for name in cells.header if not (program.leaves_out and name.startswith(program.leaves_out))]
    meanings = (parsed(said.mapping.get(column, column)) for column in header)
    known = {meaning[0] for meaning in meanings if meaning is not None}
    meant = likely_meant(header, said.mapping, known, program.habits)
    if not _has_attitude(known | {name.partition("_")[0] for name in meant.values()}):
        meant |= unordered(header, program.habits.last is True)
    return replace(said, mapping={**meant, **said.mapping})


def _has_attitude(quantities: Iterable[str]) -> bool:
    return any(name in (*QUATERNION, *MATRIX) or VERTEX.fullmatch(name) for name in quantities)


def remark(error: float) -> str:
    """Return what is to be added where the first rows do not fit however they are read; nothing where they do."""
    return f"; its first rows are {off(error)}, however they are read" if error > FITS else ""
