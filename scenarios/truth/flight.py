"""A whole free flight: parabola, closed-form rotation, and the blows between; at any precision.

Where the body is and how fast it goes stays rational to the end, so it is exact.  Only the attitude, and the spin after
a blow on a turned body, are rounded to the working precision.
"""

from collections import deque
from collections.abc import Callable
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np

from scenarios.impulse import RayMissed
from scenarios.ray import first_hit
from scenarios.scene import Impulse, Scene
from scenarios.truth.rotation import Numbers, free_rotation

Read = Callable[[float], Fraction]


class Blow(NamedTuple):
    """An impulse in exact numbers: time [s], value [N s], (3,), and where it lands, as in `scenarios.scene.Impulse`.

    ray: origin and direction, (2, 3); the direction counts as it is, unit or not.
    """

    time: Fraction
    value: Numbers
    point_world: Numbers | None
    point_body: Numbers | None
    ray: Numbers | None


class Throw(NamedTuple):
    """One row of a scene in exact numbers, in the scene's units: all that its flight depends on.

    x, v, w_world, moments, gravity: (3,); axes: body to world, (3, 3); points: (n, 3); faces: (m, 3).
    """

    x: Numbers
    axes: Numbers
    v: Numbers
    w_world: Numbers
    mass: Fraction
    moments: Numbers
    points: Numbers
    faces: np.ndarray
    gravity: Numbers
    times: tuple[Fraction, ...]
    blows: tuple[Blow, ...]


class Pose(NamedTuple):
    """The body at one instant: x [m] and v [m/s], exact, (3,); axes, body to world, (3, 3); w [rad/s], world, (3,)."""

    x: Numbers
    axes: Numbers
    v: Numbers
    w_world: Numbers


def read_throw(scene: Scene, row: int, read: Read = Fraction) -> Throw:
    """Return one throw of the scene.

    read: what to take each number of the scene for.  All instants are told by one clock, which is read once, so that
    what was simultaneous stays so; likewise equal moments are one number, so that a cube stays a cube.
    """
    body, start = scene.body, scene.start[row]
    clock = read(1.0)
    moment = {float(value): read(float(value)) for value in body.moments}
    return Throw(
        x=exact_numbers(start[0:3], read),
        axes=exact_axes(exact_numbers(start[3:7], read)),
        v=exact_numbers(start[7:10], read),
        w_world=exact_numbers(start[10:13], read),
        mass=read(float(body.mass)),
        moments=np.array([moment[float(value)] for value in body.moments]),
        points=exact_numbers(body.points, read),
        faces=body.faces,
        gravity=exact_numbers(np.zeros(3) if scene.gravity is None else scene.gravity, read),
        times=tuple(clock * Fraction(float(time)) for time in scene.rows),
        blows=tuple(_blow(impulse, clock, read) for impulse in scene.impulses),
    )


def _blow(impulse: Impulse, clock: Fraction, read: Read) -> Blow:
    world, body, ray = impulse.point_world, impulse.point_body, impulse.ray
    return Blow(
        time=clock * Fraction(float(impulse.time)),
        value=exact_numbers(impulse.value, read),
        point_world=None if world is None else exact_numbers(world, read),
        point_body=None if body is None else exact_numbers(body, read),
        ray=None if ray is None else exact_numbers(np.stack((ray.origin, ray.direction)), read),
    )


def exact_numbers(values: np.ndarray, read: Read = Fraction) -> Numbers:
    """Return an array of the same shape of what each number is taken for."""
    return np.array([read(float(value)) for value in values.flat], dtype=object).reshape(values.shape)


def exact_axes(q: Numbers) -> Numbers:
    """Return the rotation matrix of a quaternion of any length, rational if the quaternion is.

    q: w x y z, body to world, (4,).  Returns (3, 3).  Source: Shoemake (1985), divided by |q|^2.
    """
    w, x, y, z = q
    rows = (
        (w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z),
    )
    return np.array(rows) / (q @ q)


def fly(mp: Any, throw: Throw) -> list[Pose]:
    """Return the pose at each of the throw's instants, blows of that instant included.

    mp: mpmath context at the wanted precision.  Raises RayMissed.
    """
    arc = Arc(throw.x, throw.v, throw.gravity, Fraction(0))
    rotation = free_rotation(mp, throw.moments, throw.axes, throw.moments * (throw.axes.T @ throw.w_world))
    turned = Fraction(0)
    blows = deque(throw.blows)
    poses = []
    for time in throw.times:
        while blows and blows[0].time <= time:
            blow = blows.popleft()
            x, v = arc.at(blow.time)
            arc = Arc(x, v + blow.value / throw.mass, throw.gravity, blow.time)
            axes, L_body = rotation.at(blow.time - turned)
            torque = np.cross(lever(blow, x, axes, throw), blow.value)
            # A central blow leaves the rotation on its exact curve: to start it anew would round it.
            if torque.any():
                rotation = free_rotation(mp, throw.moments, axes, L_body + axes.T @ torque)
                turned = blow.time
        x, v = arc.at(time)
        axes, L_body = rotation.at(time - turned)
        poses.append(Pose(x, axes, v, axes @ (L_body / throw.moments)))
    return poses


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


def lever(blow: Blow, x: Numbers, axes: Numbers, throw: Throw) -> Numbers:
    """Return where a blow lands, from the centre of mass, world axes [m], (3,).  Raises RayMissed."""
    if blow.point_world is not None:
        return blow.point_world - x
    if blow.point_body is not None:
        return axes @ blow.point_body
    assert blow.ray is not None
    # Seen from the body the surface stands still.
    origin, direction = (blow.ray - (x, np.zeros(3, dtype=int))) @ axes
    points = throw.points.astype(float)
    hit = first_hit(origin.astype(float), direction.astype(float), points, throw.faces)
    if hit is None or hit.from_inside:
        what = "misses the body" if hit is None else "starts inside the body"
        raise RayMissed(f"the ray of the impulse at {float(blow.time):g} s {what}")
    # Doubles have said which face; where it is met is worked out again.
    corner, second, third = throw.points[throw.faces[hit.face]]
    normal = np.cross(second - corner, third - corner)
    reach = normal @ (corner - origin) / (normal @ direction)
    return axes @ (origin + reach * direction)
