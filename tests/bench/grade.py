"""`tumble grade` as a whole process: how long it takes, and how much memory, against what was asked.

    python tests/bench/grade.py [--rows 10000000] [-o FILE.csv]

Files of the yardstick are written to a temporary folder, %.12g, centre and quaternion: a right one, one that a program
of first order flew, and one that no mistake explains, which is the longest
search; of it the first word, too.  Warm: the first run of each
compiles and is left out.  Memory is the child's peak, which must not grow with the rows.
"""

import subprocess
import sys
import tempfile
from argparse import ArgumentParser
from pathlib import Path
from time import perf_counter

import numpy as np
from figures import FigureRow, show

from tumble.compare.grade.model.reference import Reference
from tumble.scenarios.read import read_scene

SCENE = "yardstick"
ROWS, PASSES = 10_000, 3
SIZES = (100_000, 1_000_000)
ASKED_S, FIRST_WORD_S = 5.0, 1.0
# Rows written at a time.
PART = 50_000
HEADER = "t_s,x_m,y_m,z_m,qw,qx,qy,qz"


def write(path: Path, rows: int, kind: str) -> None:
    """Write a trajectory: `right`; `wrong`: the clock of the attitude is 1 % fast; `odd`: pushed to and fro as well."""
    scene = read_scene(SCENE)
    reference = Reference(scene)
    with path.open("w") as file:
        file.write(f"{HEADER}\n")
        clock = np.linspace(0.0, scene.duration, rows)
        for begin in range(0, rows, PART):
            times = clock[begin : begin + PART]
            states = reference.states(0, times)
            if kind != "right":
                states[:, 3:7] = reference.states(0, np.multiply(1.01, times))[:, 3:7]
            if kind == "odd":
                states[:, 0:3] += 0.3 * np.sin(np.outer(times, (7.0, 11.0, 17.0)))
            np.savetxt(file, np.column_stack((times, states[:, :7])), fmt="%.12g", delimiter=",")


# A process begins with the peak of the one that it was made by, so this small one stands between.
PEAK = """
import resource, subprocess, sys
subprocess.run(sys.argv[1:], stdout=subprocess.DEVNULL, check=True)
print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)
"""


def graded(path: Path) -> tuple[float, float]:
    """Return how long a process takes to grade a file [s], and its peak memory [MB]."""
    words = [sys.executable, "-m", "tumble", "grade", str(path), "--scene", SCENE]
    begin = perf_counter()
    done = subprocess.run([sys.executable, "-S", "-c", PEAK, *words], stdout=subprocess.PIPE, text=True, check=True)
    return perf_counter() - begin, int(done.stdout) / 1000


def first_word(path: Path) -> FigureRow:
    """Return how long it takes until a user at a terminal is told how far off a file is; the first pass is left out."""
    words = [sys.executable, "-m", "tumble", "grade", str(path), "--scene", SCENE]
    seconds = []
    for _ in range(PASSES + 1):
        begin = perf_counter()
        with subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as process:
            assert process.stderr is not None
            line = process.stderr.readline()
            seconds.append(perf_counter() - begin)
            process.kill()
        if "largest error" not in line:
            raise SystemExit(f"the first word is: {line}")
    return FigureRow(
        f"{ROWS} rows, first word", "", None, "s", FIRST_WORD_S, float(np.mean(seconds[1:])), *_range(seconds[1:])
    )


def _range(seconds: list[float]) -> tuple[float, float]:
    return min(seconds), max(seconds)


def timed(path: Path, kind: str) -> FigureRow:
    """Return how long grading a file of ROWS rows takes."""
    write(path, ROWS, kind)
    graded(path)
    passes = [graded(path)[0] for _ in range(PASSES)]
    return FigureRow(f"{ROWS} rows, {kind}", "", None, "s", ASKED_S, float(np.mean(passes)), min(passes), max(passes))


def peak(path: Path, rows: int) -> list[FigureRow]:
    """Return the memory that a file of so many rows takes, and the time."""
    write(path, rows, "right")
    seconds, megabytes = graded(path)
    return [
        FigureRow(f"{rows} rows, peak memory", "", None, "MB", None, *[megabytes] * 3),
        FigureRow(f"{rows} rows, right", "", None, "s", None, *[seconds] * 3),
    ]


def main() -> None:
    """Measure, print and write."""
    parser = ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--rows", type=int, help="measure memory at so many rows as well")
    parser.add_argument("-o", "--output", type=Path, metavar="FILE.csv", help="also write the figures as CSV")
    options = parser.parse_args()
    sizes = (*SIZES, *([options.rows] if options.rows else []))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "trajectory.csv"
        rows = [timed(path, kind) for kind in ("right", "wrong", "odd")]
        rows.append(first_word(path))
        rows += [row for size in sizes for row in peak(path, size)]
    show(rows, options.output)


if __name__ == "__main__":
    main()
