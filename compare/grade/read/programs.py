"""How well-known programs write a trajectory: axes, Euler angles, units, and the order of a quaternion.

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
from tumble.compare.grade.read.convention_fit import FITS, misfit, misfit_text
from tumble.compare.grade.read.conventions import BODY, WORLD
from tumble.compare.grade.read.reading_options import ReadingOptions, open_questions
from tumble.compare.grade.read.suggestions import SI, ColumnDefaults, counted_quaternion, likely_names
from tumble.scenarios.scene import Scene

# A reading is as good as the best one if its error is less than twice as large, plus rounding.
ALIKE, ROUNDING = 2.0, 1e-6


@dataclass(frozen=True)
class Program:
    """How one program writes a file.

    convention: of its axes and Euler angles; angle: their unit; defaults: meaning of its columns; spin: axes of its
    angular velocity; leaves_out: prefix of columns that cannot be read, since they are in other axes.
    """

    convention: str
    angle: str
    defaults: ColumnDefaults
    spin: str = WORLD
    leaves_out: str | None = None


def _defaults(last: bool, **units: str) -> ColumnDefaults:
    """Return the units of a program's columns: SI, with exceptions by dimension; last: the scalar comes last."""
    return ColumnDefaults({**SI.units, **units}, last)


PROGRAMS = {
    "unity": Program("unity", "deg", _defaults(last=True)),
    "unreal": Program("unreal", "deg", _defaults(last=True, length="cm", speed="cm_s", rate="deg_s")),
    "blender": Program("blender", "rad", _defaults(last=False)),
    "godot": Program("godot", "rad", _defaults(last=True)),
    "ros": Program("ros", "rad", _defaults(last=True), leaves_out="twist.twist"),
    "mujoco": Program("mujoco", "rad", _defaults(last=False), spin=BODY),
}


def read_as_program(path: Path, scene: Scene, options: ReadingOptions, name: str) -> tuple[ReadingOptions, float]:
    """Return the options that read a file as a program writes it.

    Tried are: the program's axes and the scene's own; the scene's start at t = 0, at the first row and one row before
    it; the program's unit of angles and the other one.  The best fit to the scene is taken.

    Parameters
    ----------
    path, scene : the file and the scene that it is graded against
    options : the user's options, which have priority
    name : key of PROGRAMS

    Returns
    -------
    options : the user's options and the program's
    error : median vertex error of the first rows, over the body's size

    Raises
    ------
    BadTrajectory : the file is still ambiguous
    """
    program = PROGRAMS[name]
    found = open_questions(path, scene, _with_columns(path, options, program))
    whole = found.options
    if found.angles is not None:
        whole = whole.with_conventions(euler=options.conventions.euler or program.convention)
    trajectory, _ = whole.first_rows(path, scene)  # raises if a question is left
    if not trajectory.descriptions:
        raise BadTrajectory(f"{trajectory.name}: --like {name} needs a pose: name the columns of readings with --map")
    if program.spin != WORLD:
        whole = whole.with_conventions(spin=program.spin)
    given = options.conventions
    axes = [given.axes] if given.axes else [program.convention, None]
    starts = [given.start] if given.start is not None else trajectory.likely_starts()
    units = [program.angle, *({"deg", "rad"} - {program.angle})]
    reference = Reference(scene)
    ways: list[tuple[float, ReadingOptions]] = []
    for start in starts:
        for own_axes in axes:
            for unit in units if found.angles is not None else units[:1]:
                way = whole.with_conventions(axes=own_axes, start=start)
                if found.angles is not None:
                    way = way.with_angles(found.angles.named, unit)
                if (error := misfit(path, scene, way, reference)) is not None:
                    ways.append((error, way))
    least = min(error for error, _ in ways)
    error, way = next(each for each in ways if each[0] <= ALIKE * least + ROUNDING)
    return way, error


def fitting_programs(path: Path, scene: Scene, options: ReadingOptions) -> list[str]:
    """Return the programs as which a file's first rows fit the scene."""
    found = []
    for name in PROGRAMS:
        try:
            _, error = read_as_program(path, scene, options, name)
        except BadTrajectory:
            continue
        if error <= FITS:
            found.append(name)
    return found


def _with_columns(path: Path, options: ReadingOptions, program: Program) -> ReadingOptions:
    """Return the options with the columns mapped that a program's defaults name."""
    given = options.conventions
    cells = Cells(path, given.name or str(path), options.decimal, given.first_line)
    header = [name for name in cells.header if not (program.leaves_out and name.startswith(program.leaves_out))]
    meanings = (parsed(options.mapping.get(column, column)) for column in header)
    found = {meaning[0] for meaning in meanings if meaning is not None}
    likely = likely_names(header, options.mapping, found, program.defaults)
    if not _has_attitude(found | {name.partition("_")[0] for name in likely.values()}):
        likely |= counted_quaternion(header, program.defaults.last is True)
    return replace(options, mapping={**likely, **options.mapping})


def _has_attitude(quantities: Iterable[str]) -> bool:
    return any(name in (*QUATERNION, *MATRIX) or VERTEX.fullmatch(name) for name in quantities)


def misfit_remark(error: float) -> str:
    """Return a remark for first rows that fit in no reading; empty if they fit."""
    return f"; in the best reading its first rows are {misfit_text(error)}" if error > FITS else ""
