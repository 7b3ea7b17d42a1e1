"""How a step changes the angular velocity by the gyroscopic term, in the axes of the tensor: w, dt, I, I^-1 -> w.

Each is what some engine or textbook does to I w' + w x I w = 0.
"""

from collections.abc import Callable

from tools.random_programs.algebra import (
    Matrix,
    Vector,
    add,
    along,
    combined,
    cross,
    minus,
    norm,
    scale,
    skew,
    skew_times,
    solved,
    times,
)

Scheme = Callable[[Vector, float, Matrix, Matrix], Vector]
# Newton steps and fixed-point rounds of the schemes that converge.
ROUNDS = 12


def rate(w: Vector, inertia: Matrix, inverse: Matrix) -> Vector:
    """Return dw/dt without a torque, I^-1 (I w x w)."""
    return times(inverse, cross(times(inertia, w), w))


def explicit(w: Vector, dt: float, inertia: Matrix, inverse: Matrix) -> Vector:
    """Explicit Euler."""
    return along(w, dt, rate(w, inertia, inverse))


def heun(w: Vector, dt: float, inertia: Matrix, inverse: Matrix) -> Vector:
    """Heun's method."""
    first = rate(w, inertia, inverse)
    return along(w, 0.5 * dt, add(first, rate(along(w, dt, first), inertia, inverse)))


def fourth_order(w: Vector, dt: float, inertia: Matrix, inverse: Matrix) -> Vector:
    """The classical Runge-Kutta method."""
    one = rate(w, inertia, inverse)
    two = rate(along(w, 0.5 * dt, one), inertia, inverse)
    three = rate(along(w, 0.5 * dt, two), inertia, inverse)
    four = rate(along(w, dt, three), inertia, inverse)
    return along(w, dt / 6, add(add(one, four), scale(2, add(two, three))))


def newton_once(w: Vector, dt: float, inertia: Matrix, inverse: Matrix) -> Vector:
    """One Newton step of implicit Euler (Catto 2015; btRigidBody)."""
    return _newton(w, dt, inertia, 1)


def newton(w: Vector, dt: float, inertia: Matrix, inverse: Matrix) -> Vector:
    """Implicit Euler, converged."""
    return _newton(w, dt, inertia, ROUNDS)


def _newton(w: Vector, dt: float, inertia: Matrix, rounds: int) -> Vector:
    new = w
    for _ in range(rounds):
        momentum = times(inertia, new)
        residual = along(times(inertia, minus(new, w)), dt, cross(new, momentum))
        slope = combined(inertia, dt, combined(skew_times(new, inertia), -1, skew(momentum)))
        new = minus(new, solved(slope, residual))
    return new


def lacoursiere(w: Vector, dt: float, inertia: Matrix, inverse: Matrix) -> Vector:
    """(I - dt [L]) w' = L (Lacoursiere 2006; the Open Dynamics Engine)."""
    momentum = times(inertia, w)
    return solved(combined(inertia, -dt, skew(momentum)), momentum)


def rescaled(w: Vector, dt: float, inertia: Matrix, inverse: Matrix) -> Vector:
    """L += dt L x w, then as long as it was (PhysX, Jolt)."""
    momentum = times(inertia, w)
    after = along(momentum, dt, cross(momentum, w))
    size = norm(after)
    return times(inverse, scale(norm(momentum) / size, after)) if size else w


def energy_kept(w: Vector, dt: float, inertia: Matrix, inverse: Matrix) -> Vector:
    """Explicit Euler, then w scaled so that the energy is what it was."""
    after = explicit(w, dt, inertia, inverse)
    old = sum(a * b for a, b in zip(w, times(inertia, w), strict=True))
    new = sum(a * b for a, b in zip(after, times(inertia, after), strict=True))
    return scale(type(w[0])((old / new) ** 0.5), after) if new else w


def midpoint(w: Vector, dt: float, inertia: Matrix, inverse: Matrix) -> Vector:
    """The implicit midpoint rule."""
    after = w
    for _ in range(ROUNDS):
        after = along(w, dt, rate(scale(0.5, add(w, after)), inertia, inverse))
    return after


def none(w: Vector, dt: float, inertia: Matrix, inverse: Matrix) -> Vector:
    """No gyroscopic term: w stands still in the world."""
    return w


SCHEMES: dict[str, Scheme] = {
    "none": none,
    "explicit": explicit,
    "implicit": newton_once,
    "implicit, converged": newton,
    "Lacoursiere": lacoursiere,
    "rescaled": rescaled,
    "energy kept": energy_kept,
    "midpoint": midpoint,
    "midpoint, turned by the new": midpoint,
    "Heun": heun,
    "order 4": fourth_order,
}
