"""Simulates many programs at the rows of a search, and returns what each leaves."""

from collections.abc import Sequence
from time import thread_time

import numpy as np

from tumble.compare.grade.hypotheses.explanation import Mistakes
from tumble.compare.grade.hypotheses.hypothesis import Context
from tumble.compare.grade.hypotheses.mistakes.output import OUTPUT_PARTS
from tumble.compare.grade.model.program_model import SEARCHING, Pose, ProgramModel
from tumble.compare.grade.search.shells import Shells
from tumble.scenarios.frames import Array

# Programs that are simulated from one look at the clock to the next.
BETWEEN = 16
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
        self._programs: dict[Mistakes, ProgramModel] = {(): context.program}

    def errors(self, programs: Sequence[Mistakes]) -> Array:
        """Return the residuals of programs with mistakes, in floors, (V, T, K, 3).  Raises SearchStopped."""
        self.trials += len(programs)
        shells = self.shells
        x, axes = np.empty((len(programs), len(shells), 3)), np.empty((len(programs), len(shells), 3, 3))
        for number, mistakes in enumerate(programs):
            if number % BETWEEN == 0 and thread_time() > self.stops_at:
                raise SearchStopped
            pose = self._pose(mistakes)
            x[number], axes[number] = pose.x, pose.axes
        return shells.residuals(x, axes, self.context.has_centre)

    def weights(self, programs: Sequence[Mistakes]) -> Array:
        """Return the information criterion of programs, without the cost of assumptions, (V,)."""
        return self.shells.weights(self.errors(programs))

    def event_tick(self, mistakes: Mistakes) -> float:
        """Return the spacing of the instants at which events happen in a program with mistakes [s]; 0: any."""
        return self._program(mistakes).event_tick

    def fastest(self, mistakes: Mistakes) -> dict[str, float]:
        """Return the largest velocity [m/s] and spin [rad/s] of a program with mistakes."""
        program = self._program(mistakes)
        rows = program.simulate(program.clock.physics_times(self.shells.times), self.fineness)
        with np.errstate(all="ignore"):
            v, w = (float(np.sqrt(np.square(rows[:, part]).sum(axis=1)).max()) for part in (V, W))
        return {"velocity": np.nan_to_num(v, nan=0.0, posinf=0.0), "spin": np.nan_to_num(w, nan=0.0, posinf=0.0)}

    def _program(self, mistakes: Mistakes) -> ProgramModel:
        """Return the model of a program with mistakes; programs with the first ones of them are kept."""
        if not mistakes:
            return self.context.program
        first = self._programs.get(mistakes[:-1])
        if first is None:
            first = self._programs[mistakes[:-1]] = self._program(mistakes[:-1])
        return mistakes[-1].hypothesis.change(first, mistakes[-1].value)

    def _pose(self, mistakes: Mistakes) -> Pose:
        written = tuple(m for m in mistakes if m.hypothesis.part in OUTPUT_PARTS)
        run = tuple(m for m in mistakes if m.hypothesis.part not in OUTPUT_PARTS) if written else mistakes
        pose = self._poses.get(run)
        if pose is None:
            if len(self._poses) > 4000:
                self._poses.clear()
                self._programs = {(): self.context.program}
            pose = self._poses[run] = self._program(run).output(self.shells.times, self.fineness)
        if written:
            with np.errstate(all="ignore"):
                for transform in self._program(mistakes).output_transforms:
                    pose = transform(pose)
        return pose
