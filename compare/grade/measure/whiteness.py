"""Whether the residual of a series of rows is noise: no spikes, no correlation in time, no slow drift."""

from collections.abc import Sequence

import numpy as np

from tumble.scenarios.frames import Array

# A statistic of white noise exceeds this many standard deviations less than once in 10 000 files.
MOST_DEVIATIONS = 5.0
# Lags of the autocorrelation, and numbers of equal parts of the rows whose means are compared.
LAGS, PARTS = (1, 2, 3, 4, 5, 6, 8, 12), (4, 16, 64)
# The fewest rows that show it, and rows in a part.
FEWEST_ROWS, FEWEST_IN_PART = 24, 4
# Largest error over the root mean square of three axes.
SPIKE = 5.0


def is_white(errors: Array, runs: Sequence[slice]) -> bool:
    """Return whether errors, (N, 3), are white noise; runs: of neighbouring rows.

    Means of parts follow a chi-squared distribution, taken as normal by Wilson and Hilferty (PNAS 17 (1931) 684).
    """
    square = float((errors**2).mean())
    if len(errors) < FEWEST_ROWS or not square > 0.0:
        return False
    if np.linalg.norm(errors, axis=1).max() > SPIKE * np.sqrt(3.0 * square):
        return False
    return all(abs(each) <= MOST_DEVIATIONS for each in (*_correlations(errors, runs, square), *_drifts(errors)))


def _correlations(errors: Array, runs: Sequence[slice], square: float) -> list[float]:
    """Return the autocorrelation over each lag, in standard deviations of that of white noise."""
    found = []
    for lag in LAGS:
        pairs = [(errors[run][:-lag] * errors[run][lag:]).ravel() for run in runs if run.stop - run.start > lag]
        products = np.concatenate(pairs) if pairs else np.empty(0)
        if len(products) >= FEWEST_ROWS:
            found.append(float(products.sum()) / (square * np.sqrt(len(products))))
    return found


def _drifts(errors: Array) -> list[float]:
    """Return for each number of parts how much their means differ from 0, in standard deviations."""
    square = (errors**2).mean(axis=0)
    errors, square = errors[:, square > 0], square[square > 0]
    found = []
    for parts in PARTS:
        if len(errors) < parts * FEWEST_IN_PART:
            continue
        means = np.array([part.mean(axis=0) for part in np.array_split(errors, parts)])
        freedom = len(square) * parts
        chi = float((means**2 / square).sum()) * len(errors) / parts
        third = 2 / (9 * freedom)
        found.append(((chi / freedom) ** (1 / 3) - (1 - third)) / np.sqrt(third))
    return found
