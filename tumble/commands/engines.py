"""`tumble engines`: who can take part here."""

from argparse import Namespace

from compare.run.participants import launched
from compare.tables.engines import engine_row
from reports.terminal import console, engine_list


def main(options: Namespace) -> int:
    """List every engine with its version, methods and precision, or why it is missing."""
    with launched(options.engine) as participants:
        console().print(engine_list([engine_row(participant) for participant in participants]))
    return 0
