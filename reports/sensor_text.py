"""What `tumble compare` prints of a scene's sensors: a sentence and a table of errors."""

from collections.abc import Iterator, Sequence

from rich.console import RenderableType
from rich.constrain import Constrain
from rich.text import Text

from tumble.compare.comparison.schemas import SensorErrorRow
from tumble.compare.comparison.sensor_errors import sensor_error_rows
from tumble.compare.judge.sensors import SensorRun
from tumble.reports.charts import GOOD
from tumble.reports.numerals import counted
from tumble.reports.terminal import LIST_WIDTH, columns, figure, plain

# The heads of the columns: a table is at most 80 characters wide.
HEADS = {"specific force": "acc. [m/s2]", "angular velocity": "gyro [rad/s]", "field direction": "field"}


def sensor_text(runs: Sequence[SensorRun], everything: bool = False) -> Iterator[RenderableType]:
    """Yield the sensors' part of the text of one scene, nothing without sensors.

    Parameters
    ----------
    runs : the readings of every contestant
    everything : every contestant that has readings, not only the first of each engine

    Yields
    ------
    the parts of the text, from top to bottom
    """
    if not (read := [run for run in runs if run.sensors]):
        return
    shown = read if everything else [*{run.engine: run for run in reversed(read)}.values()][::-1]
    present = [name for name in HEADS if any(row.quantity == name for row in sensor_error_rows(read[0]))]
    yield Text()
    yield Constrain(plain(summary(read)), LIST_WIDTH)
    heads = [HEADS[name] for name in present]
    table = columns("sensor", "contestant", "read by", *heads, right=range(3, 3 + len(heads)))
    for number, sensor in enumerate(read[0].scene.sensors):
        for run in shown:
            own = {row.quantity: row for row in sensor_error_rows(run) if row.sensor == sensor.name}
            name = sensor.name if run is shown[0] else ""
            cells = (error_cell(own[quantity]) if quantity in own else "" for quantity in present)
            table.add_row(plain(name), plain(run.name), next(iter(own.values())).reading, *cells)
        if number + 1 < len(read[0].scene.sensors):
            table.add_section()
    yield table
    if left := len(read) - len(shown):
        yield plain(f"{counted(left, 'more contestant')} with --all; every reading with -o DIR")


def summary(runs: Sequence[SensorRun]) -> str:
    """Return how many sensors are read, and what is left out, in a sentence or two."""
    sensors = runs[0].scene.sensors
    reasons = dict.fromkeys(
        why for errors in runs[0].sensors for why in errors.truth.why if why and errors.sensor.reads_force
    )
    text = f"Largest errors of {counted(len(sensors), 'sensor')} against the true readings."
    return " ".join([text, *(f"Left out: {why}." for why in reasons)])


def error_cell(row: SensorErrorRow) -> RenderableType:
    """Return the largest error, as a limit where it is below the resolution of the reference."""
    if row.max_error is None:
        return ""
    resolution = row.resolution or 0.0
    if row.max_error <= resolution:
        return Text(f"≤{figure(resolution)}", style=GOOD)
    return figure(row.max_error)
