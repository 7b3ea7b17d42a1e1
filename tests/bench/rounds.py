"""What one process differs from the next: samples of the clock, of new processes again and again.

    python tests/bench/rounds.py [-o FILE.csv]

The intervals of ratios are tested on what this wrote once, on a machine whose two cores had other work all along:
tests/compare/run/rounds.csv, one row a round, one column a contestant, the time of a step [ns].
"""

import sys
from contextlib import ExitStack
from pathlib import Path

import pandas as pd
from figures import output_option

from tumble.compare.run.running_engines import launched
from tumble.compare.run.timing.readings import reading
from tumble.compare.run.timing.timing import Load
from tumble.compare.tables.files import write_whole
from tumble.compare.tables.frames import csv_text
from tumble.scenarios.read import read_scene

MINE = Path(__file__).parents[1] / "plugins" / "mine.py"
CONTESTANTS = ("tumble:rk4", "tumble:gauss6", "mujoco:euler", "mujoco:rk4", "pybullet:multibody", str(MINE))
PROCESSES, ROUNDS = 30, 24


def rounds_of_new_processes() -> list[list[float]]:
    """Return the time of a step [ns] of each contestant, (rounds, contestants)."""
    scene = read_scene("yardstick")
    with ExitStack() as stack:
        samplers = []
        for running_engine in stack.enter_context(launched(CONTESTANTS)):
            for method in running_engine.methods:
                load = Load(running_engine, scene, method)
                running_engine.prepare_timer(method, scene, method, load.pace)
                samplers.append((running_engine, method))
        taken = [[running_engine.sample(method) for running_engine, method in samplers] for _ in range(ROUNDS)]
    return [list(row) for row in zip(*(reading(its).samples.tolist() for its in zip(*taken, strict=True)), strict=True)]


def main() -> None:
    """Sample, and write the table."""
    output = output_option(__doc__.splitlines()[0])
    names = ["tumble:rk4", "tumble:gauss6", "mujoco:euler", "mujoco:rk4", "pybullet:multibody", "mine"]
    rows = [
        [process, number, *(float(f"{ns:.4g}") for ns in row)]
        for process in range(PROCESSES)
        for number, row in enumerate(rounds_of_new_processes())
    ]
    text = csv_text(pd.DataFrame(rows, columns=["process", "round", *names]))
    if output:
        write_whole(output, text)
    else:
        sys.stdout.write(text)


if __name__ == "__main__":
    main()
