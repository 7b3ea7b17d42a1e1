"""What `tumble report` takes: with its kernels to be compiled, as after `make venv` in a fresh clone, and set up.

    python tests/bench/report.py [-o FILE.csv]

Wall time is the reader's, and what else the machine does is in it; processor time, of all its processes, is not.
"""

import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from figures import FigureRow, figure, output_option, show

PASSES = 3
# What is asked of `make report` on two cores [s]: 75 in a fresh clone, where installing takes some 33 of them; and 20.
ASKED_COLD_S, ASKED_SET_UP_S = 42, 20


def taken(kernels: str) -> tuple[float, float]:
    """Return wall and processor time [s] of one page of the whole catalogue, its compiled kernels kept there."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "tumble", "report", "-o", str(Path(folder) / "page.html")]
        before, begin = of_children(), time.perf_counter()
        subprocess.run(command, check=True, env={**os.environ, "NUMBA_CACHE_DIR": kernels}, stderr=subprocess.DEVNULL)
        return time.perf_counter() - begin, of_children() - before


def of_children() -> float:
    """Return the processor time of all processes that were started here and have ended [s]."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def rows_of(what: str, asked: float, passes: list[tuple[float, float]]) -> list[FigureRow]:
    """Return a row of wall time and one of processor time."""
    wall, processor = zip(*passes, strict=True)
    return [figure(f"{what}, wall", "", "s", asked, wall), figure(f"{what}, processor", "", "s", None, processor)]


def main() -> None:
    """Measure, print and write."""
    output = output_option(__doc__.splitlines()[0])
    with tempfile.TemporaryDirectory() as kernels:
        cold = [taken(kernels)]
        warm = [taken(kernels) for _ in range(PASSES)]
    show([*rows_of("kernels cold", ASKED_COLD_S, cold), *rows_of("set up", ASKED_SET_UP_S, warm)], output)


if __name__ == "__main__":
    main()
