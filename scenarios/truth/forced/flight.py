"""A whole throw with forces: the blows, and the passages between them.

What is read from the scene and what a blow does is exact, in fractions; a passage is integrated in doubles, the state
being kept to about twice their digits, so that many small steps do not add up their rounding.
"""

from fractions import Fraction
from itertools import pairwise, zip_longest
from typing import Any, NamedTuple

import numpy as np

from scenarios.frames import Array
from scenarios.scene import Scene
from scenarios.truth.flight import Blow, Pose, Read, Throw, lever, read_throw
from scenarios.truth.forced.laws import AXES, MOMENTUM, SIZE, Forces, Solid, V, X
from scenarios.truth.forced.passage import LOST, TOO_LONG, Manner, passage
from scenarios.truth.rotation import Numbers


class Unending(ValueError):
    """An integration that gets nowhere, or not soon enough; its text says which."""


class Course(NamedTuple):
    """A throw in exact numbers and the tables of the forces that it flies through."""

    throw: Throw
    forces: Forces


def read_course(scene: Scene, row: int, read: Read = Fraction) -> Course:
    """Return one throw of the scene and its forces; read: what to take each number for, as in `read_throw`.

    A force that the scene has not got is a table of no rows.
    """
    drag, floor = scene.drag, scene.floor
    forces = Forces(
        gravity=_table(3, [] if scene.gravity is None else [scene.gravity], read),
        tethers=_table(
            9, [(*t.point_body, *t.anchor, t.stiffness, t.damping, t.rest_length) for t in scene.tethers], read
        ),
        drag=_table(2, [] if drag is None else [(drag.linear, drag.angular)], read),
        floor=_table(6, [] if floor is None else [(*floor.normal, floor.height, floor.stiffness, floor.damping)], read),
    )
    return Course(read_throw(scene, row, read), forces)


def _table(columns: int, rows: list, read: Read) -> Array:
    return np.array([[float(read(float(value))) for value in row] for row in rows]).reshape(-1, columns)


def solid_of(throw: Throw) -> Solid:
    """Return the body in doubles; its size is that of its points, or of its moments where it is but a point."""
    mass, moments, points = float(throw.mass), throw.moments.astype(float), throw.points.astype(float)
    radius = max(float(np.linalg.norm(points, axis=1).max()), float(np.sqrt(moments.max() / mass)))
    return Solid(mass, moments, points, radius)


def fly_course(mp: Any, course: Course, manner: Manner, implicit: bool | None) -> list[Pose]:
    """Return the pose at each of the throw's instants, blows of that instant included.

    mp: mpmath context, for the numbers of the poses.  Raises Unending, RayMissed.
    """
    throw, forces = course
    solid = solid_of(throw)
    state, rows = _start(throw), {}
    starts = sorted({Fraction(0), *(blow.time for blow in throw.blows)})
    for begin, end in zip_longest(starts, starts[1:]):
        for blow in throw.blows:
            if blow.time == begin:
                _strike(state, blow, throw)
        stops = [time for time in throw.times if begin <= time and (end is None or time < end)]
        if end is not None:
            stops.append(end)
        if not stops:
            break
        spans = np.array([float(after - before) for before, after in pairwise([begin, *stops])])
        flown = np.empty((len(stops), 2, SIZE))
        outcome, steps = passage(_in_doubles(state), spans, flown, solid, forces, manner, implicit)
        if outcome == TOO_LONG:
            raise Unending(f"more than {manner.most_steps} steps of the integration would be needed")
        if outcome == LOST:
            raise Unending("the integration gets stuck")
        manner = manner._replace(most_steps=manner.most_steps - steps)
        rows |= dict(zip(stops, flown, strict=True))
        state = _exact(flown[-1])
    return [_pose(mp, rows[time], throw) for time in throw.times]


def _start(throw: Throw) -> Numbers:
    """Return the state before any blow in fractions, (SIZE,)."""
    L = throw.axes @ (throw.moments * (throw.axes.T @ throw.w_world))
    return np.concatenate((throw.x, throw.v, throw.axes.T.ravel(), L))


def _strike(state: Numbers, blow: Blow, throw: Throw) -> None:
    """Let a blow J act: v += J/m, L += lever x J.  Raises RayMissed."""
    arm = lever(blow, state[X:V], state[AXES:MOMENTUM].reshape(3, 3).T, throw)
    state[V:AXES] += blow.value / throw.mass
    state[MOMENTUM:] += np.cross(arm, blow.value)


def _in_doubles(state: Numbers) -> Array:
    """Return fractions as doubles and their rounding, (2, SIZE)."""
    nearest = state.astype(float)
    return np.array((nearest, (state - _exact([nearest])).astype(float)))


def _exact(parts: Array | list[Array]) -> Numbers:
    """Return the sum of some rows of doubles in fractions."""
    return np.array([[Fraction(float(number)) for number in row] for row in parts]).sum(axis=0)


def _pose(mp: Any, row: Array, throw: Throw) -> Pose:
    state = np.array([mp.mpf(high) + mp.mpf(low) for high, low in row.T.tolist()])
    axes = state[AXES:MOMENTUM].reshape(3, 3).T
    return Pose(state[X:V], axes, state[V:AXES], axes @ ((axes.T @ state[MOMENTUM:]) / throw.moments))
