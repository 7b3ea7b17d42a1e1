"""A program's contact law: one impact, and motion along the plane, of the right law and of laws with a mistake.

All vectors are in the plane's frame: two axes along the plane, then its normal.
"""

from dataclasses import dataclass, replace

import numpy as np

from tumble.compare.grade.model.kernel.coasting import coast
from tumble.compare.grade.model.kernel.sliding import ROUND, impulse_of, slide_along
from tumble.scenarios.frames import Array, cross_matrix, rotation_matrix
from tumble.scenarios.lowest import lowest, lowest_point
from tumble.scenarios.scene import Body, Plane, Scene
from tumble.solver.body import Body as SolverBody
from tumble.solver.contact.flight import ContactFlight
from tumble.solver.contact.flight import Plane as SolverPlane
from tumble.solver.quaternion import from_matrix

# Friction in an impact: at each instant (Routh), on the impulse as a whole (Moreau), or after the normal impulse.
INSTANT, WHOLE, AFTER = "instant", "whole", "after"
# Sweeps of Gauss-Seidel over the normal and the friction of a whole impulse; steps of a motion along the plane.
SWEEPS, STEPS = 500, 8000
NORMAL = (0.0, 0.0, 1.0)
UP = np.array(NORMAL)
# Impacts between two rows that are followed, at most; times at once, and how often they are divided, to find the next
# one; a corner is below the plane from this share of the body's reach on.
MOST_IMPACTS, LOOKS, DIVIDED, BELOW = 4, 16, 5, 1e-9


@dataclass(frozen=True)
class ContactLaw:
    """The law of one body on one plane.

    Parameters
    ----------
    restitution, friction : of the pair
    normal : unit vector that the program takes for the normal, plane's frame
    cone : shape of the bound on friction
    in_impact : how friction acts in an impact
    torque : whether friction has a torque about the centre
    slip_of_centre : whether friction opposes the velocity of the centre, not of the contact point
    threshold : approach speed below which nothing rebounds [m/s]
    push : speed along the normal that a penetration adds, per depth [1/s]
    laid : whether the program takes the penetration out at once, so that the flights meet at another depth
    asleep : speed below which a body on the plane is stopped [m/s]
    viscous : slip below which friction falls in proportion [m/s]
    """

    restitution: float
    friction: float
    normal: tuple[float, float, float] = NORMAL
    cone: int = ROUND
    in_impact: str = INSTANT
    torque: bool = True
    slip_of_centre: bool = False
    threshold: float = 0.0
    push: float = 0.0
    laid: bool = False
    asleep: float = 0.0
    viscous: float = 0.0


@dataclass(frozen=True)
class Approach:
    """A body just before an impact: velocity [m/s], angular velocity [rad/s], (3,), axes, (3, 3), and lever [m], (3,).

    depth: at which the flights before and after it meet [m]; laid: that from which the body was laid on the plane [m].
    """

    v: Array
    w: Array
    axes: Array
    lever: Array
    depth: float
    laid: float = 0.0


def right_law(plane: Plane) -> ContactLaw:
    """Return the scene's law."""
    return ContactLaw(plane.restitution, plane.friction)


def inverse_inertia(body: Body, axes: Array) -> Array:
    """Return the inverse inertia tensor about the centre [1/(kg m2)], (3, 3)."""
    inverse: Array = (axes / body.moments) @ axes.T
    return inverse


def frame_of(normal: Array) -> Array:
    """Return axes, rows, whose third one is a normal; the first two are nearest to the plane's own."""
    first = np.array((1.0, 0.0, 0.0)) - normal * normal[0]
    first /= np.linalg.norm(first)
    return np.array((first, np.cross(normal, first), normal), float)


def after_impact(body: Body, at: Approach, law: ContactLaw) -> tuple[Array, Array]:
    """Return the velocity [m/s] and the angular velocity [rad/s] after an impact, (3,) each."""
    turn = np.eye(3) if law.normal == NORMAL else frame_of(np.array(law.normal))
    v, w, axes = turn @ at.v, turn @ at.w, turn @ at.axes
    lever = np.array((0.0, 0.0, -body.radius)) if body.radius else turn @ at.lever
    u = v + np.cross(w, lever)
    if u[2] >= 0:
        return at.v, at.w
    e = law.restitution if -u[2] >= law.threshold else 0.0
    target = -e * u[2] + law.push * (at.laid if law.laid else at.depth)
    plain = law.torque and not law.slip_of_centre and law.cone == ROUND
    if plain and law.in_impact == INSTANT and law.friction > 0 and not body.radius:
        v, w = _at_each_instant(body, v, w, axes, lever, -target / u[2], law.friction)
        return turn.T @ v, turn.T @ w
    inverse = inverse_inertia(body, axes)
    response = np.eye(3) / body.mass - cross_matrix(lever) @ inverse @ cross_matrix(lever)
    friction_response = response[:2, :2] if law.torque else np.eye(2) / body.mass
    slip = v[:2] if law.slip_of_centre else u[:2]
    once = law.in_impact == AFTER or bool(body.radius)
    ways = np.array((1.0 if once else SWEEPS, law.torque, not law.slip_of_centre), float)
    f, g, press = impulse_of(response, friction_response, u, slip, target, law.friction, law.cone, ways)
    along = np.array((f, g, press))
    torque = np.cross(lever, (0.0, 0.0, press)) + (np.cross(lever, (f, g, 0.0)) if law.torque else 0.0)
    return turn.T @ (v + along / body.mass), turn.T @ (w + inverse @ torque)


def after_impacts(
    body: Body, at: Approach, law: ContactLaw, pull: Array, span: float
) -> tuple[Array, Array, int] | None:
    """Return v and w after the impacts of all corners within a time, and how many there are.

    Parameters
    ----------
    body : with corners
    at : at the first impact
    law : of each impact
    pull : gravity, plane's frame [m/s2], (3,)
    span : time from the first impact on [s]

    Returns
    -------
    v [m/s], w [rad/s], (3,) each, of the last flight, continued back to the first impact, and the number of impacts;
    None if there are too many to follow
    """
    took, v, w, axes, lever = 0.0, at.v, at.w, at.axes, at.lever
    for count in range(1, MOST_IMPACTS + 1):
        v, w = after_impact(body, replace(at, v=v, w=w, axes=axes, lever=lever), law)
        q = from_matrix(axes[None])[0]
        met = _next_touch(body, (q, v, w, -float(lever[2])), pull, span - took)
        if met is None:
            return v - took * pull, free_rotation(body.moments, q, w, np.array([-took]))[1][0], count
        turned, spins = free_rotation(body.moments, q, w, np.array([met]))
        took, v, w, axes = took + met, v + met * pull, spins[0], rotation_matrix(turned)[0]
        lever = lowest_of(body, axes)
    return None


def lowest_of(body: Body, axes: Array) -> Array:
    """Return the lever of the lowest point of a body [m], (3,); axes: the body's, (3, 3)."""
    lever: Array = lowest_point(body, from_matrix(axes[None]), UP)[0]
    return lever


def _next_touch(body: Body, state: tuple[Array, Array, Array, float], pull: Array, span: float) -> float | None:
    """Return when the lowest corner of a free body is below the plane [s], None if not within a time.

    state: q, v, w and the height of the centre.
    """
    q, v, w, height = state
    low, high = 0.0, span
    for _ in range(DIVIDED):
        times = np.linspace(low, high, LOOKS + 1)[1:]
        low_points = lowest(body, free_rotation(body.moments, q, w, times)[0], UP)
        below = np.flatnonzero(height + times * v[2] + times**2 / 2 * pull[2] + low_points < -BELOW * body.reach)
        if not len(below):
            return None
        high = float(times[below[0]])
        low = float(times[below[0] - 1]) if below[0] else low
    return high


def free_rotation(moments: Array, q: Array, w: Array, times: Array) -> tuple[Array, Array]:
    """Return attitudes, (n, 4), and angular velocities, (n, 3), of free rotation from one state."""
    a, b, c = moments.tolist()
    body = SolverBody(1.0, (a, b, c))
    spins = np.empty((len(times), 14))
    spins[:, 7:14] = *q, *(moments * (rotation_matrix(q).T @ w))
    coast(spins, times, body.inverse_moments, body.gyroscopic)
    return spins[:, 0:4], np.einsum("tij,tj->ti", rotation_matrix(spins[:, 0:4]), spins[:, 4:7] / moments)


def _at_each_instant(
    body: Body, v: Array, w: Array, axes: Array, lever: Array, restitution: float, friction: float
) -> tuple[Array, Array]:
    """Return v and w after an impact of one corner, with friction at each instant, by the solver's impact."""
    a, b, c = body.moments.tolist()
    corner = (axes.T @ lever)[None]
    plane = SolverPlane(np.zeros(3), np.array(NORMAL), restitution, friction, corner)
    flight = ContactFlight(SolverBody(body.mass, (a, b, c)), "events", None, plane)
    start = np.concatenate(((0.0, 0.0, -lever[2]), from_matrix(axes[None])[0], v, w))
    flight.write(start[None])
    flight.advance(1, 1e-12)
    after = flight.read()[0]
    return after[7:10], after[10:13]


@dataclass(frozen=True)
class Slide:
    """A motion along the plane at given times.

    x, v : place and velocity along it, (n, 2)
    turned : integral of the angular velocity [rad], (n, 3)
    """

    x: Array
    v: Array
    turned: Array


def slide(scene: Scene, pull: Array, v: Array, w: Array, law: ContactLaw, times: Array, steps: int = STEPS) -> Slide:
    """Return the motion of a sphere, or of a box on a face, along the plane, from times[0] on.

    Parameters
    ----------
    scene : its body and plane
    pull : gravity, plane's frame [m/s2], (3,)
    v, w : velocity [m/s] and angular velocity [rad/s] at the first time, (3,)
    law : the law
    times : increasing [s], (n,)
    steps : number of first-order steps

    Returns
    -------
    the motion, from the origin
    """
    body = scene.body
    normal = np.array(law.normal)
    press = max(0.0, float(-pull @ normal))
    down = pull - (pull @ normal) * normal
    radius = body.radius or 0.0
    turns = bool(radius and law.torque)
    spread = 1.0 + (body.mass * radius**2 / float(body.moments[0]) if turns else 0.0)
    gain = body.mass * radius / float(body.moments[0]) if turns else 0.0
    sees = 0.0 if law.slip_of_centre else radius
    dt = (float(times[-1]) - float(times[0])) / steps
    path = np.empty((steps + 1, 7))
    path[0] = 0.0, 0.0, v[0], v[1], *w
    spin, stops = (sees, spread, gain), (law.asleep, law.viscous)
    slide_along(path, dt, (float(down[0]), float(down[1])), law.friction * press, law.cone, spin, stops)
    at = (times - times[0]) / dt
    low = np.minimum(at.astype(int), steps - 1)
    share = (at - low)[:, None]
    inside = share * dt
    between = path[low] + share * (path[low + 1] - path[low])
    turned = np.zeros((steps + 1, 3))
    turned[1:] = np.cumsum((path[1:, 4:7] + path[:-1, 4:7]) * (dt / 2), axis=0)
    rotated = turned[low] + inside * (path[low, 4:7] + between[:, 4:7]) / 2
    # Places by their velocities, so that a parabola stays one between steps.
    change = (path[low + 1, 2:4] - path[low, 2:4]) / dt
    x = path[low, 0:2] + inside * path[low, 2:4] + inside**2 / 2 * change
    return Slide(x, between[:, 2:4], rotated)
