"""`tumble advise`: the cheapest engine, method and step within a tolerance."""

from argparse import Namespace

from tumble.compare.sweep.study import advise_scenes
from tumble.finished import exit_code
from tumble.notes import display
from tumble.reports.sweep_text import advice_text
from tumble.reports.terminal import console
from tumble.scenarios.read import read_scenes


def main(options: Namespace) -> int:
    """Sweep each scene as far as the tolerance needs, and print what to use."""
    found, named = advise_scenes(
        read_scenes(options.scene),
        options.tolerance,
        options.engine,
        beyond_samples=options.beyond_samples,
        time_limit=options.time_limit,
        memory_limit=options.memory_limit,
        display=display(options),
    )
    out = console()
    for sweep in found:
        for piece in advice_text(sweep, options.tolerance, named):
            out.print(piece)
    return exit_code(run.status for sweep in found for run in sweep.runs)
