"""The reference solution of a scene.

Free flight under gravity and impulses has a closed form, computed in extended precision: Jacobi functions by Landen's
steps, attitude by Carlson's integral.  `elliptic` has the functions, `rotation` the closed form, `flight` the whole
throw, `resolution` how accurate the answer is, and `bulk` is the same compiled, for many throws.  Scenes with a tether,
drag or a floor are integrated: `forced`.  All start from the file's numbers, in fractions: `throw` and `inertia`.
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
from tumble.scenarios.truth.rational import Fraction
from tumble.scenarios.truth.resolution import FAR, TRUSTED, Answer, input_error_of, own_error, rounding, settle
from tumble.scenarios.truth.throw import Throw, read_throw

if TYPE_CHECKING:
    from tumble.scenarios.truth.bulk.flight import Flights
    from tumble.scenarios.truth.contact.record import ContactRecord

# At least this many throws, or instants, take longer one by one than compiled code takes to load.
MANY, MANY_INSTANTS = 64, 400
# Instants computed together where the compiled loop has left some.
AT_A_TIME = 32

ShareCallback = Callable[[float], object]


class NoTruth(UserError):
    """The trajectory cannot be computed accurately enough to be a reference; the message says why."""


@dataclass(frozen=True, eq=False)
class Truth:
    """The reference solution of a scene: R instants of N throws.

    Rows that could not be computed are nan, and their bound is infinite.

    Parameters
    ----------
    times : (R,), s
        the scene's rows, each after its impulses
    states : (R, N, 13)
        each number the double nearest to the exact one
    vertices : (R, N, n, 3), m
        likewise, world axes
    bound : (R, N), m
        upper bound on a vertex's distance from the exact solution, rounding to doubles included
    input_error : (R, N), m
        how far a vertex moves when each number of the scene changes by half its last bit
    how
        exact, by the closed form, or the integration
    horizon : s
        last row up to which every throw is known to a millionth of the body, or to 1e-12 of its distance; infinite
        if all rows are
    why
        what ends it there
    contacts
        contact record of each throw, in scenes with a plane
    """

    times: Array
    states: Array
    vertices: Array
    bound: Array
    input_error: Array
    how: str
    horizon: float = np.inf
    why: str = ""
    contacts: "tuple[ContactRecord, ...]" = ()

    @property
    def identity(self) -> str:
        """What tells it from that of another scene: nothing but the scene, from which it follows."""
        return "truth"

    @property
    def resolution(self) -> Array:
        """The least error that can be told from none [m], (R, N)."""
        return np.maximum(self.bound, self.input_error)

    @property
    def known(self) -> int:
        """The number of rows within the horizon."""
        return int(np.searchsorted(self.times, self.horizon, side="right"))

    @property
    def ends(self) -> str:
        """The horizon and its reason, for a message; empty if there is none."""
        return "" if self.known == len(self.times) else f"; known until {self.horizon:.6g} s: {self.why}"

    def until_horizon(self) -> "Truth":
        """Return the rows that are within the horizon."""
        rows = {
            name: getattr(self, name)[: self.known] for name in ("times", "states", "vertices", "bound", "input_error")
        }
        return replace(self, **rows)


def truth(
    scene: Scene,
    with_input_error: bool = True,
    on_share: ShareCallback = lambda share: None,
    limit_s: float = float("inf"),
) -> Truth:
    """Return the reference solution of every throw of a scene.

    Parameters
    ----------
    scene
    with_input_error
        whether to compute `Truth.input_error`, most of the work of a free flight; otherwise it is 0
    on_share
        called with each share of the throws that is done
    limit_s : s
        wall time for each of its three parts: the solution, its check, the input error

    Returns
    -------
    truth

    Raises
    ------
    NoTruth
        No sample after the start can be computed, or none within limit_s.
    RayMissed
        An impulse's ray does not hit the body.
    """
    from mpmath import MPContext  # a tenth of a second that only this call should pay

    # A context of our own: whoever else uses mpmath keeps its precision.
    mp = MPContext()
    contacts: tuple[ContactRecord, ...] = ()
    try:
        with within(limit_s):
            if scene.plane is None:
                rows, how, why = _all_throws(mp, scene, with_input_error, on_share)
            else:
                from tumble.scenarios.truth.contact.answer import on_plane

                rows, how, why, contacts = on_plane(mp, scene, with_input_error, on_share)
    except Late:
        raise NoTruth(f"the truth was not computed within {PARTS * limit_s:g} s (--time-limit)") from None
    except OverflowError:
        raise NoTruth("there is no truth: its numbers leave the range of doubles") from None
    answer = Truth(scene.rows, *rows, how=" / ".join(dict.fromkeys(how)), contacts=contacts)
    return _until_horizon(answer, scene, " / ".join(dict.fromkeys(filter(None, why))))


def _all_throws(
    mp: Any, scene: Scene, with_input_error: bool, on_share: ShareCallback
) -> tuple[list[Array], list[str], list[str]]:
    """Return states, vertices, bound and input error of all throws, how they were computed and why some end."""
    many = _many(mp, scene, on_share)
    left = np.arange(len(scene.start)) if many is None else np.flatnonzero(np.isnan(many.input_error).any(axis=0))
    flights = []
    for row in left.tolist():
        current().check()
        flights.append(_flight(mp, scene, row, with_input_error))
        on_share(1 - (len(left) - len(flights)) / len(scene.start))
    *columns, how, why = map(list, zip(*flights, strict=True)) if flights else [[]] * 6
    stacked = [np.stack(column, axis=1) for column in columns if column]
    if many is None:
        return stacked, how, why
    for every, own in zip(many, stacked, strict=False):
        every[:, left] = own
    if not with_input_error:
        many.input_error[:] = 0.0
    return list(many), ["exact", *how], why


def _many(mp: Any, scene: Scene, on_share: ShareCallback) -> "Flights | None":
    """Return the throws of a free scene without impulses, if there are enough for compiled code, or None."""
    if not scene.is_free or scene.impulses or len(scene.start) < MANY:
        return None
    from tumble.scenarios.truth.bulk.flight import all_flights

    def report(share: float) -> None:
        current().check()
        on_share(share)

    return all_flights(mp, scene, report)


def _until_horizon(answer: Truth, scene: Scene, why: str) -> Truth:
    """Return the answer with its horizon.  Raises NoTruth where that lies before the first sample."""
    blurred = _blurred(scene, answer.vertices, answer.resolution).any(axis=1)
    if not blurred.any():
        return answer
    known = int(np.argmax(blurred))
    if not why or np.isfinite(answer.vertices[known]).all():
        why = "beyond it the last bit of a number of the scene moves a vertex by more than a millionth of the body"
    if known == 0 or answer.times[known - 1] < scene.times[0]:
        raise NoTruth(f"there is no truth at the first sample: {why}")
    return replace(answer, horizon=float(answer.times[known - 1]), why=why)


def _blurred(scene: Scene, vertices: Array, resolution: Array) -> np.ndarray:
    """Return where the resolution [m], (...), of vertices, (..., n, 3), is too coarse for a truth."""
    size = scene.body.reach
    return ~(resolution <= TRUSTED * size + FAR * np.abs(vertices).max(axis=(-2, -1)))


def _flight(mp: Any, scene: Scene, row: int, with_input_error: bool) -> tuple[Array, Array, Array, Array, str, str]:
    """Return states (R, 13), vertices (R, n, 3), bound and input error (R,) of one throw; how made, why it ends."""
    if scene.is_free and len(scene.rows) >= MANY_INSTANTS:
        from tumble.scenarios.truth.bulk.samples import one_flight

        if (found := one_flight(mp, scene, row)) is not None:
            return _completed(mp, scene, row, with_input_error, [column[:, 0] for column in found])
    return _one_by_one(mp, scene, row, with_input_error)


def _completed(mp: Any, scene: Scene, row: int, with_input_error: bool, columns: list[Array]) -> tuple:
    """Return a flight with the rows that the compiled loop has left, up to the first that is beyond the horizon."""
    left = np.flatnonzero(np.isnan(columns[3]))
    for first in range(0, len(left), AT_A_TIME):
        some = left[first : first + AT_A_TIME]
        part = _one_by_one(mp, replace(scene, times=scene.rows[some]), row, True)[:4]
        for every, own in zip(columns, part, strict=True):
            every[some] = own[-len(some) :]
        lost: np.ndarray = some[_blurred(scene, columns[1][some], np.maximum(columns[2][some], columns[3][some]))]
        if len(lost):
            for every, filling in zip(columns, (np.nan, np.nan, np.inf, np.inf), strict=True):
                every[left[left > lost[0]]] = filling
            break
    _follow_sign(columns[0][:, 3:7], scene.start[row, 3:7])
    if not with_input_error:
        columns[3][:] = 0.0
    return *columns, "exact", ""


def _one_by_one(mp: Any, scene: Scene, row: int, with_input_error: bool) -> tuple[Array, Array, Array, Array, str, str]:
    """Return the same, instant by instant."""
    throw = read_throw(scene, row)
    answer = _closed(mp, scene, row, throw, with_input_error) if scene.is_free else _integrated(mp, scene, row, throw)
    mp.prec = answer.flight.bits
    states = np.array([_state(mp, pose, throw.state_axes) for pose in answer.flight.poses])
    _follow_sign(states[:, 3:7], scene.start[row, 3:7])
    vertices = rounded_vertices(answer.flight.poses, throw.points, answer.flight.bits)
    bound = answer.error + rounding(vertices)
    parts = (states, np.nan), (vertices, np.nan), (bound, np.inf), (answer.input_error, np.inf)
    states, vertices, bound, moved = (_filled(*each, rows=len(throw.times)) for each in parts)
    return states, vertices, bound, moved, answer.how, answer.why


def _filled(values: Array, filling: float, rows: int) -> Array:
    """Return an array with rows of a number added."""
    return np.concatenate((values, np.full((rows - len(values), *values.shape[1:]), filling)))


def _closed(mp: Any, scene: Scene, row: int, throw: Throw, with_input_error: bool) -> Answer:
    rougher, finer = settle(mp, throw)
    error = own_error(rougher, finer, throw.points.astype(float))
    moved = input_error_of(mp, scene, row, throw, rougher) if with_input_error else np.zeros(len(error))
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


def rounded_vertices(poses: list[Pose], points: Numbers, bits: int) -> Array:
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
