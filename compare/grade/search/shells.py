"""The rows that a search looks at, in shells of time, and what residuals in them weigh.

Errors of a wrong program grow from row to row, and soon every row is wrong.  So the rows are put into shells: the first
row, the next few, and so on.  A residual is weighed shell by shell, by the logarithm of its size there: a mistake that
makes the first rows right counts, even if the rest is as wrong as before, because another mistake acts later.  The
centre and the rotation are weighed apart as well, for many mistakes are of one of them alone.
"""

from itertools import pairwise

import numpy as np

from tumble.compare.grade.measure.errors import SampledRows, golden_subsample
from tumble.compare.grade.measure.significance import EXPLAINED, FREE_OF_A_BODY, ResidualScale
from tumble.compare.grade.search.kernels import (
    pose_residuals,
    precisions_of,
    squares_of,
    translation_equations,
    without_translation,
)
from tumble.scenarios.frames import Array

# First rows that are all looked at, and rows after an impulse.
FIRST, AFTER_AN_IMPULSE = 10, 2
# All rows; noise is the less of a hindrance the more there are.
ROWS, NOISY_ROWS = 40, 56
# Rows in the first shells; each shell after them has twice as many rows as the one before, and the last has the rest.
SHELLS = (1, 3, 6)
# The residual of one shell may be this many times as large as that of all.
OF_A_SHELL = 2.0
# The mean square of noise in one shell is at most this many times that in another.
EVEN = 10.0
# Single precision of unusually short steps has up to so many times the effect of that of usual ones.
NEAR = 10.0
# A residual counts as at most this many times the body's size, as that of a run that diverged does.
LARGEST = 1e6
# Vertices whose smallest extent is below this share of the largest lie in a plane.
FLAT = 1e-6
# They are not sheared if they are off by at most so many floors.
UNSHEARED = 20.0
# The block of the centre.
THE_CENTRE = np.array((0, 1))
# What is left for the translation, over its rounding, so that equations can be solved.
REGULAR = 1e-12


class Shells:
    """Rows of one throw up to a time, in shells.

    times [s], (T,); a residual of a row has the shift of the centre and of three points of the body, which rotate and
    shear with it, in floors: (4, 3).  If a file has too few vertices for that, it has those of the vertices.
    """

    def __init__(
        self,
        sample: SampledRows,
        scale: ResidualScale,
        points: Array,
        until: float,
        events: Array,
        are_written: bool = False,
        rows: int = ROWS,
    ) -> None:
        """Choose the rows.

        points: vertices in the file [m], axes of the body, (K, 3); until: [s]; events: times of impulses [s];
        are_written: the file has vertices, rounded each, and no pose; rows: their number, without those of events.
        """
        kept = _chosen(sample.times, until, events, rows)
        self.times, vertices = sample.times[kept], sample.vertices[kept]
        self.floors_m = scale.floors_m[kept]
        self._trust = 1.0 / self.floors_m[:, None, :]
        self._points = points
        self.is_pose, x, axes = _affine(vertices, points, self.floors_m)
        reach = float(np.sqrt((points**2).sum(axis=1).mean())) or 1.0
        self._arms = _arms(points) if are_written and self.is_pose else reach * np.eye(3)
        self._x, self._axes = np.ascontiguousarray(x), np.ascontiguousarray(axes)
        self._vertices = vertices
        edges, size = [0], 0
        for size in SHELLS:
            edges.append(min(edges[-1] + size, len(kept)))
        while edges[-1] < len(kept):
            size *= 2
            rest = len(kept) - edges[-1]
            edges.append(len(kept) if rest < 1.5 * size else edges[-1] + size)
        self._edges = np.unique(edges)
        self.sizes = np.diff(self._edges)
        # The centre, and the three points that rotate; or all vertices.
        self._points_from = np.array((0, 1, 4) if self.is_pose else (0, len(points)))
        self._blocks = [slice(*both) for both in pairwise(self._points_from.tolist())]
        free = min(FREE_OF_A_BODY, 3 * len(points)) / len(self._blocks)
        self._numbers = self.sizes * free
        self._most = np.square(LARGEST * scale.size_m * self._trust.max())
        since = np.maximum(self.times[:, None] - np.concatenate(([0.0], events[events < until])), 0.0)
        # Jumps: a program that moves by the old velocity is a step late, from the start and from each impulse on.
        powers = np.column_stack((np.ones_like(self.times), since, since[:, 0] ** 2, since > 0))
        self._powers = np.unique(powers / np.maximum(powers.max(axis=0), 1e-300), axis=1)

    def __len__(self) -> int:
        return len(self.times)

    @property
    def numbers(self) -> int:
        """How many numbers the residuals of a program are."""
        return 3 * len(self.times) * self._blocks[-1].stop

    def residuals(self, x: Array, axes: Array, has_centre: bool) -> Array:
        """Return what programs leave, in floors, (V, T, 4, 3), from x [m], (V, T, 3), and axes, (V, T, 3, 3)."""
        if self.is_pose:
            found = np.empty((*x.shape[:2], 4, 3))
            own = self._x, self._axes, self._arms
            pose_residuals(x, axes, *own, has_centre, self._trust[:, 0], found)
            return found
        with np.errstate(all="ignore"):
            places = np.einsum("vtij,kj->vtki", axes, self._points)
            places = places + x[:, :, None] if has_centre else places
            return (self._vertices - places) * self._trust

    def squares(self, errors: Array) -> Array:
        """Return the mean squares in each shell of the centre and of the rotation, in floors, (V, shells, 2).

        errors: residuals, (V, T, K, 3).  If a file has too few vertices for that, there is one of all: (V, shells, 1).
        """
        return self._squares_of(errors, self._points_from)

    def parts(self, errors: Array) -> list[Array]:
        """Return residuals, (V, T, K, 3), of the centre and of the rotation; all in one where they are not apart."""
        return [errors[:, :, block] for block in self._blocks]

    def _squares_of(self, part: Array, points: np.ndarray) -> Array:
        """Return the mean squares in each shell of residuals, (V, T, K, 3), in blocks of points: (V, S, B)."""
        found = np.empty((len(part), len(self.sizes), len(points) - 1))
        squares_of(part, self._edges, points, self._most, found)
        return found

    def weights(self, errors: Array) -> Array:
        """Return the information criterion of residuals, (V, T, K, 3), without the cost of assumptions: (V,).

        The noise is unknown in each shell, but above the floor.
        """
        return np.log1p(self.squares(errors)).sum(axis=2) @ self._numbers

    def weights_and_free(self, errors: Array) -> tuple[Array, Array]:
        """Return the weights of residuals, (V, T, K, 3), and those with a free translation, (V,) both."""
        logarithms = np.log1p(self.squares(errors))
        weights = logarithms.sum(axis=2) @ self._numbers
        if not self.is_pose:
            return weights, weights
        left = self._centre_without_translation(errors, errors)
        free = np.log1p(self._squares_of(left[:, :, None], THE_CENTRE))
        return weights, weights + (free - logarithms)[:, :, 0] @ self._numbers

    def precisions(self, errors: Array) -> Array:
        """Return the weights of residuals, (V, T, K, 3), in a fit that minimises `weights`: (V, T, K)."""
        found = np.empty(errors.shape[:3])
        precisions_of(self.squares(errors), self._edges, self._points_from, found)
        return found

    def weighted(self, residuals: Array, like: Array) -> Array:
        """Return residuals, (V, T, K, 3), over the noise that those of a program, (1, T, K, 3), have in each row."""
        return np.sqrt(self.precisions(like))[..., None] * residuals

    def is_whole(self, errors: Array) -> bool:
        """Return whether residuals, (T, K, 3), are within the floor: all of them, and nearly those of each shell."""
        squares = self.squares(errors[None])[0]
        mean = float((squares * self.sizes[:, None]).sum() / (self.sizes.sum() * squares.shape[1]))
        return mean <= EXPLAINED**2 and float(squares.max()) <= (OF_A_SHELL * EXPLAINED) ** 2

    def is_near(self, errors: Array) -> bool:
        """Return whether residuals, (T, K, 3), are small enough for single precision to be the reason."""
        return float(self.squares(errors[None]).max()) <= (NEAR * EXPLAINED) ** 2

    def is_even(self, errors: Array) -> bool:
        """Return whether residuals, (T, K, 3), are about as large in each shell of several rows, as noise is."""
        squares = self.squares(errors[None])[0][self.sizes > SHELLS[0]]
        return len(squares) > 0 and bool((squares.max(axis=0) <= EVEN * squares.min(axis=0)).all())

    def first_beyond(self, errors: Array, most: float) -> float:
        """Return the time of the first row whose residuals, (T, K, 3), exceed some floors [s]; inf if none does."""
        beyond = ~(np.abs(errors).max(axis=(1, 2)) <= most)  # also nan
        return float(self.times[beyond.argmax()]) if beyond.any() else np.inf

    def without_centre(self, errors: Array) -> Array:
        """Return residuals, (T, K, 3), with those of the centre set to 0; unchanged where they are not apart."""
        return np.where(np.arange(errors.shape[1])[:, None] == 0, 0.0, errors) if self.is_pose else errors

    def without_translation(self, errors: Array, like: Array | None = None) -> Array:
        """Return residuals without those of the centre that another start, acceleration or impulse would explain.

        They are polynomials of time, with kinks and jumps at impulses, along each axis, fitted to rows as far as these
        are precise; like: residuals that show how precise rows are, (T, K, 3), if those themselves do not.
        """
        if not self.is_pose:
            return errors
        found = errors.copy()
        found[:, :, 0] = self._centre_without_translation(errors, errors if like is None else like[None])
        return found

    def _centre_without_translation(self, errors: Array, like: Array) -> Array:
        """Return what `without_translation` leaves of the centre's residuals, (V, T, 3)."""
        count, centres, trust = self._powers.shape[1], np.ascontiguousarray(errors[:, :, 0]), self._trust[:, 0]
        normal, right = np.empty((len(errors), count, count)), np.empty((len(errors), count, 3))
        precise = self._squares_of(np.ascontiguousarray(like[:, :, :1]), THE_CENTRE)[:, :, 0]
        translation_equations(centres, precise, self._edges, self._powers, trust, normal, right)
        # Each power is scaled apart: rows that are right are precise to the floor, and others may hardly count.
        size = np.sqrt(np.einsum("vpp->vp", normal))[:, :, None]
        size[size == 0.0] = 1.0
        normal = normal / (size * size.swapaxes(1, 2)) + REGULAR * np.eye(count)
        left = np.empty(centres.shape)
        without_translation(centres, self._powers, np.linalg.solve(normal, right / size) / size, trust, left)
        return left


def finite(numbers: Array) -> Array:
    """Return numbers with 0 in the place of those of a run that diverged."""
    return np.where(np.isfinite(numbers), numbers, 0.0)


def _chosen(times: Array, until: float, events: Array, rows: int) -> np.ndarray:
    """Return the numbers of the rows: all of the first ones, some after each event, and of the rest some."""
    count = int(np.searchsorted(times, until * (1 + 1e-9), side="right"))
    first = np.arange(min(FIRST, count))
    after = np.searchsorted(times, events[(events > 0) & (events < until)])[:, None] + np.arange(AFTER_AN_IMPULSE)
    rest = golden_subsample(count, rows - len(first))
    chosen = np.unique(np.concatenate((first, after.ravel(), rest, [count - 1])))
    return chosen[(chosen >= 0) & (chosen < count)]


def _arms(points: Array) -> Array:
    """Return three points, one a column [m], (3, 3), that any rotation or shear moves as the vertices, (K, 3).

    The mean square of the distances is the same.  Along an axis on which the body is thin, vertices hardly tell how it
    rotates and shears, and what their rounding makes of that would be as large at points on axes of one length.
    """
    _, sizes, axes = np.linalg.svd(points, full_matrices=False)
    return np.sqrt(3.0 / len(points)) * sizes * axes.T


def _affine(vertices: Array, points: Array, floors_m: Array) -> tuple[bool, Array, Array]:
    """Return the affine maps of points, (K, 3), to vertices, (T, K, 3): whether they are known, x and axes.

    Of points in a plane, only a rotation and a scale are; floors_m: of vertices, which show whether it is one, (T, 3).
    """
    nothing = np.zeros((len(vertices), 3)), np.zeros((len(vertices), 3, 3))
    centred = points - points.mean(axis=0)
    _, extent, basis = np.linalg.svd(centred, full_matrices=False)
    if len(extent) < 3 or extent[1] <= FLAT * extent[0]:
        return False, *nothing
    if extent[2] <= FLAT * extent[0]:
        return _similar(vertices, points, basis[:2], floors_m)
    full = np.column_stack((np.ones(len(points)), points))
    maps = np.einsum("pk,tki->tpi", np.linalg.pinv(full), vertices)
    return True, maps[:, 0], np.swapaxes(maps[:, 1:], 1, 2)


def _similar(vertices: Array, points: Array, plane: Array, floors_m: Array) -> tuple[bool, Array, Array]:
    """Return what `_affine` does of points in a plane, from which the body is rotated and scaled, and not sheared.

    The normal of the plane is scaled as the plane is: a quaternion that is not of unit length scales the body.  plane:
    two unit vectors in it, (2, 3).
    """
    middle, normal = points.mean(axis=0), np.cross(*plane)
    flat = (points - middle) @ plane.T
    centres = vertices.mean(axis=1)
    images = np.einsum("pk,tki->tpi", np.linalg.pinv(flat), vertices - centres[:, None])
    scales = np.linalg.svd(images, compute_uv=False)
    sizes = np.sqrt(np.maximum(scales.prod(axis=1), np.finfo(float).tiny))
    across = np.cross(images[:, 0], images[:, 1]) / sizes[:, None]
    axes = np.einsum("tpi,pj->tij", np.concatenate((images, across[:, None]), axis=1), [*plane, normal])
    off = np.ptp(scales, axis=1) * np.abs(flat).max()
    return bool((off <= UNSHEARED * floors_m.max(axis=1)).all()), centres - axes @ middle, axes
