"""What a scene is: a body, its start, what strikes it and pulls at it, and when it is looked at.

These are plain values.  `tumble.scenarios.read` makes them from a scene file; engines receive them and read their
attributes.
Every array is read-only: an engine cannot alter the question.
"""

from dataclasses import dataclass, field, fields
from functools import cached_property

import numpy as np

from tumble.scenarios.forces import GRAVITY, PLANE, acting
from tumble.scenarios.frames import Array


def frozen_array(values: object, dtype: type = float) -> np.ndarray:
    """Return a read-only, C-ordered copy.

    Parameters
    ----------
    values
    dtype

    Returns
    -------
    array
    """
    array = np.array(values, dtype=dtype, order="C")
    array.flags.writeable = False
    return array


class _Frozen:
    """Makes every array of a dataclass read-only, also after it has crossed to a worker process."""

    def __post_init__(self) -> None:
        for item in fields(self):  # type: ignore[arg-type]
            value = getattr(self, item.name)
            if isinstance(value, np.ndarray):
                value.flags.writeable = False

    def __setstate__(self, state: dict) -> None:
        self.__dict__.update(state)
        self.__post_init__()


@dataclass(frozen=True)
class Disc:
    """A disc about its body's z axis.

    Parameters
    ----------
    radius : m
    thickness : m
    """

    radius: float
    thickness: float


@dataclass(frozen=True, eq=False)
class Body(_Frozen):
    """A rigid body in its principal axes, the origin at its centre of mass.

    Parameters
    ----------
    shape
        as in the scene file
    mass : kg
    moments : (3,), kg m2
        principal moments of inertia
    points : (n, 3), m
        vertices, body axes
    faces : (m, 3)
        triangles as indices into points, counter-clockwise from outside; empty for a body without surface
    size : (3,), m
        full edges of a box, else None
    file_axes : (4,)
        quaternion, scene file's axes -> principal axes; the identity for a box
    radius : m
        of a sphere, else None
    disc
        radius and thickness of a disc, else None
    """

    shape: str
    mass: float
    moments: Array
    points: Array
    faces: np.ndarray
    size: Array | None = None
    file_axes: Array = field(default_factory=lambda: frozen_array((1.0, 0.0, 0.0, 0.0)))
    radius: float | None = None
    disc: Disc | None = None

    @property
    def has_surface(self) -> bool:
        """Whether a ray can meet it: a body given by its tensor alone has points, and no surface."""
        return bool(len(self.faces)) or self.radius is not None or self.disc is not None

    @cached_property
    def reach(self) -> float:
        """How far the furthest point is from the centre of mass [m]."""
        return float(np.linalg.norm(self.points, axis=1).max())


@dataclass(frozen=True, eq=False)
class Ray(_Frozen):
    """A ray, such as a click.

    Parameters
    ----------
    origin : (3,), m
        world axes
    direction : (3,)
        unit vector, world axes
    """

    origin: Array
    direction: Array


@dataclass(frozen=True, eq=False)
class Impulse(_Frozen):
    """An impulse at one instant, and where it acts: exactly one of the last three is set.

    Parameters
    ----------
    time : s
    value : (3,), N s
        world axes
    point_world : (3,), m
    point_body : (3,), m
        principal axes, from the centre of mass
    ray
        the first surface that it hits
    """

    time: float
    value: Array
    point_world: Array | None = None
    point_body: Array | None = None
    ray: Ray | None = None


@dataclass(frozen=True, eq=False)
class Tether(_Frozen):
    """Spring and damper from a body point to a fixed one.

    F = -k d - c p' where rest_length is 0, else F = -(k (|d| - l0) + c d'.u) u, with d = p - anchor and u = d/|d|.

    Parameters
    ----------
    point_body : (3,), m
        principal axes
    anchor : (3,), m
        world axes
    stiffness : N/m
    damping : N s/m
    rest_length : m
    """

    point_body: Array
    anchor: Array
    stiffness: float
    damping: float
    rest_length: float


@dataclass(frozen=True)
class Drag:
    """F = -linear v;  tau = -angular w.

    Parameters
    ----------
    linear : N s/m
    angular : N m s/rad
    """

    linear: float
    angular: float


@dataclass(frozen=True, eq=False)
class Floor(_Frozen):
    """Penalty floor at every vertex below height along normal: N = max(0, -k y - c y') where y < 0, no friction.

    height [m]; normal: unit, (3,), world; stiffness [N/m]; damping [N s/m].
    """

    height: float
    normal: Array
    stiffness: float
    damping: float


@dataclass(frozen=True, eq=False)
class Plane(_Frozen):
    """A rigid plane below the body: Newton's restitution and Coulomb's friction of the pair of body and plane.

    Parameters
    ----------
    point : (3,), m
        world axes
    normal : (3,)
        unit vector towards the body's side, world axes
    restitution
        0 to 1
    friction
        at least 0
    """

    point: Array
    normal: Array
    restitution: float
    friction: float


@dataclass(frozen=True, eq=False)
class Sensor(_Frozen):
    """A sensor fixed to the body, which reads in its own axes.

    Parameters
    ----------
    name
        unique in its scene
    kind
        imu, accelerometer, gyro or magnetometer-direction
    rate : Hz
        it reads at 0, 1/rate, 2/rate, ...
    point_body : (3,), m
        principal axes, from the centre of mass
    orientation : (4,)
        quaternion, sensor axes -> principal axes
    average
        whether a reading is the mean over the 1/rate before it, not the value at its instant
    field : (3,)
        unit vector, world axes, that a magnetometer-direction reads; None for the others
    """

    name: str
    kind: str
    rate: float
    point_body: Array
    orientation: Array
    average: bool = False
    field: Array | None = None

    @property
    def reads_force(self) -> bool:
        """Whether it reads specific force."""
        return self.kind in ("imu", "accelerometer")

    @property
    def reads_spin(self) -> bool:
        """Whether it reads angular velocity."""
        return self.kind in ("imu", "gyro")


@dataclass(frozen=True, eq=False)
class WrittenSensor(_Frozen):
    """A sensor as the file gives it, and what was made of it.

    point [m], (3,), and orientation, (4,), of any length, sensor to body: along the file's axes; field, (3,), of any
    length, or None.
    """

    made: Sensor
    point: Array
    orientation: Array
    field: Array | None


@dataclass(frozen=True, eq=False)
class WrittenImpulse(_Frozen):
    """An impulse as the file gives it, and what was made of it; None is what the file does not give.

    magnitude [N s] along a direction of any length, (3,), and that of the ray, (3,); point_body [m], (3,), along the
    file's axes.
    """

    made: Impulse
    magnitude: float | None
    direction: Array | None
    ray_direction: Array | None
    point_body: Array | None


@dataclass(frozen=True, eq=False)
class Written(_Frozen):
    """Numbers of the scene file that a Scene has only in other axes, or as what follows from them, rounded.

    Each counts as long as the Scene still has what was made of it: `dataclasses.replace` may change the rest.
    body, start, (13,), normal, (3,), of the floor, plane_normal, (3,): what was made.  inertia [kg m2], (3, 3), points
    [m], (n, 3): along the file's axes, of a mesh from the file's origin; None for a box.  orientation, (4,),
    file_normal and file_plane_normal, (3,): of any length.
    """

    body: Body
    inertia: Array | None
    points: Array | None
    start: Array
    orientation: Array
    impulses: tuple[WrittenImpulse, ...]
    normal: Array | None
    file_normal: Array | None
    plane_normal: Array | None = None
    file_plane_normal: Array | None = None
    sensors: tuple[WrittenSensor, ...] = ()


@dataclass(frozen=True, eq=False)
class Ensemble(_Frozen):
    """Throws that are too many to be held at once: what they are drawn from (`tumble.scenarios.ensemble`).

    Parameters
    ----------
    throws
        number of them
    start : (1, 13)
        as written, before the impulses
    impulses
        of t = 0
    seed
    magnitude
        share by which an impulse's size varies
    cone : rad
        half angle around its direction
    point : m
        radius around the point where it acts
    orientation : rad
        largest turn of the start
    """

    throws: int
    start: Array
    impulses: tuple[Impulse, ...]
    seed: int
    magnitude: float
    cone: float
    point: float
    orientation: float


@dataclass(frozen=True, eq=False)
class Scene(_Frozen):
    """A benchmark problem, the same for every engine.

    What a scene does not have is None or empty: a force of zero strength is not stored.

    Parameters
    ----------
    name
    title
    source
        where the case comes from
    duration : s
    times : (S,), s
        sample times, increasing
    step : s
        time step that a plain run uses
    body
    start : (N, 13)
        states before any impulse, one row a throw
    gravity : (3,), m/s2
        None if there is none
    written
        numbers of the file that the fields here round, for the truth alone
    impulses
        in the order they act
    tethers
    drag
    floor
    plane
    sensors
        in the order of the file; they act on nothing
    ensemble
        of a scene that is run in parts, whose start is throw 0; None: start has all throws
    """

    name: str
    title: str
    source: str
    duration: float
    times: Array
    step: float
    body: Body
    start: Array
    gravity: Array | None = None
    written: Written | None = field(default=None, kw_only=True)
    impulses: tuple[Impulse, ...] = ()
    tethers: tuple[Tether, ...] = ()
    drag: Drag | None = None
    floor: Floor | None = None
    plane: Plane | None = None
    sensors: tuple[Sensor, ...] = ()
    ensemble: Ensemble | None = None

    def sensor_times(self, sensor: Sensor) -> Array:
        """Return the instants at which a sensor reads, 0, 1/rate, ... up to the end.

        Parameters
        ----------
        sensor

        Returns
        -------
        times : (K,), s
        """
        # Whether the last one is within the duration is asked to the rounding of their product.
        count = int(self.duration * sensor.rate * (1 + 2.0**-50)) + 1
        return np.minimum(np.arange(count) / sensor.rate, self.duration)

    @property
    def is_free(self) -> bool:
        """Whether nothing acts between impulses but gravity."""
        return set(acting(self)) <= {GRAVITY}

    @property
    def is_unforced(self) -> bool:
        """Whether no force acts between impulses and impacts but gravity: no tether, no drag, no penalty floor."""
        return set(acting(self)) <= {GRAVITY, PLANE}

    @property
    def rows(self) -> Array:
        """The instants of a trajectory's rows [s]: t = 0 and then the samples."""
        return self.times if self.times[0] == 0.0 else np.concatenate(([0.0], self.times))
