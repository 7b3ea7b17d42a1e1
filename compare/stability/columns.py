"""A scene at several values of the number that makes it stiff, each for the same radians of its stiffest mode."""

import math
from collections.abc import Sequence
from concurrent.futures import Future
from dataclasses import dataclass, fields, replace
from functools import cached_property

import numpy as np

from tumble.compare.run.truths import Answer
from tumble.compare.stability.modes import Mode, stiffest_mode
from tumble.scenarios.forces import GRAVITY, LAWS, Law
from tumble.scenarios.frames import Array
from tumble.scenarios.read import BadScene
from tumble.scenarios.scene import Scene
from tumble.scenarios.truth import Truth

RADIANS = 72 * math.pi  # of the stiffest mode in a flight: 36 turns
ROWS = 32
FACTORS = (0.01, 0.1, 1.0, 10.0, 100.0)
# At twice the stiffness the mode is 1.4 times as fast; less than this is no answer to a number that was doubled.
ANSWERS = 1.1
PROBED, PROBED_ROWS = 1000, 64


NO_FORCES = {
    item.name: item.default for item in fields(Scene) if item.name in {law.part for law in LAWS if law is not GRAVITY}
}


@dataclass(frozen=True)
class Parameter:
    """A number that can make a scene stiff: its name with its unit, the law that has it, and its key there.

    That of all tethers is one number; the spin is no law's: it is that of the start with its impulses.
    """

    name: str
    law: Law | None = None
    key: str = ""

    def value(self, scene: Scene) -> float:
        """Return the number, the largest of several tethers, or 0 where the scene has it not."""
        if self.law is None:
            return stiffest_mode(replace(scene, **NO_FORCES)).rate
        return max((getattr(one, self.key) for one in self.law.all_of(scene)), default=0.0)

    def scaled(self, scene: Scene, by: float) -> Scene:
        """Return the scene with the number times a factor."""
        return spun(scene, by) if self.law is None else self.law.scaled(scene, by, self.key)


# Springs before what only takes: of two that make the mode equally fast the first is asked.
PARAMETERS = (
    *(
        Parameter(name, law, key)
        for law in sorted(LAWS, key=lambda law: law.stored is None)
        for name, key in law.numbers.items()
    ),
    Parameter("spin [rad/s]"),
)


def spun(scene: Scene, by: float) -> Scene:
    """Return the scene with its spin and its impulses scaled."""
    start = scene.start.copy()
    start[:, 10:13] *= by
    return replace(scene, start=start, impulses=tuple(replace(blow, value=by * blow.value) for blow in scene.impulses))


def natural_parameter(scene: Scene) -> Parameter:
    """Return the number that, doubled, makes the stiffest mode fastest.  Raises BadScene where there is no mode."""
    rate = stiffest_mode(scene).rate
    there = [each for each in PARAMETERS if each.value(scene)] if rate else []
    gains = {each: stiffest_mode(each.scaled(scene, 2.0)).rate / rate for each in there}
    best = max(gains, key=lambda each: gains[each], default=None)
    if best is None or gains[best] < ANSWERS:
        raise BadScene(f"{scene.name}: nothing turns, pulls or brakes at its start, so no step is too long for it")
    return best


@dataclass(frozen=True, eq=False)
class Column:
    """A scene at one value of its number, for RADIANS of its stiffest mode; impulses after t = 0 are left out."""

    scene: Scene
    parameter: Parameter
    factor: float
    mode: Mode

    @cached_property
    def value(self) -> float:
        """The number."""
        return self.parameter.value(self.scene)

    @property
    def seconds(self) -> float:
        """How long the flights are."""
        return RADIANS / self.mode.rate

    def flight(self, steps: int) -> Scene:
        """Return what is flown in so many steps, a power of two: with the truth's rows, or one a step where fewer."""
        return self._looked_at(self.seconds, np.arange(1, min(steps, ROWS) + 1) / min(steps, ROWS))

    def probe(self, dt: float, steps: int) -> Scene:
        """Return what is flown in so many steps of exactly dt [s], looked at after whole steps."""
        return self._looked_at(steps * dt, np.linspace(0, steps, PROBED_ROWS + 1).round()[1:] / steps)

    def _looked_at(self, seconds: float, shares: Array) -> Scene:
        return replace(self.scene, duration=seconds, times=seconds * shares, step=seconds / PROBED)


def columns(scene: Scene, factors: Sequence[float] = FACTORS) -> list[Column]:
    """Return a scene at its own value times every factor.  Raises BadScene as natural_parameter does."""
    alone = replace(scene, start=scene.start[:1], impulses=tuple(blow for blow in scene.impulses if blow.time == 0.0))
    parameter = natural_parameter(alone)
    found = []
    for factor in factors:
        changed = parameter.scaled(alone, factor)
        found.append(Column(changed, parameter, factor, stiffest_mode(changed)))
    return found


def limits_steps(scene: Scene) -> bool:
    """Whether a mode of the scene limits how long a step may be, so that it has columns."""
    try:
        return bool(columns(scene, [1.0]))
    except BadScene:
        return False


@dataclass(frozen=True, eq=False)
class Question:
    """One scene at all its values, each with its truth, which may still be on its way."""

    scene: Scene
    columns: list[Column]
    truths: list[Future[Answer]]

    @property
    def own(self) -> int:
        """The column of the scene as it is written."""
        return next(place for place, column in enumerate(self.columns) if column.factor == 1.0)


def truth_of(flown: Scene, true: Truth | None) -> Truth | None:
    """Return the rows of a column's truth that a flight with fewer of them is looked at in."""
    if true is None or len(true.times) == len(flown.rows):
        return true
    kept = slice(None, None, (len(true.times) - 1) // (len(flown.rows) - 1))
    rows = {name: getattr(true, name)[kept] for name in ("times", "states", "vertices", "bound", "input_error")}
    return replace(true, **rows)
