"""The table of a vertex in what `tumble grade` prints: within 80 columns, with three digits of the largest numbers."""

from io import StringIO
from types import SimpleNamespace

import numpy as np
import pytest

from tumble.compare.grade.measure.errors import SampledRows
from tumble.reports.grade import vertex_table
from tumble.reports.terminal import LIST_WIDTH, console

ROWS = 12


def printed(size_m, error_m):
    random = np.random.default_rng(5)
    times = np.linspace(0.0, 3.0, ROWS) + 1 / 24
    true = size_m * random.uniform(-1, 1, (ROWS, 1, 3))
    off = error_m * random.uniform(-1, 1, (ROWS, 1, 3))
    off[-1] = error_m * np.array((-0.754, 0.123, -0.456))
    sample = SampledRows(times, true + off, true, np.full((ROWS, 3), 1e-15), None)
    out = StringIO()
    measured = SimpleNamespace(sample=sample, description=SimpleNamespace(vertices=(2,)), worst_vertex=2)
    console(file=out).print(vertex_table(measured))
    return out.getvalue()


@pytest.mark.parametrize(
    ("size_m", "error_m", "told"),
    [
        (99.0, 9000.0, "error x, y, z [km]"),
        (0.3, 9e-5, "-67.9, 11.1, -41.0"),
        (9.0, 9.0, "-6.79, 1.11, -4.10"),
        (950.0, 3e-9, "-2.26, 0.37, -1.37"),
        (1e-5, 6e-14, "-45.2, 7.4, -27.4"),
    ],
)
def test_the_table_fits_and_errors_have_three_digits(size_m, error_m, told):
    text = printed(size_m, error_m)
    assert max(map(len, text.splitlines())) <= LIST_WIDTH
    assert told in text
