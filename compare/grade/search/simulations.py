"""Simulates many programs at the rows of a search, and returns what each leaves."""

from collections.abc import Sequence

import numpy as np

from tumble.compare.grade.hypotheses.explanation import Mistakes
from tumble.compare.grade.hypotheses.hypothesis import Context
from tumble.compare.grade.hypotheses.mistakes.output import OUTPUT_PARTS
from tumble.compare.grade.measure.speeds import largest_speeds
from tumble.compare.grade.model.program_model import SEARCHING, Pose, ProgramModel, outputs
from tumble.compare.grade.search.clock import search_clock
from tumble.compare.grade.search.shells import Shells
from tumble.scenarios.frames import Array

# Programs that are simulated from one look at the clock to the next.
BETWEEN = 16
# Programs whose poses are kept.
MOST_POSES = 4000
# Columns of a simulated row.
V, W = slice(12, 15), slice(15, 18)


class SearchStopped(Exception):
    """The search has used its processor time."""


class Simulations:
    """Simulates programs with mistakes at the rows of `shells`; trials: their number."""

    def __init__(self, context: Context, shells: Shells, stops_at: float, fineness: float = SEARCHING) -> None:
        self.context, self.shells, self.stops_at, self.trials = context, shells, stops_at, 0
        self.fineness = fineness
        self._poses: dict[Mistakes, Pose] = {}
        self._last: tuple[Mistakes | None, Array] = None, np.empty(0)
        self._programs: dict[Mistakes, ProgramModel] = {(): context.program}

    def errors(self, programs: Sequence[Mistakes]) -> Array:
        """Return the residuals of programs with mistakes, in floors, (V, T, K, 3).  Raises SearchStopped."""
        self.trials += len(programs)
        if len(programs) == 1 and programs[0] == self._last[0]:
            return self._last[1]
        runs = [_run_of(mistakes) for mistakes in programs]
        self._simulate(runs)
        poses = [self._poses[run] for run in runs]
        with np.errstate(all="ignore"):  # a run that diverged
            for number, (mistakes, run) in enumerate(zip(programs, runs, strict=True)):
                if run is not mistakes:
                    for transform in self._written(mistakes, run).output_transforms:
                        poses[number] = transform(poses[number])
        x, axes = np.array([pose.x for pose in poses]), np.array([pose.axes for pose in poses])
        errors = self.shells.residuals(x, axes, self.context.has_centre)
        if len(programs) == 1:
            self._last = programs[0], errors
        return errors

    def _simulate(self, runs: Sequence[Mistakes]) -> None:
        """Simulate programs that are not known yet; those that are known are kept, as long as they are not too many."""
        if len(self._poses) > MOST_POSES:
            self._poses.clear()
            self._programs = {(): self.context.program}
        new = [run for run in dict.fromkeys(runs) if run not in self._poses]
        for begin in range(0, len(new), BETWEEN):
            if search_clock() > self.stops_at:
                raise SearchStopped
            some = new[begin : begin + BETWEEN]
            poses = outputs([self._program(run) for run in some], self.shells.times, self.fineness)
            self._poses.update(zip(some, poses, strict=True))

    def weights(self, programs: Sequence[Mistakes]) -> Array:
        """Return the information criterion of programs, without the cost of assumptions, (V,)."""
        return self.shells.weights(self.errors(programs))

    def event_tick(self, mistakes: Mistakes) -> float:
        """Return the spacing of the instants at which events happen in a program with mistakes [s]; 0: any."""
        return self._program(mistakes).event_tick

    def fastest(self, mistakes: Mistakes) -> dict[str, float]:
        """Return the largest speeds of a program with mistakes, each by its name in `measure.speeds.SPEEDS`."""
        program = self._program(mistakes)
        rows = program.simulate(program.clock.physics_times(self.shells.times), self.fineness)
        return largest_speeds(rows[:, V], rows[:, W])

    def _program(self, mistakes: Mistakes) -> ProgramModel:
        """Return the model of a program with mistakes; it is kept, as are those with the first ones of them."""
        found = self._programs.get(mistakes)
        if found is None:
            hypothesis, value = mistakes[-1]
            found = self._programs[mistakes] = hypothesis.change(self._program(mistakes[:-1]), value)
        return found

    def _written(self, mistakes: Mistakes, run: Mistakes) -> ProgramModel:
        """Return the model of a program with mistakes, of which a run has all but those of its output."""
        program = self._program(run)
        for hypothesis, value in mistakes:
            if hypothesis.part in OUTPUT_PARTS:
                program = hypothesis.change(program, value)
        return program


def _run_of(mistakes: Mistakes) -> Mistakes:
    """Return those of the mistakes that change the run, and not only its output."""
    for mistake in mistakes:
        if mistake.hypothesis.part in OUTPUT_PARTS:
            return tuple(m for m in mistakes if m.hypothesis.part not in OUTPUT_PARTS)
    return mistakes
