"""The noise of rows, from the rows alone: high differences of neighbouring rows leave noise of a smooth motion.

Source: Press et al., "Numerical Recipes" (2007), on differences; the variance of the k-th difference of white noise is
binomial(2k, k) times its own, and neighbouring ones have a correlation of -k/(k + 1).
"""

from math import comb, sqrt

import numpy as np

from tumble.scenarios.frames import Array

# The order of the differences: of the centre, which few forces move, of rows between many impulses and of others; and
# of vertices, which rotate as well.  The fewest numbers that show noise.
OF_CENTRE, OF_VERTICES, FEWEST = (4, 8), 8, 12
# Intervals that differ by less than this share are equal.
EQUAL = 1e-4
# Differences beyond this many medians are of an event, such as an impact.
OUTLIER = 6.0
# One plus the correlation of neighbouring differences, over that of white noise: noise and some motion have a higher
# one, and rows that are half a turn apart 0.
LEAST, MOST = 0.36, 2.7
# The standard deviation of normal deviations, over the median of their sizes.
OF_MEDIAN = 1.4826


def white_noise_m(
    times: Array, vertices: Array, events: Array, rounding_s: float = 0.0, are_independent: bool = False
) -> float:
    """Return the standard deviation of a coordinate's white noise [m], 0 where rows do not show any.

    times [s], (S,); vertices [m], (S, K, 3); events: times of impulses [s], which no difference spans; rounding_s: of
    times; are_independent: each vertex was measured, so the noise of their mean is smaller.
    """
    steps = np.diff(times)
    usual = float(np.median(steps)) if len(steps) else 0.0
    broken = np.abs(steps - usual) > EQUAL * usual + 2 * rounding_s
    broken |= np.isin(np.arange(len(steps)), np.searchsorted(times, events) - 1)
    centre, larger = vertices.mean(axis=1), sqrt(vertices.shape[1]) if are_independent else 1.0
    for order in OF_CENTRE:
        if noise_m := _noise_of(centre, broken, order):
            return larger * noise_m
    return _noise_of(vertices.reshape(len(times), -1), broken, OF_VERTICES)


def _noise_of(numbers: Array, broken: np.ndarray, order: int) -> float:
    """Return the standard deviation of white noise in columns of rows, (S, N), or 0; broken: intervals, (S - 1,)."""
    if len(numbers) <= order + 1:
        return 0.0
    spans = np.convolve(broken, np.ones(order), "valid") == 0
    differences = np.diff(numbers, order, axis=0)
    median = float(np.median(np.abs(differences[spans]))) if spans.any() else 0.0
    kept = spans & (np.abs(differences).max(axis=1) <= OUTLIER * OF_MEDIAN * median)
    pairs = kept[:-1] & kept[1:]
    before, after = differences[:-1][pairs], differences[1:][pairs]
    size = float(np.linalg.norm(before) * np.linalg.norm(after))
    if len(before) < FEWEST or not size > 0.0:
        return 0.0
    share = (1.0 + float((before * after).sum()) / size) * (order + 1)
    return OF_MEDIAN * median / sqrt(comb(2 * order, order)) if LEAST <= share <= MOST else 0.0
