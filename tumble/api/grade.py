"""`tumble.grade`: the error of a trajectory that some other program wrote, and its most likely cause."""

import math
import tempfile
from collections.abc import Collection, Mapping, Sequence
from numbers import Real
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from tumble.api.progress import display
from tumble.api.result import Result, call, text_of
from tumble.api.scene import Scene, SceneLike
from tumble.compare.grade.file_grade import FileGrade
from tumble.compare.grade.grade import SEARCH_S
from tumble.compare.grade.read.conventions import BODY, WORLD, Conventions
from tumble.compare.grade.read.programs import PROGRAMS
from tumble.compare.grade.read.reading_options import ReadingOptions
from tumble.compare.grade.study import grade_file
from tumble.compare.grade.tables import grade_tables
from tumble.reports.file_grade import file_text
from tumble.scenarios.read import scene_of_document
from tumble.scenarios.refusal import UserError
from tumble.scenarios.scene import Scene as Question

# Allowed words, as those of the command line.
CHOICES: dict[str, Collection[str]] = {
    "like": PROGRAMS,
    "by": ("pose", "matrix", "vertices"),
    "spin": (WORLD, BODY),
    "decimal": (".", ","),
}


class GradeResult(Result):
    """The grade of a trajectory, of a sensor's readings, or of both: tables, verdict, mistakes that explain it."""

    def __init__(self, grade: FileGrade, command: str) -> None:
        super().__init__(grade_tables(grade, command), text_of(file_text(grade)))
        self._grade = grade

    @property
    def verdict(self) -> str:
        """What was found, one of the verdicts of docs/grade.md."""
        return self._grade.verdict

    @property
    def mistakes(self) -> list[str]:
        """The names (docs/mistakes.md) of the mistakes that explain the file best; empty if none was found."""
        tables = [self.tables[name] for name in ("diagnosis.csv", "sensor-diagnosis.csv") if name in self.tables]
        best = [name for table in tables for name in table[table["rank"] == 1]["mistake"]]
        return [name for name in dict.fromkeys(best) if name]

    @property
    def engines(self) -> list[str]:
        """The engines whose defaults explain the file."""
        pose = self._grade.pose
        return list(pose.diagnosis.engines) if pose and pose.diagnosis else []

    @property
    def max_error_m(self) -> float:
        """Largest vertex error [m]; nan if there is no pose."""
        return float(self._grade.pose.measured.worst_m) if self._grade.pose else float("nan")


def grade(
    trajectory: "str | Path | pd.DataFrame | Mapping[str, Any] | Any",
    scene: SceneLike,
    *,
    columns: Mapping[str, str] | None = None,
    names: Sequence[str] = (),
    like: str | None = None,
    by: str | None = None,
    euler: str | None = None,
    axes: str | None = None,
    start: float | None = None,
    spin: str = "world",
    sensor: str | None = None,
    decimal: str = ".",
    search: float = SEARCH_S,
    progress: bool = True,
) -> GradeResult:
    """Measure how far off a trajectory is, and find the most likely cause.

    Parameters
    ----------
    trajectory : a path (CSV, JSON lines, Parquet), a table of pandas, polars or Arrow, or arrays by the name of their
        column.  One row an instant, times increasing.
    scene : the scene that it is graded against: a name, a path, a table as in TOML, or a `Scene`.
    columns : what each column is, with its unit: `{"Time": "t_s", "Pos X": "x_cm"}`.
    names : names of the columns of a file without a header.
    like : read it as one of this program: unity, unreal, blender, godot, ros, mujoco.
    by : what to grade where it has several: pose, matrix or vertices.
    euler : what angles rx, ry, rz are: a program, or the order of the turns.
    axes : its axes: a program, or what our x, y, z are, "x,y,-z".
    start : what its clock shows at the start [s].
    spin : axes of the angular velocity, "world" or "body".
    sensor : the sensor of the scene that readings ax, ay, az, gx, gy, gz are of; its only one if left out.
    decimal : decimal sign of a file.
    search : processor time after which the search for the cause stops with the best so far [s].
    progress : draw a bar in a terminal or a notebook.

    Returns
    -------
    GradeResult

    Raises
    ------
    UserError
        Where the trajectory cannot be read, or how to read it is not clear; the message says what to give.

    Examples
    --------
    >>> import tumble
    >>> motion = tumble.run("two-hits", "tumble:exact", progress=False)
    >>> tumble.grade(motion, "two-hits", progress=False).verdict
    'correct'
    """
    for name, value in {"like": like, "by": by, "spin": spin, "decimal": decimal}.items():
        if value is not None and value not in CHOICES[name]:
            raise UserError(f"{name} = {value!r}: must be {' or '.join(map(repr, CHOICES[name]))}")
    if start is not None and not (isinstance(start, Real) and math.isfinite(start)):
        raise UserError(f"start = {start!r}: must be a number of seconds")
    if not (isinstance(search, Real) and search > 0):
        raise UserError(f"search = {search!r}: must be a number of seconds above 0")
    if names and not isinstance(trajectory, str | Path):
        raise UserError("names: are those of a file without a header; to rename columns of a table, give columns")
    conventions = Conventions(euler, axes, start, spin)
    options = ReadingOptions(dict(columns or {}), decimal, by, conventions)
    with tempfile.TemporaryDirectory(prefix="tumble-") as folder:
        found = grade_file(
            str(_file(trajectory, Path(folder))),
            _question(scene),
            options,
            like=like,
            names=names,
            sensor=sensor,
            search_s=search,
            shown=None if isinstance(trajectory, str | Path) else "the trajectory",
            display=display(progress),
        )
    return GradeResult(found, call("grade", found.file, scene))


def _question(scene: SceneLike) -> Question:
    """Return the scene; one that only grading needs may be without a step and samples."""
    given = Scene.of(scene) if not isinstance(scene, Mapping) else None
    if given is not None:
        return given.question
    return scene_of_document(dict(scene), Path("scene.toml"), "scene", to_run=False)  # type: ignore[arg-type, call-overload]


def _file(trajectory: Any, folder: Path) -> Path:
    """Return the file of a trajectory, written into the folder with every digit where it is none."""
    if isinstance(trajectory, str | Path):
        return Path(trajectory)
    if not isinstance(trajectory, pd.DataFrame):
        # Of polars and of Arrow: pandas has deprecated the interchange protocol, and needs pyarrow for its successor.
        names = getattr(trajectory, "column_names", getattr(trajectory, "columns", None))
        if names is None and not isinstance(trajectory, Mapping):
            raise UserError(f"{type(trajectory).__name__}: must be a path, a data frame, or arrays by column name")
        names = trajectory if names is None else names
        trajectory = pd.DataFrame({str(name): np.asarray(trajectory[name]) for name in names})
    if not len(trajectory):
        raise UserError("the trajectory has no rows")
    file = folder / "trajectory.csv"
    trajectory.to_csv(file, index=False)  # the shortest digits that round-trip
    return file
