"""A rigid body as numbers, Euler's equations, and the motion of any of its points."""

from dataclasses import dataclass

from tumble.solver.compilation import inner, scalar
from tumble.solver.quaternion import Quaternion, rotate, rotate_back
from tumble.solver.vectors import Vector, add, cross, dot, scale, times


@dataclass(frozen=True)
class Body:
    """A rigid body in its principal axes, the origin at its centre of mass.

    Parameters
    ----------
    mass : kg
    moments : (3,), kg m2
        principal moments of inertia

    Raises
    ------
    ValueError
        The mass or a moment is not positive.
    """

    mass: float
    moments: Vector

    def __post_init__(self) -> None:
        if not all(value > 0.0 for value in (self.mass, *self.moments)):
            raise ValueError(f"mass and moments must be positive, got {self.mass} and {self.moments}")

    @property
    def inverse_moments(self) -> Vector:
        """1 / moments [1/(kg m2)]."""
        a, b, c = self.moments
        return (1.0 / a, 1.0 / b, 1.0 / c)

    @property
    def gyroscopic(self) -> Vector | None:
        """1/C - 1/B, 1/A - 1/C, 1/B - 1/A [1/(kg m2)], the coefficients of dL/dt = L x w; None for equal moments.

        Equal moments have no gyroscopic torque, so their angular velocity is constant: kernels compile no term for it.
        """
        a, b, c = self.moments
        if a == b == c:
            return None
        # The difference of the moments, not of their inverses: exact where they are close.
        return ((b - c) / (b * c), (c - a) / (c * a), (a - b) / (a * b))


@inner
def by_moment(inverse_moments: Vector) -> tuple[int, int, int]:
    """Return the axes of the least, the middle and the greatest moment."""
    least, greatest = 0, 2
    for axis in range(3):
        if inverse_moments[axis] > inverse_moments[least]:
            least = axis
        if inverse_moments[axis] < inverse_moments[greatest]:
            greatest = axis
    return least, 3 - least - greatest, greatest


@scalar
def momentum_rate(l_body: Vector, gyroscopic: Vector) -> Vector:
    """Return dL/dt = L x w seen from the turning body [N m], in body axes, with no torque.

    l_body: angular momentum [kg m2/s].  Source: Euler (1765); Goldstein, "Classical Mechanics" (1980), eq. 5-39.
    """
    return times(gyroscopic, products(l_body))


@scalar
def products(l_body: Vector) -> Vector:
    """Return L2 L3, L3 L1 and L1 L2 [(kg m2/s)2]: dL/dt for `Body.gyroscopic` times as much."""
    return (l_body[1] * l_body[2], l_body[2] * l_body[0], l_body[0] * l_body[1])


@scalar
def momentum_resolved(l_body: Vector, gyroscopic: Vector, right: Vector) -> Vector:
    """Return the d of d - D d = right, where D is the derivative of `momentum_rate` at l_body, by Cramer's rule.

    gyroscopic: times a step, so that D is a number; it and right may be complex.
    """
    (a, b, c), (x, y, z) = gyroscopic, l_body
    row1, row2, row3 = (1.0, -a * z, -a * y), (-b * z, 1.0, -b * x), (-c * y, -c * x, 1.0)
    minor1, minor2, minor3 = cross(row2, row3), cross(row3, row1), cross(row1, row2)
    sum_of_minors = add(scale(right[0], minor1), add(scale(right[1], minor2), scale(right[2], minor3)))
    return scale(1.0 / dot(row1, minor1), sum_of_minors)


@scalar
def angular_acceleration(q: Quaternion, w_world: Vector, moments: Vector, gyroscopic: Vector | None) -> Vector:
    """Return the angular acceleration of a body that no torque acts on [rad/s2], world axes.

    The same in both sets of axes: dw/dt differs between them by w x w = 0.
    """
    if gyroscopic is None:
        return (0.0, 0.0, 0.0)
    rate = momentum_rate(times(moments, rotate_back(q, w_world)), gyroscopic)
    return rotate(q, (rate[0] / moments[0], rate[1] / moments[1], rate[2] / moments[2]))


@scalar
def point_position(x: Vector, q: Quaternion, point_body: Vector) -> Vector:
    """Return where a point of the body is [m], world axes: p = x + R p0 (CE1051A report, eq. 2.12)."""
    return add(x, rotate(q, point_body))


@scalar
def point_velocity(v: Vector, q: Quaternion, w_world: Vector, point_body: Vector) -> Vector:
    """Return how fast a point of the body moves [m/s], world axes: v + w x R p0 (CE1051A report, eq. 2.13)."""
    return add(v, cross(w_world, rotate(q, point_body)))


@scalar
def point_acceleration(a: Vector, q: Quaternion, w_world: Vector, alpha_world: Vector, point_body: Vector) -> Vector:
    """Return the acceleration of a point of the body [m/s2], world axes: a + alpha x R p0 + w x (w x R p0).

    a: of the centre of mass; alpha_world: angular acceleration [rad/s2].
    Source: CE1051A report, eq. 2.14, which leaves out alpha x R p0: nothing where the angular velocity is constant, as
    for its cube in free flight, but not for a brick.
    """
    lever = rotate(q, point_body)
    return add(a, add(cross(alpha_world, lever), cross(w_world, cross(w_world, lever))))
