"""The noise of rows, from the rows alone: high differences of neighbouring rows leave noise of a smooth motion.

Source: Press et al., "Numerical Recipes" (2007), on differences; the variance of the k-th difference of white noise is
binomial(2k, k) times its own, and neighbouring ones have a correlation of -k/(k + 1).
"""

from math import comb, sqrt

import numpy as np

from tumble.scenarios.frames import Array

# The order of the differences, and the fewest of them that show noise.
ORDER, FEWEST = 8, 12
# Intervals that differ by less than this share are equal.
EQUAL = 1e-4
# Differences beyond this many medians are of an event, such as an impact.
OUTLIER = 6.0
# Neighbouring differences of white noise have a correlation of -8/9, of noise and some motion a higher one, and those
# of rows that are half a turn apart -1.
CORRELATIONS = (-0.96, -0.7)
# The standard deviation of normal deviations, over the median of their sizes.
OF_MEDIAN = 1.4826


def white_noise_m(times: Array, vertices: Array, events: Array) -> float:
    """Return the standard deviation of a coordinate's white noise [m], 0 where rows do not show any.

    times [s], (S,); vertices [m], (S, K, 3); events: times of impulses [s], which no difference spans.
    """
    if len(times) < ORDER + FEWEST:
        return 0.0
    steps = np.diff(times)
    usual = float(np.median(steps))
    broken = np.abs(steps - usual) > EQUAL * usual
    broken |= np.isin(np.arange(len(steps)), np.searchsorted(times, events) - 1)
    spans = np.convolve(broken, np.ones(ORDER), "valid") == 0
    differences = np.diff(vertices.reshape(len(times), -1), ORDER, axis=0)
    sizes = np.abs(differences[spans])
    if len(sizes) < FEWEST:
        return 0.0
    median = float(np.median(sizes))
    kept = spans & (np.abs(differences).max(axis=1) <= OUTLIER * OF_MEDIAN * median)
    pairs = kept[:-1] & kept[1:]
    before, after = differences[:-1][pairs], differences[1:][pairs]
    size = float(np.linalg.norm(before) * np.linalg.norm(after))
    if len(before) < FEWEST or not size > 0.0:
        return 0.0
    low, high = CORRELATIONS
    if not low <= float((before * after).sum()) / size <= high:
        return 0.0
    return OF_MEDIAN * median / sqrt(comb(2 * ORDER, ORDER))
