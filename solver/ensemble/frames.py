"""The axes a throw is told in: those of the least, the middle and the greatest moment, then those its L runs round."""

from tumble.solver.body import by_moment
from tumble.solver.ensemble.lanes import lane
from tumble.solver.vectors import Vector


@lane
def ordered(inverse_moments: Vector, gyroscopic: Vector) -> tuple[tuple[int, int, int], float, Vector]:
    """Return the axes of the least, the middle and the greatest moment, and handed and g of `throw` in that order."""
    x, y, z = axes = by_moment(inverse_moments)
    handedness = 1.0 if (y - x) % 3 == 1 else -1.0
    return axes, handedness, (abs(gyroscopic[x]), abs(gyroscopic[y]), abs(gyroscopic[z]))


@lane
def framed(least: bool, signs: Vector, a: Vector) -> Vector:
    """Return a vector of the order of the moments in the axes of its throw's frame."""
    return (signs[0] * (a[2] if least else a[0]), signs[1] * a[1], signs[2] * (a[0] if least else a[2]))


@lane
def placed(least: bool, signs: Vector, a: Vector) -> Vector:
    """Return a vector of the frame in the order of the moments."""
    first, third = signs[0] * a[0], signs[2] * a[2]
    return (third if least else first, signs[1] * a[1], first if least else third)


@lane
def frame_of(direct: Vector, g: Vector, handedness: float) -> tuple[bool, Vector]:
    """Return whether L runs round the axis of the least moment, and the signs of the frame's axes.

    direct: L/|L|; g and handed: as `throw` has them.  L runs round the axis of the greatest where 2E I2 < L^2, which is
    L1^2 g3 < L3^2 g1.  Where it is that of the least, half a turn about (1, 0, 1) exchanges the two, and half a turn
    about axis 1 brings L to the side of axis 3.
    """
    least = direct[2] * direct[2] * g[0] < direct[0] * direct[0] * g[2]
    sense = -1.0 if least else 1.0
    side = -1.0 if (direct[0] if least else direct[2]) < 0.0 else 1.0
    return least, (1.0, handedness * sense * side, side)
