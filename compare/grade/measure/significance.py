"""What a residual weighs: how much less of it a mistake must leave before it is believed, and when it is only noise."""

from dataclasses import dataclass

import numpy as np

from tumble.scenarios.frames import Array

# A pose is six numbers, however many vertices it is seen by.
FREE_OF_A_BODY = 6
# Below this weight two explanations fit alike: odds of e^5, 150 to 1.
ALIKE = 10.0
# A residual this near the floor has left nothing to explain.
EXPLAINED = 2.0
# Neighbouring rows of noise have a relation of 0 with a standard deviation of 1/sqrt(pairs): so many of these.
WHITE = 3.5
# Rows back.
LAGS = 6
# Fewer pairs say nothing.
TELLING = 16
# What moves a body by more than this share of its size, root mean square, is no noise: rows that are further apart than
# the body's turns have nothing to do with one another either.
LOUDEST = 0.1
# Noise has no spikes: nothing is off by more than so many times the root mean square.
SPIKE = 5.0
# A number that was fitted is worth one of so many, against a value that has a name.
FITTED = 100
# Compiled flights with different mistakes agree with themselves to about this much of the body's size.
FLIGHT = 1e-9


@dataclass(frozen=True)
class Scale:
    """What a residual is held against.

    numbers: independent ones; floor_m: what they cannot tell from nothing; size_m: of the body; floors_m: of each
    row's axes, (S, 3), of which floor_m is the root mean square.
    """

    numbers: int
    floor_m: float
    size_m: float
    floors_m: Array

    def weighed(self, errors: Array, floors_m: Array | None = None) -> Array:
        """Return errors of rows, (S, K, 3), as if each row's axes were known as well as the mean of them."""
        floors_m = self.floors_m if floors_m is None else np.maximum(self.floors_m, floors_m)
        return errors * (self.floor_m / (np.sqrt(3.0) * floors_m))[:, None]

    def is_nothing(self, rms_m: float) -> bool:
        """Whether a residual is at the floor."""
        return rms_m <= EXPLAINED * self.floor_m

    def is_noise(self, rms_m: float, max_m: float, related: float, pairs: int) -> bool:
        """Whether a residual, whose neighbouring rows are so related, is no more than noise would be."""
        unrelated = pairs >= TELLING and abs(related) <= WHITE / np.sqrt(pairs)
        return unrelated and rms_m <= LOUDEST * self.size_m and max_m <= SPIKE * rms_m

    def weights(self, rms_m: Array) -> Array:
        """Return the Bayesian information criterion of fits without what they assume, less being better.

        The noise is unknown but above the floor, which takes the place of a residual of 0.
        Source: Schwarz, Ann. Statist. 6 (1978) 461.
        """
        with np.errstate(over="ignore"):
            return self.numbers * np.log(np.square(rms_m) + self.floor_m**2)

    def weight(self, rms_m: float, cost: float) -> float:
        """Return the same of one fit, and the cost of what it assumes."""
        return float(self.weights(np.array(rms_m))) + cost

    def fitted(self) -> float:
        """Return the cost of a number that was fitted: it could have been any of many, and follows the noise."""
        return float(np.log(self.numbers)) + chosen(FITTED)


def chosen(many: int) -> float:
    """Return the cost of one of so many things: their description length, in the same units."""
    return 2.0 * float(np.log(many))


def independent(rows: int, vertices: int) -> int:
    """Return how many numbers of rows of vertices are independent."""
    return rows * min(3 * vertices, FREE_OF_A_BODY)


def root_mean_square(errors: Array) -> float:
    """Return the root mean square of lengths, (..., 3)."""
    flat = errors.ravel()
    with np.errstate(over="ignore", invalid="ignore"):
        return float(np.sqrt(3.0 * (flat @ flat) / flat.size))


def relation(errors: Array) -> float:
    """Return how rows' errors, (S, ...), are related to those some rows before, where that is most.

    0 for noise, 1 for a drift; also of what repeats itself every few rows.
    """
    flat = errors.reshape(len(errors), -1)
    found = [_related(flat[:-back], flat[back:]) for back in range(1, min(LAGS, len(flat) // 4) + 1)]
    return max(found, key=abs, default=0.0)


def _related(before: Array, after: Array) -> float:
    size = float(np.linalg.norm(before) * np.linalg.norm(after))
    return float((before * after).sum()) / size if size > 0 else 0.0
