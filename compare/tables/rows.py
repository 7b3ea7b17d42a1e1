"""The tables that others script against: one row type a table, one field a column, one CSV text a table."""

import csv
import io
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import astuple, dataclass, fields
from types import NoneType
from typing import TYPE_CHECKING, Any, TypeVar, get_args, get_type_hints

import numpy as np

from compare.run.flight import Trajectory
from scenarios.frames import Array, quaternion_product
from scenarios.scene import Body

if TYPE_CHECKING:
    from compare.judge.errors import Run  # it knows the truth, which a trajectory alone has no use for

Row = TypeVar("Row")
Cells = dict[str, str]

STATE_COLUMNS = [
    "t_s", "x_m", "y_m", "z_m", "qw", "qx", "qy", "qz",
    "vx_m_s", "vy_m_s", "vz_m_s", "wx_rad_s", "wy_rad_s", "wz_rad_s",
]  # fmt: skip

# Text that a spreadsheet takes for a formula, or what is written here in its place.
FORMULA = re.compile(r"['\s]*[=+\-@]")


@dataclass(frozen=True)
class VertexErrorRow:
    """One vertex of one run at one sample; of many throws the first, which is the scene as written."""

    scene: str
    engine: str
    method: str
    dt_s: float
    t_s: float
    vertex: int
    true_x_m: float
    true_y_m: float
    true_z_m: float
    x_m: float
    y_m: float
    z_m: float
    error_x_m: float
    error_y_m: float
    error_z_m: float
    error_m: float


@dataclass(frozen=True)
class RunRow:
    """One run: errors over all vertices and samples, drifts from the truth, and what its native loop took.

    Where there is no flight or no truth the figures are empty and the status says why.
    """

    scene: str
    engine: str
    method: str
    dt_s: float
    steps: int | None
    status: str
    max_error_m: float | None = None
    rms_error_m: float | None = None
    final_error_m: float | None = None
    limit_m: float | None = None
    energy_drift: float | None = None
    momentum_drift: float | None = None
    angular_momentum_drift: float | None = None
    wall_s: float | None = None
    wall_ns_per_step: float | None = None
    wall_per_sim_s: float | None = None


def vertex_error_rows(run: "Run") -> Iterator[VertexErrorRow]:
    """Yield the rows of one run, by sample and vertex."""
    if not run.has_errors or run.truth is None:
        return
    samples = len(run.scene.times)
    true, flown = run.truth.vertices[-samples:], run.flight.vertices[-samples:]
    for (sample, vertex), distance in np.ndenumerate(run.distances[:, 0]):
        at = sample, 0, vertex
        yield VertexErrorRow(
            run.scene.name,
            run.engine,
            run.method,
            run.dt,
            float(run.scene.times[sample]),
            vertex,
            *xyz(true[at]),
            *xyz(flown[at]),
            *xyz(run.errors[at]),
            float(distance),
        )


def xyz(vector: Array) -> tuple[float, float, float]:
    """Return a vector, (3,), as three cells."""
    x, y, z = vector.tolist()
    return x, y, z


def run_row(run: "Run") -> RunRow:
    """Return the row of one run."""
    key = run.scene.name, run.engine, run.method, run.dt
    if not isinstance(run.answer, Trajectory):
        return RunRow(*key, None, run.status)
    steps, wall_s = run.flight.steps, run.flight.wall_s
    wall = wall_s, wall_s / steps * 1e9, wall_s / run.scene.duration
    if not run.has_errors:
        return RunRow(*key, steps, run.status, None, None, None, None, None, None, None, *wall)
    distances = run.distances
    return RunRow(
        *key,
        steps,
        run.status,
        float(distances.max()),
        float(np.sqrt((distances**2).mean())),
        float(distances[-1].max()),
        float(run.limits.max()),
        *run.drifts,
        *wall,
    )


def trajectory_header(vertices: int, throws: int) -> list[str]:
    """Return the column names of a trajectory; with many throws the first says which."""
    points = [f"v{vertex}{axis}_m" for vertex in range(vertices) for axis in "xyz"]
    return ["throw"] * (throws > 1) + STATE_COLUMNS + points


def trajectory_rows(flight: Trajectory, body: Body) -> Iterator[list[float]]:
    """Yield one row a sample and throw; the quaternion is that of the scene file's axes."""
    throws = flight.states.shape[1]
    for throw in range(throws):
        for time, states, points in zip(flight.times, flight.states, flight.vertices, strict=True):
            state = states[throw].copy()
            if body.file_axes[0] != 1.0:
                state[3:7] = quaternion_product(state[3:7], body.file_axes)
            yield [throw] * (throws > 1) + [float(time), *state.tolist(), *points[throw].ravel().tolist()]


def csv_text(header: Sequence[str], rows: Iterable[Iterable[Any]]) -> str:
    """Return rows as CSV, first line the header, floats in 17 digits, nothing for None."""
    lines = Lines()
    writer = csv.writer(lines)
    writer.writerow(header)
    writer.writerows([cell(value) for value in row] for row in rows)
    return "\n".join([*lines, ""])


class Lines(list[str]):
    """The lines of a CSV file without their ends.

    A writer quotes what its own line ends are made of: \\r\\n here, so that a \\r in a text ends no line either.
    """

    def write(self, line: str) -> None:
        """Take one line."""
        self.append(line.removesuffix("\r\n"))


def cell(value: object) -> object:
    """Return what stands in a CSV cell: floats in 17 digits, and before text that a spreadsheet would run a '."""
    if isinstance(value, float):
        return f"{value:.17g}"
    return f"'{value}" if isinstance(value, str) and FORMULA.match(value) else value


def text_of_cell(cell: str) -> str:
    """Return the text that `cell` was made of."""
    return cell[1:] if cell.startswith("'") and FORMULA.match(cell) else cell


def table_text(row_type: type, rows: Iterable[Any]) -> str:
    """Return a table of rows of one type as CSV."""
    return csv_text([field.name for field in fields(row_type)], map(astuple, rows))


def cells(text: str) -> Iterator[Cells]:
    """Yield a table's rows, column name -> cell."""
    lines = csv.reader(io.StringIO(text, newline=""))
    names = next(lines)
    return (dict(zip(names, map(text_of_cell, line), strict=True)) for line in lines)


def typed(row_type: type[Row], table: Iterable[Cells]) -> Iterator[Row]:
    """Yield rows as row_type; an empty cell is None where the column may be.  Raises ValueError, KeyError."""
    hints = get_type_hints(row_type)
    readers = {field.name: reader(hints[field.name]) for field in fields(row_type)}  # type: ignore[arg-type]
    for row in table:
        yield row_type(**{name: read(row[name]) for name, read in readers.items()})


def reader(hint: Any) -> Callable[[str], Any]:
    """Return what makes a column's value from its cell."""
    kinds = get_args(hint) or (hint,)
    if hint is bool:
        return lambda cell: cell == str(True)
    read = kinds[0]
    if NoneType in kinds:
        return lambda cell: read(cell) if cell else None
    return read
