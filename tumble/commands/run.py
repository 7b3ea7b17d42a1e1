"""`tumble run`: one trajectory."""

import sys
from argparse import Namespace
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from shutil import copyfileobj
from tempfile import SpooledTemporaryFile

from tumble.compare.engines import OWN, OWN_ON_PLANE
from tumble.compare.run.engines.registry import BadEngine
from tumble.compare.run.flight import check_step, mean_step
from tumble.compare.run.progress import ProgressCallback, no_progress
from tumble.compare.run.running_engines import RunningEngine
from tumble.compare.run.starting import started
from tumble.compare.run.status import Failure
from tumble.compare.tables.files import write_whole
from tumble.compare.tables.trajectory import trajectory_text
from tumble.notes import display, note
from tumble.scenarios.read import BadScene, read_scene
from tumble.scenarios.scene import Scene

# Numbers of a trajectory that are simulated at a time, and characters of its text that stay in memory.
NUMBERS, IN_MEMORY = 2**19, 2**24


def main(options: Namespace) -> int:
    """Run one scene in one engine; the trajectory goes to standard output or to a file, notes to standard error."""
    if len(options.engine) > 1:
        raise BadEngine("run takes one engine; to compare several, type `tumble compare`")
    if options.output and Path(options.output).is_dir():
        example = Path(options.output) / "trajectory.csv"
        raise BadEngine(f"-o {options.output}: is a folder; give a file, e.g. -o {example}")
    scene = read_scene(options.scene)
    check_step(scene, options.dt)
    if options.sensors and not scene.sensors:
        raise BadScene(f"--sensors {options.sensors}: {scene.name} has no sensor; add a [[sensor]] table to the scene")
    show = display(options)
    engine = options.engine or [OWN if scene.plane is None else OWN_ON_PLANE]
    with (
        started(engine, options.time_limit, options.memory_limit, show) as (running_engine,),
        # Whole or not at all, and not all of it in memory.
        SpooledTemporaryFile(IN_MEMORY, "w+", encoding="utf-8", errors="backslashreplace", newline="") as text,
    ):
        with show(len(scene.start)) as on_progress:
            for piece in pieces(running_engine, scene, options.dt or scene.step, on_progress):
                text.write(piece)
            if options.sensors:
                write_sensors(Path(options.sensors), running_engine, scene, options.dt)
        text.seek(0)
        if options.output:
            write_whole(Path(options.output), iter(partial(text.read, IN_MEMORY), ""))
        else:
            copyfileobj(text, sys.stdout)
    return 0


def write_sensors(folder: Path, running_engine: RunningEngine, scene: Scene, dt: float | None) -> None:
    """Read the scene's sensors by the engine's first method, and write the tables."""
    from tumble.compare.comparison.sensor_tables import sensor_tables  # pandas is slow to load
    from tumble.compare.comparison.sensors import sensor_run
    from tumble.compare.tables.frames import write_tables

    found = sensor_run(running_engine, scene, running_engine.methods[0], dt or scene.step)
    if isinstance(found.answer, Failure):
        raise BadEngine(f"{found.name} on {scene.name}: {found.answer}")
    folder.mkdir(parents=True, exist_ok=True)
    write_tables(folder, sensor_tables([found]))
    note(f"sensors written to {folder}")


def pieces(
    running_engine: RunningEngine, scene: Scene, dt: float, on_progress: ProgressCallback = no_progress
) -> Iterator[str]:
    """Yield the trajectory's text, some throws at a time, and print notes about it."""
    method, throws = running_engine.methods[0], len(scene.start)
    name = f"{running_engine.title}:{method}"
    at_a_time = max(1, NUMBERS // (len(scene.rows) * (13 + scene.body.points.size)))
    diverged, remarks = [], {}
    for first in range(0, throws, at_a_time):
        part = replace(scene, start=scene.start[first : first + at_a_time])
        trajectory = running_engine.simulate(part, method, dt)
        if isinstance(trajectory, Failure):
            raise BadEngine(f"{name} on {scene.name}: {trajectory}")
        if trajectory.diverged_at is not None:
            diverged.append(trajectory.diverged_at)
        remarks |= dict.fromkeys(
            [trajectory.remark] * bool(trajectory.remark) + [f"flagged: {found}" for found in trajectory.notes]
        )
        if running_engine.tolerance(method) is None and trajectory.diverged_at is None:
            taken = mean_step(scene.duration, trajectory.steps, dt)
            why = f"samples and impulses cut the steps of {dt:g} s"
            cut = f"took {trajectory.steps} steps of {taken:.4g} s on average: {why}"
            remarks |= dict.fromkeys([cut] * (taken != dt))
        yield trajectory_text(trajectory, scene.body, first, throws)
        on_progress(name, len(part.start))
    if diverged:
        note(f"{name} diverged at {min(diverged):.6g} s")
    for line in remarks:
        note(f"{name} {line}")
