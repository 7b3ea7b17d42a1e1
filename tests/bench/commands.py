"""What commands take, as whole processes with compiled kernels.

    python tests/bench/commands.py [--all] [-o FILE.csv]

What is timed several times is run once before; `one_throw.py` has compiled all that the sweep needs.  `--all`: also
`stability` and `check` of everything, which take minutes.
"""

import os
import sys
import tempfile
from argparse import ArgumentParser
from pathlib import Path

from figures import FigureRow, of_process, rows_of, show

# The words of each command, what is asked of it on two cores [s], and how often it is timed; commands of minutes.
COMMANDS = (("compare brick-tumble", 1.5, 3), ("sweep yardstick", 10.0, 1))
LONG = (("stability", 60.0, 1), ("check --accept -o record", 40.0, 1))


def timed(words: str, asked_s: float, passes: int) -> list[FigureRow]:
    """Return what a command takes in a folder of its own."""
    with tempfile.TemporaryDirectory() as folder:
        before = Path.cwd()
        os.chdir(folder)
        command = [sys.executable, "-m", "tumble", *words.split()]
        taken = [of_process(command) for _ in range(passes + (passes > 1))][-passes:]
        os.chdir(before)
    return rows_of(f"`tumble {words}`", asked_s, taken)


def main() -> None:
    """Measure, print and write."""
    parser = ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--all", action="store_true", help="also commands of minutes")
    parser.add_argument("-o", "--output", type=Path, metavar="FILE.csv", help="also write the figures as CSV")
    options = parser.parse_args()
    output = options.output and options.output.resolve()
    asked = (*COMMANDS, *(LONG if options.all else ()))
    show([row for each in asked for row in timed(*each)], output)


if __name__ == "__main__":
    main()
