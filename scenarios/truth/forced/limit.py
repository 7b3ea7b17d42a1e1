"""How far the answer of an integration can be trusted, and how far a program in doubles can be held to it.

The flight is made twice, by two collocations at two tolerances, and again for every change of the inputs.
"""

from fractions import Fraction
from random import Random
from typing import Any, NamedTuple

import numpy as np

from scenarios.frames import Array
from scenarios.scene import Scene
from scenarios.truth.flight import Pose
from scenarios.truth.forced.flight import Course, Unending, fly_course, read_course, solid_of
from scenarios.truth.forced.passage import Manner
from scenarios.truth.forced.radau import tableau
from scenarios.truth.limit import HALF_ULP, PATTERNS, Answer, Flight, changing, movement

# Of the numbers told: those of the two doubles that the integration keeps of each, and some for arithmetic.
BITS = 128
# Stages and tolerance of the answer, and of the rougher flight that tells how good it is.
FINE, ROUGH = (9, 1e-9), (7, 1e-8)
# With Newton's iteration steps can be so long that the order falls to that of the stages: the tolerance has to do more.
FINE_STIFF, ROUGH_STIFF = (9, 1e-11), (7, 1e-10)
MOST_STEPS, MOST_STIFF_STEPS = 100_000, 2_000
# The rounding of the two flights is of the same size and its own in each: the answer's is below twice their difference.
SAFETY = 2.0
# A truth that is not known to this share of the body's size is none.
TRUSTED = 1e-6
# The inputs are changed by much more than 2^-53, so that what comes of it stands out from rounding, and the effect is
# scaled down.  That is right while it is proportional, seen by turning the signs round: then it is turned round too.
CHANGES = (Fraction(1, 2**30), Fraction(1, 2**38), Fraction(1, 2**46))
PROPORTIONAL = 0.1


class Flights(NamedTuple):
    """The answer, and the rougher flight; whether they needed Newton's iteration."""

    finer: list[Pose]
    rougher: list[Pose]
    stiff: bool

    @property
    def how(self) -> str:
        """How they were made, in words."""
        (fine, tolerance), (rough, looser) = (FINE_STIFF, ROUGH_STIFF) if self.stiff else (FINE, ROUGH)
        orders = f"Radau collocation of orders {2 * fine - 1} and {2 * rough - 1}"
        return f"{orders}, tolerances {tolerance:g} and {looser:g}{', by Newton' if self.stiff else ''}"


def answer(mp: Any, scene: Scene, row: int) -> Answer:
    """Return one throw of a scene with forces.  Raises Unending, RayMissed."""
    mp.prec = BITS
    course = read_course(scene, row)
    flights = fly_twice(mp, course)
    error = integration_error(flights, course)
    if not (error <= TRUSTED * solid_of(course.throw).radius).all():
        raise Unending(f"two integrations of it are {error.max() / SAFETY:.2g} m apart")
    return Answer(Flight(BITS, flights.finer), error, input_floor(mp, scene, row, flights), flights.how)


def fly_twice(mp: Any, course: Course) -> Flights:
    """Fly the throw twice, plainly if that comes to an end, else by Newton's iteration.  Raises Unending, RayMissed."""
    try:
        return Flights(_fly(mp, course, FINE, False), _fly(mp, course, ROUGH, False), False)
    except Unending:
        return Flights(_fly(mp, course, FINE_STIFF, True), _fly(mp, course, ROUGH_STIFF, True), True)


def _fly(mp: Any, course: Course, how: tuple[int, float], stiff: bool) -> list[Pose]:
    stages, tolerance = how
    manner = Manner(tableau(stages), tolerance, MOST_STIFF_STEPS if stiff else MOST_STEPS)
    return fly_course(mp, course, manner, stiff or None)


def integration_error(flights: Flights, course: Course) -> Array:
    """Return how far a vertex of the answer may be from the truth [m], (R,): an error once made is never forgotten."""
    points = course.throw.points
    apart = [movement(*poses, points, points) for poses in zip(flights.rougher, flights.finer, strict=True)]
    return SAFETY * np.maximum.accumulate(apart)


def input_floor(mp: Any, scene: Scene, row: int, flights: Flights) -> Array:
    """Return how far the vertices move when every number of the scene is changed by a relative 2^-53 [m], (R,).

    The numbers, the signs and their patterns are those of `scenarios.truth.limit.input_floor`, and the forces' numbers.
    """
    change = next((change for change in CHANGES[:-1] if _is_proportional(mp, scene, row, flights, change)), CHANGES[-1])
    moves = [_moved(mp, scene, row, flights, pattern, change) for pattern in range(PATTERNS)]
    return np.maximum.reduce(moves) * float(HALF_ULP / change)


def _is_proportional(mp: Any, scene: Scene, row: int, flights: Flights, change: Fraction) -> bool:
    there, back = (_moved(mp, scene, row, flights, 0, signed) for signed in (change, -change))
    return bool((abs(there - back) <= PROPORTIONAL * there.max()).all())


def _moved(mp: Any, scene: Scene, row: int, flights: Flights, pattern: int, change: Fraction) -> Array:
    """Return how far the vertices move when every number is changed by that share [m], (R,)."""
    plain, changed = read_course(scene, row), read_course(scene, row, changing(Random(pattern), change))
    poses = _fly(mp, changed, ROUGH_STIFF if flights.stiff else ROUGH, flights.stiff)
    pairs = zip(flights.rougher, poses, strict=True)
    return np.array([movement(*pair, plain.throw.points, changed.throw.points) for pair in pairs])
