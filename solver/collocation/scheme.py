"""A collocation method as numbers, made from the instants of its stages."""

from typing import NamedTuple

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from tumble.solver.eight import COUNT

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


class Scheme(NamedTuple):
    """A method as numbers, for a step from 0 to 1.

    coefficients, (3, 3), and weights, (3,): the integrals of a parabola, given at the stages, up to the stages and 1.
    The same in columns of eight, for `tumble.solver.eight`: to_stages, (3, 8), up to the stages, and zeros; integrals
    and values, (6, 8): its integrals up to the instants at which forces are looked at, and its values there; means,
    (16, 8): the force that counts for a stage, a row for the force at each instant.  These three are there twice: for
    the instants of the mean, and then with the stages for instants.  degrees, (8, 8): Legendre's coefficients of the
    polynomial through what is seen at the instants of the mean, a row for each, and zeros unless there are eight.
    Where there are fewer instants than eight the last is there again, and does not count.
    keeps_energy: whether the instants of the mean are more than the stages, and what work they see is done.
    real_rate, to_real, from_real: the real eigenvalue of the coefficients, its left and its right eigenvector;
    pair_rate, to_pair, from_pair: the same of one eigenvalue of the conjugate pair.
    """

    coefficients: Array
    weights: Array
    to_stages: Array
    integrals: Array
    values: Array
    means: Array
    degrees: Array
    keeps_energy: bool
    real_rate: float
    to_real: Array
    from_real: Array
    pair_rate: complex
    to_pair: ComplexArray
    from_pair: ComplexArray


def scheme(stages: Array, instants: Array) -> Scheme:
    """Return the method with these three stages, which looks at forces at these instants, all in [0, 1].

    The force that counts for a stage is its mean over the step, weighed with the stage's own parabola, by the
    quadrature of the instants; where they are the stages themselves, it is the force there.
    Source of the mean: Hairer, "Energy-preserving variant of collocation methods" (2010), definition 1.
    """
    parabolas = _lagrange(stages)
    integrals = [parabola.integ() for parabola in parabolas]
    coefficients = _at(integrals, stages)
    weights = _at(integrals, np.ones(1))[0]
    looks = instants, stages
    seen = np.concatenate([np.append(look, np.full(COUNT - len(look), look[-1])) for look in looks])
    # What makes Legendre's coefficients of a curve from its values at the instants: the first is its mean.
    legendre = [np.linalg.inv(np.polynomial.legendre.legvander(2.0 * look - 1.0, len(look) - 1)) for look in looks]
    means = [first[0][:, None] * _at(parabolas, look) / weights for first, look in zip(legendre, looks, strict=True)]
    keeps_energy = len(instants) == COUNT
    rates, right = np.linalg.eig(coefficients)
    left = np.linalg.inv(right)
    real, pair = np.argmin(np.abs(np.imag(rates))), np.argmax(np.imag(rates))
    return Scheme(
        coefficients=coefficients,
        weights=weights,
        to_stages=_in_eights(coefficients.T),
        integrals=_twice(_at(integrals, seen)),
        values=_twice(_at(parabolas, seen)),
        means=np.concatenate([_in_eights(mean, COUNT) for mean in means]),
        degrees=_in_eights(legendre[0].T if keeps_energy else np.zeros((1, 1)), COUNT),
        keeps_energy=keeps_energy,
        real_rate=float(rates[real].real),
        to_real=np.ascontiguousarray(np.real(left[real])),
        from_real=np.ascontiguousarray(np.real(right[:, real])),
        pair_rate=complex(rates[pair]),
        to_pair=np.ascontiguousarray(left[pair]),
        from_pair=np.ascontiguousarray(right[:, pair]),
    )


def _in_eights(rows: NDArray[np.floating], count: int | None = None) -> Array:
    """Return rows that zeros make eight numbers long, and as many rows as asked for."""
    whole = np.zeros((count or len(rows), COUNT))
    whole[: rows.shape[0], : rows.shape[1]] = rows
    return whole


def _twice(columns: Array) -> Array:
    """Return columns of eight instants and of eight more as rows of eight, one below the other."""
    return np.ascontiguousarray(np.concatenate([columns[:COUNT].T, columns[COUNT:].T]))


def _lagrange(points: Array) -> list[Polynomial]:
    """Return the polynomials that are 1 at one of the points and 0 at the others."""
    others = [np.delete(points, number) for number in range(len(points))]
    return [Polynomial.fromroots(roots) / np.prod(own - roots) for own, roots in zip(points, others, strict=True)]


def _at(polynomials: list[Polynomial], points: Array) -> Array:
    """Return the values of polynomials, the columns, at points, the rows."""
    return np.ascontiguousarray(np.stack([polynomial(points) for polynomial in polynomials], axis=-1))
