"""Stability of a contestant: a map over one parameter of the scene and the step, and the largest stable step.

A scene is run at several values of the parameter that makes it stiff (`natural_parameter`), each for the same number of
radians of its stiffest mode, so that the step is w dt on one scale for all.  Every cell of the map is a run compared
with the reference.  The limit is then found at the scene's own value by bisection, with runs of PROBED steps of exactly
one length, which need no reference: up to the limit the energy stays bounded (`verdict.bounded`).  Where theory has a
limit, the search begins just below and just above it.
"""

import math
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise

import numpy as np

from tumble.compare.judge.errors import Run, RunAnswer
from tumble.compare.judge.verdict import Verdict, bounded, verdict
from tumble.compare.run.running_engines import RunningEngine
from tumble.compare.stability.columns import PROBED, ROWS, Column, Question, truth_of
from tumble.compare.stability.schemas import LimitRow, StabilityRow
from tumble.compare.stability.theory import Theory, theory
from tumble.compare.tables.runs import boundless, contestant_columns, status_columns
from tumble.scenarios.scene import Scene
from tumble.scenarios.truth import Truth

# Steps of a run, for w dt of 57, 28, 14, ..., 0.06.  At other values than the scene's own: every other of these down to
# 0.22, and those between two different verdicts.
STEPS = tuple(2**k for k in range(2, 13))
COARSE_STEPS = STEPS[:9:2]


@dataclass(frozen=True)
class Effort:
    """The steps of the runs at a scene's own value, and the relative precision of limits."""

    steps: tuple[int, ...] = STEPS
    precision: float = 0.005


FULL = Effort()
# For the page: no steps finer than those at other values, which take longest.
BRIEF = Effort(STEPS[:9], 0.02)
# A true limit is also stable at half the step for four times as many steps; growth per step like (w dt)^2, which only
# needs time to show at any step, is not.
HALF, LONGER = 0.5, 4
ONE_PERCENT, ONE_MM = 0.01, 1e-3


@dataclass(frozen=True)
class Piece:
    """The results of one contestant in one scene, which are complete or absent.

    Parameters
    ----------
    rows : one for each run
    limit : the largest stable step
    """

    rows: tuple[StabilityRow, ...]
    limit: LimitRow


@dataclass(frozen=True, eq=False)
class Cell:
    """One run, its step [s], and its verdict."""

    column: Column
    dt: float
    run: Run
    verdict: Verdict

    @property
    def w_dt(self) -> float:
        """The step in radians of the stiffest mode."""
        return self.dt * self.column.mode.rate

    @property
    def bounded(self) -> bool:
        """Whether the energy stays bounded."""
        return bounded(self.run, self.verdict)

    @property
    def error(self) -> float:
        """The largest vertex error [m], at least the resolution of the reference; infinite if there is none."""
        if not self.run.has_errors or not np.isfinite(self.run.distances).all():
            return math.inf
        return max(float(self.run.distances.max()), float(self.run.limits.max()))

    @property
    def row(self) -> StabilityRow:
        """Its row."""
        errors = self.run.has_errors
        return StabilityRow(
            **contestant_columns(self.run),
            dt_s=self.dt,
            parameter=self.column.parameter.name,
            value=self.column.value,
            **status_columns(self.run),
            verdict=self.verdict.word,
            max_error_m=boundless(self.run.distances.max()) if errors else None,
            energy_ratio=self.verdict.energy_ratio,
            resolution_m=float(self.run.limits.max()) if errors else None,
        )


@dataclass(frozen=True, eq=False)
class Trials:
    """One contestant in one scene."""

    running_engine: RunningEngine
    method: str
    question: Question
    effort: Effort = FULL
    _cells: dict[tuple[int, int], Cell] = field(default_factory=dict, init=False)

    def cell(self, place: int, steps: int) -> Cell:
        """Return one cell of the map, which is run once."""
        if (place, steps) not in self._cells:
            column = self.question.columns[place]
            scene = column.scene_of(steps)
            true = truth_of(scene, self.question.truths[place].result().truth)
            self._cells[place, steps] = self._evaluated(column, scene, column.seconds / steps, true)
        return self._cells[place, steps]

    def probe(self, dt: float, steps: int = PROBED) -> Cell:
        """Return a long run of steps of exactly dt [s], evaluated by its energy alone."""
        column = self.question.columns[self.question.own]
        return self._evaluated(column, column.probe(dt, steps), dt, None)

    def _evaluated(self, column: Column, scene: Scene, dt: float, true: Truth | None) -> Cell:
        answer = self.running_engine.simulate(scene, self.method, dt)
        run = RunAnswer.of(self.running_engine, self.method, dt, answer).run(scene, self.running_engine.title, true)
        return Cell(column, dt, run, verdict(run))

    def piece(self) -> Piece:
        """Return the map and the limits."""
        own = self.question.own
        first = self.cell(own, ROWS)
        if first.verdict.word == "refused":
            return Piece((first.row,), self.limit_row(note=first.verdict.why))
        places = range(len(self.question.columns))
        if self.running_engine.takes_own_steps(self.method):
            cells = [self.cell(place, ROWS) for place in places]
            return Piece(tuple(cell.row for cell in cells), self.limit_row(note="chooses its own steps"))
        maps = [
            [self.cell(place, steps) for steps in self.effort.steps] if place == own else self.coarse_to_fine(place)
            for place in places
        ]
        rows = tuple(cell.row for cells in maps for cell in cells)
        return Piece(rows, self.limits(maps[own][::-1]))

    def coarse_to_fine(self, place: int) -> list[Cell]:
        """Return the cells of one value, the longest step first: a coarse set, and those between two verdicts."""
        coarse = {steps: self.cell(place, steps) for steps in COARSE_STEPS}
        between = [
            2 * few for few, many in pairwise(COARSE_STEPS) if coarse[few].verdict.word != coarse[many].verdict.word
        ]
        cells = coarse | {steps: self.cell(place, steps) for steps in between}
        return [cells[steps] for steps in sorted(cells)]

    def limits(self, ladder: list[Cell]) -> LimitRow:
        """Return the row of limits from the cells of the scene's own value, the smallest step first."""
        w_dt, beyond = self.stable_limit(ladder)
        rate = ladder[0].column.mode.rate
        dt_stable = None if not w_dt else min(w_dt / rate, ladder[-1].dt)
        farthest = self.farthest(ladder[0])
        no_truth = ladder[0].run.truth is None
        return self.limit_row(
            w_dt,
            beyond,
            dt_stable,
            None if no_truth else self.largest_within(ladder, ONE_PERCENT * farthest),
            None if no_truth else self.largest_within(ladder, ONE_MM),
            "no reference solution: by the energy balance alone" if no_truth else "",
        )

    def stable_limit(self, ladder: list[Cell]) -> tuple[float, str]:
        """Return the w dt up to which the energy stays bounded, and the verdict beyond.

        A bisection may miss a narrow resonance below the limit it finds; a map has no finer cells either.
        """
        bad = next((place for place, cell in enumerate(ladder) if not cell.bounded), len(ladder))
        beyond = ladder[bad].verdict.word if bad < len(ladder) else ""
        # A run of RADIANS can be too short to show what one of PROBED steps does.
        while bad > 0 and not (found := self.probe(ladder[bad - 1].dt)).bounded:
            bad, beyond = bad - 1, found.verdict.word
        if 0 < bad < len(ladder):
            low, high = ladder[bad - 1].dt, ladder[bad].dt
            rate = ladder[0].column.mode.rate
            near = self.theory.w_dt / rate if self.theory else None
            dt = edge(low, high, lambda dt: self.probe(dt).bounded, self.effort.precision, near)
            if self.probe(HALF * dt, LONGER * PROBED).bounded:
                return dt * rate, beyond
        return (math.inf if bad == len(ladder) else 0.0), beyond

    @cached_property
    def theory(self) -> Theory | None:
        """The limit at the scene's own value by theory."""
        column = self.question.columns[self.question.own]
        return theory(self.running_engine, self.method, column.scene, column.mode)

    @staticmethod
    def farthest(cell: Cell) -> float:
        """Return the largest true displacement of a vertex [m]."""
        true = cell.run.truth
        return 0.0 if true is None else float(np.linalg.norm(true.vertices - true.vertices[0], axis=-1).max())

    def largest_within(self, ladder: list[Cell], target_m: float) -> float | None:
        """Return the largest step up to which all errors are within a target [s], None if the smallest step's is not.

        Between two steps of the sequence those are tried that divide the interval of two samples.
        """
        bad = next((place for place, cell in enumerate(ladder) if cell.error > target_m), len(ladder))
        if bad == 0:
            return None
        if bad == len(ladder):
            return ladder[-1].dt
        seconds = ladder[0].column.seconds
        few, many = (round(seconds / (cell.dt * ROWS)) for cell in (ladder[bad], ladder[bad - 1]))
        while few and many - few > 1 and many > (1 + self.effort.precision) * few:
            middle = round(math.sqrt(few * many))
            if self.cell(self.question.own, middle * ROWS).error > target_m:
                few = middle
            else:
                many = middle
        return seconds / (many * ROWS) if many else ladder[bad - 1].dt

    def limit_row(
        self,
        w_dt: float | None = None,
        beyond: str = "",
        dt_stable: float | None = None,
        dt_1pct: float | None = None,
        dt_1mm: float | None = None,
        note: str = "",
    ) -> LimitRow:
        """Return the row of limits, with theory's beside it."""
        column, known = self.question.columns[self.question.own], self.theory
        return LimitRow(
            scene=column.scene.name,
            engine=self.running_engine.title,
            method=self.method,
            parameter=column.parameter.name,
            value=column.value,
            w_rad_s=column.mode.rate,
            w_dt_limit=w_dt,
            beyond=beyond,
            theory_w_dt=None if known is None else known.w_dt,
            theory="" if known is None else known.source,
            dt_stable_s=dt_stable,
            dt_1pct_s=dt_1pct,
            dt_1mm_s=dt_1mm,
            note=note,
        )


def edge(low: float, high: float, holds: Callable[[float], bool], within: float, near: float | None = None) -> float:
    """Return the largest number at which `holds`, true at low and false at high, is true, to a relative precision.

    near: where it may be; just below and just above that are tried first, then farther and farther from it.
    """
    if near is not None and low < near < high:
        factor = math.sqrt(1 + within) * (1 - sys.float_info.epsilon)
        while low < near / factor or near * factor < high:
            for tried in (near / factor, near * factor):
                if low < tried < high:
                    low, high = (tried, high) if holds(tried) else (low, tried)
            factor = factor**4
    while high > (1 + within) * low:
        middle = math.sqrt(low * high)
        low, high = (middle, high) if holds(middle) else (low, middle)
    return float(low)
