"""One triaxial box and three throws of it, for the tests of engines.

Three different moments, because a cube cannot show a wrong gyroscopic term.
"""

import numpy as np

from scenarios.frames import Array
from scenarios.mass import BOX_FACES, box_corners
from scenarios.published import table_4_1
from scenarios.scene import Body, Scene, frozen_array

SIZE = (0.4, 0.15, 0.1)
MASS = 2.4
MOMENTS = MASS / 12 * np.array([0.15**2 + 0.1**2, 0.4**2 + 0.1**2, 0.4**2 + 0.15**2])
GRAVITY = (0.3, -9.81, 0.1)

# Position, attitude (of unit length below), velocity, angular velocity near the middle axis, near the third, near none.
THROWS = np.array(
    [
        [0.3, -1.2, 0.7, 0.8, 0.2, -0.4, 0.4, 0.5, 3.0, -1.0, 0.2, 3.1, 0.4],
        [-7.0, 0.0, 0.1, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 2.0, 0.1, 0.2, -2.0],
        [0.0, 40.0, 2.0, -0.1, 0.7, 0.7, -0.1, -3.0, 1.0, 0.3, 1.5, 1.2, 1.0],
    ]
)
THROWS[:, 3:7] /= np.linalg.norm(THROWS[:, 3:7], axis=1, keepdims=True)


def scene(
    start: Array = THROWS,
    gravity: tuple[float, float, float] | None = None,
    mass: float = MASS,
    moments: Array | tuple[float, float, float] = tuple(MOMENTS),
) -> Scene:
    """Return a scene with no impulse; its times are those of Table 4.1, for the hand calculation flies no others."""
    times = frozen_array(table_4_1().physics_times)
    body = Body("box", mass, frozen_array(moments), frozen_array(box_corners(np.array(SIZE))), BOX_FACES)
    field = None if gravity is None else frozen_array(gravity)
    return Scene("triaxial", "Triaxial box", "", times[-1], times, 0.001, body, frozen_array(start), field)
