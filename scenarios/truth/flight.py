"""A whole free flight: parabola, closed-form rotation, and the blows between; at any precision.

Where the body is and how fast it goes stays rational to the end, so it is exact.  Only the attitude, and the spin after
a blow on a turned body, are rounded to the working precision.
"""

from collections import deque
from typing import Any, NamedTuple

import numpy as np

from tumble.scenarios.impulse import RayMissed
from tumble.scenarios.ray import first_hit
from tumble.scenarios.truth.deadline import current
from tumble.scenarios.truth.inertia import Numbers, Principal, inverse, root_of
from tumble.scenarios.truth.rational import Fraction, cross
from tumble.scenarios.truth.rotation import Rotation, SteadySpin, free_rotation
from tumble.scenarios.truth.throw import ExactImpulse, Throw


class Pose(NamedTuple):
    """The body at one instant: x [m] and v [m/s], exact, (3,); axes, the file's to world, (3, 3); w [rad/s], world."""

    x: Numbers
    axes: Numbers
    v: Numbers
    w_world: Numbers


def poses(mp: Any, throw: Throw, own: Principal) -> list[Pose]:
    """Return the pose at each of the throw's instants, blows of that instant included.

    mp: mpmath context at the wanted precision; own: principal moments and axes, to that precision.  Raises RayMissed.
    """
    following = deque(stretches(mp, throw, own))
    now, poses, inertia = following.popleft(), [], inverse(throw.solid.tensor)
    for time in throw.times:
        current().check()
        while following and following[0].arc.since <= time:
            now = following.popleft()
        x, v = now.arc.at(time)
        axes, L_body = now.rotation.at(time - now.turned)
        poses.append(Pose(x, axes, v, axes @ (inertia @ L_body)))
    return poses


class Stretch(NamedTuple):
    """A flight from the start or a blow on: parabola, and rotation since an instant `turned` [s], maybe earlier."""

    arc: "Arc"
    rotation: Rotation
    turned: Fraction


def stretches(mp: Any, throw: Throw, own: Principal) -> list[Stretch]:
    """Return the flights from the start and from each blow until the last instant on, as `poses` puts them together."""
    turning = Turning(mp, throw.solid.tensor, own)
    arc = Arc(throw.x, throw.v, throw.gravity, Fraction(0))
    rotation = turning.start(throw.axes, throw.solid.tensor @ (throw.axes.T @ throw.w_world))
    found = [Stretch(arc, rotation, Fraction(0))]
    for impulse in throw.impulses:
        if impulse.time > throw.times[-1]:
            break
        current().check()
        arc, rotation, turned = found[-1]
        x, v = arc.at(impulse.time)
        arc = Arc(x, v + impulse.value / throw.solid.mass, throw.gravity, impulse.time)
        axes, L_body = rotation.at(impulse.time - turned)
        torque = cross(lever(impulse, x, axes, throw), impulse.value)
        # A central blow leaves the rotation on its exact curve: to start it anew would round it.
        if torque.any():
            rotation, turned = turning.start(axes, L_body + axes.T @ torque), impulse.time
        found.append(Stretch(arc, rotation, turned))
    return found


class Turning:
    """The free rotations of a body whose tensor, (3, 3), is given along the file's axes."""

    def __init__(self, mp: Any, tensor: Numbers, own: Principal) -> None:
        self._mp, self._principal, self.inverse = mp, own, inverse(tensor)

    def start(self, axes: Numbers, L_body: Numbers) -> Rotation:
        """Return the rotation from the file's axes, (3, 3), and the angular momentum along them [kg m2/s], (3,)."""
        moments, turn = self._principal
        w_body = self.inverse @ L_body
        # Asked along the file's axes, where L is a fraction still.
        if not cross(L_body, w_body).any():
            return SteadySpin(self._mp, axes, L_body, w_body)
        own = free_rotation(self._mp, moments, axes @ turn, turn.T @ L_body)
        return own if isinstance(turn[0, 0], Fraction) else Turned(own, turn.T)


class Turned(NamedTuple):
    """A rotation told along other axes of the body; turn: from those of the rotation told of, (3, 3)."""

    rotation: Rotation
    turn: Numbers

    def at(self, t: Fraction) -> tuple[Numbers, Numbers]:
        """Return (axes, L_body [kg m2/s]) at t [s] after the start, (3, 3) and (3,)."""
        axes, L_body = self.rotation.at(t)
        return axes @ self.turn, L_body @ self.turn


class Arc(NamedTuple):
    """A parabola from x [m] with v [m/s] at an instant [s], under gravity [m/s2]."""

    x: Numbers
    v: Numbers
    gravity: Numbers
    since: Fraction

    def at(self, time: Fraction) -> tuple[Numbers, Numbers]:
        """Return (x [m], v [m/s])."""
        t = time - self.since
        return self.x + self.v * t + self.gravity * (t * t / 2), self.v + self.gravity * t


def quaternion(mp: Any, axes: Numbers) -> Numbers:
    """Return the unit quaternion w x y z, (4,), of a rotation matrix, (3, 3).

    Source: Shepperd, "Quaternion from rotation matrix", J. Guidance and Control 1 (1978) 223.
    """
    trace = axes.trace()
    # Four times the products of the quaternion's numbers by one another; the row of the largest is the safest.
    products = np.empty((4, 4), dtype=object)
    products[0, 0] = 1 + trace
    products[0, 1:] = products[1:, 0] = axes[2, 1] - axes[1, 2], axes[0, 2] - axes[2, 0], axes[1, 0] - axes[0, 1]
    products[1:, 1:] = axes + axes.T
    products[np.arange(1, 4), np.arange(1, 4)] += 1 - trace
    largest = products[products.diagonal().argmax()]
    return largest / mp.sqrt(largest @ largest)


def lever(impulse: ExactImpulse, x: Numbers, axes: Numbers, throw: Throw) -> Numbers:
    """Return where a blow lands, from the centre of mass, world axes [m], (3,).  Raises RayMissed."""
    if impulse.point_world is not None:
        return impulse.point_world - x
    if impulse.point_body is not None:
        return axes @ impulse.point_body
    assert impulse.ray is not None
    # Seen from the body the surface stands still.
    origin, direction = (impulse.ray - (x, np.zeros(3, dtype=int))) @ axes
    if throw.radius is not None:
        return axes @ _on_sphere(origin, direction, throw.radius, impulse.time)
    if throw.disc is not None:
        return axes @ _on_disc(origin, direction, throw.disc, impulse.time)
    points = throw.points.astype(float)
    hit = first_hit(origin.astype(float), direction.astype(float), points, throw.faces)
    if hit is None or hit.from_inside:
        raise _missed(hit is None, impulse.time)
    # Doubles have said which face; where it is met is worked out again.
    corner, second, third = throw.points[throw.faces[hit.face]]
    normal = cross(second - corner, third - corner)
    reach = normal @ (corner - origin) / (normal @ direction)
    return axes @ (origin + reach * direction)


def _on_sphere(origin: Numbers, direction: Numbers, radius: Fraction, time: Any) -> Numbers:
    """Return where a ray meets a sphere about 0 from outside, (3,): the lesser root of |o + s d| = r."""
    square, along = direction @ direction, origin @ direction
    rest = along * along - square * (origin @ origin - radius * radius)
    if rest < 0 or (along > 0 and origin @ origin > radius * radius):
        raise _missed(True, time)
    if origin @ origin < radius * radius:
        raise _missed(False, time)
    return origin - direction * ((along + root_of(rest)) / square)


def _on_disc(origin: Numbers, direction: Numbers, disc: tuple[Fraction, Fraction], time: Any) -> Numbers:
    """Return where a ray meets a disc about the z axis from outside, (3,): where it is in both cylinder and slab."""
    radius, half = disc[0], disc[1] / 2
    square, along = direction[:2] @ direction[:2], origin[:2] @ direction[:2]
    rest = radius * radius - origin[:2] @ origin[:2]
    # Where it enters and leaves what bounds it, in units of the direction.
    inside = []
    if square:
        root = along * along + square * rest
        if root < 0:
            raise _missed(True, time)
        inside.append(((-along - root_of(root)) / square, (-along + root_of(root)) / square))
    if direction[2]:
        inside.append(sorted((z - origin[2]) / direction[2] for z in (-half, half)))
    outside = (not square and rest < 0) or (not direction[2] and abs(origin[2]) > half)
    begins, ends = max(first for first, _ in inside), min(last for _, last in inside)
    if outside or begins > ends or ends < 0:
        raise _missed(True, time)
    if begins < 0:
        raise _missed(False, time)
    return origin + direction * begins


def _missed(is_beside: bool, time: Any) -> RayMissed:
    what = "misses the body" if is_beside else "starts inside the body"
    return RayMissed(f"the ray of the impulse at {float(time):g} s {what}")
