"""The scene that tests of tools/random_programs use: a brick thrown tumbling."""

import numpy as np

from tools.random_programs.scene import Scene, box_inertia, corners

SIZE = np.array((0.5, 0.3, 0.2))
BRICK = Scene(
    "brick",
    1.0,
    2.0,
    box_inertia(2.0, SIZE),
    corners(SIZE),
    np.array((0.4, 1.0, -0.6)),
    np.array((0.7, 0.1, -0.5, 0.5)),
    np.array((0.8, 5.0, -0.4)),
    np.array((2.0, -3.0, 1.5)),
    np.array((0.0, -9.81, 0.0)),
    SIZE,
)
