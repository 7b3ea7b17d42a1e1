"""The true answer of a scene: free flight under gravity and impulses, in closed form and extended precision.

Shares no formulation with any engine: Jacobi functions by Landen's steps, attitude by Carlson's integral.
`elliptic` has the functions, `rotation` the closed form, `flight` the whole throw, `limit` how good the answer is.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from scenarios.frames import Array
from scenarios.scene import Scene
from scenarios.truth.flight import Pose, read_throw
from scenarios.truth.limit import input_floor, own_error, settle
from scenarios.truth.rotation import Numbers


class NoTruth(ValueError):
    """The scene has a force for which there is no closed form."""


@dataclass(frozen=True, eq=False)
class Truth:
    """Where the body truly is, R instants of N throws.

    times: instants [s], (R,), the scene's rows, each after its impulses;
    states: (R, N, 13), each number the double nearest to the exact one; vertices: world [m], (R, N, n, 3), likewise;
    bound: how far a vertex may be from the exact answer, its rounding to doubles included [m], (R, N);
    floor: how far a vertex moves when every input changes by a relative 2^-53 [m], (R, N).
    """

    times: Array
    states: Array
    vertices: Array
    bound: Array
    floor: Array

    @property
    def limit(self) -> Array:
        """The least error that can be told from none [m], (R, N)."""
        return np.maximum(self.bound, self.floor)


def unsolved(scene: Scene) -> list[str]:
    """Return the forces of the scene for which there is no closed form."""
    forces = {"tether": scene.tethers, "drag": scene.drag, "floor": scene.floor}
    return [name for name, force in forces.items() if force]


def has_truth(scene: Scene) -> bool:
    """Whether the scene has a truth."""
    return not unsolved(scene)


def truth(scene: Scene) -> Truth:
    """Return the exact flight of every throw of the scene.

    Raises NoTruth for a scene with tether, drag or floor, RayMissed where an impulse's ray does not meet the body.
    """
    if not has_truth(scene):
        raise NoTruth(f"no closed form with {' and '.join(unsolved(scene))}")

    from mpmath import MPContext  # a tenth of a second that only this call should pay

    # A context of our own: whoever else uses mpmath keeps its precision.
    mp = MPContext()
    flights = [_flight(mp, scene, row) for row in range(len(scene.start))]
    states, vertices, bound, floor = (np.stack(column, axis=1) for column in zip(*flights, strict=True))
    return Truth(scene.rows, states, vertices, bound, floor)


def _flight(mp: Any, scene: Scene, row: int) -> tuple[Array, Array, Array, Array]:
    """Return states (R, 13), vertices (R, n, 3), bound (R,) and floor (R,) of one throw."""
    throw = read_throw(scene, row)
    rougher, finer = settle(mp, throw)
    states = np.array([_state(mp, pose) for pose in finer.poses])
    _follow_sign(states[:, 3:7], scene.start[row, 3:7])
    vertices = np.array([_vertices(pose, throw.points, finer.bits) for pose in finer.poses])
    rounding = np.linalg.norm(np.spacing(np.abs(vertices)) / 2, axis=-1).max(axis=-1)
    bound = own_error(rougher, finer, scene.body.points) + rounding
    return states, vertices, bound, input_floor(mp, scene, row, rougher)


def _state(mp: Any, pose: Pose) -> Array:
    return np.concatenate((pose.x, _quaternion(mp, pose.axes), pose.v, pose.w_world)).astype(float)


def _quaternion(mp: Any, axes: Numbers) -> Numbers:
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


def _follow_sign(quaternions: Array, first: Array) -> None:
    """Of q and -q, which are one attitude, take in place the one nearer to the row before."""
    for before, q in zip((first, *quaternions), quaternions, strict=False):
        if before @ q < 0:
            q *= -1


def _vertices(pose: Pose, points: Numbers, bits: int) -> Array:
    """Return x + R p, (n, 3), each number the nearest double: a sum of whole numbers, divided once."""
    grain, unit = max(point.denominator for point in points.flat), 2**bits
    whole = np.vectorize(round, otypes=[object])
    axes, points, x = whole(pose.axes * unit), whole(points * grain), whole(pose.x * (unit * grain))
    return ((points @ axes.T + x) / (unit * grain)).astype(float)
