"""`tumble engines`: who can take part here."""

from argparse import Namespace

from compare.crew import crew
from compare.results import engine_row
from reports.terminal import console, engine_list


def main(options: Namespace) -> int:
    """List every engine with its version, methods and precision, or why it is missing."""
    with crew(options.engine) as entrants:
        console().print(engine_list([engine_row(entrant) for entrant in entrants]))
    return 0
