"""All tables of films, by file name: bodies, loads and motions."""

from collections.abc import Iterator, Sequence

import numpy as np
import pandas as pd

from tumble.compare.judge import mechanics
from tumble.compare.motion.film import Film
from tumble.compare.motion.schemas import (
    ACTS,
    BODIES,
    DEFORMED,
    FACES,
    MOTION,
    POINTS,
    BodyRow,
    DeformedRow,
    FaceRow,
    LoadRow,
    PointRow,
)
from tumble.compare.run.flight import Trajectory
from tumble.compare.tables.frames import frame, typed
from tumble.compare.tables.runs import vector_columns
from tumble.compare.tables.trajectory import STATE_COLUMNS
from tumble.scenarios.frames import Array, vertices
from tumble.scenarios.impulse import RayMissed, strike_point
from tumble.scenarios.scene import Body, Scene

TRUTH = "truth"
PLACE = ("x_m", "y_m", "z_m")
# A body is deformed if a vertex is further than this share of its size from where a rigid body has it.
RIGID = 1e-9
# The corners of each face of a box in order round it; opposite faces come in pairs.
BOX_FACES = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))


def film_tables(films: Sequence[Film]) -> dict[str, pd.DataFrame]:
    """Return all tables of films.

    Parameters
    ----------
    films : of the scenes

    Returns
    -------
    table by file name
    """
    return {
        BODIES.file: frame(BODIES, (body_row(film.scene) for film in films)),
        POINTS.file: frame(POINTS, (row for film in films for row in point_rows(film.scene))),
        FACES.file: frame(FACES, (row for film in films for row in face_rows(film.scene))),
        ACTS.file: frame(ACTS, (row for film in films for row in act_rows(film))),
        MOTION.file: motion_table(films),
        DEFORMED.file: frame(DEFORMED, (row for film in films for row in deformed_rows(film))),
    }


def body_row(scene: Scene) -> BodyRow:
    """Return the row of a scene's body."""
    return BodyRow(
        scene=scene.name,
        shape=scene.body.shape,
        mass_kg=scene.body.mass,
        **vector_columns(scene.body.moments, "i1_kg_m2", "i2_kg_m2", "i3_kg_m2"),
    )


def point_rows(scene: Scene) -> Iterator[PointRow]:
    """Yield the vertices."""
    for vertex, point in enumerate(scene.body.points):
        yield PointRow(scene=scene.name, vertex=vertex, **vector_columns(point, *PLACE))


def face_rows(scene: Scene) -> Iterator[FaceRow]:
    """Yield the faces: those of the box or the mesh, or the convex hull of a body that has only points."""
    for face, corners in enumerate(faces(scene.body)):
        yield FaceRow(scene=scene.name, face=face, vertices=" ".join(map(str, corners)))


def faces(body: Body) -> Sequence[Sequence[int]]:
    """Return each face's vertices, counter-clockwise from outside."""
    if body.size is not None:
        return BOX_FACES
    if body.disc is not None:
        return disc_faces(len(body.points))
    return body.faces.tolist() if len(body.faces) else hull(body.points)


def disc_faces(count: int) -> list[list[int]]:
    """Return the faces of a disc with so many points: below and above, and between its rims if there are two."""
    below, above = list(range(1, 9)), list(range(count - 8, count))
    sides = [[below[at - 1], below[at], above[at], above[at - 1]] for at in range(8)] if count > 9 else []
    return [below[::-1], above, *sides]


def hull(points: Array) -> list[list[int]]:
    """Return the triangles of the convex hull; nothing if the points lie in a plane."""
    from scipy.spatial import ConvexHull, QhullError  # slow to load, and only for bodies without faces

    try:
        found = ConvexHull(points)
    except (QhullError, ValueError):
        return []
    outward = found.equations[:, :3]
    turned = np.cross(
        points[found.simplices[:, 1]] - points[found.simplices[:, 0]],
        points[found.simplices[:, 2]] - points[found.simplices[:, 0]],
    )
    inward = np.einsum("ij,ij->i", turned, outward) < 0
    return [
        list(reversed(three)) if wrong else list(three)
        for three, wrong in zip(found.simplices.tolist(), inward, strict=True)
    ]


def act_rows(film: Film) -> Iterator[LoadRow]:
    """Yield the loads: impulses are applied where the true body is."""
    scene = film.scene
    for impulse in scene.impulses:
        row = int(np.searchsorted(film.truth.times, impulse.time))
        if row == len(film.truth.times):
            continue  # beyond the horizon
        state = film.truth.states[row, 0]
        try:
            point = strike_point(impulse, state, scene.body)
        except RayMissed:
            continue
        yield load_row(scene, "impulse", impulse.time, point, impulse.value)
    for tether in scene.tethers:
        yield load_row(scene, "tether", 0.0, tether.anchor, tether.point_body)
    if scene.floor is not None:
        normal = scene.floor.normal
        yield load_row(scene, "floor", 0.0, scene.floor.height * normal, normal)
    if scene.gravity is not None:
        yield load_row(scene, "gravity", 0.0, np.zeros(3), scene.gravity)


def load_row(scene: Scene, kind: str, time: float, place: Array, vector: Array) -> LoadRow:
    """Return the row of one load: at a time [s] and a place [m], (3,), with its vector, (3,)."""
    vectors = {**vector_columns(place, *PLACE), **vector_columns(vector, "u", "v", "w")}
    return LoadRow(scene=scene.name, kind=kind, t_s=time, **vectors)


def motion_table(films: Sequence[Film]) -> pd.DataFrame:
    """Return motion.csv: the rows of each reference, then those of every contestant as far as it is finite."""
    parts = [motion_columns(film, *shown) for film in films for shown in all_shown(film)]
    return typed(MOTION, {name: np.concatenate([part[name] for part in parts]) for name in MOTION.names if parts})


def all_shown(film: Film) -> Iterator[tuple[tuple[str, str], float, Array, Array]]:
    """Yield engine and method, step [s], states (R, 13) and vertices (R, n, 3) [m] of the reference and of each run."""
    yield (TRUTH, ""), 0.0, film.truth.states[:, 0], film.truth.vertices[:, 0]
    known = len(film.truth.times)
    for contestant, trajectory in film.trajectories.items():
        yield contestant, film.dt, trajectory.states[:known, 0], trajectory.vertices[:known, 0]


def motion_columns(
    film: Film, contestant: tuple[str, str], dt_s: float, states: Array, points: Array
) -> dict[str, Array]:
    """Return the columns of one: states (R, 13), vertices (R, n, 3) [m]."""
    rows = finite_rows(states, points)
    states, points = states[:rows], points[:rows]
    body, true = film.scene.body, film.truth.states[:, 0]
    with np.errstate(all="ignore"):  # what diverges is finite before its energy is
        errors = np.linalg.norm(points - film.truth.vertices[:rows, 0], axis=-1).max(axis=-1)
        energy, energy_true = (mechanics.energy(each, body, film.scene.gravity) for each in (states, true[:rows]))
        l_true = np.linalg.norm(mechanics.angular_momentum(true, body), axis=-1).max() or 1.0
        l_error = mechanics.angular_momentum(states, body) - mechanics.angular_momentum(true[:rows], body)
        energy_drift = (energy - energy_true) / (mechanics.kinetic_energy(true, body).max() or 1.0)
        l_body = body.moments * mechanics.in_body_axes(states, states[:, 10:13])
        angular_momentum_drift = np.linalg.norm(l_error, axis=-1) / l_true
    return {
        **same_in_rows(rows, scene=film.scene.name, engine=contestant[0], method=contestant[1], dt_s=dt_s),
        "t_s": film.truth.times[:rows],
        **dict(zip(STATE_COLUMNS[1:], states.T, strict=True)),
        **dict(zip(("l1_kg_m2_s", "l2_kg_m2_s", "l3_kg_m2_s"), l_body.T, strict=True)),
        "error_m": errors,
        "energy_drift": energy_drift,
        "angular_momentum_drift": angular_momentum_drift,
    }


def finite_rows(states: Array, points: Array) -> int:
    """Return how many rows there are before the first that is not finite: states (R, 13), vertices (R, n, 3)."""
    finite = np.isfinite(states).all(axis=1) & np.isfinite(points).all(axis=(1, 2))
    return len(states) if finite.all() else int(np.argmin(finite))


def same_in_rows(count: int, **values: object) -> dict[str, Array]:
    """Return columns that have the same value in so many rows."""
    return {name: np.full(count, value, dtype=object) for name, value in values.items()}


def deformed(film: Film) -> dict[tuple[str, str], Trajectory]:
    """Return the runs, by engine and method, whose body is no longer rigid."""
    body = film.scene.body
    size = body.reach
    found = {}
    for contestant, trajectory in film.trajectories.items():
        with np.errstate(all="ignore"):
            apart = np.abs(trajectory.vertices - vertices(trajectory.states, body.points))
        if np.nanmax(apart, initial=0.0) > RIGID * size:
            found[contestant] = trajectory
    return found


def deformed_rows(film: Film) -> Iterator[DeformedRow]:
    """Yield the vertices of the runs whose body is no longer rigid."""
    for (engine, method), trajectory in deformed(film).items():
        for time, points in zip(film.truth.times.tolist(), trajectory.vertices[:, 0], strict=False):
            for vertex, point in enumerate(points):
                if np.isfinite(point).all():
                    yield DeformedRow(
                        scene=film.scene.name,
                        engine=engine,
                        method=method,
                        t_s=time,
                        vertex=vertex,
                        **vector_columns(point, *PLACE),
                    )
