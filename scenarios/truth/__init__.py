"""The true answer of a scene.

Free flight under gravity and impulses has a closed form, worked out in extended precision: Jacobi functions by Landen's
steps, attitude by Carlson's integral.  `elliptic` has the functions, `rotation` the closed form, `flight` the whole
throw, `limit` how good the answer is.  A flight with tether, drag or floor is integrated: `forced`.  Neither shares a
formulation with the solver or an engine.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from scenarios.frames import Array
from scenarios.scene import Scene
from scenarios.truth.flight import Pose, exact_numbers, read_throw
from scenarios.truth.limit import Answer, input_floor, own_error, settle
from scenarios.truth.rotation import Numbers


class NoTruth(ValueError):
    """The flight cannot be told well enough to hold anything against it; the text says why."""


@dataclass(frozen=True, eq=False)
class Truth:
    """Where the body truly is, R instants of N throws.

    times: instants [s], (R,), the scene's rows, each after its impulses;
    states: (R, N, 13), each number the double nearest to the exact one; vertices: world [m], (R, N, n, 3), likewise;
    bound: how far a vertex may be from the exact answer, its rounding to doubles included [m], (R, N);
    floor: how far a vertex moves when every input changes by a relative 2^-53 [m], (R, N);
    how: exact, by the closed form, or by which integration.
    """

    times: Array
    states: Array
    vertices: Array
    bound: Array
    floor: Array
    how: str

    @property
    def limit(self) -> Array:
        """The least error that can be told from none [m], (R, N)."""
        return np.maximum(self.bound, self.floor)


def truth(scene: Scene) -> Truth:
    """Return the true flight of every throw of the scene.

    Raises NoTruth where forces make a flight that cannot be integrated well enough, RayMissed where an impulse's ray
    does not meet the body.
    """
    from mpmath import MPContext  # a tenth of a second that only this call should pay

    # A context of our own: whoever else uses mpmath keeps its precision.
    mp = MPContext()
    flights = [_flight(mp, scene, row) for row in range(len(scene.start))]
    states, vertices, bound, floor, how = zip(*flights, strict=True)
    told = [np.stack(column, axis=1) for column in (states, vertices, bound, floor)]
    return Truth(scene.rows, *told, how=" / ".join(dict.fromkeys(how)))


def _flight(mp: Any, scene: Scene, row: int) -> tuple[Array, Array, Array, Array, str]:
    """Return states (R, 13), vertices (R, n, 3), bound (R,) and floor (R,) of one throw, and how it was made."""
    answer = _closed(mp, scene, row) if scene.is_free else _integrated(mp, scene, row)
    mp.prec = answer.flight.bits
    states = np.array([_state(mp, pose) for pose in answer.flight.poses])
    _follow_sign(states[:, 3:7], scene.start[row, 3:7])
    points = exact_numbers(scene.body.points)
    vertices = np.array([_vertices(pose, points, answer.flight.bits) for pose in answer.flight.poses])
    rounding = np.linalg.norm(np.spacing(np.abs(vertices)) / 2, axis=-1).max(axis=-1)
    return states, vertices, answer.error + rounding, answer.floor, answer.how


def _closed(mp: Any, scene: Scene, row: int) -> Answer:
    rougher, finer = settle(mp, read_throw(scene, row))
    error = own_error(rougher, finer, scene.body.points)
    return Answer(finer, error, input_floor(mp, scene, row, rougher), "exact")


def _integrated(mp: Any, scene: Scene, row: int) -> Answer:
    # It is compiled, by a compiler that a free flight need not load.
    from scenarios.truth import forced

    try:
        return forced.answer(mp, scene, row)
    except forced.Unending as why:
        raise NoTruth(f"the true flight cannot be told: {why}") from why


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
