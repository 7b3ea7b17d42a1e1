"""Simulates a throw as programs with mistakes would, and evaluates what each leaves of the rows."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from time import thread_time

import numpy as np

from tumble.compare.grade.hypotheses.explanation import Explanation, Mistake, Mistakes
from tumble.compare.grade.hypotheses.hypothesis import Context, Hypothesis
from tumble.compare.grade.hypotheses.mistakes.output import OUTPUT_PARTS
from tumble.compare.grade.measure.errors import SampledRows, golden_subsample
from tumble.compare.grade.measure.significance import (
    ResidualScale,
    autocorrelation,
    choice_cost,
    is_even,
    root_mean_square,
    spares_rows,
)
from tumble.compare.grade.measure.single_precision import single_floor
from tumble.compare.grade.model.kernel.dynamics import RUNGE_KUTTA, SMOOTH
from tumble.compare.grade.model.program_model import FINE, RIGHT_CLOCK, SEARCHING, Pose, ProgramModel
from tumble.scenarios.frames import Array

# Rows of the sample that fits use, and rows of those that a quick look uses.
FITTED_ROWS, QUICK_ROWS = 96, 24
# Simulated steps after which a search adds no more mistakes: the limit of a search, the same on any machine.
ENOUGH = 60_000_000
# Radians in a step of a quick look if more than this share of the body's size is to be explained.
COARSE, LARGE = 0.4, 0.02
# A residual that is not finite counts as this many times the body's size.
DIVERGED = 1e6
# A run costs at least this many steps, and at most this many are counted.
STARTED, MOST_COUNTED = 1000, 100_000
# States of a run among which the nearest to a row is sought: this many in a radian of rotation, and at most.
IN_A_RADIAN, MOST_STATES = 10, 2000


class SearchStopped(Exception):
    """The search has used its processor time."""


class Evaluator:
    """Evaluates mistakes against the sampled rows of one throw.

    rows: the sample; fitted_rows: those that fits use; quick_rows: those that a quick look uses; hypotheses: in the
    order in which a program makes the mistakes; trials: number of simulated programs; simulated_steps: steps that
    they took, without those whose output alone was changed; stops_at: processor time of the thread at which the search
    stops [s]; on_progress: called with the share of ENOUGH steps.
    """

    def __init__(
        self,
        context: Context,
        hypotheses: Sequence[Hypothesis],
        sample: SampledRows,
        points: Array,
        scale: ResidualScale,
        single: bool = False,
        on_progress: Callable[[float], object] = lambda share: None,
    ) -> None:
        """Prepare the rows; points: the vertices in the file [m], body axes, (K, 3); single: single precision."""
        self.context, self.hypotheses, self.scale = context, list(hypotheses), scale
        self.trials, self.simulated_steps, self._on_progress = 0, 0, on_progress
        self.rows, self._single = sample, single
        self.stops_at = np.inf
        fitted = golden_subsample(len(sample), FITTED_ROWS)
        self.fitted_rows = sample.some(fitted)
        quick = np.unique(np.linspace(0, len(self.fitted_rows) - 1, QUICK_ROWS).round().astype(int))
        self.quick_rows = self.fitted_rows.some(quick)
        self._quick_vertices = np.ascontiguousarray(np.swapaxes(self.quick_rows.vertices, 1, 2))
        self._quick_trust = (scale.floor_m / (np.sqrt(3.0) * scale.floors_m[fitted][quick]))[:, :, None]
        self._trust = (scale.floor_m / (np.sqrt(3.0) * scale.floors_m[fitted]))[:, None]
        self._program, self._points = context.program, points
        self._duration, self._turn_s = context.duration, context.turn_s
        self._place = {hypothesis: number for number, hypothesis in enumerate(hypotheses)}
        self._poses: dict[tuple, Pose] = {}
        self._quick_fineness = SEARCHING
        self.aim_at(root_mean_square(sample.vertices - sample.true))

    def truncated(self, share: float) -> "Evaluator":
        """Return an evaluator for the rows of the first share of the duration."""
        early = self.rows.times <= share * self._duration
        scale = replace(self.scale, floors_m=self.scale.floors_m[early])
        evaluator = Evaluator(self.context, self.hypotheses, self.rows.some(early), self._points, scale, self._single)
        evaluator.stops_at = self.stops_at
        return evaluator

    def aim_at(self, residual_m: float) -> None:
        """Simulate quick looks as finely as it takes to explain a residual [m]."""
        fineness = COARSE if residual_m > LARGE * self.scale.size_m else SEARCHING
        if fineness != self._quick_fineness:
            self._quick_fineness = fineness
            self._poses.clear()

    def is_spent(self, share: float = 1.0, begun: int = 0) -> bool:
        """Whether a share of the ENOUGH steps of a search has been simulated; begun: steps that do not count."""
        return self.simulated_steps - begun > share * ENOUGH

    def explain(self, mistakes: Mistakes) -> Explanation:
        """Return what mistakes leave of all rows, finely simulated."""
        self.trials += 1
        program = self.program_with(mistakes)
        errors = self._errors(self._output(program, self.rows, FINE), self.rows)
        floors_m = self._single_floor(program) if self._single else None
        rms_m, weighted_rms_m = root_mean_square(errors), root_mean_square(self.scale.weighted(errors, floors_m))
        with np.errstate(over="ignore"):  # a run that diverged
            max_m = float(np.linalg.norm(errors, axis=-1).max())
        within_floor = self.scale.is_within_floor(weighted_rms_m)
        correlation = 0.0 if within_floor else self._autocorrelation(program, errors)
        return Explanation(
            mistakes=mistakes,
            rms_m=rms_m,
            max_m=max_m,
            within_floor=within_floor,
            is_noise=not within_floor
            and self.scale.is_noise(rms_m, max_m, correlation, len(errors) - 1)
            and is_even(errors)
            and not spares_rows(errors, self.scale.floors_m),
            weight=self.scale.weight(root_mean_square(self.scale.weighted(errors)), self.cost(mistakes)),
            weighted_rms_m=weighted_rms_m,
        )

    def _autocorrelation(self, program: ProgramModel, errors: Array) -> float:
        """Return the autocorrelation of errors in world axes or in body axes, the larger one."""
        axes = program.simulate(program.clock.physics_times(self.rows.times), SEARCHING)[:, 3:12].reshape(-1, 3, 3)
        with np.errstate(all="ignore"):
            in_body = np.einsum("tji,tkj->tki", axes, errors)
            return max(autocorrelation(errors), autocorrelation(in_body), key=abs)

    def _single_floor(self, program: ProgramModel) -> Array | None:
        """Return the effect of single precision on a run in steps, (S, 3), None for a continuous one."""
        if program.scheme.attitude == SMOOTH:
            return None
        return single_floor(program, self.rows.times, self._points)[:, None]

    def quick_weight(self, mistakes: Mistakes) -> float:
        """Return the weight of mistakes in a quick look."""
        self.trials += 1
        physical = tuple(m for m in mistakes if m.hypothesis.part not in OUTPUT_PARTS)
        pose = self.transformed(self.pose(physical), [m for m in mistakes if m.hypothesis.part in OUTPUT_PARTS])
        return float(self.quick_weights(pose)[0]) + self.cost(mistakes)

    def log_residual(self, mistakes: Mistakes, fineness: float = SEARCHING) -> float:
        """Return the logarithm of the weighted residual of the fitted rows."""
        with np.errstate(all="ignore"):
            rms_m = root_mean_square(self.residuals(mistakes, fineness)) * self.scale.size_m
            return float(np.log(rms_m + 1e-3 * self.scale.floor_m))

    def residuals(self, mistakes: Mistakes, fineness: float = SEARCHING) -> Array:
        """Return the weighted residuals of the fitted rows over the body's size, a flat array; large if not finite."""
        self.trials += 1
        errors = self._errors(self._output(self.program_with(mistakes), self.fitted_rows, fineness), self.fitted_rows)
        with np.errstate(all="ignore"):
            found = (errors * self._trust).ravel() / self.scale.size_m
        return np.nan_to_num(found, nan=DIVERGED, posinf=DIVERGED, neginf=-DIVERGED)

    def quick_weights(self, stack: Pose) -> Array:
        """Return the weights, without the cost of assumptions, of several runs one after the other, (n,)."""
        rows = len(self.quick_rows)
        with np.errstate(all="ignore"):
            apart = self._rotated(stack).reshape(-1, rows, 3, len(self._points)) - self._quick_vertices
            apart *= self._quick_trust
            rms_m = np.sqrt(np.einsum("nrik,nrik->n", apart, apart) / (rows * len(self._points)))
            return np.where(np.isfinite(rms_m), self.scale.weights(rms_m), np.inf)

    def pose(self, mistakes: Mistakes) -> Pose:
        """Return the output of a program with these mistakes at the quick rows, simulated once."""
        pose = self._poses.get(mistakes)
        if pose is None:
            program = self.program_with(mistakes)
            pose = self._poses[mistakes] = self._output(program, self.quick_rows, self._quick_fineness)
        return pose

    def _output(self, program: ProgramModel, rows: SampledRows, fineness: float) -> Pose:
        """Return the output of a program at rows, and count the steps that its run takes.  Raises SearchStopped."""
        if thread_time() > self.stops_at:
            raise SearchStopped
        scheme, smooth = program.scheme, program.scheme.attitude == SMOOTH
        count = self._duration / (fineness * self._turn_s if smooth else scheme.step)
        stages = 4 if smooth or scheme.attitude == RUNGE_KUTTA else 1
        self.simulated_steps += STARTED + stages * round(min(count, MOST_COUNTED))
        self._on_progress(self.simulated_steps / ENOUGH)
        return program.output(rows.times, fineness)

    def transformed(self, pose: Pose, mistakes: Sequence[Mistake]) -> Pose:
        """Return a pose with mistakes in its output."""
        if not mistakes:
            return pose
        with np.errstate(all="ignore"):
            for transform in self.program_with(mistakes).output_transforms:
                pose = transform(pose)
        return pose

    def nearest_times(self, program: ProgramModel, rows: SampledRows) -> Array:
        """Return the times [s] at which a run comes nearest to rows, whatever the clock, (S,)."""
        from scipy.spatial.distance import cdist  # only a search pays for this import

        count = int(np.clip(IN_A_RADIAN * self._duration / self._turn_s, 2 * len(rows), MOST_STATES))
        times = np.linspace(0, self._duration, count)
        pose = replace(program, clock=RIGHT_CLOCK).output(times)
        with np.errstate(all="ignore"):
            apart = cdist(rows.vertices.reshape(len(rows), -1), self._places(pose).reshape(count, -1))
            nearest = np.argmin(np.where(np.isfinite(apart), apart, np.inf), axis=1).clip(1, count - 2)
            # The minimum of a parabola through the squares of three distances.
            before, at, after = (apart[np.arange(len(rows)), nearest + side] ** 2 for side in (-1, 0, 1))
            offset = np.nan_to_num(0.5 * (before - after) / (before - 2 * at + after)).clip(-1, 1)
        return (nearest + offset) * times[1]

    def program_with(self, mistakes: Sequence[Mistake]) -> ProgramModel:
        """Return the model of a program with these mistakes."""
        program = self._program
        for mistake in mistakes:
            program = mistake.hypothesis.change(program, mistake.value)
        return program

    def cost(self, mistakes: Sequence[Mistake]) -> float:
        """Return the weight of the assumptions: which mistakes, and their values."""
        cost = 0.0
        for mistake in mistakes:
            hypothesis = mistake.hypothesis
            cost += choice_cost(len(self.hypotheses)) + hypothesis.from_data * self.scale.parameter_cost()
            if hypothesis.choices:
                cost += choice_cost(len(hypothesis.choices))
            elif mistake.has_named_value:
                cost += choice_cost(len(hypothesis.named_values))
            elif hypothesis.fitted:
                cost += self.scale.parameter_cost()
        return cost

    def ordered(self, mistakes: Mistakes) -> Mistakes:
        """Return mistakes in the order in which a program makes them."""
        return tuple(sorted(mistakes, key=lambda mistake: self._order(mistake.hypothesis)))

    def _order(self, hypothesis: Hypothesis) -> int:
        """Return the place of a hypothesis; for one of an engine's scheme, the first place of its part."""
        place = self._place.get(hypothesis)
        same = (number for number, other in enumerate(self.hypotheses) if other.part == hypothesis.part)
        return next(same, 0) if place is None else place

    def scheme_weight(self, mistakes: Mistakes) -> float:
        """Return the weight of the mistakes of an engine's scheme over all rows."""
        self.trials += 1
        errors = self._errors(self._output(self.program_with(mistakes), self.rows, SEARCHING), self.rows)
        with np.errstate(all="ignore"):
            rms_m = root_mean_square(self.scale.weighted(errors))
        return self.scale.weight(rms_m, self.cost(mistakes)) if np.isfinite(rms_m) else np.inf

    def _errors(self, pose: Pose, rows: SampledRows) -> Array:
        with np.errstate(all="ignore"):
            return rows.vertices - self._places(pose)

    def _places(self, pose: Pose) -> Array:
        """Return the vertices in a program's output [m], (S, K, 3)."""
        return np.swapaxes(self._rotated(pose), 1, 2)

    def _rotated(self, pose: Pose) -> Array:
        """Return the vertices in a program's output [m], (S, 3, K)."""
        rotated = (pose.axes.reshape(-1, 3) @ self._points.T).reshape(-1, 3, len(self._points))
        return rotated + pose.x[:, :, None] if self.context.has_centre else rotated
