"""`tumble run`: one trajectory."""

import sys
from argparse import Namespace
from pathlib import Path

from compare.engines import OWN
from compare.run.flight import check_step
from compare.run.participants import launched
from compare.run.registry import BadEngine
from compare.run.worker import Failure
from compare.tables.files import write_whole
from compare.tables.trajectory import trajectory_text
from scenarios.read import read_scene
from tumble.notes import note


def main(options: Namespace) -> int:
    """Fly one scene in one engine; the trajectory goes to standard output or to a file, notes to standard error."""
    if len(options.engine) > 1:
        raise BadEngine("run flies one engine; to hold several against each other use `tumble compare`")
    if options.output and Path(options.output).is_dir():
        example = Path(options.output) / "trajectory.csv"
        raise BadEngine(f"-o {options.output}: is a folder; run writes one file, e.g. -o {example}")
    scene = read_scene(options.scene)
    check_step(scene, options.dt)
    with launched(options.engine or [OWN], options.time_limit, options.memory_limit) as (participant,):
        method = participant.methods[0]
        flight = participant.fly(scene, method, options.dt or scene.step)
    name = f"{participant.title}:{method}"
    if isinstance(flight, Failure):
        raise BadEngine(f"{name} on {scene.name}: {flight.status}")
    if flight.diverged_at is not None:
        note(f"{name} diverged at {flight.diverged_at:.6g} s")
    if flight.remark:
        note(f"{name} {flight.remark}")
    for found in flight.notes:
        note(f"{name} flagged: {found}")
    text = trajectory_text(flight, scene.body)
    if options.output:
        write_whole(Path(options.output), text)
    else:
        sys.stdout.write(text)
    return 0
