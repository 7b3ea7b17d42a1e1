"""The tables of films: one line a column."""

from dataclasses import dataclass
from typing import Annotated

from tumble.compare.tables.schema import Table
from tumble.compare.tables.shared import CONTESTANT, Engine, Method, SceneName

PLACE = "the load: point of application of an impulse, anchor of a tether, point of the floor"
VECTOR = "the load: impulse [N s], end of a tether in principal axes [m], normal of the floor, or gravity [m/s2]"
Instant = Annotated[float, "time of the frame"]


@dataclass(frozen=True, kw_only=True)
class MotionRow:
    """The state of the reference (engine `truth`) or of a contestant at one instant, and its drifts."""

    scene: SceneName
    engine: Engine
    method: Method
    dt_s: Annotated[float, "step asked for; 0 for the reference"]
    t_s: Instant
    x_m: Annotated[float, "x of the centre of mass, world axes"]
    y_m: Annotated[float, "y of the centre of mass, world axes"]
    z_m: Annotated[float, "z of the centre of mass, world axes"]
    qw: Annotated[float, "w of the quaternion from principal to world axes"]
    qx: Annotated[float, "x of the quaternion from principal to world axes"]
    qy: Annotated[float, "y of the quaternion from principal to world axes"]
    qz: Annotated[float, "z of the quaternion from principal to world axes"]
    vx_m_s: Annotated[float, "x of the velocity of the centre of mass, world axes"]
    vy_m_s: Annotated[float, "y of the velocity of the centre of mass, world axes"]
    vz_m_s: Annotated[float, "z of the velocity of the centre of mass, world axes"]
    wx_rad_s: Annotated[float, "x of the angular velocity, world axes"]
    wy_rad_s: Annotated[float, "y of the angular velocity, world axes"]
    wz_rad_s: Annotated[float, "z of the angular velocity, world axes"]
    l1_kg_m2_s: Annotated[float, "first component of the angular momentum about the centre of mass, principal axes"]
    l2_kg_m2_s: Annotated[float, "second component of the angular momentum about the centre of mass, principal axes"]
    l3_kg_m2_s: Annotated[float, "third component of the angular momentum about the centre of mass, principal axes"]
    error_m: Annotated[float, "largest vertex error"]
    energy_drift: Annotated[float, "difference from the true energy, over the largest true kinetic energy"]
    angular_momentum_drift: Annotated[float, "difference from the true angular momentum, over its largest true value"]


@dataclass(frozen=True, kw_only=True)
class DeformedRow:
    """One vertex of a body that is no longer rigid, at one instant."""

    scene: SceneName
    engine: Engine
    method: Method
    t_s: Instant
    vertex: Annotated[int, "number of the vertex"]
    x_m: Annotated[float, "x of the vertex, world axes"]
    y_m: Annotated[float, "y of the vertex, world axes"]
    z_m: Annotated[float, "z of the vertex, world axes"]


@dataclass(frozen=True, kw_only=True)
class BodyRow:
    """One body: its shape, mass and principal moments."""

    scene: SceneName
    shape: Annotated[str, "box, mesh or rigid"]
    mass_kg: Annotated[float, "mass"]
    i1_kg_m2: Annotated[float, "moment of inertia about the first principal axis"]
    i2_kg_m2: Annotated[float, "moment of inertia about the second principal axis"]
    i3_kg_m2: Annotated[float, "moment of inertia about the third principal axis"]


@dataclass(frozen=True, kw_only=True)
class PointRow:
    """One vertex of a body."""

    scene: SceneName
    vertex: Annotated[int, "number of the vertex"]
    x_m: Annotated[float, "x of the vertex from the centre of mass, principal axes"]
    y_m: Annotated[float, "y of the vertex from the centre of mass, principal axes"]
    z_m: Annotated[float, "z of the vertex from the centre of mass, principal axes"]


@dataclass(frozen=True, kw_only=True)
class FaceRow:
    """One face of a body; for a body with points only, of their convex hull."""

    scene: SceneName
    face: Annotated[int, "number of the face"]
    vertices: Annotated[str, "numbers of its vertices, counter-clockwise from outside, separated by blanks"]


@dataclass(frozen=True, kw_only=True)
class LoadRow:
    """One load on a body: an impulse, a tether, a floor or gravity."""

    scene: SceneName
    kind: Annotated[str, "impulse, tether, floor or gravity"]
    t_s: Annotated[float, "time of an impulse, else 0"]
    x_m: Annotated[float, f"x of {PLACE}, world axes"]
    y_m: Annotated[float, f"y of {PLACE}, world axes"]
    z_m: Annotated[float, f"z of {PLACE}, world axes"]
    u: Annotated[float, f"x of {VECTOR}"]
    v: Annotated[float, f"y of {VECTOR}"]
    w: Annotated[float, f"z of {VECTOR}"]


BODIES = Table("bodies.csv", BodyRow, ("scene",))
POINTS = Table("points.csv", PointRow, ("scene", "vertex"))
FACES = Table("faces.csv", FaceRow, ("scene", "face"))
ACTS = Table("loads.csv", LoadRow)
MOTION = Table("motion.csv", MotionRow, (*CONTESTANT, "t_s"))
DEFORMED = Table("deformed.csv", DeformedRow, (*CONTESTANT, "t_s", "vertex"))
TABLES = (BODIES, POINTS, FACES, ACTS, MOTION, DEFORMED)
