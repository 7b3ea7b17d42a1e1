"""Flies a throw as programs with mistakes would, and says what each leaves of the rows: at a glance, or in full."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from tumble.compare.grade.hypotheses.explanation import Explanation, Mistake, Mistakes
from tumble.compare.grade.hypotheses.hypothesis import Hypothesis, Question
from tumble.compare.grade.hypotheses.mistakes.output import WRITTEN
from tumble.compare.grade.measure.errors import Kept, golden
from tumble.compare.grade.measure.significance import Scale, chosen, relation, root_mean_square
from tumble.compare.grade.measure.single_precision import single_floor
from tumble.compare.grade.model.kernel.dynamics import RUNGE_KUTTA, SMOOTH
from tumble.compare.grade.model.program_model import FINE, RIGHT, SEARCHING, Account, Pose
from tumble.scenarios.frames import Array

# Rows that a search takes, of those kept, and a first look of these.
SOUGHT, GLANCE = 96, 24
# Steps of flights after which no more mistakes are put on top of others: the bound of a search, the same on any
# machine.
ENOUGH = 60_000_000
# Radians in a step of a first look where more than this share of the body's size is to be explained.
COARSE, LARGE = 0.4, 0.02
# Steps that it takes as long as to begin a flight, and the most that are counted of one.
STARTED, MOST_COUNTED = 1000, 100_000
# Instants of a flight that rows are sought at: so many in a radian of the body's turn, and no more than so many.
IN_A_RADIAN, MOST_INSTANTS = 10, 2000


class Flights:
    """What mistakes leave of one throw.

    kept: its rows; glance: some of them; points: the vertices that they show [m], (K, 3); hypotheses: in the order in
    which a program makes them; tried: flights looked at so far; steps: that they took, of those
    that were not only written down in another way; tell: is told what share they are of those that a search may take.
    """

    def __init__(
        self,
        question: Question,
        hypotheses: Sequence[Hypothesis],
        kept: Kept,
        points: Array,
        scale: Scale,
        single: bool = False,
        tell: Callable[[float], object] = lambda share: None,
    ) -> None:
        self.question, self.hypotheses, self.scale, self.tried = question, list(hypotheses), scale, 0
        self.steps, self._tell = 0, tell
        self.all, self._single = kept, single
        self._sought = golden(len(kept), SOUGHT)
        self.kept = kept.some(self._sought)
        rows = np.unique(np.linspace(0, len(self.kept) - 1, GLANCE).round().astype(int))
        self.glance = self.kept.some(rows)
        self._glance_turned = np.ascontiguousarray(np.swapaxes(self.glance.vertices, 1, 2))
        self._glance_trust = (scale.floor_m / (np.sqrt(3.0) * scale.floors_m[self._sought][rows]))[:, :, None]
        self._trust = (scale.floor_m / (np.sqrt(3.0) * scale.floors_m[self._sought]))[:, None]
        self._account, self._points = question.account, points
        self._duration, self._turn_s = question.duration, question.turn_s
        self._place = {hypothesis: number for number, hypothesis in enumerate(hypotheses)}
        self._flown: dict[tuple, Pose] = {}
        self._glancing = SEARCHING
        self.look_for(root_mean_square(kept.vertices - kept.true))

    def until(self, share: float) -> "Flights":
        """Return the same of the rows up to a share of the flight."""
        early = self.all.times <= share * self._duration
        scale = replace(self.scale, floors_m=self.scale.floors_m[early])
        return Flights(self.question, self.hypotheses, self.all.some(early), self._points, scale, self._single)

    def look_for(self, residual_m: float) -> None:
        """Take first looks at flights as fine as it takes to explain so much [m]."""
        glancing = COARSE if residual_m > LARGE * self.scale.size_m else SEARCHING
        if glancing != self._glancing:
            self._glancing = glancing
            self._flown.clear()

    def explain(self, mistakes: Mistakes) -> Explanation:
        """Return what mistakes leave of all rows, flown finely."""
        self.tried += 1
        account = self.changed(mistakes)
        errors = self._errors(self._written(account, self.all, FINE), self.all)
        floors_m = self._rounded(account) if self._single else None
        rms_m, weighed_m = root_mean_square(errors), root_mean_square(self.scale.weighed(errors, floors_m))
        with np.errstate(over="ignore"):  # a flight that blew up
            largest = float(np.linalg.norm(errors, axis=-1).max())
        nothing = self.scale.is_nothing(weighed_m)
        noise = not nothing and self.scale.is_noise(rms_m, largest, self._related(account, errors), len(errors) - 1)
        weight = self.scale.weight(root_mean_square(self.scale.weighed(errors)), self.cost(mistakes))
        return Explanation(mistakes, rms_m, largest, nothing, noise, weight, weighed_m)

    def _related(self, account: Account, errors: Array) -> float:
        """Return how neighbouring rows' errors are related, in world axes or in the body's, where that is more."""
        axes = account.flown(account.clock.reached(self.all.times), SEARCHING)[:, 3:12].reshape(-1, 3, 3)
        with np.errstate(all="ignore"):
            in_body = np.einsum("tji,tkj->tki", axes, errors)
            return max(relation(errors), relation(in_body), key=abs)

    def _rounded(self, account: Account) -> Array | None:
        """Return what single precision leaves of a flight in steps, (S, 3), None of a smooth one."""
        if account.scheme.attitude == SMOOTH:
            return None
        return single_floor(account, self.all.times, self._points)[:, None]

    def glanced(self, mistakes: Mistakes) -> float:
        """Return the weight of mistakes by a first look."""
        self.tried += 1
        flight = tuple(m for m in mistakes if m.hypothesis.part not in WRITTEN)
        pose = self.written(self.pose(flight), [m for m in mistakes if m.hypothesis.part in WRITTEN])
        return float(self.weights(pose)[0]) + self.cost(mistakes)

    def left(self, mistakes: Mistakes, fineness: float = SEARCHING) -> float:
        """Return the logarithm of what mistakes leave of all rows."""
        self.tried += 1
        errors = self._errors(self._written(self.changed(mistakes), self.kept, fineness), self.kept)
        errors = errors * self._trust
        with np.errstate(all="ignore"):
            left = float(np.log(root_mean_square(errors) + 1e-3 * self.scale.floor_m))
        return left if np.isfinite(left) else np.inf

    def weights(self, stack: Pose) -> Array:
        """Return the weights, without what is assumed, of flights one after the other, (n,)."""
        rows = len(self.glance)
        with np.errstate(all="ignore"):
            apart = self._turned(stack).reshape(-1, rows, 3, len(self._points)) - self._glance_turned
            apart *= self._glance_trust
            rms_m = np.sqrt(np.einsum("nrik,nrik->n", apart, apart) / (rows * len(self._points)))
            return np.where(np.isfinite(rms_m), self.scale.weights(rms_m), np.inf)

    def pose(self, flight: Mistakes) -> Pose:
        """Return what a program with these mistakes writes down, flown once."""
        pose = self._flown.get(flight)
        if pose is None:
            pose = self._flown[flight] = self._written(self.changed(flight), self.glance, self._glancing)
        return pose

    def _written(self, account: Account, rows: Kept, fineness: float) -> Pose:
        """Return what a program writes down at rows, and count the steps that its flight takes."""
        scheme, smooth = account.scheme, account.scheme.attitude == SMOOTH
        count = self._duration / (fineness * self._turn_s if smooth else scheme.step)
        self.steps += STARTED + (4 if smooth or scheme.attitude == RUNGE_KUTTA else 1) * round(min(count, MOST_COUNTED))
        self._tell(self.steps / ENOUGH)
        return account.written(rows.times, fineness)

    def written(self, pose: Pose, mistakes: Sequence[Mistake]) -> Pose:
        """Return a pose as mistakes in writing leave it."""
        if not mistakes:
            return pose
        with np.errstate(all="ignore"):
            for writing in self.changed(mistakes).writings:
                pose = writing(pose)
        return pose

    def reached(self, account: Account, rows: Kept) -> Array:
        """Return the instants [s] at which a flight comes nearest to rows, by whatever clock, (S,)."""
        from scipy.spatial.distance import cdist  # as in `fitting`: what is seen at once is told first

        count = int(np.clip(IN_A_RADIAN * self._duration / self._turn_s, 2 * len(rows), MOST_INSTANTS))
        instants = np.linspace(0, self._duration, count)
        pose = replace(account, clock=RIGHT).written(instants)
        with np.errstate(all="ignore"):
            apart = cdist(rows.vertices.reshape(len(rows), -1), self._places(pose).reshape(count, -1))
            nearest = np.argmin(np.where(np.isfinite(apart), apart, np.inf), axis=1).clip(1, count - 2)
            # Of a parabola through the squares of three distances.
            before, at, after = (apart[np.arange(len(rows)), nearest + side] ** 2 for side in (-1, 0, 1))
            aside = np.nan_to_num(0.5 * (before - after) / (before - 2 * at + after)).clip(-1, 1)
        return (nearest + aside) * instants[1]

    def changed(self, mistakes: Sequence[Mistake]) -> Account:
        """Return the account of a program with these mistakes."""
        account = self._account
        for mistake in mistakes:
            account = mistake.hypothesis.change(account, mistake.value)
        return account

    def cost(self, mistakes: Sequence[Mistake]) -> float:
        """Return the weight of what mistakes assume: which ones, and their values."""
        cost = 0.0
        for mistake in mistakes:
            hypothesis = mistake.hypothesis
            cost += chosen(len(self.hypotheses)) + hypothesis.taken * self.scale.fitted()
            if hypothesis.choices:
                cost += chosen(len(hypothesis.choices))
            elif mistake.is_known:
                cost += chosen(len(hypothesis.known))
            elif hypothesis.fitted:
                cost += self.scale.fitted()
        return cost

    def ordered(self, mistakes: Mistakes) -> Mistakes:
        """Return mistakes in the order in which a program makes them."""
        return tuple(sorted(mistakes, key=lambda mistake: self._order(mistake.hypothesis)))

    def _order(self, hypothesis: Hypothesis) -> int:
        """Return the place of a hypothesis, of an engine's law that of the first of its part."""
        place = self._place.get(hypothesis)
        same = (number for number, other in enumerate(self.hypotheses) if other.part == hypothesis.part)
        return next(same, 0) if place is None else place

    def law(self, mistakes: Mistakes) -> float:
        """Return the weight of mistakes that are not searched for, over all rows."""
        self.tried += 1
        errors = self._errors(self._written(self.changed(mistakes), self.all, SEARCHING), self.all)
        with np.errstate(all="ignore"):
            rms_m = root_mean_square(self.scale.weighed(errors))
        return self.scale.weight(rms_m, self.cost(mistakes)) if np.isfinite(rms_m) else np.inf

    def _errors(self, pose: Pose, rows: Kept) -> Array:
        with np.errstate(all="ignore"):
            return rows.vertices - self._places(pose)

    def _places(self, pose: Pose) -> Array:
        """Return where a program has the vertices [m], (S, K, 3)."""
        return np.swapaxes(self._turned(pose), 1, 2)

    def _turned(self, pose: Pose) -> Array:
        """Return the same with the vertices last, (S, 3, K)."""
        turned = (pose.axes.reshape(-1, 3) @ self._points.T).reshape(-1, 3, len(self._points))
        return turned + pose.x[:, :, None] if self.question.centred else turned
