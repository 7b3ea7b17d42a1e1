"""How far the answer of an integration can be trusted, and how far a program in doubles can be held to it.

The flight is made twice, by series of two orders at two tolerances, and in doubles again for changes of the inputs.
"""

from functools import cache
from random import Random
from time import thread_time
from typing import Any

import numpy as np

from tumble.scenarios.frames import Array
from tumble.scenarios.scene import Scene
from tumble.scenarios.truth.flight import Pose
from tumble.scenarios.truth.forced.flight import Budget, Integration, length_of
from tumble.scenarios.truth.forced.laws import AXES, MOMENTUM, V, X
from tumble.scenarios.truth.forced.passage import Accuracy
from tumble.scenarios.truth.forced.together import side_by_side
from tumble.scenarios.truth.inertia import inverse
from tumble.scenarios.truth.resolution import PATTERNS, TRUSTED, Answer, Flight, in_proportion
from tumble.scenarios.truth.throw import Throw, changing, read_throw

# Of the numbers told: those of the two doubles that the integration keeps of each, and some for arithmetic.
BITS = 128
# The answer; the rougher flight that tells how good it is; and those that tell what the inputs do.
FINE, ROUGH = Accuracy(32, 2.0**-94, True, (13, 1e-21)), Accuracy(26, 2.0**-76, True, (10, 1e-16))
# For the inputs: in doubles, but where something dies out too fast for series, with few stages.
PLAIN, QUICK = Accuracy(18, 2.0**-53, False, (0, 0.0)), Accuracy(26, 2.0**-76, True, (7, 1e-12))
SAFETY = 2.0
# A step rounds each number by some 2^-103 of it; what half a last bit of the inputs does, 2^-54, is the floor.
ROUNDING_PER_STEP = 2.0**-47
# The inputs are changed by many times half their last bit, so that what comes of it stands out from the doubles'
# rounding, and the effect is scaled down.
CHANGES, QUICK_CHANGES = ((PLAIN, 2.0**23), (PLAIN, 2.0**8)), ((QUICK, 2.0**36),)
# So many steps make a flight slow; and how many times as many instants are tried next.
MANY_STEPS, FURTHER = 5000, 4
# The pattern and the share of a throw as it is written; how many flights it takes to see whether effects are even.
UNCHANGED, TRIED = (0, 0.0), 3


def answer(mp: Any, scene: Scene, row: int, throw: Throw) -> Answer:
    """Return one throw of a scene with forces, as far as it could be worked out.  Raises RayMissed."""
    mp.prec = BITS
    fine, rough = (Integration(throw, accuracy, Budget()).run() for accuracy in (FINE, ROUGH))
    changes = QUICK_CHANGES if fine.crept else CHANGES
    input_error, why = input_error_of(scene, row, throw, min(len(fine.rows), len(rough.rows)), changes, fine.steps)
    known = len(input_error)
    points = throw.points.astype(float)
    apart = moved(rough.rows[:known], fine.rows[:known], points, 0 * points)[:, 0]
    error = SAFETY * np.maximum.accumulate(apart) + ROUNDING_PER_STEP * fine.steps * np.maximum.accumulate(input_error)
    poses = _poses(mp, fine.rows[:known], throw)
    by = f"Taylor series of orders {FINE.order} and {ROUGH.order}"
    by += f", Radau collocation of {FINE.creeping[0]} and {ROUGH.creeping[0]} stages" if fine.crept else ""
    how = f"{by}, in 32 digits, restarted at every switch"
    return Answer(Flight(BITS, poses), error, input_error, how, why or fine.why or rough.why)


def simulate(mp: Any, throw: Throw) -> Flight:
    """Return the answer alone, as far as it could be worked out.  Raises RayMissed."""
    mp.prec = BITS
    return Flight(BITS, _poses(mp, Integration(throw, FINE, Budget()).run().rows, throw))


def _poses(mp: Any, rows: Array, throw: Throw) -> list[Pose]:
    """Return the poses of rows of pairs, (R, 2, SIZE)."""
    inertia, poses = inverse(throw.solid.tensor), []
    for numbers in rows:
        state = np.array([mp.mpf(high) + mp.mpf(low) for high, low in numbers.T.tolist()])
        axes = state[AXES:MOMENTUM].reshape(3, 3)
        poses.append(Pose(state[X:V], axes, state[V:AXES], axes @ (inertia @ state[MOMENTUM:])))
    return poses


def moved(rows: Array, others: Array, points: Array, grown: Array) -> Array:
    """Return the largest move of a vertex, as it is and about the centre [m], (R, 2), from rows of pairs to others.

    rows, others: (R, 2, SIZE);
    points and by how much they are others there: file axes [m], (n, 3).
    """
    differ = (others[:, 0] - rows[:, 0]) + (others[:, 1] - rows[:, 1])
    turned = differ[:, AXES:MOMENTUM].reshape(-1, 3, 3)
    axes = others[:, 0, AXES:MOMENTUM].reshape(-1, 3, 3)
    about = points @ turned.swapaxes(1, 2) + grown @ axes.swapaxes(1, 2)
    moves = differ[:, np.newaxis, X:V] + about
    return np.linalg.norm((moves, about), axis=-1).max(axis=-1).T


def input_error_of(
    scene: Scene, row: int, throw: Throw, known: int, changes: tuple[tuple[Accuracy, float], ...], steps: int
) -> tuple[Array, str]:
    """Return how far the vertices move when each number of the file moves by half its last bit [m], (R,), R <= known,

    and why there are fewer than `known`.  Numbers, signs and patterns are those of
    `tumble.scenarios.truth.resolution.input_error_of`.  steps: those of the flight; if there are many, near instants
    are tried before far ones, which may be beyond the horizon.
    """
    input_error, budget = np.empty(0), Budget()
    for accuracy, share in changes:
        tried = Sensitivity(scene, row, throw, accuracy, share, budget)
        reach = known if steps < MANY_STEPS else min(len(input_error) + 1, known)
        while (count := tried.proportional(reach)) == reach < known:
            further = tried.affordable(min(FURTHER * reach, known), TRIED + PATTERNS - 1)
            if further <= reach:
                tried.is_late = True
                break
            reach = further
        input_error = np.concatenate((input_error, tried.moves(count)[len(input_error) :]))
        if len(input_error) == known:
            return input_error, ""
        if tried.is_late:
            return input_error, late(budget)
    longer = Sensitivity(scene, row, throw, ROUGH, 1.0, budget)
    for reach in (len(input_error) + 1, known):
        input_error = np.concatenate((input_error, longer.moves(reach)[len(input_error) :]))
        if longer.why or longer.is_late or input_error[-1] > TRUSTED * length_of(throw):
            break
    return input_error, late(budget) if longer.is_late else longer.why


def late(budget: Budget) -> str:
    """Return why there is no more to be known of what the inputs do."""
    return f"{budget.said} were up for what the last bits of its numbers do"


class Sensitivity:
    """What a change of all inputs by a share of half their last bits does, over that share.

    why: why the flights went no further, if they did not; is_late: whether there was no time for all that was asked.
    """

    def __init__(self, scene: Scene, row: int, throw: Throw, accuracy: Accuracy, share: float, budget: Budget) -> None:
        self._read = cache(
            lambda pattern, signed: read_throw(scene, row, changing(Random(pattern), signed)) if signed else throw
        )
        self._throw, self._accuracy, self._share, self._budget = throw, accuracy, share, budget
        # The rows of each flight and how many were asked for, and the processor time of a second of flight.
        self._flights: dict[tuple[int, float], tuple[int, Array]] = {}
        self._pace = 0.0
        self.why, self.is_late = "", False

    def proportional(self, reach: int) -> int:
        """Return at how many of the first rows the opposite change does the same."""
        self._fly([UNCHANGED, (0, self._share), (0, -self._share)], reach)
        there, back = self._moved(0, self._share, reach), self._moved(0, -self._share, reach)
        count = min(len(back), len(there))
        far = np.abs(self._rows(*UNCHANGED, reach)[:count, 0, X:V]).max(axis=1)
        points = self._throw.points.astype(float)
        even = in_proportion(there[:count], back[:count], self._share, points, far)
        return count if even.all() else int(np.argmin(even))

    def moves(self, reach: int) -> Array:
        """Return the largest move over the sign patterns at the first rows [m], (R,), R <= reach.

        There are no more rows than there is time for in the flights of all patterns.
        """
        if not reach:
            return np.empty(0)
        first = self._moved(0, self._share, reach)[:, 0]
        reach = self.affordable(len(first), PATTERNS - 1)
        self._fly([(pattern, self._share) for pattern in range(1, PATTERNS)], reach)
        moves = [first, *(self._moved(pattern, self._share, reach)[:, 0] for pattern in range(1, PATTERNS))]
        self.is_late = self.is_late or reach < len(first) or self._budget.is_up()
        reached = min(map(len, moves))
        return np.maximum.reduce([move[:reached] for move in moves])

    def affordable(self, reach: int, flights: int) -> int:
        """Return how many of the first rows so many flights have time for, if time goes evenly; the start is free."""
        needed_s = flights * self._pace * np.array(self._throw.times[:reach], dtype=float)
        return max(1, int(np.searchsorted(needed_s, self._budget.left_s(), side="right")))

    def _moved(self, pattern: int, signed: float, reach: int) -> Array:
        plain, rows = self._rows(*UNCHANGED, reach), self._rows(pattern, signed, reach)
        count, throw = min(len(plain), len(rows)), self._read(pattern, signed)
        points, grown = self._throw.points.astype(float), (throw.points - self._throw.points).astype(float)
        return moved(plain[:count], rows[:count], points, grown) / self._share

    def _rows(self, pattern: int, signed: float, reach: int) -> Array:
        """Return the first rows of a throw that is changed so, fewer where its flight went no further."""
        self._fly([(pattern, signed)], reach)
        return self._flights[pattern, signed][1][:reach]

    def _fly(self, changes: list[tuple[int, float]], reach: int) -> None:
        """Fly throws that are changed so up to the first rows, if they were not yet: side by side where that can be."""
        wanted = [change for change in changes if self._flights.get(change, (-1,))[0] < reach]
        throws = [self._read(*change)._replace(times=self._read(*change).times[:reach]) for change in wanted]
        at_once = side_by_side(throws, self._accuracy, self._budget)
        if at_once is None and len(wanted) > 1:
            for change in wanted:
                self._fly([change], reach)
        elif wanted:
            before = thread_time()
            trajectories = at_once.run() if at_once else [Integration(throws[0], self._accuracy, self._budget).run()]
            for change, throw, trajectory in zip(wanted, throws, trajectories, strict=True):
                self._flights[change] = (reach, trajectory.rows)
                simulated_s = float(throw.times[max(len(trajectory.rows), 1) - 1])
                self._pace = (thread_time() - before) / len(throws) / simulated_s if simulated_s else 0.0
                self.why = self.why or trajectory.why
