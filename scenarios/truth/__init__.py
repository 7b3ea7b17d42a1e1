"""The true answer of a scene.

Free flight under gravity and impulses has a closed form, worked out in extended precision: Jacobi functions by Landen's
steps, attitude by Carlson's integral.  `elliptic` has the functions, `rotation` the closed form, `flight` the whole
throw, `limit` how good the answer is, and `bulk` is the same compiled, for many throws.  A flight with tether, drag or
floor is integrated: `forced`.  All start from the numbers as they are written, in fractions: `throw` and `inertia`.
None shares a formulation with the solver or an engine.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from tumble.scenarios.frames import Array
from tumble.scenarios.refusal import UserError
from tumble.scenarios.scene import Scene
from tumble.scenarios.truth.deadline import PARTS, Late, current, within
from tumble.scenarios.truth.flight import Pose, quaternion
from tumble.scenarios.truth.inertia import Numbers
from tumble.scenarios.truth.limit import FAR, TRUSTED, Answer, input_floor, own_error, rounding, settle
from tumble.scenarios.truth.rational import Fraction
from tumble.scenarios.truth.throw import Throw, read_throw

if TYPE_CHECKING:
    from tumble.scenarios.truth.bulk.flight import Flights
    from tumble.scenarios.truth.contact.record import ContactRecord

# So many throws take longer one by one than compiled code takes to load.
MANY, MANY_INSTANTS = 64, 400
# Instants worked out together where the compiled loop has left some.
AT_A_TIME = 32

Tell = Callable[[float], object]


class NoTruth(UserError):
    """The flight cannot be told well enough to hold anything against it; the text says why."""


@dataclass(frozen=True, eq=False)
class Truth:
    """Where the body truly is, R instants of N throws.

    times: instants [s], (R,), the scene's rows, each after its impulses;
    states: (R, N, 13), each number the double nearest to the exact one; vertices: world [m], (R, N, n, 3), likewise;
    bound: how far a vertex may be from the exact answer, its rounding to doubles included [m], (R, N);
    floor: how far a vertex moves when each number of the scene moves by half its last bit [m], (R, N);
    how: exact, by the closed form, or by which integration;
    horizon: until when every throw is known to a millionth of the body, or to 1e-12 of its distance [s]: the last such
    row, infinite where all are; why: what ends it.  Rows that could not be worked out are nan, their bound infinite.
    contacts: what each throw of a scene with a plane does there.
    """

    times: Array
    states: Array
    vertices: Array
    bound: Array
    floor: Array
    how: str
    horizon: float = np.inf
    why: str = ""
    contacts: "tuple[ContactRecord, ...]" = ()

    @property
    def limit(self) -> Array:
        """The least error that can be told from none [m], (R, N)."""
        return np.maximum(self.bound, self.floor)

    @property
    def known(self) -> int:
        """How many rows, from the first on, are within the horizon."""
        return int(np.searchsorted(self.times, self.horizon, side="right"))

    @property
    def ends(self) -> str:
        """What to say where there is a horizon."""
        return "" if self.known == len(self.times) else f"; known until {self.horizon:.6g} s: {self.why}"

    def until_horizon(self) -> "Truth":
        """Return the rows that are within the horizon."""
        rows = {name: getattr(self, name)[: self.known] for name in ("times", "states", "vertices", "bound", "floor")}
        return replace(self, **rows)


def truth(scene: Scene, floor: bool = True, tell: Tell = lambda share: None, limit_s: float = float("inf")) -> Truth:
    """Return the true flight of every throw of the scene.

    floor: whether to find how far rounded inputs move it, which is most of the work of a free flight; else it is 0;
    tell: is told again and again what share of the throws is done; limit_s: wall time that each of its
    three parts may take [s], the answer, its check, and what the inputs do.
    Raises NoTruth where not one sample after the start can be told, or not within that time, RayMissed where an
    impulse's ray does not meet the body.
    """
    from mpmath import MPContext  # a tenth of a second that only this call should pay

    # A context of our own: whoever else uses mpmath keeps its precision.
    mp = MPContext()
    contacts: tuple[ContactRecord, ...] = ()
    try:
        with within(limit_s):
            if scene.plane is None:
                told, how, why = _told(mp, scene, floor, tell)
            else:
                from tumble.scenarios.truth.contact.answer import on_plane

                told, how, why, contacts = on_plane(mp, scene, floor, tell)
    except Late:
        raise NoTruth(f"the true flight was not worked out within {PARTS * limit_s:g} s (--time-limit)") from None
    except OverflowError:
        raise NoTruth("the true flight cannot be told: its numbers leave the range of doubles") from None
    answer = Truth(scene.rows, *told, how=" / ".join(dict.fromkeys(how)), contacts=contacts)
    return _until_horizon(answer, scene, " / ".join(dict.fromkeys(filter(None, why))))


def _told(mp: Any, scene: Scene, floor: bool, tell: Tell) -> tuple[list[Array], list[str], list[str]]:
    """Return states, vertices, bound and floor of all throws, how they were made and why some end."""
    many = _many(mp, scene, tell)
    left = np.arange(len(scene.start)) if many is None else np.flatnonzero(np.isnan(many.floor).any(axis=0))
    flights = []
    for row in left.tolist():
        current().check()
        flights.append(_flight(mp, scene, row, floor))
        tell(1 - (len(left) - len(flights)) / len(scene.start))
    *columns, how, why = map(list, zip(*flights, strict=True)) if flights else [[]] * 6
    told = [np.stack(column, axis=1) for column in columns if column]
    if many is None:
        return told, how, why
    for every, own in zip(many, told, strict=False):
        every[:, left] = own
    if not floor:
        many.floor[:] = 0.0
    return list(many), ["exact", *how], why


def _many(mp: Any, scene: Scene, tell: Tell) -> "Flights | None":
    """Return the throws of a free scene without blows, where they are so many that compiled code pays, or None."""
    if not scene.is_free or scene.impulses or len(scene.start) < MANY:
        return None
    from tumble.scenarios.truth.bulk.flight import all_flights

    def told(share: float) -> None:
        current().check()
        tell(share)

    return all_flights(mp, scene, told)


def _until_horizon(answer: Truth, scene: Scene, why: str) -> Truth:
    """Return the answer with its horizon.  Raises NoTruth where that lies before the first sample."""
    blurred = _blurred(scene, answer.vertices, answer.limit).any(axis=1)
    if not blurred.any():
        return answer
    known = int(np.argmax(blurred))
    if not why or np.isfinite(answer.vertices[known]).all():
        why = "beyond it the last bit of a number of the scene moves a corner by more than a millionth of the body"
    if known == 0 or answer.times[known - 1] < scene.times[0]:
        raise NoTruth(f"the true flight cannot be told at its first sample: {why}")
    return replace(answer, horizon=float(answer.times[known - 1]), why=why)


def _blurred(scene: Scene, vertices: Array, limit: Array) -> np.ndarray:
    """Return where a limit [m], (...), of vertices, (..., n, 3), is more than a truth may have."""
    size = scene.body.reach
    return ~(limit <= TRUSTED * size + FAR * np.abs(vertices).max(axis=(-2, -1)))


def _flight(mp: Any, scene: Scene, row: int, floor: bool) -> tuple[Array, Array, Array, Array, str, str]:
    """Return states (R, 13), vertices (R, n, 3), bound and floor (R,) of one throw; how it was made and why it ends."""
    if scene.is_free and len(scene.rows) >= MANY_INSTANTS:
        from tumble.scenarios.truth.bulk.samples import one_flight

        if (found := one_flight(mp, scene, row)) is not None:
            return _completed(mp, scene, row, floor, [column[:, 0] for column in found])
    return _one_by_one(mp, scene, row, floor)


def _completed(mp: Any, scene: Scene, row: int, floor: bool, told: list[Array]) -> tuple:
    """Return a flight with the rows that the compiled loop has left, up to the first that is beyond the horizon."""
    left = np.flatnonzero(np.isnan(told[3]))
    for first in range(0, len(left), AT_A_TIME):
        some = left[first : first + AT_A_TIME]
        part = _one_by_one(mp, replace(scene, times=scene.rows[some]), row, True)[:4]
        for every, own in zip(told, part, strict=True):
            every[some] = own[-len(some) :]
        lost: np.ndarray = some[_blurred(scene, told[1][some], np.maximum(told[2][some], told[3][some]))]
        if len(lost):
            for every, filling in zip(told, (np.nan, np.nan, np.inf, np.inf), strict=True):
                every[left[left > lost[0]]] = filling
            break
    _follow_sign(told[0][:, 3:7], scene.start[row, 3:7])
    if not floor:
        told[3][:] = 0.0
    return *told, "exact", ""


def _one_by_one(mp: Any, scene: Scene, row: int, floor: bool) -> tuple[Array, Array, Array, Array, str, str]:
    """Return the same, instant by instant."""
    throw = read_throw(scene, row)
    answer = _closed(mp, scene, row, throw, floor) if scene.is_free else _integrated(mp, scene, row, throw)
    mp.prec = answer.flight.bits
    states = np.array([_state(mp, pose, throw.state_axes) for pose in answer.flight.poses])
    _follow_sign(states[:, 3:7], scene.start[row, 3:7])
    vertices = told_vertices(answer.flight.poses, throw.points, answer.flight.bits)
    bound = answer.error + rounding(vertices)
    told = (states, np.nan), (vertices, np.nan), (bound, np.inf), (answer.floor, np.inf)
    states, vertices, bound, moved = (_filled(*each, rows=len(throw.times)) for each in told)
    return states, vertices, bound, moved, answer.how, answer.why


def _filled(values: Array, filling: float, rows: int) -> Array:
    """Return an array with rows of a number added."""
    return np.concatenate((values, np.full((rows - len(values), *values.shape[1:]), filling)))


def _closed(mp: Any, scene: Scene, row: int, throw: Throw, floor: bool) -> Answer:
    rougher, finer = settle(mp, throw)
    error = own_error(rougher, finer, throw.points.astype(float))
    moved = input_floor(mp, scene, row, throw, rougher) if floor else np.zeros(len(error))
    return Answer(finer, error, moved, "exact")


def _integrated(mp: Any, scene: Scene, row: int, throw: Throw) -> Answer:
    # It is compiled, by a compiler that a free flight need not load.
    from tumble.scenarios.truth import forced

    return forced.answer(mp, scene, row, throw)


def _state(mp: Any, pose: Pose, state_axes: Numbers) -> Array:
    return np.concatenate((pose.x, quaternion(mp, pose.axes @ state_axes.T), pose.v, pose.w_world)).astype(float)


def _follow_sign(quaternions: Array, first: Array) -> None:
    """Of q and -q, which are one attitude, take in place the one nearer to the row before."""
    for before, q in zip((first, *quaternions), quaternions, strict=False):
        if before @ q < 0:
            q *= -1


def told_vertices(poses: list[Pose], points: Numbers, bits: int) -> Array:
    """Return x + R p, (R, n, 3), each number the nearest double: a sum of whole numbers, divided once."""
    whole, unit = np.vectorize(round, otypes=[object]), 2**bits
    # Points in units of the largest, axes of 1: all have that many bits.
    size = Fraction(2) ** max(point.numerator.bit_length() - point.denominator.bit_length() for point in points.flat)
    grains = whole(points * (unit / size))
    return np.array(
        [
            (grains @ whole(pose.axes * unit).T + whole(pose.x * (unit * unit / size))) / (unit * unit) * float(size)
            for pose in poses
        ],
        dtype=float,
    )
