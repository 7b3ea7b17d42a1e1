"""One throw in exact numbers: what the scene file says, and what follows from it, in fractions.

The body is told along the axes of its file.  Where a Scene has something else than its file said (another start, a
changed impulse), or never came from a file, its doubles are what is written.
"""

from collections.abc import Callable
from math import ulp
from random import Random
from typing import NamedTuple

import numpy as np

from tumble.scenarios.scene import Impulse, Scene, Sensor, Tether, Written, WrittenImpulse
from tumble.scenarios.truth.inertia import Numbers, Solid, box, disc, identity, mesh, sphere, square_root
from tumble.scenarios.truth.rational import Fraction

Read = Callable[[float], Fraction]


class ExactImpulse(NamedTuple):
    """An impulse: time [s], value [N s], (3,), and where it lands, as in `tumble.scenarios.scene.Impulse`, file axes.

    ray: origin and direction, (2, 3); the direction counts as it is, unit or not.
    """

    time: Fraction
    value: Numbers
    point_world: Numbers | None
    point_body: Numbers | None
    ray: Numbers | None


class Spring(NamedTuple):
    """A tether: point (3,), body, and anchor (3,), world [m], stiffness, damping and rest length, (3,), SI."""

    point: Numbers
    anchor: Numbers
    strength: Numbers


class Ground(NamedTuple):
    """A floor: unit normal, (3,), and height [m], stiffness, damping, (3,), SI."""

    normal: Numbers
    strength: Numbers


class Mount(NamedTuple):
    """A sensor: point [m], (3,); its axes along the file's, (3, 3); the field that it reads, world, (3,), 0 if none."""

    point: Numbers
    axes: Numbers
    field: Numbers


class Throw(NamedTuple):
    """One row of a scene in the scene's units: all that its flight depends on.

    x, v, w_world, gravity: (3,); axes: the file's to world, (3, 3); solid: tensor, file axes; points: from the centre
    of mass, file axes, (n, 3); faces: (m, 3); radius: of a sphere [m], else None; disc: its radius and thickness,
    or None [m]; state_axes: from the file's axes to those of a state, (3, 3); drag: linear, angular, (2,), or None.
    """

    x: Numbers
    axes: Numbers
    v: Numbers
    w_world: Numbers
    solid: Solid
    points: Numbers
    faces: np.ndarray
    radius: Fraction | None
    disc: tuple[Fraction, Fraction] | None
    state_axes: Numbers
    gravity: Numbers
    times: tuple[Fraction, ...]
    impulses: tuple[ExactImpulse, ...]
    springs: tuple[Spring, ...]
    drag: Numbers | None
    ground: Ground | None


def read_throw(scene: Scene, row: int, read: Read = Fraction) -> Throw:
    """Return one throw of the scene.

    read: what to take each number that is written for.  All instants are told by one clock, which is read once, so that
    what was simultaneous stays so.
    """
    start, clock = scene.start[row], read(1.0)
    solid, points, state_axes = _read_body(scene, read)
    return Throw(
        x=exact_numbers(start[0:3], read),
        axes=_read_axes(scene, start, state_axes, read),
        v=exact_numbers(start[7:10], read),
        w_world=exact_numbers(start[10:13], read),
        solid=solid,
        points=points,
        faces=scene.body.faces,
        radius=None if scene.body.radius is None else max(abs(number) for number in points.flat),
        disc=None if scene.body.disc is None else (max(points[:, 0]), 2 * max(points[:, 2])),
        state_axes=state_axes,
        gravity=exact_numbers(np.zeros(3) if scene.gravity is None else scene.gravity, read),
        times=tuple(clock * Fraction(float(time)) for time in scene.rows),
        impulses=tuple(_exact_impulse(scene, impulse, clock, points, state_axes, read) for impulse in scene.impulses),
        springs=tuple(_spring(scene, tether, points, state_axes, read) for tether in scene.tethers),
        drag=exact_numbers(np.array((scene.drag.linear, scene.drag.angular)), read) if scene.drag else None,
        ground=_ground(scene, read),
    )


def read_mount(scene: Scene, sensor: Sensor, throw: Throw, read: Read = Fraction) -> Mount:
    """Return where a sensor is on the body; what differs from the file's sensor of that name is taken as it is."""
    written, turn = _written(scene), throw.state_axes.T
    found = [one for one in written.sensors if one.made.name == sensor.name] if written else []
    same = {
        name: one
        for one in found
        for name in ("point_body", "orientation", "field")
        if np.array_equal(getattr(one.made, name), getattr(sensor, name))
    }
    point = (
        exact_numbers(same["point_body"].point, read)
        if "point_body" in same
        else turn @ exact_numbers(sensor.point_body, read)
    )
    axes = (
        exact_axes(exact_numbers(same["orientation"].orientation, read))
        if "orientation" in same
        else turn @ exact_axes(exact_numbers(sensor.orientation, read))
    )
    field = same["field"].field if "field" in same else sensor.field
    aim = 0 * point if field is None else _unit(exact_numbers(field, read))
    return Mount(point, axes, aim)


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


def changing(random: Random, share: float = 1.0) -> Read:
    """Return a reading of numbers that moves each, up or down as the signs fall, by that share of half its last bit.

    Half the last bit is what reading a decimal into a double may cost.  A zero stays one.
    """

    def changed(value: float) -> Fraction:
        sign = 2 * random.getrandbits(1) - 1
        return Fraction(value) + sign * Fraction(share * ulp(value) / 2) if value else Fraction(0)

    return changed


def _read_body(scene: Scene, read: Read) -> tuple[Solid, Numbers, Numbers]:
    """Return the solid, its points from the centre of mass, (n, 3), and the state's axes, (3, 3)."""
    body, written = scene.body, _written(scene)
    if written is None:
        # Equal moments are one number, so that a cube stays a cube.
        moment = {float(value): read(float(value)) for value in body.moments}
        tensor = identity() * [moment[float(value)] for value in body.moments]
        mass = read(float(body.mass))
        return Solid(mass, 0 * tensor[0], tensor), exact_numbers(body.points, read), identity()
    mass, state_axes = read(float(body.mass)), exact_axes(exact_numbers(body.file_axes))
    if body.radius is not None:
        radius = read(float(body.radius))
        ends = np.array([[int(np.sign(number)) for number in point] for point in body.points], dtype=object)
        return sphere(mass, radius), ends * radius, state_axes
    if body.disc is not None:
        radius, thickness = read(float(body.disc.radius)), read(float(body.disc.thickness))
        rims = _rims(radius, thickness, len(body.points) // 8)
        return disc(mass, radius, thickness), rims, state_axes
    if written.points is None:
        assert body.size is not None
        size = exact_numbers(body.size, read)
        corners = np.array([[int(np.sign(number)) for number in point] for point in body.points], dtype=object)
        return box(mass, size), corners * (size / 2), state_axes
    points = exact_numbers(written.points, read)
    if written.inertia is None:
        solid = mesh(mass, points, body.faces)
        return solid, points - solid.centre, state_axes
    tensor = exact_numbers(written.inertia, read)
    return Solid(mass, 0 * tensor[0], (tensor + tensor.T) / 2), points, state_axes


def _rims(radius: Fraction, thickness: Fraction, count: int) -> Numbers:
    """Return the points of a disc, (n, 3): its middle, and every eighth of a turn on each of its rims."""
    zero, half = Fraction(0), square_root(Fraction(1, 2))
    quarter = ((Fraction(1), zero), (half, half), (zero, Fraction(1)), (-half, half))
    circle = np.array([*quarter, *((-x, -y) for x, y in quarter)], dtype=object) * radius
    heights = (zero,) if count == 1 else (-thickness / 2, thickness / 2)
    return np.array([(zero, zero, zero), *((x, y, z) for z in heights for x, y in circle)], dtype=object)


def _written(scene: Scene) -> Written | None:
    """Return what the file says, where the body is still the one that it speaks of."""
    if scene.written is None:
        return None
    body, made = scene.body, scene.written.body
    arrays = ((body.moments, made.moments), (body.points, made.points), (body.file_axes, made.file_axes))
    same = body is made or (body.mass == made.mass and all(np.array_equal(*pair) for pair in arrays))
    return scene.written if same else None


def _read_axes(scene: Scene, start: np.ndarray, state_axes: Numbers, read: Read) -> Numbers:
    """Return how the file's axes stand at the start, (3, 3)."""
    written = _written(scene)
    if written is not None and np.array_equal(start, written.start):
        return exact_axes(exact_numbers(written.orientation, read))
    return exact_axes(exact_numbers(start[3:7], read)) @ state_axes


def _exact_impulse(
    scene: Scene, impulse: Impulse, clock: Fraction, points: Numbers, state_axes: Numbers, read: Read
) -> ExactImpulse:
    made = _as_written(scene, impulse, "value")
    if made and made.magnitude is not None and made.direction is not None:
        value = read(made.magnitude) * _unit(exact_numbers(made.direction, read))
    else:
        value = exact_numbers(impulse.value, read)
    ray, aimed = impulse.ray, _as_written(scene, impulse, "ray")
    if ray is not None:
        aim = ray.direction if aimed is None or aimed.ray_direction is None else aimed.ray_direction
        ray = exact_numbers(np.stack((ray.origin, aim)), read)
    point_body, landed = None, _as_written(scene, impulse, "point_body")
    if landed and landed.point_body is not None:
        point_body = exact_numbers(landed.point_body, read)
    elif impulse.point_body is not None:
        point_body = _body_point(scene, impulse.point_body, points, state_axes, read)
    world = impulse.point_world
    return ExactImpulse(
        time=clock * Fraction(float(impulse.time)),
        value=value,
        point_world=None if world is None else exact_numbers(world, read),
        point_body=point_body,
        ray=ray,
    )


def _as_written(scene: Scene, impulse: Impulse, what: str) -> WrittenImpulse | None:
    """Return the file's impulse whose value, ray or point in body axes this one still has, or None."""
    written = _written(scene)
    for candidate in () if written is None else written.impulses:
        ours, theirs = getattr(impulse, what), getattr(candidate.made, what)
        if what == "ray" and ours is not None and theirs is not None:
            ours, theirs = ours.direction, theirs.direction
        same_time = candidate.made.time == impulse.time
        if same_time and ours is not None and theirs is not None and np.array_equal(ours, theirs):
            return candidate
    return None


def _body_point(scene: Scene, point: np.ndarray, points: Numbers, state_axes: Numbers, read: Read) -> Numbers:
    """Return a point of the body, (3,), file axes: the vertex that stands there, or else its own numbers."""
    vertices = np.flatnonzero((scene.body.points == point).all(axis=1))
    return points[vertices[0]] if len(vertices) else state_axes.T @ exact_numbers(point, read)


def _unit(vector: Numbers) -> Numbers:
    return vector / square_root(vector[0] ** 2 + vector[1] ** 2 + vector[2] ** 2)


def _spring(scene: Scene, tether: Tether, points: Numbers, state_axes: Numbers, read: Read) -> Spring:
    strength = np.array((tether.stiffness, tether.damping, tether.rest_length))
    point = _body_point(scene, tether.point_body, points, state_axes, read)
    return Spring(point, exact_numbers(tether.anchor, read), exact_numbers(strength, read))


def _ground(scene: Scene, read: Read) -> Ground | None:
    floor, written = scene.floor, scene.written
    if floor is None:
        return None
    as_read = written is not None and written.normal is not None and np.array_equal(floor.normal, written.normal)
    normal = written.file_normal if written is not None and as_read else floor.normal
    assert normal is not None
    strength = np.array((floor.height, floor.stiffness, floor.damping))
    return Ground(_unit(exact_numbers(normal, read)), exact_numbers(strength, read))
