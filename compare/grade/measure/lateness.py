"""How late rows are, as their first interval shows: it is shorter than the motion that follows, or longer."""

from typing import NamedTuple

import numpy as np

from tumble.scenarios.frames import Array

# Rows through which a polynomial is laid, and degrees that are tried.
ROWS, DEGREES = 8, (2, 3, 4, 5)
# Floors by which rows may differ that do not move, and by which a row is off the motion that it is on.
RESTING = 4.0
# Times the error of a polynomial at a row that it does not know that a lateness must be.
CLEARLY = 5.0
# Share of the way from a place to the first row of a motion by which it may be off that motion.
OFF = 0.1
# Share of a row interval that a lateness is at least: the force of a first step moves a body by less.
LEAST = 0.03
# Iterations for the time at which a polynomial is nearest to a place.
ITERATIONS = 8


class Lateness(NamedTuple):
    """By how much rows are late, negative if they are early, and how exactly that is known [s]."""

    seconds: float
    error: float


def lateness(times: Array, vertices: Array, true: Array, floors_m: Array) -> Lateness | None:
    """Return by how much rows are late or early; None if the first ones do not show that, or the true ones do as well.

    The rows after the first one are extrapolated to the first place, in time; so are those after the two next ones to
    these, where the answer is known.  times [s], (S,); vertices and true: in the file and of the scene [m], (S, K, 3);
    floors_m: of the rows' axes, (S, 3).
    """
    with np.errstate(all="ignore"):  # a run that diverged
        found = _shown(times, vertices, true[0], floors_m) if times[0] == 0.0 else None
        # An impulse of the scene in the first interval looks like late rows.
        return None if found is None or _shown(times, true, true[0], floors_m) else found


def _shown(times: Array, vertices: Array, start: Array, floors_m: Array) -> Lateness | None:
    """Return by how much rows, (S, K, 3), seem to be late or early; start: [m], (K, 3)."""
    rests = np.abs(vertices - vertices[0]).max(axis=1) <= RESTING * floors_m
    first = int(np.argmin(rests.all(axis=1)))  # the first row that has moved
    if not first or len(times) < first + ROWS:
        return None
    late, early = _of_all(times, vertices, first, vertices[0]), _of_all(times, vertices, 0, start)
    least = LEAST * float(times[1] - times[0])
    if late and least < late.seconds <= times[first]:
        return late
    return early if early and early.seconds < -least else None


def first_motion(times: Array, vertices: Array, true: Array, floors_m: Array) -> tuple[float, float] | None:
    """Return the rows between which a body begins to move, [s], that should move from the start on; None if it does.

    times [s], (S,); vertices and true: in the file and of the scene [m], (S, K, 3); floors_m: (S, 3).
    """

    def first_moved(places: Array) -> int:
        moved = np.square((places - places[0]) / floors_m[:, None]).mean(axis=(1, 2))
        return int(np.argmax(moved > RESTING**2))

    with np.errstate(all="ignore"):  # a run that diverged
        first, right = first_moved(vertices), first_moved(true)
    is_late = times[0] == 0.0 and right == 1 < first
    return (float(times[first - 1]), float(times[first])) if is_late else None


def _of_all(times: Array, vertices: Array, first: int, place: Array) -> Lateness | None:
    """Return when all vertices have been at a place; None if their centre was there at another time than the rest.

    A body that does not rotate may as well have moved at another velocity at first.
    """
    found, turned = (
        _met(times, each, first, at) for each, at in ((vertices, place), (_spread(vertices), _spread(place)))
    )
    if not (found and turned) or abs(found.seconds - turned.seconds) > CLEARLY * (found.error + turned.error):
        return None
    return found


def _spread(vertices: Array) -> Array:
    """Return vertices, (..., K, 3), from their centre."""
    return vertices - vertices.mean(axis=-2, keepdims=True)


def _met(times: Array, vertices: Array, first: int, place: Array) -> Lateness | None:
    """Return when the motion of some rows has been at a place, counted from the first row; None if that is unclear."""
    places, place = vertices.reshape(len(vertices), -1), place.ravel()
    rows, found = slice(first, first + ROWS), list[tuple[float, float, float]]()
    for degree in DEGREES:
        errors = []
        for known in (first, first + 1):
            rest = slice(known + 1, rows.stop)
            errors.append(_nearest(times[rest], places[rest], degree, places[known])[0] - times[known])
        seconds, off = _nearest(times[rows], places[rows], degree, place)
        found.append((float(np.abs(errors).max()), float(seconds - times[0]), off))
    error, seconds, off = min(found)
    return Lateness(seconds, error) if abs(seconds) > CLEARLY * error and off < OFF else None


def _nearest(times: Array, places: Array, degree: int, place: Array) -> tuple[float, float]:
    """Return when a polynomial through places is nearest to another one before, and how far off, as a share of the way.

    The way is that from the first of the places.
    """
    scale, seconds = float(np.ptp(times)), 0.0
    polynomial = np.polynomial.polynomial.polyfit((times - times[0]) / scale, places, degree)
    slope = np.polynomial.polynomial.polyder(polynomial)
    for _ in range(ITERATIONS):
        at, speed = (np.polynomial.polynomial.polyval(seconds, each) for each in (polynomial, slope))
        squared = float(speed @ speed)
        seconds += float(speed @ (place - at)) / squared if squared else 0.0
        seconds = min(max(seconds, -1.0), 1.0)
    at = np.polynomial.polynomial.polyval(seconds, polynomial)
    way = float(np.linalg.norm(place - places[0]))
    return float(times[0] + seconds * scale), float(np.linalg.norm(place - at)) / way if way else np.inf
