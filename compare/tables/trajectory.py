"""A trajectory as CSV: one row a sample and throw, with as many vertices as the body has."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from tumble.compare.run.flight import Trajectory
from tumble.compare.tables.cells import float_cells, lines_text
from tumble.scenarios.frames import Array, quaternion_product
from tumble.scenarios.scene import Body

if TYPE_CHECKING:  # `tumble run` needs neither
    import pandas as pd

    from tumble.scenarios.truth import Truth

STATE_COLUMNS = [
    "t_s", "x_m", "y_m", "z_m", "qw", "qx", "qy", "qz",
    "vx_m_s", "vy_m_s", "vz_m_s", "wx_rad_s", "wy_rad_s", "wz_rad_s",
]  # fmt: skip


def trajectory_header(vertices: int, throws: int) -> list[str]:
    """Return the column names of a trajectory; with many throws the first says which."""
    points = [f"v{vertex}{axis}_m" for vertex in range(vertices) for axis in "xyz"]
    return ["member"] * (throws > 1) + STATE_COLUMNS + points


def trajectory_text(flight: Trajectory, body: Body, first: int = 0, of: int | None = None) -> str:
    """Return a trajectory as CSV text, throw after throw; the quaternion is that of the scene file's axes.

    Parameters
    ----------
    flight : the trajectory, all throws of the scene or a part of them
    body : the body of the scene
    first : number of the first throw of this part; a part with 0 has the header
    of : number of throws in all parts; None: those of `flight`

    Returns
    -------
    the lines of the file, the header included if `first` is 0
    """
    samples, throws = flight.states.shape[:2]
    header = trajectory_header(len(body.points), of or throws)
    numbers = [[str(first + throw) for throw in range(throws) for _ in range(samples)]] * (header[0] == "member")
    text = lines_text(header, numbers + [float_cells(each, "nan") for each in trajectory_columns(flight, body)])
    return text[text.index("\n") + 1 :] if first else text


def trajectory_frame(flight: "Trajectory | Truth", body: Body) -> "pd.DataFrame":
    """Return a trajectory as a table, member after member; the quaternion is that of the scene file's axes.

    Parameters
    ----------
    flight : the trajectory or the reference solution, of N members
    body : the body of the scene

    Returns
    -------
    one row a sample of each member; the column `member` is present if N > 1
    """
    import pandas as pd

    samples, members = flight.states.shape[:2]
    header = trajectory_header(len(body.points), members)
    which = [np.repeat(np.arange(members), samples)] if members > 1 else []
    return pd.DataFrame(dict(zip(header, [*which, *trajectory_columns(flight, body)], strict=True)))


def trajectory_columns(flight: "Trajectory | Truth", body: Body) -> Iterator[Array]:
    """Yield time, the thirteen numbers of the states and the vertices, each (throws * samples,)."""
    samples, throws = flight.states.shape[:2]
    states = flight.states.swapaxes(0, 1).reshape(-1, 13).copy()
    if body.file_axes[0] != 1.0:
        states[:, 3:7] = quaternion_product(states[:, 3:7], body.file_axes)
    yield np.tile(flight.times, throws)
    yield from states.T
    yield from flight.vertices.swapaxes(0, 1).reshape(throws * samples, -1).T
