"""What `tumble report` takes: with its kernels to be compiled, as after `make venv` in a fresh clone, and set up.

    python tests/bench/report.py [-o FILE.csv]

Wall time is the reader's, and what else the machine does is in it; processor time, of all its processes, is not.  What
the kernels cost is the difference of the two pages.
"""

import sys
import tempfile
from pathlib import Path

import numpy as np
from figures import of_process, output_option, rows_of, show

# What is asked of the page on two cores [s].
ASKED_SET_UP_S, ASKED_KERNELS_S = 12, 10


def taken(kernels: str) -> tuple[float, float]:
    """Return wall and processor time [s] of one page of the whole catalogue, its compiled kernels kept there."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "tumble", "report", "-o", str(Path(folder) / "page.html")]
        return of_process(command, NUMBA_CACHE_DIR=kernels)


def main() -> None:
    """Measure, print and write."""
    output = output_option(__doc__.splitlines()[0])
    with tempfile.TemporaryDirectory() as kernels:
        cold = taken(kernels)
        warm = taken(kernels)
    compiling = tuple(np.subtract(cold, warm).tolist())
    show(
        [
            *rows_of("first page", None, [cold]),
            *rows_of("page, set up", ASKED_SET_UP_S, [warm]),
            *rows_of("kernels: the difference", ASKED_KERNELS_S, [compiling]),
        ],
        output,
    )


if __name__ == "__main__":
    main()
