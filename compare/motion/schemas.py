"""The tables of films: one line a column."""

from dataclasses import dataclass
from typing import Annotated

from compare.tables.schema import Table
from compare.tables.shared import CONTESTANT, Engine, Method, SceneName

World = Annotated[float, "the same"]
Instant = Annotated[float, "time of the frame"]


@dataclass(frozen=True)
class MotionRow:
    """Where the truth (engine `truth`) or a contestant is at one instant, and what a free body would keep."""

    scene: SceneName
    engine: Engine
    method: Method
    dt_s: Annotated[float, "step that was asked for; 0 for the truth"]
    t_s: Instant
    x_m: Annotated[float, "centre of mass, world axes"]
    y_m: World
    z_m: World
    qw: Annotated[float, "quaternion from principal to world axes"]
    qx: World
    qy: World
    qz: World
    vx_m_s: Annotated[float, "velocity, world axes"]
    vy_m_s: World
    vz_m_s: World
    wx_rad_s: Annotated[float, "angular velocity, world axes"]
    wy_rad_s: World
    wz_rad_s: World
    l1_kg_m2_s: Annotated[float, "angular momentum about the centre of mass, principal axes"]
    l2_kg_m2_s: World
    l3_kg_m2_s: World
    error_m: Annotated[float, "largest vertex error"]
    energy_drift: Annotated[float, "difference from the true energy, over the largest kinetic"]
    angular_momentum_drift: Annotated[float, "difference from the true angular momentum, over the largest"]


@dataclass(frozen=True)
class DeformedRow:
    """Where a vertex is of a body that is no longer rigid, at one instant."""

    scene: SceneName
    engine: Engine
    method: Method
    t_s: Instant
    vertex: Annotated[int, "number of the vertex"]
    x_m: Annotated[float, "where it is, world axes"]
    y_m: World
    z_m: World


@dataclass(frozen=True)
class BodyRow:
    """One body: its shape, mass and principal moments."""

    scene: SceneName
    shape: Annotated[str, "box, mesh or rigid"]
    mass_kg: Annotated[float, "mass"]
    i1_kg_m2: Annotated[float, "principal moment of inertia"]
    i2_kg_m2: World
    i3_kg_m2: World


@dataclass(frozen=True)
class PointRow:
    """One vertex of a body."""

    scene: SceneName
    vertex: Annotated[int, "number of the vertex"]
    x_m: Annotated[float, "where it is from the centre of mass, principal axes"]
    y_m: World
    z_m: World


@dataclass(frozen=True)
class FaceRow:
    """One face of a body; of one that has only points, of their convex hull."""

    scene: SceneName
    face: Annotated[int, "number of the face"]
    vertices: Annotated[str, "its vertices, counter-clockwise from outside"]


@dataclass(frozen=True)
class ActRow:
    """What acts on a body: an impulse, a tether, a floor, gravity."""

    scene: SceneName
    kind: Annotated[str, "impulse, tether, floor or gravity"]
    t_s: Annotated[float, "time of an impulse, else 0"]
    x_m: Annotated[float, "where it acts, world axes: where an impulse lands, a tether's anchor, a point of the floor"]
    y_m: World
    z_m: World
    u: Annotated[float, "impulse [N s], end of the tether in principal axes [m], normal of the floor, gravity [m/s2]"]
    v: World
    w: World


BODIES = Table("bodies.csv", BodyRow, ("scene",))
POINTS = Table("points.csv", PointRow, ("scene", "vertex"))
FACES = Table("faces.csv", FaceRow, ("scene", "face"))
ACTS = Table("acts.csv", ActRow)
MOTION = Table("motion.csv", MotionRow, (*CONTESTANT, "t_s"))
DEFORMED = Table("deformed.csv", DeformedRow, (*CONTESTANT, "t_s", "vertex"))
TABLES = (BODIES, POINTS, FACES, ACTS, MOTION, DEFORMED)
