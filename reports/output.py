"""Standard output whose reader has gone."""

import os
import sys


def drop_output() -> None:
    """Discard what is still buffered for standard output, so that it does not raise again at exit."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
