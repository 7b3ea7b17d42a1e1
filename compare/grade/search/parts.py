"""The parts of a run that a search looks at, longer and longer ones: simulations of programs there, and scores."""

from collections.abc import Sequence

import numpy as np

from tumble.compare.grade.hypotheses.explanation import Mistakes
from tumble.compare.grade.measure.significance import ResidualScale
from tumble.compare.grade.model.program_model import error_m
from tumble.compare.grade.search.evaluator import Evaluator
from tumble.compare.grade.search.least_squares import Fit
from tumble.compare.grade.search.shells import NOISY_ROWS, ROWS, Shells, finite
from tumble.compare.grade.search.simulations import Simulations
from tumble.scenarios.frames import Array

# The first part of the run that is looked at: radians, rows; and how much longer each part is than the one before.
RADIANS, SHARE_OF_ALL, FEWEST, LONGER = 4.0, 0.3, 12, 4.0
# Radians in a step of a continuous run: its error, over the body's size, is ERROR at UNIT, and grows with the fourth
# power; it is to be below a share of the floor.
UNIT, ERROR, OF_FLOOR, FINEST, COARSEST = 0.2, 1e-5, 0.3, 0.02, 0.15
# Numbers of residuals that are scored at once: as many as a core's cache holds.
AT_ONCE = 65_536
# Derivatives by no value.
NO_SLOPES = np.empty(0)
# Coarse simulations show what to try next if their errors are below this share of what is off.
SCREENED = 1e-3


class Parts:
    """The parts of a run, of which one is looked at."""

    def __init__(self, evaluator: Evaluator, scale: ResidualScale) -> None:
        """Look at all of the run; scale: what residuals are compared to."""
        self._context, self._sample, self._points = evaluator.context, evaluator.rows, evaluator.points
        self._scale, self._cost = scale, evaluator.cost
        self._reached, self._rests_from = evaluator.reached, evaluator.rests_from
        self._rows = NOISY_ROWS if evaluator.is_noisy else ROWS
        self._events = np.array([impulse.time for impulse in self._context.program.impulses])
        self._made: dict[float, Simulations] = {}
        self._coarse: dict[float, Simulations] = {}
        self.look_at_all()

    @property
    def trials(self) -> int:
        """The number of simulated programs."""
        every = {*self._made.values(), *self._coarse.values()}
        return sum(simulations.trials for simulations in every)

    def look_at_all(self) -> None:
        """Look at all of the run, whatever time that takes."""
        self._stops_at = np.inf
        self._begin(self._context.duration)

    def stop_at(self, stops_at: float) -> None:
        """Raise SearchStopped from a processor time on [s]."""
        self._stops_at = self._simulations.stops_at = stops_at

    def _horizons(self) -> list[float]:
        duration, spacing = self._context.duration, self._context.spacing_s
        until = max(min(RADIANS * self._context.turn_s, SHARE_OF_ALL * duration), FEWEST * spacing)
        found = []
        while until * 1.5 < duration:
            found.append(until)
            until *= LONGER
        return [*found, duration]

    def _begin(self, until: float) -> None:
        self._until = until
        self._simulations, _ = self._fine_and_coarse(until)
        self._fit = Fit(self._simulations)
        self._fit.is_free = True

    def _fine_and_coarse(self, until: float) -> tuple[Simulations, Simulations]:
        """Return fine and coarse simulations until a time [s], which stop when this search does."""
        if until not in self._made:
            self._made[until], self._coarse[until] = self._simulations_until(until)
        both = self._made[until], self._coarse[until]
        for simulations in both:
            simulations.stops_at = self._stops_at
        return both

    def _look_at(self, until: float) -> None:
        """Look at the run until a time [s], with the right translation."""
        self._begin(until)
        self._fit.is_free = False

    def _simulations_until(self, until: float) -> tuple[Simulations, Simulations]:
        """Return fine and coarse simulations until a time [s]."""
        are_written = self._context.kind == "vertices"
        shells = Shells(self._sample, self._scale, self._points, until, self._events, are_written, self._rows)
        floor_m = np.sqrt(3.0) * float(np.median(self._scale.floors_m.min(axis=1)))  # of the axis with most digits
        small = OF_FLOOR * floor_m / (ERROR * self._scale.size_m)
        fineness = float(np.clip(UNIT * small**0.25, FINEST, COARSEST))
        # A motion may amplify the error.
        if (wrong := error_m(self._context.program, fineness, until) / (OF_FLOOR * floor_m)) > 1.0:
            fineness = max(FINEST, fineness * wrong**-0.25)
        fine = Simulations(self._context, shells, self._stops_at, fineness)
        return fine, Simulations(self._context, shells, self._stops_at, COARSEST) if fineness < COARSEST else fine

    def _slopes(self, mistakes: Mistakes) -> Array:
        """Return the derivatives of residuals by the values that are fitted, (P, T, K, 3)."""
        errors = self._simulations.errors([mistakes])[0]
        return self._fit.directions(mistakes, errors)

    def _screened(self, mistakes: Mistakes, programs: Sequence[Mistakes], slopes: Array) -> Array:
        """Return the scores of programs that are a change away from one; coarsely simulated, if that is far off."""
        fine, coarse = self._fine_and_coarse(self._until)
        errors, others = (each.errors([mistakes]) for each in (fine, coarse))
        with np.errstate(all="ignore"):  # a run that diverged, or is right
            share = float(np.sqrt(np.square(others - errors).mean() / np.square(errors).mean()))
        return self._profiled(programs, slopes, coarse if share < SCREENED else fine)

    def _profiled(
        self, programs: Sequence[Mistakes], slopes: Array = NO_SLOPES, simulations: Simulations | None = None
    ) -> Array:
        """Return the scores of programs, with what derivatives, (P, T, K, 3), can explain of each left out."""
        found, simulations = np.empty(len(programs)), simulations or self._simulations
        count = max(1, AT_ONCE // simulations.shells.numbers)
        for begin in range(0, len(programs), count):
            part = slice(begin, begin + count)
            errors = simulations.errors(programs[part])
            found[part] = self._fit.scored(errors)[1]
            if len(slopes):
                found[part] = np.minimum(found[part], self._fit.scored(self._left(errors, slopes))[1])
        return found + np.array([self._cost(program) for program in programs])

    def _nearest(self, programs: Sequence[Mistakes], count: int, slopes: Array = NO_SLOPES) -> list[Mistakes]:
        """Return so many programs with the best scores, best first; slopes: as in `_profiled`."""
        scores = self._profiled(programs, slopes)
        return [programs[number] for number in np.argsort(scores, kind="stable")[:count]]

    def _left(self, errors: Array, slopes: Array) -> Array:
        """Return what derivatives, (P, T, K, 3), leave of residuals, (V, T, K, 3)."""
        shells = self._simulations.shells
        with np.errstate(all="ignore"):
            known, count = finite(errors), len(slopes)
            if self._fit.is_free:
                median = known[int(np.argsort(shells.weights(known))[len(known) // 8])]
                known, slopes = shells.without_translation(known, median), shells.without_translation(slopes, median)
            rows = shells.precisions(errors).reshape(len(errors), -1)
            products = np.einsum("ptki,qtki->pqtk", slopes, slopes).reshape(count * count, -1)
            normal = (rows @ products.T).reshape(-1, count, count)
            weighted = (known * rows.reshape(*errors.shape[:3])[..., None]).reshape(len(errors), -1)
            right = weighted @ slopes.reshape(count, -1).T
            size = np.einsum("vpp->vp", normal)
            normal = normal + 1e-9 * np.eye(count) * np.where(size > 0, size, 1.0)[:, :, None]
            step = np.linalg.solve(normal, right[:, :, None])[:, :, 0]
            return known - (step @ slopes.reshape(count, -1)).reshape(errors.shape)
