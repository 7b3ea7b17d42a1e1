"""How far a truth can be trusted, and how far a program in doubles can be held to it."""

from random import Random
from typing import Any, NamedTuple

import numpy as np

from scenarios.frames import Array
from scenarios.scene import Scene
from scenarios.truth.flight import Pose, fly
from scenarios.truth.inertia import Numbers
from scenarios.truth.throw import Throw, changing, read_throw

# The first, 33 digits, can lose the eleven that 1e11 radians cost; the last is for what no double can follow.
PRECISIONS = (112, 168, 252, 378, 567, 850, 1275, 1913, 2869, 4304)  # bits
# Agreement that leaves the rounding to doubles, 2^-53, nothing to do with the truth's own error.
AGREEMENT = 2.0**-75
PATTERNS = 8


class Flight(NamedTuple):
    """The poses of a throw, one a row, worked out with that many bits."""

    bits: int
    poses: list[Pose]


class Answer(NamedTuple):
    """A flight, how far its vertices may be off [m], (R,), how far inputs can move them [m], (R,), how it was made;

    and where it ends before the throw does, why: then there are fewer rows.
    """

    flight: Flight
    error: Array
    floor: Array
    how: str
    why: str = ""


def settle(mp: Any, throw: Throw) -> tuple[Flight, Flight]:
    """Return the flight at two precisions that agree, or the last two there are: the rougher, then the finer.

    So the precision rises by itself with whatever costs digits: radians turned, the separatrix, extreme moments.
    The finer is the answer, the rougher tells how good it is.
    """
    rougher, finer = _flight(mp, throw, PRECISIONS[0]), _flight(mp, throw, PRECISIONS[1])
    for bits in PRECISIONS[2:]:
        if all(_agree(rough, fine) for rough, fine in zip(rougher.poses, finer.poses, strict=True)):
            break
        rougher, finer = finer, _flight(mp, throw, bits)
    return rougher, finer


def _flight(mp: Any, throw: Throw, bits: int) -> Flight:
    mp.prec = bits
    return Flight(bits, fly(mp, throw))


def _agree(rough: Pose, fine: Pose) -> bool:
    turned, w_off = abs(fine.axes - rough.axes), abs(fine.w_world - rough.w_world)
    return bool(turned.max() <= AGREEMENT and w_off.max() <= AGREEMENT * abs(fine.w_world).max())


def own_error(rougher: Flight, finer: Flight, points: Array) -> Array:
    """Return how far the vertices of the rougher flight are from the finer's [m], (R,): more than the finer's error.

    points: file axes [m], (n, 3).
    """
    turned = [fine.axes - rough.axes for rough, fine in zip(rougher.poses, finer.poses, strict=True)]
    return np.linalg.norm(points @ np.swapaxes(np.array(turned, dtype=float), 1, 2), axis=-1).max(axis=-1)


def input_floor(mp: Any, scene: Scene, row: int, plain: Flight) -> Array:
    """Return how far the vertices move when every number of the scene is changed by a relative 2^-53 [m], (R,).

    The change is what reading a decimal into a double may do: no program in doubles can be held to less.  It goes
    to the start, mass, moments, points, gravity and impulses, each number with its own sign, and to the clock (0.1 s is
    no double either).  Zeros stay zeros.  A sign pattern moves a vertex by the sum of the numbers' own effects,
    randomly signed, whose mean square over all patterns is the sum of their squares.  Of such sums, if normal, the
    largest of eight lies between 1 and 2.7 times the root mean square in nine cases of ten; eight more flights would
    raise its median by a sixth.
    """
    points = read_throw(scene, row).points
    floor = np.zeros(len(plain.poses))
    for pattern in range(PATTERNS):
        throw = read_throw(scene, row, changing(Random(pattern)))
        changed = _flight(mp, throw, plain.bits)
        moved = [movement(*pair, points, throw.points) for pair in zip(plain.poses, changed.poses, strict=True)]
        floor = np.maximum(floor, moved)
    return floor


def movement(pose: Pose, changed: Pose, points: Numbers, changed_points: Numbers) -> float:
    """Return the largest move of a vertex [m]: subtracted in exact numbers, then measured in doubles."""
    x = (changed.x - pose.x).astype(float)
    turned = (changed.axes - pose.axes).astype(float)
    grown = (changed_points - points).astype(float)
    moves = x + points.astype(float) @ turned.T + grown @ changed.axes.astype(float).T
    return float(np.linalg.norm(moves, axis=-1).max())
