"""Simulates many programs at the rows of a search, and returns what each leaves."""

from collections.abc import Sequence

import numpy as np

from tumble.compare.grade.hypotheses.explanation import Mistakes
from tumble.compare.grade.hypotheses.hypothesis import Context
from tumble.compare.grade.hypotheses.mistakes.output import OUTPUT_PARTS
from tumble.compare.grade.measure.speeds import largest_speeds
from tumble.compare.grade.model.program_model import SEARCHING, OutputTransform, Pose, ProgramModel, poses, written
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
        # Where the poses of a run are among those that are kept, before output transforms.
        self._places: dict[Mistakes, int] = {}
        self._x, self._axes, self._q = self._room(MOST_POSES)
        self._last: tuple[Mistakes | None, Array] = None, np.empty(0)
        self._programs: dict[Mistakes, ProgramModel] = {(): context.program}

    def errors(self, programs: Sequence[Mistakes]) -> Array:
        """Return the residuals of programs with mistakes, in floors, (V, T, K, 3).  Raises SearchStopped."""
        self.trials += len(programs)
        if len(programs) == 1 and programs[0] == self._last[0]:
            return self._last[1]
        runs = [_run_of(mistakes) for mistakes in programs]
        self._simulate(runs)
        places = [self._places[run] for run in runs]
        x, axes = self._x[places], self._axes[places]
        for number, (mistakes, run) in enumerate(zip(programs, runs, strict=True)):
            if transforms := self._transforms(mistakes, run):
                pose = Pose(self.shells.times, x[number], axes[number], self._q[places[number]])
                _, x[number], axes[number], _ = written(pose, transforms)
        errors = self.shells.residuals(x, axes, self.context.has_centre)
        if len(programs) == 1:
            self._last = programs[0], errors
        return errors

    def _simulate(self, runs: Sequence[Mistakes]) -> None:
        """Simulate programs that are not known yet; those that are known are kept, as long as there is room."""
        new = [run for run in dict.fromkeys(runs) if run not in self._places]
        if len(self._places) + len(new) > len(self._x):
            self._places.clear()
            self._programs = {(): self.context.program}
            new = list(dict.fromkeys(runs))
            if len(new) > len(self._x):
                self._x, self._axes, self._q = self._room(len(new))
        for begin in range(0, len(new), BETWEEN):
            if search_clock() > self.stops_at:
                raise SearchStopped
            some = new[begin : begin + BETWEEN]
            first = len(self._places)
            kept = slice(first, first + len(some))
            found = poses([self._program(run) for run in some], self.shells.times, self.fineness)
            self._x[kept], self._axes[kept], self._q[kept] = found
            self._places.update(zip(some, range(first, first + len(some)), strict=True))

    def _room(self, count: int) -> tuple[Array, Array, Array]:
        """Return room for so many poses in each row: x, axes and q."""
        return tuple(np.empty((count, len(self.shells), *shape)) for shape in ((3,), (3, 3), (4,)))  # type: ignore[return-value]

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

    def _transforms(self, mistakes: Mistakes, run: Mistakes) -> tuple[OutputTransform, ...]:
        """Return the output transforms of a program with mistakes, of which a run has all but those of its output."""
        program = self._program(run)
        if run is not mistakes:
            for hypothesis, value in mistakes:
                if hypothesis.part in OUTPUT_PARTS:
                    program = hypothesis.change(program, value)
        return program.output_transforms


def _run_of(mistakes: Mistakes) -> Mistakes:
    """Return those of the mistakes that change the run, and not only its output."""
    for mistake in mistakes:
        if mistake.hypothesis.part in OUTPUT_PARTS:
            return tuple(m for m in mistakes if m.hypothesis.part not in OUTPUT_PARTS)
    return mistakes
