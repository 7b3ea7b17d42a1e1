"""A scene at several values of the parameter that makes it stiff, each for the same radians of its stiffest mode."""

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

RADIANS = 72 * math.pi  # of the stiffest mode in a run: 36 periods
ROWS = 32
FACTORS = (0.01, 0.1, 1.0, 10.0, 100.0)
# At twice the stiffness the mode is 1.4 times as fast; a parameter whose doubling has less effect than this is none.
ANSWERS = 1.1
PROBED, PROBED_ROWS = 1000, 64


NO_FORCES = {
    item.name: item.default for item in fields(Scene) if item.name in {law.part for law in LAWS if law is not GRAVITY}
}


@dataclass(frozen=True)
class Parameter:
    """A parameter that can make a scene stiff: its name with its unit, the force law that has it, and its key there.

    All tethers share one; the spin, which has no force law, is that of the start after its impulses.
    """

    name: str
    law: Law | None = None
    key: str = ""

    def value(self, scene: Scene) -> float:
        """Return the value, the largest of several tethers, or 0 if the scene does not have it."""
        if self.law is None:
            return stiffest_mode(replace(scene, **NO_FORCES)).rate
        return max((getattr(one, self.key) for one in self.law.all_of(scene)), default=0.0)

    def scaled(self, scene: Scene, by: float) -> Scene:
        """Return the scene with the parameter times a factor."""
        return spun(scene, by) if self.law is None else self.law.scaled(scene, by, self.key)


# Springs before dampers: of two that make the mode equally fast the first is used.
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
    return replace(scene, start=start, impulses=tuple(replace(each, value=by * each.value) for each in scene.impulses))


def natural_parameter(scene: Scene) -> Parameter:
    """Return the parameter that, doubled, makes the stiffest mode fastest.  Raises BadScene if there is no mode."""
    rate = stiffest_mode(scene).rate
    present = [each for each in PARAMETERS if each.value(scene)] if rate else []
    gains = {each: stiffest_mode(each.scaled(scene, 2.0)).rate / rate for each in present}
    best = max(gains, key=lambda each: gains[each], default=None)
    if best is None or gains[best] < ANSWERS:
        raise BadScene(f"{scene.name}: no rotation, spring or damper acts at its start, so nothing limits the step")
    return best


@dataclass(frozen=True, eq=False)
class Column:
    """A scene at one parameter value, for RADIANS of its stiffest mode, without impulses after t = 0."""

    scene: Scene
    parameter: Parameter
    factor: float
    mode: Mode

    @cached_property
    def value(self) -> float:
        """The parameter value."""
        return self.parameter.value(self.scene)

    @property
    def seconds(self) -> float:
        """Duration of the runs [s]."""
        return RADIANS / self.mode.rate

    def scene_of(self, steps: int) -> Scene:
        """Return the scene to run in `steps` steps, a power of two, sampled at most ROWS times."""
        return self._sampled(self.seconds, np.arange(1, min(steps, ROWS) + 1) / min(steps, ROWS))

    def probe(self, dt: float, steps: int) -> Scene:
        """Return the scene to run in `steps` steps of exactly dt [s], sampled after whole steps."""
        return self._sampled(steps * dt, np.linspace(0, steps, PROBED_ROWS + 1).round()[1:] / steps)

    def _sampled(self, seconds: float, shares: Array) -> Scene:
        return replace(self.scene, duration=seconds, times=seconds * shares, step=seconds / PROBED)


def columns(scene: Scene, factors: Sequence[float] = FACTORS) -> list[Column]:
    """Return a scene at its own parameter value times every factor.  Raises BadScene as natural_parameter does."""
    alone = replace(scene, start=scene.start[:1], impulses=tuple(each for each in scene.impulses if each.time == 0.0))
    parameter = natural_parameter(alone)
    found = []
    for factor in factors:
        changed = parameter.scaled(alone, factor)
        found.append(Column(changed, parameter, factor, stiffest_mode(changed)))
    return found


def limits_steps(scene: Scene) -> bool:
    """Whether a mode of the scene limits the step, so that it has columns."""
    try:
        return bool(columns(scene, [1.0]))
    except BadScene:
        return False


@dataclass(frozen=True, eq=False)
class Question:
    """One scene at all its parameter values, each with its reference solution, which may still be computing."""

    scene: Scene
    columns: list[Column]
    truths: list[Future[Answer]]

    @property
    def identity(self) -> list[object]:
        """What all of it follows from."""
        return [self.scene, [(column.parameter, column.factor) for column in self.columns]]

    @property
    def own(self) -> int:
        """The column at the scene's own value."""
        return next(place for place, column in enumerate(self.columns) if column.factor == 1.0)


def truth_of(scene: Scene, true: Truth | None) -> Truth | None:
    """Return a column's reference solution at the samples of a run that has fewer."""
    if true is None or len(true.times) == len(scene.rows):
        return true
    every = slice(None, None, (len(true.times) - 1) // (len(scene.rows) - 1))
    rows = {name: getattr(true, name)[every] for name in ("times", "states", "vertices", "bound", "input_error")}
    return replace(true, **rows)
