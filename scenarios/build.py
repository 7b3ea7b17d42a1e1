"""From the tables of a scene file to a Scene: what their types cannot say is checked here."""

import logging
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from tumble.scenarios import mass
from tumble.scenarios.format import (
    MOST_SAMPLES,
    BodyTable,
    BoxTable,
    DiscTable,
    EnsembleTable,
    File,
    ImpulseTable,
    Keys,
    MeshTable,
    RayTable,
    Refused,
    RigidTable,
    SensorTable,
    SphereTable,
)
from tumble.scenarios.frames import Array, quaternion_product, rotation_matrix, vertices
from tumble.scenarios.impulse import RayMissed, jump
from tumble.scenarios.lowest import lowest
from tumble.scenarios.scene import (
    Body,
    Disc,
    Drag,
    Ensemble,
    Floor,
    Impulse,
    Plane,
    Ray,
    Scene,
    Sensor,
    Tether,
    Written,
    WrittenImpulse,
    WrittenSensor,
    frozen_array,
)
from tumble.scenarios.surface import read_surface

log = logging.getLogger(__name__)

MOST_STEPS = 1e9
ROUNDING = 1e-12  # relative: how far a tensor may be from symmetric, or from A + B >= C
CONVEX = 1e-6  # relative: how much volume single precision takes from a convex mesh, and more
UNIT = 4 * sys.float_info.epsilon  # how far the square of a unit vector of rounded numbers may be from 1
SMALLEST = sys.float_info.min  # below which a float has not all its digits
# Of the body's size and distances: how far a body that touches a plane may be from it as its numbers are rounded.
TOUCHING = 2.0**-46
LANDINGS = ("point", "vertex", "point_body", "ray")
BLOW_SPREADS = ("magnitude", "cone", "point")


def scene_from(file: File, path: Path, to_run: bool, in_parts: bool = False) -> Scene:
    """Return the scene, one of very many throws with its ensemble if it will be run in parts.

    Raises Refused for what the types alone could not see.
    """
    if file.step is None and to_run:
        raise Refused(("step",), "missing; must be a number > 0", False)
    step = file.duration if file.step is None else file.step
    if not file.title.isprintable():
        raise Refused(("title",), "must be one line of printable text")
    if file.duration / step > MOST_STEPS:
        raise Refused(("step",), f"must be at least the duration / {MOST_STEPS:.0e}")
    body, file_points = _body(file.body, path.parent)
    start = _start(file.body, body)
    impulses = [_impulse(table, ("impulse", i), file.duration, body, start) for i, table in enumerate(file.impulse)]
    sensors = tuple(_sensor(table, ("sensor", i), file, body) for i, table in enumerate(file.sensor))
    pulls: dict[str, Any] = {part: law(file, body) for part, law in PULLS.items()}
    written = Written(
        body=body,
        inertia=frozen_array(file.body.inertia) if isinstance(file.body, RigidTable) else None,
        points=file_points,
        start=start[0],
        orientation=frozen_array(file.body.orientation),
        impulses=tuple(map(_written_impulse, impulses, file.impulse)),
        normal=pulls["floor"].normal if pulls["floor"] else None,
        file_normal=None if file.floor is None else frozen_array(file.floor.normal),
        plane_normal=pulls["plane"].normal if pulls["plane"] else None,
        file_plane_normal=None if file.plane is None else frozen_array(file.plane.normal),
        sensors=tuple(map(_written_sensor, sensors, file.sensor)),
    )
    times = _times(file, to_run)
    ensemble = None
    if file.ensemble:
        start, ensemble = _throws(file.ensemble, start, impulses, body, len(times) + 1)
        impulses = [impulse for impulse in impulses if impulse.time > 0]
        if ensemble and not in_parts:
            start, ensemble = _whole(ensemble, body), None
    if pulls["plane"]:
        _refuse_below(pulls["plane"], body, start)
        if to_run and body.shape == "mesh" and not _is_convex(body):
            log.info(f"{path.stem}: the mesh is not convex; what touches the plane is its convex hull")
    return Scene(
        name=path.stem,
        title=file.title,
        source=file.source,
        duration=file.duration,
        times=times,
        step=step,
        body=body,
        start=start,
        written=written,
        impulses=tuple(sorted((impulse for impulse in impulses if impulse.value.any()), key=lambda it: it.time)),
        sensors=sensors,
        ensemble=ensemble,
        **pulls,
    )


def _times(file: File, to_run: bool) -> Array:
    """Return the sample instants [s], (S,): the end alone where nothing is flown and none are given."""
    if file.times is not None and file.samples is not None:
        raise Refused(("samples",), "must be left out where times are given")
    if file.times is not None:
        times, keys = np.array(file.times), ("times",)
    elif file.samples is not None:
        times, keys = np.linspace(0, file.duration, file.samples + 1)[1:], ("samples",)
    elif not to_run:
        times, keys = np.array([file.duration]), ("duration",)
    else:
        raise Refused(("times",), "missing; must be a list of instants, or samples a number of them", False)
    if not (np.diff(times) > 0).all():
        raise Refused(keys, "must be strictly increasing instants")
    if times[0] < 0 or times[-1] > file.duration:
        raise Refused(keys, f"must be within the duration, 0 to {file.duration!r}")
    return frozen_array(times)


def _body(
    table: BoxTable | DiscTable | MeshTable | RigidTable | SphereTable, folder: Path
) -> tuple[Body, Array | None]:
    """Return the body in its principal axes, and its points as a mesh's or a rigid body's file has them, (n, 3)."""
    size, radius, disc, file_points, where = None, None, None, None, ("body",)
    if isinstance(table, BoxTable):
        size = frozen_array(table.size)
        points, faces, tensor = mass.box_corners(size), mass.BOX_FACES, mass.box(table.mass, size).tensor
    elif isinstance(table, SphereTable):
        radius, faces = table.radius, np.empty((0, 3), dtype=int)
        points, tensor = mass.sphere_points(radius), mass.sphere(table.mass, radius).tensor
    elif isinstance(table, DiscTable):
        disc, faces = Disc(table.radius, table.thickness), np.empty((0, 3), dtype=int)
        points = mass.disc_points(table.radius, table.thickness)
        tensor = mass.disc(table.mass, table.radius, table.thickness).tensor
    elif isinstance(table, MeshTable):
        file_points, points, faces, tensor = _solid(table, folder)
    else:
        points, faces, tensor = np.array(table.points), np.empty((0, 3), dtype=int), np.array(table.inertia)
        file_points, where = frozen_array(points), ("body", "inertia")
    moments, file_axes = _principal(tensor, where)
    points = frozen_array(points @ rotation_matrix(file_axes).T)
    shape = str(table.__struct_config__.tag)
    faces = frozen_array(faces, int)
    return Body(shape, table.mass, moments, points, faces, size, file_axes, radius, disc), file_points


def _principal(tensor: Array, where: Keys) -> tuple[Array, Array]:
    """Return moments and axes, as mass.principal_axes does, of a tensor that some body could have."""
    if not np.isfinite(tensor).all():
        raise Refused(where, "must have finite moments of inertia")
    if (np.abs(tensor - tensor.T) > ROUNDING * np.abs(tensor).max()).any():
        raise Refused(where, "must be symmetric")
    moments, file_axes = mass.principal_axes(tensor / 2 + tensor.T / 2)
    a, b, c = sorted(moments)
    if a < SMALLEST:
        raise Refused(where, f"must have principal moments of inertia > 0, but one is {a:.3g}")
    if a + b < c * (1 - ROUNDING):
        raise Refused(where, f"inertia that no body has: A + B >= C must hold, but {a:.6g} + {b:.6g} < {c:.6g}")
    return moments, file_axes


def _solid(table: MeshTable, folder: Path) -> tuple[Array, Array, np.ndarray, Array]:
    """Return a mesh's points [m], (n, 3), as in the file and from its centre of mass, its outward faces, (m, 3), and

    its tensor [kg m2], (3, 3).
    """
    try:
        points, faces = read_surface(folder / table.file)
        solid = mass.mesh(table.mass, points, faces)
    except ValueError as error:
        raise Refused(("body", "file"), str(error)) from None
    outward = faces if solid.volume > 0 else faces[:, ::-1]
    return frozen_array(points), points - solid.centre, outward, solid.tensor


def _is_convex(body: Body) -> bool:
    """Whether a mesh encloses the volume of its convex hull."""
    from scipy.spatial import ConvexHull  # slow to load

    a, b, c = body.points[body.faces].transpose(1, 0, 2)
    volume = np.einsum("ij,ij->", a, np.cross(b, c)) / 6
    return bool(ConvexHull(body.points).volume <= volume * (1 + CONVEX))


def _start(table: BodyTable, body: Body) -> Array:
    """Return the state before any impulse, (1, 13)."""
    # The file says how its own axes stand; the state, how the principal axes do.
    to_file_axes = body.file_axes * (1, -1, -1, -1)
    q = quaternion_product(_unit(table.orientation, ("body", "orientation")), to_file_axes)
    start = frozen_array([[*table.position, *q, *table.velocity, *table.angular_velocity]])
    if not np.isfinite(vertices(start, body.points)).all():
        raise Refused(("body",), "must have vertices at finite coordinates")
    return start


def _throws(
    table: EnsembleTable, start: Array, impulses: list[Impulse], body: Body, rows: int
) -> tuple[Array, Ensemble | None]:
    """Return the states after the impulses of t = 0, (N, 13), of all throws, or of throw 0 of too many, which follow.

    rows: instants of a trajectory.
    """
    for key in BLOW_SPREADS:
        if getattr(table, key) and any(impulse.time > 0 for impulse in impulses):
            raise Refused(("ensemble", key), "must be 0 where an impulse comes after t = 0: only those at 0 are spread")
        if getattr(table, key) and not impulses:
            raise Refused(("ensemble", key), "must be 0 where there is no impulse to spread")
    if table.member is not None and table.member >= table.throws:
        raise Refused(("ensemble", "member"), f"must be below throws, {table.throws}")
    # Only many throws pay for random numbers.
    from tumble.scenarios.ensemble import BLOCK, OutOfReach, is_large, starts, throws

    first = tuple(impulse for impulse in impulses if impulse.time == 0 and impulse.value.any())
    spreads = (table.magnitude, table.cone, table.point, table.orientation)
    large = Ensemble(table.throws, start, first, table.seed, *spreads) if is_large(table.throws, rows, body) else None
    number = table.member or 0
    try:
        # Of too many, those that are looked at now.
        begin = number // BLOCK * BLOCK if large else 0
        drawn = (
            starts(large, body, begin, min(begin + BLOCK, table.throws))
            if large
            else throws(start, first, body, table.throws, table.seed, *spreads)
        )
    except RayMissed as missed:
        raise Refused(("ensemble", "orientation"), f"must let every ray meet the body: {missed}") from None
    except OutOfReach as missed:
        raise Refused(("ensemble", "point"), f"must reach the body's surface: {missed}") from None
    if not np.isfinite(vertices(drawn, body.points)).all() or not np.isfinite(drawn).all():
        raise Refused(("ensemble",), "must give every throw a finite start", False)
    if large or table.member is not None:
        drawn = drawn[number - begin : number - begin + 1]
    return frozen_array(drawn), large if table.member is None else None


def _whole(ensemble: Ensemble, body: Body) -> Array:
    """Return the states of all throws of a large ensemble, (N, 13)."""
    from tumble.scenarios.ensemble import MOST_TOGETHER, starts

    if ensemble.throws > MOST_TOGETHER:
        raise Refused(
            ("ensemble", "throws"), f"must be at most {MOST_TOGETHER} here; `tumble compare` runs more, in parts"
        )
    return frozen_array(starts(ensemble, body, 0, ensemble.throws))


def _unit(vector: tuple[float, ...], keys: Keys) -> Array:
    largest = max(map(abs, vector))
    scaled = np.array(vector) / (largest or 1.0)  # whose squares neither overflow nor all underflow
    if not scaled.any():
        raise Refused(keys, "must not be zero")
    # Dividing by a length of 1 that is rounded would only move digits that are right.
    is_unit = abs(float(np.dot(vector, vector)) - 1) <= UNIT if largest < 2 else False
    return frozen_array(vector if is_unit else scaled / np.linalg.norm(scaled))


def _vertex(vertex: int, keys: Keys, body: Body) -> Array:
    if vertex >= len(body.points):
        raise Refused(keys, f"must be a vertex of the body, 0 to {len(body.points) - 1}")
    return body.points[vertex]


def _written_impulse(impulse: Impulse, table: ImpulseTable) -> WrittenImpulse:
    """Return an impulse as its table gives it."""
    aim = None if table.ray is None else frozen_array(table.ray.direction)
    return WrittenImpulse(
        made=impulse,
        magnitude=table.magnitude,
        direction=aim if table.direction is None else frozen_array(table.direction),
        ray_direction=aim,
        point_body=None if table.point_body is None else frozen_array(table.point_body),
    )


def _impulse(table: ImpulseTable, keys: Keys, duration: float, body: Body, start: Array) -> Impulse:
    if table.time > duration:
        raise Refused((*keys, "time"), f"must be within the duration, 0 to {duration!r}")
    impulse = Impulse(table.time, _impulse_value(table, keys), **_landing(table, keys, body))
    if impulse.ray and table.time > 0:
        return impulse  # whether it meets the body, only the flight can tell
    try:
        # Blows of one instant do not move the body, so each meets it as it starts; a later one is tried for size.
        after = jump(impulse, start, body)
    except RayMissed as error:
        raise Refused((*keys, "ray"), f"must meet the body's surface from outside: {error}") from None
    if not np.isfinite(after).all():
        raise Refused(keys, "must leave the body with a finite velocity")
    return impulse


def _impulse_value(table: ImpulseTable, keys: Keys) -> Array:
    """Return the impulse itself [N s], (3,)."""
    if table.value is not None and table.magnitude is None:
        if table.direction is not None:
            raise Refused((*keys, "direction"), "must be left out where value is given")
        return frozen_array(table.value)
    if table.magnitude is None or table.value is not None:
        raise Refused(keys, "must have either value, or magnitude with a direction")
    if table.direction is not None:
        return frozen_array(table.magnitude * _unit(table.direction, (*keys, "direction")))
    if table.ray is not None:
        return frozen_array(table.magnitude * _unit(table.ray.direction, (*keys, "ray", "direction")))
    raise Refused((*keys, "magnitude"), "must come with a direction, or with a ray that gives it")


def _landing(table: ImpulseTable, keys: Keys, body: Body) -> dict[str, Any]:
    """Return the one field of an Impulse that says where it lands."""
    given = [key for key in LANDINGS if getattr(table, key) is not None]
    if len(given) != 1:
        has = " and ".join(given) or "none"
        raise Refused(keys, f"must have exactly one of {', '.join(LANDINGS)}; it has {has}")
    where = getattr(table, given[0])
    keys = (*keys, given[0])
    match given[0]:
        case "point":
            return {"point_world": frozen_array(where)}
        case "vertex":
            return {"point_body": _vertex(where, keys, body)}
        case "point_body":
            return {"point_body": frozen_array(rotation_matrix(body.file_axes) @ where)}
        case _:
            return {"ray": _ray(where, keys, body)}


def _ray(table: RayTable, keys: Keys, body: Body) -> Ray:
    if not body.has_surface:
        raise Refused(keys, "must meet a surface, and a rigid body has none: give a point or a vertex")
    return Ray(frozen_array(table.origin), _unit(table.direction, (*keys, "direction")))


def _gravity(file: File, body: Body) -> Array | None:
    return frozen_array(file.gravity) if any(file.gravity) else None


def _tethers(file: File, body: Body) -> tuple[Tether, ...]:
    found = [
        Tether(
            _vertex(table.vertex, ("tether", i, "vertex"), body),
            frozen_array(table.anchor),
            table.stiffness,
            table.damping,
            table.rest_length,
        )
        for i, table in enumerate(file.tether)
    ]
    return tuple(tether for tether in found if tether.stiffness or tether.damping)


def _drag(file: File, body: Body) -> Drag | None:
    table = file.drag
    return Drag(table.linear, table.angular) if table and (table.linear or table.angular) else None


def _floor(file: File, body: Body) -> Floor | None:
    if file.floor is None:
        return None
    table, normal = file.floor, _unit(file.floor.normal, ("floor", "normal"))
    return Floor(table.height, normal, table.stiffness, table.damping) if table.stiffness or table.damping else None


def _plane(file: File, body: Body) -> Plane | None:
    if file.plane is None:
        return None
    table, normal = file.plane, _unit(file.plane.normal, ("plane", "normal"))
    return Plane(frozen_array(table.point), normal, table.restitution, table.friction)


def _sensor(table: SensorTable, keys: Keys, file: File, body: Body) -> Sensor:
    if not table.name.strip() or not table.name.isprintable():
        raise Refused((*keys, "name"), "must be printable text")
    if any(other.name == table.name for other in file.sensor[: int(keys[1])]):
        raise Refused((*keys, "name"), "must be unique; another sensor has that name")
    if not file.duration * table.rate < MOST_SAMPLES:
        raise Refused((*keys, "rate"), f"must make at most {MOST_SAMPLES} readings, duration x rate")
    reads_field = table.kind == "magnetometer-direction"
    if reads_field != (table.field is not None):
        need = "missing; must be a list of 3 numbers" if reads_field else "is for a magnetometer-direction only"
        raise Refused((*keys, "field"), need, not reads_field)
    point = frozen_array(rotation_matrix(body.file_axes) @ table.point)
    if not np.isfinite(point).all():
        raise Refused((*keys, "point"), "must have finite coordinates")
    return Sensor(
        table.name,
        table.kind,
        table.rate,
        point,
        frozen_array(quaternion_product(body.file_axes, _unit(table.orientation, (*keys, "orientation")))),
        table.average,
        None if table.field is None else _unit(table.field, (*keys, "field")),
    )


def _written_sensor(sensor: Sensor, table: SensorTable) -> WrittenSensor:
    """Return a sensor as its table gives it."""
    field = None if table.field is None else frozen_array(table.field)
    return WrittenSensor(sensor, frozen_array(table.point), frozen_array(table.orientation), field)


def _refuse_below(plane: Plane, body: Body, start: Array) -> None:
    """Raise Refused where a body starts below the plane by more than rounding."""
    points = vertices(start, body.points)
    heights = (start[:, 0:3] - plane.point) @ plane.normal + lowest(body, start[:, 3:7], plane.normal)
    rounded = TOUCHING * (body.reach + float(np.abs(points).max()) + float(np.abs(plane.point).max()))
    if heights.min() < -rounded:
        raise Refused(
            ("plane",), f"must lie below the body at the start, which reaches {-heights.min():.3g} m under it", False
        )


# The forces of a Scene, each made from the file and the body.
PULLS: dict[str, Callable[[File, Body], Any]] = {
    "gravity": _gravity,
    "tethers": _tethers,
    "drag": _drag,
    "floor": _floor,
    "plane": _plane,
}
