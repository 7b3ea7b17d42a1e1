"""Errors of very many throws, added up part by part: counts, moments, a histogram of fixed size and the worst throws.

The histogram has bins of equal relative width, as that of Masson, Rim and Lee (DDSketch, VLDB 2019), but cut out of the
bits of a double: no logarithm is rounded.  Counts add up exactly, so that parts give the same bits however they are
shared out.  A KLL sketch is smaller but tosses coins: two runs of a part would differ, and its tail has no digits.
"""

from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from tumble.compare.judge.errors import Run
from tumble.compare.run.status import Failure, Status
from tumble.scenarios.frames import Array

# Throws that are listed one by one.
WORST = 100
# Bits of a double below a bin's: 64 bins from one power of two to the next.
BELOW = 52 - 6
# Most that the middle of a bin differs from what is in it, as a share.
BIN_ERROR = 2.0**-7
# Of two parts, that with the status further to the right.
ORDER = (Status.OK, Status.FLAGGED, Status.DIVERGED)


@dataclass(frozen=True, eq=False)
class Spread:
    """The errors of one contestant in a number of throws.

    Parameters
    ----------
    throws : number of them that were run
    unknown : of these, how many have no reference solution, and so no error
    lost : of these, how many diverged
    status, why : the worst of a part, of several the first
    steps : of one throw
    wall_s : wall time of the engine's native loops [s]
    bins, counts : histogram of the throws' errors: bits of a double above BELOW, and how many are there
    mean_m, squares : mean of the finite errors [m], and sum of squared distances from it
    worst, worst_m, worst_resolution_m : numbers, largest vertex error and resolution of the worst throws
    over_time_m, limits_m : largest error and resolution at each sample [m], (S,)
    final_m : largest error at the last sample [m]
    vertex_squares, vertices : sum of squared errors of all vertices, and their number
    drifts : of energy, momentum, angular momentum, as `Run.drifts`
    bound_m, input_error_m : of the reference solution [m]
    """

    throws: int
    unknown: int = 0
    lost: int = 0
    status: Status = Status.OK
    why: str = ""
    steps: int = 0
    wall_s: float = 0.0
    bins: np.ndarray = field(default_factory=partial(np.empty, 0, np.int64))
    counts: np.ndarray = field(default_factory=partial(np.empty, 0, np.int64))
    mean_m: float = 0.0
    squares: float = 0.0
    worst: np.ndarray = field(default_factory=partial(np.empty, 0, np.int64))
    worst_m: np.ndarray = field(default_factory=partial(np.empty, 0))
    worst_resolution_m: np.ndarray = field(default_factory=partial(np.empty, 0))
    over_time_m: np.ndarray = field(default_factory=partial(np.empty, 0))
    limits_m: np.ndarray = field(default_factory=partial(np.empty, 0))
    final_m: float = 0.0
    vertex_squares: float = 0.0
    vertices: int = 0
    drifts: tuple[float, float, float] = (0.0, 0.0, 0.0)
    bound_m: float = 0.0
    input_error_m: float = 0.0

    @property
    def known(self) -> int:
        """The number of throws that have an error, which may be infinite."""
        return int(self.counts.sum())

    @property
    def has_failed(self) -> bool:
        """Whether a part has no trajectory."""
        return self.status not in ORDER

    def quantile(self, share: float) -> float:
        """Return the error that this share of the throws does not exceed [m], within BIN_ERROR of it."""
        rank = min(int(np.ceil(share * self.known)), self.known)
        number = int(np.searchsorted(np.cumsum(self.counts), max(rank, 1)))
        most = max(float(self.worst_m[0]), float(self.limits_m.max(initial=0)))
        return min(float(middle(self.bins[number : number + 1])[0]), most)

    @property
    def deviation_m(self) -> float:
        """Standard deviation of the finite errors [m]."""
        finite = self.known - self.lost
        return float(np.sqrt(self.squares / (finite - 1))) if finite > 1 else 0.0


def bins_of(errors: Array) -> np.ndarray:
    """Return the bin of each error, not negative, (N,)."""
    return np.ascontiguousarray(errors, float).view(np.int64) >> BELOW


def middle(bins: np.ndarray) -> Array:
    """Return the middle of bins; infinite of the bin of infinity."""
    middles = ((bins << BELOW) + (1 << (BELOW - 1))).view(np.float64)
    return np.where(np.isnan(middles), np.inf, middles)


def spread_of(run: Run, first: int) -> Spread:
    """Return the errors of a run of some throws.

    Parameters
    ----------
    run : of the throws
    first : number of the first of them

    Returns
    -------
    the spread of their errors
    """
    throws = len(run.scene.start)
    found = Spread(throws, status=run.status, why=run.reason)
    if isinstance(run.answer, Failure):
        return found
    found = replace(found, steps=run.flight.steps, wall_s=run.flight.wall_s)
    if run.truth is None:
        return replace(found, unknown=throws)
    with np.errstate(invalid="ignore"):
        own = run.distances.max(axis=(0, 2))
    own, limits = np.where(np.isnan(own), np.inf, own), run.limits.max(axis=0)
    errors = np.maximum(own, limits)
    finite = errors[np.isfinite(errors)]
    bins, counts = np.unique(bins_of(errors), return_counts=True)
    worst = np.argsort(-own, kind="stable")[:WORST]
    mean = float(finite.mean()) if len(finite) else 0.0
    with np.errstate(over="ignore", invalid="ignore"):
        vertex_squares = float((run.distances**2).sum())
    return replace(
        found,
        lost=throws - len(finite),
        bins=bins,
        counts=counts,
        mean_m=mean,
        squares=float(((finite - mean) ** 2).sum()),
        worst=first + worst,
        worst_m=own[worst],
        worst_resolution_m=limits[worst],
        over_time_m=run.distances.max(axis=(1, 2)),
        limits_m=run.limits.max(axis=1),
        final_m=float(run.distances[-1].max()),
        vertex_squares=vertex_squares,
        vertices=run.distances.size,
        drifts=tuple(np.where(np.isnan(run.drifts), np.inf, run.drifts).tolist()),
        bound_m=float(run.truth.bound.max()),
        input_error_m=float(run.truth.input_error.max()),
    )


def added(one: Spread, other: Spread) -> Spread:
    """Return the spread of both; of equal errors, `one` comes first.

    Parameters
    ----------
    one, other : of throws that follow each other

    Returns
    -------
    the spread of all
    """
    throws = one.throws + other.throws
    if one.has_failed or other.has_failed:
        failed = one if one.has_failed else other
        return Spread(throws, status=failed.status, why=failed.why)
    leading = one if ORDER.index(one.status) >= ORDER.index(other.status) else other
    bins, counts = counted_together(one, other)
    ours, theirs = one.known - one.lost, other.known - other.lost
    apart, finite = other.mean_m - one.mean_m, max(ours + theirs, 1)
    known = [each for each in (one, other) if each.known]
    samples = min((len(each.over_time_m) for each in known), default=0)
    worst_m = np.concatenate((one.worst_m, other.worst_m))
    worst = np.argsort(-worst_m, kind="stable")[:WORST]

    def most(name: str) -> Array:
        """Return the larger of the two at each sample that both have a reference solution at."""
        return np.max([getattr(each, name)[:samples] for each in known], axis=0) if known else np.empty(0)

    return Spread(
        throws,
        unknown=one.unknown + other.unknown,
        lost=one.lost + other.lost,
        status=leading.status,
        why=leading.why,
        steps=max(one.steps, other.steps),
        wall_s=one.wall_s + other.wall_s,
        bins=bins,
        counts=counts,
        # Chan, Golub and LeVeque (1979).
        mean_m=one.mean_m + apart * theirs / finite,
        squares=one.squares + other.squares + apart * apart * ours * theirs / finite,
        worst=np.concatenate((one.worst, other.worst))[worst],
        worst_m=worst_m[worst],
        worst_resolution_m=np.concatenate((one.worst_resolution_m, other.worst_resolution_m))[worst],
        over_time_m=most("over_time_m"),
        limits_m=most("limits_m"),
        final_m=float(np.maximum(one.final_m, other.final_m)),
        vertex_squares=one.vertex_squares + other.vertex_squares,
        vertices=one.vertices + other.vertices,
        drifts=tuple(max(pair, key=abs) for pair in zip(one.drifts, other.drifts, strict=True)),  # type: ignore[arg-type]
        bound_m=max(one.bound_m, other.bound_m),
        input_error_m=max(one.input_error_m, other.input_error_m),
    )


def counted_together(one: Spread, other: Spread) -> tuple[np.ndarray, np.ndarray]:
    """Return the bins of two histograms and the counts of both."""
    bins, places = np.unique(np.concatenate((one.bins, other.bins)), return_inverse=True)
    counts = np.zeros(len(bins), np.int64)
    np.add.at(counts, places, np.concatenate((one.counts, other.counts)))
    return bins, counts
