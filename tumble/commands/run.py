"""`tumble run`: one trajectory."""

import sys
from argparse import Namespace
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from shutil import copyfileobj
from tempfile import SpooledTemporaryFile

from tumble.compare.engines import OWN
from tumble.compare.run.engines.registry import BadEngine
from tumble.compare.run.flight import check_step, mean_step
from tumble.compare.run.progress import ProgressCallback, no_progress
from tumble.compare.run.running_engines import RunningEngine
from tumble.compare.run.starting import started
from tumble.compare.run.worker import Failure
from tumble.compare.tables.files import write_whole
from tumble.compare.tables.trajectory import trajectory_text
from tumble.notes import display, note
from tumble.scenarios.read import read_scene
from tumble.scenarios.scene import Scene

# Numbers of a trajectory that are flown at a time, and characters of its text that are kept in memory.
NUMBERS, IN_MEMORY = 2**19, 2**24


def main(options: Namespace) -> int:
    """Fly one scene in one engine; the trajectory goes to standard output or to a file, notes to standard error."""
    if len(options.engine) > 1:
        raise BadEngine("run flies one engine; to hold several against each other use `tumble compare`")
    if options.output and Path(options.output).is_dir():
        example = Path(options.output) / "trajectory.csv"
        raise BadEngine(f"-o {options.output}: is a folder; run writes one file, e.g. -o {example}")
    scene = read_scene(options.scene)
    check_step(scene, options.dt)
    show = display(options)
    with (
        started(options.engine or [OWN], options.time_limit, options.memory_limit, show) as (running_engine,),
        # Whole or not at all, and not all of it in memory.
        SpooledTemporaryFile(IN_MEMORY, "w+", encoding="utf-8", errors="backslashreplace", newline="") as text,
    ):
        with show(len(scene.start)) as on_progress:
            for piece in pieces(running_engine, scene, options.dt or scene.step, on_progress):
                text.write(piece)
        text.seek(0)
        if options.output:
            write_whole(Path(options.output), iter(partial(text.read, IN_MEMORY), ""))
        else:
            copyfileobj(text, sys.stdout)
    return 0


def pieces(
    running_engine: RunningEngine, scene: Scene, dt: float, on_progress: ProgressCallback = no_progress
) -> Iterator[str]:
    """Yield the trajectory's text, run and written some throws at a time, and say what there is to say of it."""
    method, throws = running_engine.methods[0], len(scene.start)
    name = f"{running_engine.title}:{method}"
    at_a_time = max(1, NUMBERS // (len(scene.rows) * (13 + scene.body.points.size)))
    diverged, said = [], {}
    for first in range(0, throws, at_a_time):
        part = replace(scene, start=scene.start[first : first + at_a_time])
        flight = running_engine.fly(part, method, dt)
        if isinstance(flight, Failure):
            raise BadEngine(f"{name} on {scene.name}: {flight.status}")
        if flight.diverged_at is not None:
            diverged.append(flight.diverged_at)
        said |= dict.fromkeys([flight.remark] * bool(flight.remark) + [f"flagged: {found}" for found in flight.notes])
        if running_engine.tolerance(method) is None and flight.diverged_at is None:
            taken = mean_step(scene.duration, flight.steps, dt)
            cut = f"took {flight.steps} steps of {taken:.4g} s on average: samples and impulses cut those of {dt:g} s"
            said |= dict.fromkeys([cut] * (taken != dt))
        yield trajectory_text(flight, scene.body, first, throws)
        on_progress(name, len(part.start))
    if diverged:
        note(f"{name} diverged at {min(diverged):.6g} s")
    for line in said:
        note(f"{name} {line}")
