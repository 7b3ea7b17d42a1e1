"""`tumble grade` as a whole process: how long it takes, and how much memory, against what was asked.

    python tests/bench/grade.py [--rows 10000000] [-o FILE.csv]

Files of the yardstick are written to a temporary folder, %.12g, centre and quaternion: a right one, one that a program
of first order flew, and one that no mistake explains, which is the longest search; of it the first word, too.  Warm:
kernels are compiled on a short file.  Memory is the child's peak, which must not grow with the rows.
"""

import subprocess
import sys
import tempfile
from argparse import ArgumentParser
from pathlib import Path
from time import perf_counter

import numpy as np
from figures import FigureRow, figure, of_children, rows_of, show

from tumble.compare.grade.model.reference import Reference
from tumble.scenarios.read import read_scene

SCENE = "yardstick"
ROWS, FIRST_WORDS = 10_000, 3
# A file as long compiles what one of ROWS needs.
SHORT = 300
SIZES = (100_000, 1_000_000)
ASKED_S, FIRST_WORD_S = 3.0, 0.7
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


def graded(path: Path) -> tuple[tuple[float, float], int]:
    """Return wall and processor time of a process that grades a file [s], and its peak memory [MB]."""
    words = [sys.executable, "-m", "tumble", "grade", str(path), "--scene", SCENE]
    before, begin = of_children(), perf_counter()
    done = subprocess.run([sys.executable, "-S", "-c", PEAK, *words], stdout=subprocess.PIPE, text=True, check=True)
    return (perf_counter() - begin, of_children() - before), int(done.stdout) // 1000


def first_word(path: Path) -> FigureRow:
    """Return how long it takes until a user at a terminal is told how far off a file is; the first pass is left out."""
    words = [sys.executable, "-m", "tumble", "grade", str(path), "--scene", SCENE]
    seconds = []
    for _ in range(FIRST_WORDS + 1):
        begin = perf_counter()
        with subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as process:
            assert process.stderr is not None
            line = process.stderr.readline()
            seconds.append(perf_counter() - begin)
            process.kill()
        if "largest error" not in line:
            raise SystemExit(f"the first word is: {line}")
    return figure(f"{ROWS} rows, first word", "", "s", FIRST_WORD_S, seconds[1:])


def timed(path: Path, kind: str) -> list[FigureRow]:
    """Return how long grading a file of ROWS rows takes."""
    write(path, ROWS, kind)
    return rows_of(f"{ROWS} rows, {kind}", ASKED_S, [graded(path)[0]])


def peak(path: Path, rows: int) -> list[FigureRow]:
    """Return the memory that a file of so many rows takes, and the time."""
    write(path, rows, "right")
    taken, megabytes = graded(path)
    return [
        FigureRow(f"{rows} rows, peak memory", "", None, "MB", None, *[megabytes] * 3),
        *rows_of(f"{rows} rows, right", None, [taken]),
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
        write(path, SHORT, "odd")
        graded(path)
        rows = [row for kind in ("right", "wrong", "odd") for row in timed(path, kind)]
        rows.append(first_word(path))
        rows += [row for size in sizes for row in peak(path, size)]
    show(rows, options.output)


if __name__ == "__main__":
    main()
