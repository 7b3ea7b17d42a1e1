"""`tumble merge`: the results of all shards of a command, as if it had run whole."""

from argparse import Namespace
from importlib import import_module
from pathlib import Path

from tumble.compare.run.shards.merging import merging
from tumble.shares import merged_options, with_parquet


def main(options: Namespace) -> int:
    """Run the command of the shards with their results; return its exit code."""
    merged = merged_options(options.folder, options.output, options.quiet)
    command = import_module(f"tumble.commands.{merged.command}")
    with merging([Path(folder) for folder in options.folder]):
        return with_parquet(command.main, merged)
