"""The study of `tumble grade`: a file and a scene in, its errors and the diagnosis out."""

import logging
import os
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import replace
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING

from tumble.compare.grade.file_grade import FileGrade
from tumble.compare.grade.grade import SEARCH_S, TASKS, grade
from tumble.compare.grade.hypotheses.explanation import Explanation
from tumble.compare.grade.measure.errors import Measured
from tumble.compare.grade.read.columns import AmbiguousFile, BadTrajectory
from tumble.compare.grade.read.formats import as_csv
from tumble.compare.grade.read.mapping import mapping_file
from tumble.compare.grade.read.reading_options import ReadingOptions
from tumble.compare.grade.read.refusals import refusal
from tumble.compare.grade.read.sensor_rows import rows_of_sensor
from tumble.compare.run.progress import Display, no_display
from tumble.scenarios.scene import Scene

if TYPE_CHECKING:  # most files have no readings
    from tumble.compare.grade.measure.readings import MeasuredReadings

log = logging.getLogger(__name__)


def grade_file(
    file: str,
    scene: Scene,
    options: ReadingOptions | None = None,
    *,
    like: str | None = None,
    map_file: str | None = None,
    names: Sequence[str] = (),
    shown: str | None = None,
    sensor: str | None = None,
    search_s: float = SEARCH_S,
    answer_s: float = inf,
    on_measured: Callable[[str, Measured, Sequence[str]], object] = lambda name, measured, observed: None,
    on_nearest: Callable[[Explanation], object] = lambda nearest: None,
    on_readings: "Callable[[str, Sequence[MeasuredReadings]], object]" = lambda name, measured: None,
    display: Display = no_display,
) -> FileGrade:
    """Grade the poses of one file, and the readings of a sensor, as far as it has them.

    Parameters
    ----------
    file : CSV, JSON lines or Parquet; - is standard input
    scene : the scene that it is graded against
    options : how the file is to be read
    like : read it as one of this program: unity, unreal, blender, godot, ros, mujoco
    map_file : TOML with a table [columns]; None: FILE.toml, if there is one
    names : names of the columns of a file without a header
    shown : what messages call the file; None: its path
    sensor : name of the sensor that readings are of; None: the scene's only one
    search_s : processor time after which the search for the cause of a wrong pose stops [s]
    answer_s : processor time of this process in which the answer should be there [s]; a search is shortened for it
    on_measured : called with the file's name, the errors and the observations, before a search
    on_nearest : called with the nearest engine scheme if none fits and a search begins
    on_readings : called with the file's name and the errors of its readings, before a search
    display : shows progress

    Returns
    -------
    the grades

    Raises
    ------
    BadTrajectory : the file cannot be read, or how to read it is not clear; the message has what to type
    NoTruth : the scene has no reference solution
    """
    given = options or ReadingOptions()
    beside = Path(map_file or f"{file}.toml")
    source = ""
    if map_file or os.path.isfile(beside):
        given = replace(given, mapping={**mapping_file(beside), **given.mapping})
        source = f"columns are named by {beside}"
    with ExitStack() as drafts:
        path, name, first_line = as_csv(file, list(names), given.decimal, drafts)
        name = shown or name
        reading = replace(given, conventions=replace(given.conventions, name=name, first_line=first_line))
        try:
            if like:
                reading = _like(like, path, scene, reading)
            trajectory = reading.opened(path, scene)
            read_by = None
            if trajectory.devices or sensor is not None:
                from tumble.compare.grade.sensor_grade import chosen_sensor

                read_by = chosen_sensor(scene, sensor)
                if not trajectory.devices:
                    raise BadTrajectory(
                        f"{name}: --sensor {sensor}: the file has no readings, ax, ay, az or gx, gy, gz"
                    )
                path = rows_of_sensor(path, name, read_by, drafts)
            pose = readings = None
            with display(TASKS * (bool(trajectory.descriptions) + (read_by is not None))) as on_progress:
                if trajectory.descriptions:
                    pose = grade(
                        path,
                        scene,
                        reading.mapping,
                        reading.by,
                        reading.decimal,
                        lambda measured, observed: on_measured(name, measured, observed),  # type: ignore[arg-type, return-value]
                        reading.conventions,
                        on_nearest=on_nearest,  # type: ignore[arg-type]
                        on_progress=on_progress,
                        search_s=search_s,
                        answer_s=answer_s,
                    )
                if read_by is not None:
                    from tumble.compare.grade.sensor_grade import grade_readings

                    readings = grade_readings(
                        reading.opened(path, scene),
                        scene,
                        read_by,
                        lambda measured: on_readings(name, measured),
                        on_progress,
                        pose=pose,
                    )
        except AmbiguousFile as question:
            raise _with_source(refusal(path, scene, reading, question), source) from None
        except BadTrajectory as error:
            raise _with_source(error, source) from None
    for line in (*reading.conventions.notes, source):
        if line:
            log.info(line)
    return FileGrade(pose, readings)


def _like(program: str, path: Path, scene: Scene, given: ReadingOptions) -> ReadingOptions:
    """Return the options that read a file as a program writes it, and log them."""
    from tumble.compare.grade.read.programs import misfit_remark, read_as_program

    reading, error = read_as_program(path, scene, given, program)
    options = reading.command_line(given) or "no further options"
    log.info(f"--like {program} reads the file with {options}{misfit_remark(error)}")
    return reading


def _with_source(error: BadTrajectory, source: str) -> BadTrajectory:
    """Return an error with the file that named the columns, if there is one."""
    return BadTrajectory(f"{error} ({source})") if source else error
