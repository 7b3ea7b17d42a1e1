"""`tumble advise`: the cheapest way to an error."""

from argparse import Namespace

from compare.run.participants import flights, launched
from compare.sweep.sweep import sweep
from reports.terminal import advice_text, console
from scenarios.read import read_scene
from tumble.notes import progress


def main(options: Namespace) -> int:
    """Sweep one scene and print the cheapest method and step of each engine."""
    scene = read_scene(options.scene)
    with launched(options.engine, options.time_limit) as participants:
        with progress(flights(participants, [scene]) + 1) as tick:
            found = sweep(participants, scene, tick)
        out = console()
        for piece in advice_text(found, options.tolerance):
            out.print(piece)
    return 0
