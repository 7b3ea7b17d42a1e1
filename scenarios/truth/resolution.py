"""How far a truth can be trusted, and how far a program in doubles can be held to it."""

from collections.abc import Sequence
from random import Random
from typing import Any, NamedTuple

import numpy as np

from tumble.scenarios.frames import Array
from tumble.scenarios.scene import Scene
from tumble.scenarios.truth.flight import Pose, poses
from tumble.scenarios.truth.inertia import Numbers, Principal, principal
from tumble.scenarios.truth.mpfr import in_mpfr
from tumble.scenarios.truth.rational import Fraction
from tumble.scenarios.truth.throw import Throw, changing, read_throw

# The first, 33 digits, can lose the eleven that 1e11 radians cost; the last is for what no double can follow.
PRECISIONS = (112, 168, 252, 378, 567, 850, 1275, 1913, 2869, 4304)  # bits
# Agreement that leaves the rounding to doubles, 2^-53, nothing to do with the truth's own error.
AGREEMENT = 2.0**-75
# A truth that is not known to this share of the body's size, and this share of its distance, is none.
TRUSTED, FAR = 1e-6, 1e-12
PATTERNS = 8
# The changes that a derivative is taken from, in half last bits: much beyond what doubles round, still in proportion.
SHARES = 2.0**23, 2.0**11
# What a smaller change, of the opposite sign, is made with to see that the effect is in proportion.
OPPOSITE = -0.125
# How unequal the effects may then be, and what share of the body's size they may move it.
PROPORTIONAL, SMALL = 0.1, 1e-3


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
    input_error: Array
    how: str
    why: str = ""


def settle(mp: Any, throw: Throw) -> tuple[Flight, Flight]:
    """Return the flight at two precisions that agree, or the last two there are: the rougher, then the finer.

    So the precision rises by itself with whatever costs digits: radians turned, the separatrix, extreme moments.
    The finer is the answer, the rougher tells how good it is.
    """
    rougher, finer = closed_form(mp, throw, PRECISIONS[0]), closed_form(mp, throw, PRECISIONS[1])
    for bits in PRECISIONS[2:]:
        if all(_agree(rough, fine) for rough, fine in zip(rougher.poses, finer.poses, strict=True)):
            break
        rougher, finer = finer, closed_form(mp, throw, bits)
    return rougher, finer


def closed_form(mp: Any, throw: Throw, bits: int) -> Flight:
    """Return the flight of a body that nothing pulls but gravity and blows, with that many bits."""
    mp.prec = bits
    return Flight(bits, in_mpfr(poses, mp, throw, principal(mp, throw.solid.tensor)))


def _agree(rough: Pose, fine: Pose) -> bool:
    turned, w_off = abs(fine.axes - rough.axes), abs(fine.w_world - rough.w_world)
    return bool(turned.max() <= AGREEMENT and w_off.max() <= AGREEMENT * abs(fine.w_world).max())


def own_error(rougher: Flight, finer: Flight, points: Array) -> Array:
    """Return how far the vertices of the rougher flight are from the finer's [m], (R,): more than the finer's error.

    points: file axes [m], (n, 3).
    """
    turned = [fine.axes - rough.axes for rough, fine in zip(rougher.poses, finer.poses, strict=True)]
    return np.linalg.norm(points @ np.swapaxes(np.array(turned, dtype=float), 1, 2), axis=-1).max(axis=-1)


def rounding(vertices: Array) -> Array:
    """Return what telling vertices, (..., n, 3), in doubles costs, the worst vertex [m], (...)."""
    return np.linalg.norm(np.spacing(np.abs(vertices)) / 2, axis=-1).max(axis=-1)


def input_error_of(mp: Any, scene: Scene, row: int, throw: Throw, plain: Flight) -> Array:
    """Return how far the vertices move when every number of the scene is changed by half its last bit [m], (R,).

    The change is what reading a decimal into a double may do: no program in doubles can be held to less.  It goes
    to each number that the file has, each with its own sign, and to the clock (0.1 s is no double either).  Zeros stay
    zeros.  A sign pattern moves a vertex by the sum of the numbers' own effects, randomly signed, whose mean square
    over all patterns is the sum of their squares.  Of such sums, if normal, the largest of eight lies between 1 and 2.7
    times the root mean square in nine cases of ten; eight more flights would raise its median by a sixth.

    It is a derivative: the difference of flights in doubles for changes of many times as much, over that.
    Where the difference is no derivative, the flights are made with the digits of the plain one.
    """
    readings = [Reading(scene, row, pattern) for pattern in range(PATTERNS)]
    for share in SHARES:
        try:
            moved = _derivative(mp, throw, readings, share)
        except (ArithmeticError, ValueError):  # numbers that leave the range of doubles
            continue
        if moved is not None:
            return moved
    others = [changed(1.0) for changed in readings]
    moves = [_moved(plain, closed_form(mp, other, plain.bits), throw, other) for other in others]
    return np.maximum.reduce(moves)[:, 0]


class Reading(NamedTuple):
    """The throw with every number changed, by the signs of one pattern."""

    scene: Scene
    row: int
    pattern: int

    def __call__(self, share: float) -> Throw:
        """Return the throw for changes of a share of half the last bits."""
        return read_throw(self.scene, self.row, changing(Random(self.pattern), share))


def _derivative(mp: Any, throw: Throw, readings: list[Reading], share: float) -> Array | None:
    """Return the largest moves for half the last bits [m], (R,); None where those for a share are not in proportion."""
    plain = _in_doubles(mp, throw)

    def moves(reading: Reading, share: float) -> Array:
        changed = reading(share)
        return _moved(plain, _in_doubles(mp, changed), throw, changed) / abs(share)

    there, back = moves(readings[0], share), moves(readings[0], OPPOSITE * share)
    far = np.abs([pose.x.astype(float) for pose in plain.poses]).max(axis=1)
    if not in_proportion(there, back, share, throw.points.astype(float), far).all():
        return None
    found = np.maximum.reduce([there, *(moves(reading, share) for reading in readings[1:])])[:, 0]
    return found if np.isfinite(found).all() else None  # not where doubles were left, as a denormal's changes may do


def in_proportion(there: Array, back: Array, share: float, points: Array, far: Array) -> Array:
    """Return whether moves of the vertices over the share of half last bits that made them are a derivative, (R,).

    there, back: for changes of opposite signs, as they are and about the centre [m], (R, 2); points: (n, 3);
    far: how far away the body is [m], (R,).  Moves that are no longer small against the body may be alike for opposite
    signs, and tell nothing.  The centre of one that is far away moves by more; how it turns may not hide behind that.
    """
    little = SMALL * np.linalg.norm(points, axis=1).max()
    small = share * there <= little + np.outer(share * 2.0**-50 * far, (1, 0))
    even = abs(there - back) <= PROPORTIONAL * np.maximum(there, back)[:, :1]
    return (small & even).all(axis=1)


def doubles(mp: Any, throw: Throw) -> tuple[Any, Principal]:
    """Return mpmath's context of doubles and the throw's principal axes in it."""
    from mpmath import fp

    mp.prec = PRECISIONS[0]
    own = principal(mp, throw.solid.tensor)
    if not isinstance(own.axes[0, 0], Fraction):
        own = Principal(own.moments, own.axes.astype(float))
    return fp, own


def _in_doubles(mp: Any, throw: Throw) -> Flight:
    """Return the flight by the same closed form in doubles, which take a tenth of the time.

    Raises ArithmeticError where numbers leave their range.
    """
    context, own = doubles(mp, throw)
    with np.errstate(invalid="raise"):
        return Flight(53, poses(context, throw, own))


def _moved(plain: Flight, changed: Flight, throw: Throw, other: Throw) -> Array:
    """Return the largest move of a vertex, as it is and about the centre [m], (R, 2)."""
    return movements(plain.poses, changed.poses, throw.points, other.points)


def movements(poses: Sequence[Pose], changed: Sequence[Pose], points: Numbers, changed_points: Numbers) -> Array:
    """Return the largest move of a vertex from pose to pose, as it is and about the centre [m], (R, 2).

    It is subtracted in exact numbers, then measured in doubles.
    """
    pairs = list(zip(poses, changed, strict=True))
    x, x_changed = (np.array([pair[n].x for pair in pairs]).reshape(-1, 3) for n in (0, 1))
    axes, axes_changed = (np.array([pair[n].axes for pair in pairs]).reshape(-1, 3, 3) for n in (0, 1))
    turned, grown = (axes_changed - axes).astype(float), (changed_points - points).astype(float)
    about = points.astype(float) @ np.swapaxes(turned, 1, 2) + grown @ np.swapaxes(axes_changed.astype(float), 1, 2)
    moved = (x_changed - x).astype(float)[:, None] + about
    return np.linalg.norm((moved, about), axis=-1).max(axis=-1).T
