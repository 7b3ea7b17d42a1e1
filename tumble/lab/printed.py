"""Table 4.1 as it was printed, in the scene: vertex 5 as the class's application and calculation had it."""

from typing import Any

import numpy as np
import viser

from tumble.lab.space import Space
from tumble.scenarios.frames import Array
from tumble.scenarios.published import VERTEX, table_4_1

APPLICATION, CALCULATED, TRUE = (27, 33, 39), (196, 40, 30), (110, 121, 131)
SIZE = 0.03


class PrintedTable:
    """The printed positions, joined by lines, and the true way of the vertex.

    The calculation is joined to the truth at each of the five times, so that its error is a line that can be seen.
    """

    def __init__(self, api: viser.SceneApi, space: Space, rows: Array) -> None:
        """rows: the throw's instants [s]."""
        table = table_4_1()
        self._api, self._space = api, space
        self._at = np.array([int(np.argmin(np.abs(rows - time))) for time in table.physics_times])
        self._printed = {CALCULATED: space.drawn(table.calculated), APPLICATION: space.drawn(table.application)}
        self._known = -1
        for colour, points in self._printed.items():
            name = f"{space.root}/printed{colour[0]}"
            api.add_point_cloud(
                f"{name}/points", points, colour, point_size=SIZE, point_shape="circle", point_shading="flat",
                precision="float32",
            )  # fmt: skip
            api.add_line_segments(f"{name}/way", ways(points), colour, thickness=1.5, thickness_units="screen")
        self._label = api.add_label(f"{space.root}/vertex", f"vertex {VERTEX}", anchor="bottom-right")
        self._parts: list[Any] = []

    def show(self, vertices: Array, true: Array) -> None:
        """Draw the vertex, of vertices that are there [m], (n, 3), and its way, of those of the truth, (k, n, 3)."""
        self._label.position = tuple(self._space.drawn(vertices[VERTEX]))
        if len(true) == self._known:
            return
        self._known = len(true)
        for part in self._parts:
            part.remove()
        drawn = self._space.drawn(true[:, VERTEX])
        there = self._at[self._at < len(true)]
        errors = np.stack([self._printed[CALCULATED][: len(there)], drawn[there]], axis=1)
        self._parts = [
            self._api.add_line_segments(
                f"{self._space.root}/{name}{len(true)}", lines.astype(np.float32), colour, thickness=thickness,
                thickness_units="screen",
            )
            for name, lines, colour, thickness in (
                ("trueway", ways(drawn), TRUE, 2.0),
                ("calculation", errors, CALCULATED, 1.0),
            )
            if len(lines)
        ]  # fmt: skip


def ways(points: Array) -> np.ndarray:
    """Return the lines that join points, (n, 3), in their order, (n - 1, 2, 3)."""
    return np.stack([points[:-1], points[1:]], axis=1).astype(np.float32)
