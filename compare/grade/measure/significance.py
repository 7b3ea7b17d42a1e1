"""The significance of residuals: when a mistake is believed, and when a residual is noise."""

from dataclasses import dataclass

import numpy as np

from tumble.scenarios.frames import Array

# A pose has six degrees of freedom, whatever the number of vertices.
FREE_OF_A_BODY = 6
# Explanations whose weights differ by less fit equally well: odds below e^5, 150 to 1.
ALIKE = 10.0
# A residual up to this many floors leaves nothing to explain.
EXPLAINED = 2.0
# Noise has an autocorrelation of 0 with a standard deviation of 1/sqrt(pairs): at most this many of these.  Of few
# pairs, which have at least three coordinates each, it is at most the second number.
WHITE, CORRELATED = 3.5, 0.4
# Largest lag in rows.
LAGS = 6
# Fewer pairs show no correlation.
FEWEST_PAIRS = 16
# A residual above this share of the body's size, root mean square, is not noise: rows that are further apart than the
# body's rotations are uncorrelated, too.
LARGEST_NOISE = 0.1
# Noise is as large in every part of a file: of so many parts, the smallest is at least this share of the whole.
PARTS, AS_LARGE = 4, 1 / 3
# Noise has no spikes above this many times the root mean square.
SPIKE = 5.0
# Noise spares no row.  A row is spared if no coordinate is off by more than so many floors, where the root mean square
# is at least so many: with noise in three coordinates that happens to one row in 10 000.  The first row may have none.
SPARED, LARGE = 5.0, 100.0
# More rows than this, and than this share of them, are no chance.
SPARED_ROWS, SPARED_SHARE = 2, 0.02
# Model-selection penalty of a fitted value: ln(100) units more than a named value.
FITTED_VALUES = 100
# Rows in which single precision may move the body by more than this share of its size decide nothing, if it could
# explain all; nor do those in which the reference is less accurate.  The fewest rows without these that are enough.
LARGE_FLOOR, FEWEST_ROWS = 1e-3, 12
# Error of the compiled kernel, over the body's size.
KERNEL_ERROR = 1e-9


@dataclass(frozen=True)
class ResidualScale:
    """The scale that residuals are compared to.

    numbers: of independent observations; floor_m: noise floor, below which a residual is indistinguishable from zero;
    size_m: of the body; floors_m: of each row's axes, (S, 3), of which floor_m is the root mean square.
    """

    numbers: int
    floor_m: float
    size_m: float
    floors_m: Array

    def weighted(self, errors: Array) -> Array:
        """Return errors of rows, (S, K, 3), scaled to the same floor in each row and axis."""
        return errors * (self.floor_m / (np.sqrt(3.0) * self.floors_m))[:, None]

    def in_floors(self, errors: Array) -> float:
        """Return the root mean square of errors of rows, (S, K, 3), in floors."""
        return root_mean_square(self.weighted(errors)) / self.floor_m

    def with_single(self, single_m: Array) -> "ResidualScale":
        """Return the scale with an effect of single precision on each row [m], (S,)."""
        floors_m = np.sqrt(np.square(self.floors_m) + np.square(single_m)[:, None] / 3)
        return ResidualScale(self.numbers, typical_floor(floors_m), self.size_m, floors_m)

    def with_noise(self, noise_m: float) -> "ResidualScale":
        """Return the scale with noise in each coordinate [m]."""
        floors_m = np.sqrt(np.square(self.floors_m) + noise_m**2)
        return ResidualScale(self.numbers, typical_floor(floors_m), self.size_m, floors_m)

    def is_within_floor(self, rms_m: float) -> bool:
        """Whether a residual is within the floor."""
        return rms_m <= EXPLAINED * self.floor_m

    def is_noise(self, rms_m: float, max_m: float, correlation: float, pairs: int) -> bool:
        """Whether a residual is noise, by its size, spikes and the autocorrelation over `pairs` rows."""
        unrelated = pairs >= FEWEST_PAIRS and abs(correlation) <= min(WHITE / np.sqrt(pairs), CORRELATED)
        return unrelated and rms_m <= LARGEST_NOISE * self.size_m and max_m <= SPIKE * rms_m

    def weight(self, in_floors: float, cost: float) -> float:
        """Return the Bayesian information criterion of a residual in floors, with a cost; smaller is better.

        The noise is unknown but above the floor, which is added to the residual.
        Source: Schwarz, Ann. Statist. 6 (1978) 461.
        """
        with np.errstate(over="ignore"):
            return self.numbers * float(np.log1p(np.square(in_floors))) + cost

    def parameter_cost(self) -> float:
        """Return the cost of a fitted value."""
        return float(np.log(self.numbers)) + choice_cost(FITTED_VALUES)


def typical_floor(floors_m: Array) -> float:
    """Return the floor of most rows [m], from those of each row's axes, (S, 3): precise rows have more weight."""
    return float(np.sqrt(3.0) * np.median(floors_m))


def is_even(errors: Array) -> bool:
    """Whether rows' errors, (S, ...), are as large in every part of the file, as noise is."""
    parts = [root_mean_square(part) for part in np.array_split(errors, PARTS) if part.size]
    return min(parts) >= AS_LARGE * root_mean_square(errors)


def spares_rows(errors: Array, floors_m: Array) -> bool:
    """Return whether rows besides the first have no error, (S, K, 3), though others have a large one.

    floors_m: of each row's axes, (S, 3).
    """
    if root_mean_square(errors) < LARGE * root_mean_square(floors_m):
        return False
    spared = (np.abs(errors[1:]) <= SPARED * floors_m[1:, None]).all(axis=(1, 2))
    return int(spared.sum()) >= max(SPARED_ROWS, SPARED_SHARE * len(errors))


def choice_cost(count: int) -> float:
    """Return the cost of a choice among this many: its description length, in the same units."""
    return 2.0 * float(np.log(count))


def independent(rows: int, vertices: int) -> int:
    """Return the number of independent coordinates of rows of vertices."""
    return rows * min(3 * vertices, FREE_OF_A_BODY)


def root_mean_square(errors: Array) -> float:
    """Return the root mean square of lengths, (..., 3)."""
    flat = errors.ravel()
    with np.errstate(over="ignore", invalid="ignore"):
        # Not by BLAS, whose threads cost more than they save.
        return float(np.sqrt(3.0 * np.einsum("i,i->", flat, flat) / flat.size))


def autocorrelation(errors: Array) -> float:
    """Return the largest autocorrelation of rows' errors, (S, ...), over lags of up to LAGS rows.

    It is 0 for noise, 1 for a drift, and large for a period of a few rows.
    """
    flat = errors.reshape(len(errors), -1)
    found = [_correlation(flat[:-back], flat[back:]) for back in range(1, min(LAGS, len(flat) // 4) + 1)]
    return max(found, key=abs, default=0.0)


def _correlation(before: Array, after: Array) -> float:
    size = float(np.linalg.norm(before) * np.linalg.norm(after))
    return float((before * after).sum()) / size if size > 0 else 0.0
