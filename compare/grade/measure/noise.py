"""The noise of rows, from the rows alone: high differences of neighbouring rows leave noise of a smooth motion.

Rows may be missing, as in a subsample: so the differences are divided ones, times a factor that leaves the variance of
white noise as it is (Stoer and Bulirsch, "Introduction to Numerical Analysis" (2002), section 2.1.3).
"""

from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from tumble.scenarios.frames import Array

# The order of the differences: of the centre, which few forces move, of rows between many impulses and of others; and
# of vertices, which rotate as well.  The fewest numbers that show noise.
OF_CENTRE, OF_VERTICES, FEWEST = (4, 8), 8, 12
# Intervals that differ by less than this share are equal.  No difference spans one of more row intervals.
EQUAL, LONGEST = 1e-4, 3
# Rows between which a body turns further [rad] look like noise.
LARGEST_TURN = 1.0
# Differences beyond this many medians are of an event, such as an impact.
OUTLIER = 6.0
# One plus the correlation of neighbouring differences, over that of white noise: noise and some motion have a higher
# one, and rows that are half a turn apart 0.
LEAST, MOST = 0.36, 2.7
# Noise is a third along the motion; of rows that show the physics at other times, as between its ticks, nearly all is.
ALONG = 0.9
# Rounding of what vertices make, over the size of the body, or over its distance.
NEARLY, ROUNDING = 1e-9, 1e-12
# A squared distance that is as good as 0 [m2].
TINY = 1e-300
# No rounding.  The share of the differences, those that rounding moves least, and by how much more it moves others that
# show noise as well.
NO_FLOORS, FINEST, COARSER = np.zeros(3), 0.25, 2.0
# The standard deviation of normal deviations, over the median of their sizes.
OF_MEDIAN = 1.4826


def white_noise_m(
    times: Array,
    vertices: Array,
    points: Array,
    events: Array,
    rounding_s: float = 0.0,
    are_independent: bool = False,
    floors_m: Array = NO_FLOORS,
) -> float:
    """Return the standard deviation of a coordinate's white noise [m], 0 where rows do not show any but rounding.

    times [s], (S,); vertices [m], (S, K, 3); points: the vertices from the centre of mass, axes of the body [m],
    (K, 3); events: times of impulses [s], which no difference spans; rounding_s: of times; are_independent: each vertex
    was measured, so the noise of their mean is smaller; floors_m: rounding of rows along each axis, (S, 3): noise shows
    where it is small.
    """
    steps = np.diff(times)
    if len(steps) < FEWEST or not steps.min() > 0.0:
        return 0.0
    times, broken = _in_intervals(times, events, rounding_s)
    shares, is_centre = _shares_of_centre(points)
    is_fast = _turn(vertices) > LARGEST_TURN
    centre, larger = np.einsum("k,skj->sj", shares, vertices)[:, None], 1.0
    if are_independent:
        larger = 1.0 / float(np.linalg.norm(shares))
    least_m = ROUNDING * float(np.abs(vertices).max())
    squares = np.broadcast_to(np.square(floors_m), (len(times), 3))
    for order in OF_CENTRE if is_centre or not is_fast else ():
        noise_m, rounding_m = _noise_of(times, centre, squares, broken, order)
        if noise_m > least_m:
            return larger * noise_m if larger * noise_m > rounding_m else 0.0
    # A centre that shows no noise beside its motion, or beside ticks between rows, hides that of vertices.
    is_hidden = is_centre and _differences(times, centre, squares, broken, OF_VERTICES).median > least_m
    if is_fast or is_hidden:
        return 0.0
    noise_m, rounding_m = _noise_of(times, vertices, squares, broken, OF_VERTICES)
    return noise_m if noise_m > rounding_m else 0.0


def most_noise_m(times: Array, vertices: Array, points: Array, events: Array, rounding_s: float = 0.0) -> float:
    """Return what the standard deviation of white noise is at most [m], whatever the motion; inf if rows are too few.

    times, vertices, points, events, rounding_s: as in `white_noise_m`.
    """
    shares, is_centre = _shares_of_centre(points)
    if not is_centre or not np.diff(times).min(initial=np.inf) > 0.0:
        return np.inf
    times, broken = _in_intervals(times, events, rounding_s)
    order, centre = OF_CENTRE[0], np.einsum("k,skj->sj", shares, vertices)[:, None]
    if len(times) <= order + 1:
        return np.inf
    found = _differences(times, centre, np.zeros((len(times), 3)), broken, order)
    return OF_MEDIAN * found.median if found.kept.sum() >= FEWEST else np.inf


def _in_intervals(times: Array, events: Array, rounding_s: float) -> tuple[Array, np.ndarray]:
    """Return times in row intervals from the first one, (S,), and the intervals that no difference spans, (S - 1,)."""
    steps = np.diff(times)
    counts = np.rint(steps / steps.min())
    usual = float(np.median(steps / counts))
    broken = (np.abs(steps - counts * usual) > EQUAL * usual + 2 * rounding_s) | (counts > LONGEST)
    broken |= np.isin(np.arange(len(steps)), np.searchsorted(times, events) - 1)
    return np.concatenate(([0.0], np.cumsum(counts))), broken


def _shares_of_centre(points: Array) -> tuple[Array, bool]:
    """Return the shares of vertices that make the centre of mass, (K,), or else their mean; and whether they do."""
    equations = np.vstack((points.T, np.ones(len(points))))
    wanted = np.array((0.0, 0.0, 0.0, 1.0))
    shares = np.array(np.linalg.lstsq(equations, wanted)[0], dtype=float)
    is_centre = np.abs(equations @ shares - wanted).max() < NEARLY * max(1.0, np.abs(points).max())
    return shares if is_centre else np.full(len(points), 1.0 / len(points)), bool(is_centre)


def _turn(vertices: Array) -> float:
    """Return how far the vertices, (S, K, 3), usually turn from one row to the next [rad], up to 2."""
    levers = vertices - vertices.mean(axis=1, keepdims=True)
    sizes = np.sqrt(np.square(levers[1:]).sum(axis=(1, 2)))
    moves = np.sqrt(np.square(np.diff(levers, axis=0)).sum(axis=(1, 2)))
    return float(np.median(moves / np.maximum(sizes, TINY)))


class Differences(NamedTuple):
    """Divided differences of places.

    factors: (W, O + 1); places: as far as they count beside rounding [m], (W, K, 3); median: of their sizes, and
    rounding: of what rows are written with, of those that rounding moves least [m]; kept: which count, (W,).
    """

    factors: Array
    places: Array
    median: float
    rounding: float
    kept: np.ndarray


def _differences(times: Array, places: Array, squares: Array, broken: np.ndarray, order: int) -> Differences:
    """Return the differences of an order of places, (S, K, 3).

    squares: of the rounding of rows along each axis [m2], (S, 3); broken: intervals that no difference spans, (S - 1,).
    """
    spans = np.convolve(broken, np.ones(order), "valid") == 0
    windows = sliding_window_view(times, order + 1)
    factors = 1.0 / (windows[:, :, None] - windows[:, None] + np.eye(order + 1)).prod(axis=2)
    factors /= np.linalg.norm(factors, axis=1)[:, None]
    differences = np.einsum("wo,wkio->wki", factors, sliding_window_view(places, order + 1, axis=0))
    if not spans.any():
        return Differences(factors, differences, 0.0, 0.0, spans)
    rounding = np.sqrt(np.einsum("wo,wio->wi", np.square(factors), sliding_window_view(squares, order + 1, axis=0)))
    fine = rounding <= COARSER * np.quantile(rounding[spans], FINEST)
    fine &= spans[:, None]
    median = float(np.median(np.abs(np.swapaxes(differences, 1, 2)[fine])))
    if median > 0.0:  # differences that rounding moves further say as much over what moves them
        differences /= np.hypot(1.0, rounding / (OF_MEDIAN * median))[:, None]
    kept = spans & (np.abs(differences).max(axis=(1, 2)) <= OUTLIER * OF_MEDIAN * median)
    return Differences(factors, differences, median, float(np.sqrt(3.0) * np.median(rounding[fine])), kept)


def _noise_of(times: Array, places: Array, squares: Array, broken: np.ndarray, order: int) -> tuple[float, float]:
    """Return the standard deviation of white noise in places [m], (S, K, 3), or 0; and their rounding there [m].

    squares, broken: as in `_differences`.
    """
    if len(places) <= order + 1:
        return 0.0, 0.0
    factors, differences, median, rounding_m, kept = _differences(times, places, squares, broken, order)
    pairs = kept[:-1] & kept[1:]
    before, after = differences[:-1][pairs], differences[1:][pairs]
    size = float(np.linalg.norm(before) * np.linalg.norm(after))
    if len(before) < FEWEST or not size > 0.0:
        return 0.0, 0.0
    middle = order // 2  # where a difference has most of its weight
    moved = (places[middle + 1 :][: len(kept)] - places[middle - 1 :][: len(kept)])[kept]
    along = np.square((differences[kept] * moved).sum(axis=2)) / np.maximum(np.square(moved).sum(axis=2), TINY)
    if along.sum() > ALONG * np.square(differences[kept]).sum():
        return 0.0, 0.0
    white = float((factors[:-1, 1:] * factors[1:, :-1]).sum(axis=1)[pairs].mean())
    share = (1.0 + float((before * after).sum()) / size) / (1.0 + white)
    return (OF_MEDIAN * median, rounding_m) if LEAST <= share <= MOST else (0.0, 0.0)
