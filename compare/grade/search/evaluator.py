"""Evaluates explanations: what mistakes leave of all rows, finely simulated, and what it costs to assume them."""

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from tumble.compare.grade.hypotheses.explanation import Explanation, Mistake, Mistakes
from tumble.compare.grade.hypotheses.hypothesis import Context, Hypothesis
from tumble.compare.grade.measure.errors import SampledRows
from tumble.compare.grade.measure.lateness import Lateness, first_motion, lateness
from tumble.compare.grade.measure.noise import most_noise_m, white_noise_m
from tumble.compare.grade.measure.significance import (
    EXPLAINED,
    FEWEST_PAIRS,
    ResidualScale,
    autocorrelation,
    choice_cost,
    is_even,
    root_mean_square,
    spares_rows,
)
from tumble.compare.grade.measure.single_precision import fine_step, single_floor, stepwise
from tumble.compare.grade.measure.speeds import rests_from, speeds_reached
from tumble.compare.grade.model.kernel.dynamics import SMOOTH
from tumble.compare.grade.model.program_model import SEARCHING, ZERO_ORDER_HOLD, ProgramModel
from tumble.scenarios.frames import Array

# Steps in a row interval of a program of which nothing is known yet.
USUAL_STEPS = 4
# A residual of so many floors, of the digits or of single precision, is only the error of the two simulations if it is
# at most this share of what no mistake leaves.
NEARLY_DIGITS, NEARLY_SINGLE, SMALL_SHARE = 4.0, 3.0, 1e-3
# Residuals of vertices that may be noise, over that of the centre, since the attitude may have more.
MOST_NOISE = 100.0
# What errors of vertices begin with, over the noise of the centre that rows allow.
MOST_AT_FIRST = 10.0
# Effects of single precision that may be seen in noise, over that.
MOVED = (1.0, 0.25)
# Steps in a row interval that a program may take.
PARTS = 200
# Steps in a row interval of programs whose steps are too short to be seen but for their rounding, and the shortest [s].
SHORT_STEPS, SHORTEST_S = (50, 100, 200), 2e-4


class Evaluator:
    """Evaluates mistakes against the sampled rows of one throw.

    rows: the sample; points: the vertices in the file [m], axes of the body, (K, 3); scale: what residuals are compared
    to, without single precision; single: the program may be of single precision; is_known: it is; hypotheses: in the
    order in which a program makes the mistakes; trials: number of simulated programs.
    """

    def __init__(
        self,
        context: Context,
        hypotheses: Sequence[Hypothesis],
        sample: SampledRows,
        points: Array,
        scale: ResidualScale,
        single: bool = False,
        is_known: bool = False,
    ) -> None:
        self.context, self.hypotheses, self.scale = context, list(hypotheses), scale
        self.rows, self.points, self.is_known = sample, points, is_known
        self.trials = 0
        self._costs: dict[tuple[Hypothesis, bool], float] = {}
        self._explanations: dict[tuple[Mistakes, float], Explanation] = {}
        self._events = np.array([impulse.time for impulse in context.program.impulses])
        are_vertices = context.kind == "vertices"
        # Rounding is noise too, of a floor at most.
        self._noise_m = white_noise_m(
            sample.times, sample.vertices, points, self._events, context.program.rounding, are_vertices, scale.floors_m
        )
        # What noise was added to is no number of single precision, though the program may be of that.
        self.single = single or self.is_noisy
        self.double_scale = self.scale.with_noise(self._noise_m)
        usual = stepwise(context.program, context.spacing_s / USUAL_STEPS)
        self.search_scale = self._with_single(usual).with_noise(self._noise_m)

    def explain(self, mistakes: Mistakes, unseen_step_s: float = 0.0) -> Explanation:
        """Return what mistakes leave of all rows, finely simulated.

        If the program may be of single precision, it is of what makes the residual more likely, that or double.
        unseen_step_s: of a program whose steps have no effect but their rounding [s]; 0 for usual short steps.
        """
        key = mistakes, unseen_step_s
        if key not in self._explanations:
            self._explanations[key] = self._explain(mistakes, unseen_step_s)
        return self._explanations[key]

    def _explain(self, mistakes: Mistakes, unseen_step_s: float) -> Explanation:
        self.trials += 1
        program = self.program_with(mistakes)
        errors = self._errors(program)
        scale = self._with_single(program, unseen_step_s)
        rms_m = root_mean_square(errors)
        in_floors, in_digits, in_common = (each.in_floors(errors) for each in (scale, self.scale, self.search_scale))
        # Rows with as much noise are as precise, whatever their floors.
        known, noisy = self.double_scale, scale.with_noise(self._noise_m)
        in_noise = noisy.in_floors(errors)
        in_double = known.in_floors(errors)
        weights = noisy.weight(in_noise, self._vagueness(noisy)), known.weight(in_double, 0.0)
        is_little = in_digits <= NEARLY_DIGITS or in_floors <= NEARLY_SINGLE
        is_nearly = bool(mistakes) and is_little and in_common <= SMALL_SHARE * self._null_in_common
        within_floor = in_floors <= EXPLAINED or is_nearly
        return Explanation(
            mistakes=mistakes,
            rms_m=rms_m,
            max_m=_largest(errors),
            within_floor=within_floor,
            is_noise=not within_floor and self._is_noise(program, errors, scale),
            weight=self.cost(mistakes) + min(weights),
            weighted_rms_m=in_noise * known.floor_m,
            in_digits=in_digits,
            in_double=in_double,
            in_floors=in_floors,
            in_common=in_common,
        )

    def in_short_steps(self, best: Explanation) -> Explanation:
        """Return an explanation whose program takes the longest of some short steps that explain the rest, if one does.

        In single precision, many steps round more than few.
        """
        is_nearly = best.mistakes and best.in_common <= SMALL_SHARE * self._null_in_common
        if not is_nearly or not self.single or self.program_with(best.mistakes).scheme.attitude != SMOOTH:
            return best
        for step_s in self._short_steps:
            found = self.explain(best.mistakes, step_s)
            if found.is_whole:
                return found
        return best

    @property
    def is_noisy(self) -> bool:
        """Whether the file has noise that is no rounding."""
        return self._noise_m > 0.0

    @cached_property
    def reached(self) -> dict[str, list[float]]:
        """The velocities [m/s] and spins [rad/s] that the rows reach."""
        return speeds_reached(self.rows.times, self.rows.vertices, self.points, self.double_scale.floors_m)

    @cached_property
    def _most_noise_m(self) -> float:
        """What the noise of a coordinate is at most [m], as far as rows show that."""
        rounding_s = self.context.program.rounding
        return most_noise_m(self.rows.times, self.rows.vertices, self.points, self._events, rounding_s)

    @cached_property
    def rests_from(self) -> float:
        """The time from which the rows rest [s]."""
        return rests_from(self.rows.times, self.rows.vertices, self.search_scale.floors_m)

    @cached_property
    def lateness(self) -> Lateness | None:
        """By how much the rows are late, if their first interval shows it."""
        rows = self.rows
        return lateness(rows.times, rows.vertices, rows.true, self.search_scale.floors_m)

    @cached_property
    def first_motion(self) -> tuple[float, float] | None:
        """The rows [s] between which the body begins to move, if it rests for longer than an interval."""
        rows = self.rows
        return first_motion(rows.times, rows.vertices, rows.true, self.search_scale.floors_m)

    @cached_property
    def _null_in_common(self) -> float:
        """What no mistake leaves of all rows, in the floors that a search has for every program."""
        return self.search_scale.in_floors(self._errors(self.context.program))

    def is_within_single_steps(self) -> bool:
        """Return whether single precision of one step a row explains the rows; in shorter steps it explains more."""
        scale = self._with_single(stepwise(self.context.program, self.context.spacing_s))
        errors = self._errors(self.context.program)
        return scale.in_floors(errors) <= EXPLAINED

    def is_within_short_steps(self) -> bool:
        """Return whether single precision explains the rows in steps that are shorter than the usual short ones."""
        usual_s, null = fine_step(self.context.spacing_s), self.explain(())
        # The effect grows with the number of steps at most.
        return self.single and any(
            null.in_floors <= EXPLAINED * usual_s / step_s and self.explain((), step_s).within_floor
            for step_s in self._short_steps
        )

    @property
    def _short_steps(self) -> list[float]:
        """The steps that are shorter than the usual short ones [s], the longest first."""
        spacing_s = self.context.spacing_s
        steps = [spacing_s / parts for parts in SHORT_STEPS]
        return [step_s for step_s in steps if SHORTEST_S <= step_s < fine_step(spacing_s)]

    def _errors(self, program: ProgramModel) -> Array:
        """Return what a finely simulated program leaves of all rows [m], (S, K, 3)."""
        pose = program.output(self.rows.times, self.context.fineness)
        with np.errstate(all="ignore"):
            places = np.swapaxes((pose.axes.reshape(-1, 3) @ self.points.T).reshape(-1, 3, len(self.points)), 1, 2)
            return self.rows.vertices - (places + pose.x[:, None] if self.context.has_centre else places)

    def is_within_floor(self, mistakes: Mistakes, errors: Array, times: Array, floors_m: Array) -> bool:
        """Return whether residuals in the floors of a search, (T, K, 3), are within those of the program itself.

        times [s], (T,); floors_m: of the search, (T, 3).
        """
        program = self.program_with(mistakes)
        if not self.may_be_single(program):
            return False
        known = np.interp(times, self.rows.times, np.square(self.scale.floors_m).mean(axis=1))
        with np.errstate(all="ignore"):  # a run that diverged
            own = self._single_m(program, times)
            ratio = np.square(floors_m).mean(axis=1) / (known + np.square(own) / 3)
            squares = np.square(errors).mean(axis=(1, 2))
            left = float(np.sqrt((squares * ratio).mean()))
        return self.scale.is_within_floor(left * self.scale.floor_m)

    def _with_single(self, program: ProgramModel, unseen_step_s: float = 0.0) -> ResidualScale:
        """Return the scale with the effect of single precision on a program, if it may have any."""
        if not self.may_be_single(program):
            return self.scale
        return self.scale.with_single(self._single_m(program, self.rows.times, unseen_step_s))

    def may_be_single(self, program: ProgramModel) -> bool:
        """Whether a program may be of single precision: what is interpolated between its ticks may be of double."""
        return self.single or program.clock.interpolation != ZERO_ORDER_HOLD

    def _single_m(self, program: ProgramModel, times: Array, unseen_step_s: float = 0.0) -> Array:
        """Return the effect of single precision at times [s], in m, (T,).

        unseen_step_s: of a program whose own steps have no other effect [s]; 0 for usual short ones.
        """
        if program.scheme.attitude == SMOOTH:
            program = stepwise(program, unseen_step_s or fine_step(self.context.spacing_s))
        return single_floor(program, times, self.points)

    def _vagueness(self, scale: ResidualScale) -> float:
        """Return the weight of a larger noise floor, which explains more: of the likelihood of normal deviations."""
        return 2.0 * scale.numbers * float(np.log(scale.floors_m / self.double_scale.floors_m).mean())

    def _is_noise(self, program: ProgramModel, errors: Array, scale: ResidualScale) -> bool:
        """Return whether a program's errors of rows, (S, K, 3), are noise; or noise at first, and what rounding adds.

        Errors of single precision grow: rows that it may move by a part of the noise are compared with both.
        scale: with the effect of single precision, if the program may be of that.
        """
        if self._is_white(program, errors, scale):
            return True
        noise_m = self._noise_m or self._noise_at_first(errors)
        if not noise_m:
            return False
        effects, both = np.sqrt(np.square(scale.floors_m).mean(axis=1)), scale.with_noise(noise_m)
        begins = {int((effects > share * noise_m).argmax()) for share in MOVED}
        return any(
            both.is_within_floor(root_mean_square(both.weighted(errors)[begin:]))
            and self._is_white(program, errors[:begin], scale)
            for begin in begins
            if begin > FEWEST_PAIRS
        )

    def _noise_at_first(self, errors: Array) -> float:
        """Return what errors of rows, (S, K, 3), begin with, in a coordinate [m]; 0 if that can be no noise."""
        noise_m = root_mean_square(errors[: FEWEST_PAIRS + 1]) / np.sqrt(3.0)
        return noise_m if noise_m <= MOST_AT_FIRST * self._most_noise_m else 0.0

    def _is_white(self, program: ProgramModel, errors: Array, scale: ResidualScale) -> bool:
        """Return whether a program's errors of the first rows, (R, K, 3), are white noise."""
        rms_m = root_mean_square(errors)
        # The autocorrelation needs a simulation.
        return (
            (not self.is_noisy or rms_m <= MOST_NOISE * self._noise_m)
            and scale.is_noise(rms_m, _largest(errors), self._autocorrelation(program, errors), len(errors) - 1)
            and is_even(errors)
            and not spares_rows(errors, scale.floors_m[: len(errors)])
        )

    def _autocorrelation(self, program: ProgramModel, errors: Array) -> float:
        """Return the autocorrelation of the errors of the first rows in world axes or in body axes, the larger one."""
        times = self.rows.times[: len(errors)]
        axes = program.simulate(program.clock.physics_times(times), SEARCHING)[:, 3:12].reshape(-1, 3, 3)
        with np.errstate(all="ignore"):
            in_body = np.einsum("tji,tkj->tki", axes, errors)
            return max(autocorrelation(errors), autocorrelation(in_body), key=abs)

    def program_with(self, mistakes: Sequence[Mistake]) -> ProgramModel:
        """Return the model of a program with these mistakes."""
        program = self.context.program
        for mistake in mistakes:
            program = mistake.hypothesis.change(program, mistake.value)
        return program

    def cost(self, mistakes: Sequence[Mistake]) -> float:
        """Return the weight of the assumptions: which mistakes, and their values."""
        return sum(map(self._cost_of, mistakes))

    def _cost_of(self, mistake: Mistake) -> float:
        key = mistake.hypothesis, mistake.has_named_value
        if key not in self._costs:
            self._costs[key] = self._new_cost(*key)
        return self._costs[key]

    def _new_cost(self, hypothesis: Hypothesis, is_named: bool) -> float:
        numbers = hypothesis.from_data + (hypothesis.dimension if hypothesis.scale else 0)
        cost = choice_cost(len(self.hypotheses)) + hypothesis.unlikely + numbers * self.scale.parameter_cost()
        if hypothesis.choices:
            cost += choice_cost(len(hypothesis.choices))
        elif is_named:
            cost += choice_cost(len(hypothesis.named_values))
        elif hypothesis.fitted and not hypothesis.scale:
            cost += self.scale.parameter_cost()
        elif hypothesis.part == "steps":  # any part of a row interval
            cost += choice_cost(PARTS)
        return cost


def _largest(errors: Array) -> float:
    """Return the length of the largest error, (S, K, 3)."""
    with np.errstate(all="ignore"):  # a run that diverged
        return float(np.linalg.norm(errors, axis=-1).max())
