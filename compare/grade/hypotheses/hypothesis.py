"""What a hypothesis is: a mistake, what it changes in a truthful account, what is to be fitted, how it is said."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from tumble.compare.grade.model.kernel.stepping import MOST_STEPS
from tumble.compare.grade.model.program_model import Account
from tumble.scenarios.frames import Array
from tumble.scenarios.scene import Scene

# Steps that programs take.
STEPS = {
    1 / 30: "1/30 s", 0.02: "1/50 s", 1 / 60: "1/60 s", 0.01: "1/100 s", 1 / 120: "1/120 s",
    0.005: "1/200 s", 1 / 240: "1/240 s", 0.002: "1/500 s", 0.001: "1/1000 s",
    0.0005: "1/2000 s",
}  # fmt: skip
# Of itself, a step that is another but for the rounding of printed instants.
NEAR = 1e-4
# Rows that a tick may last.
TICKS = (2, 3, 4, 5, 8, 10)
# And parts of the time from row to row: one step a row is the commonest log there is, but a log can be sparse too.
MOST_A_ROW = 400
PARTS = {1: "one step a row", 2: "two steps a row", 4: "four steps a row", 10: "ten steps a row"}


class Change(Protocol):
    """Gives the account of a program with the mistake; value: what was fitted or chosen, 0 where nothing is."""

    def __call__(self, account: Account, value: float, /) -> Account: ...  # noqa: D102


@dataclass(frozen=True, eq=False)
class Question:
    """What a hypothesis may know before it is tried.

    account: of a program without mistakes; kind: what the file shows; rows: so many; duration: to the last of them [s];
    turn_s: the time in which the body turns by a radian [s]; spacing_s: from row to row; first: x [m] and q of the row
    at t = 0, (7,), where there is one; centred: the file says where the body is; offset: constant, of what it says is
    the centre, body axes [m], (3,), drift: what its velocity and acceleration [m/s, m/s2], (2, 3), are off by, where
    there is one.
    """

    scene: Scene
    account: Account
    kind: str
    rows: int
    duration: float
    turn_s: float
    spacing_s: float
    first: Array | None = None
    centred: bool = True
    offset: Array | None = None
    drift: Array | None = None

    @property
    def ticks(self) -> dict[float, str]:
        """Steps that are longer than from row to row: those that programs take, and some rows."""
        rows = {number * self.spacing_s: f"{number} rows" for number in TICKS}
        return {step: name for step, name in STEPS.items() if step > self.spacing_s * (1 + NEAR)} | rows

    @property
    def parts(self) -> list[float]:
        """Steps of which a whole number goes from row to row: one, parts of it, and those that programs take [s].

        None of which a flight takes more than can be flown.
        """
        steps = self.steps
        counts = {step: self.spacing_s / step for step in steps if self.duration <= MOST_STEPS * step}
        return [
            step
            for step, count in counts.items()
            if steps[step] in PARTS.values() or (count <= MOST_A_ROW and abs(count - round(count)) < NEAR * count)
        ]

    @property
    def steps(self) -> dict[float, str]:
        """Steps that programs take, those first that divide the time from row to row."""
        spacing = next((step for step in STEPS if abs(step - self.spacing_s) < NEAR * step), self.spacing_s)
        parts = {spacing / part: name for part, name in PARTS.items()}
        return parts | {step: name for step, name in STEPS.items() if all(abs(step - h) > NEAR * h for h in parts)}


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """A mistake.

    name: for tables; variants of one mistake share it.  part: of the program, where one mistake is made at most.
    says: in words, with a place for the value.  values: tried first, () where there is nothing to fit.
    choices: names of the values, which then are all there are.  known: values with a name, which cost little to assume.
    only_known: no others are believed.  sought: where the flight jumps as the value changes, the value that instants as
    written and as the physics had reached them [s], (S,), speak for; None where it is smooth.
    variant: differs little from the one of its name that stands before it and is none.  rare: with others it is
    polished only where it helps.  of_scene: it may be the scene that says what was not flown.  unit: of its value.
    details: what else it says, for tables.  taken: numbers that it takes from the file itself.
    """

    name: str
    part: str
    says: str
    change: Change
    values: tuple[float, ...] = ()
    choices: tuple[str, ...] = ()
    known: dict[float, str] = field(default_factory=dict)
    only_known: bool = False
    sought: Callable[[Array, Array], float] | None = None
    variant: bool = False
    rare: bool = False
    of_scene: bool = False
    unit: str = ""
    details: tuple[tuple[str, str], ...] = ()
    taken: int = 0

    @property
    def fitted(self) -> bool:
        """Whether it has a number that any value between those tried first may be."""
        return bool(self.values) and not self.choices and not self.only_known

    @property
    def bounds(self) -> tuple[float, float]:
        """The least and the greatest value that its number may have, but for those with a name."""
        return min(self.values), max(self.values)

    def said(self, value: float) -> str:
        """Return what it says with a value."""
        if self.choices:
            return self.says.format(self.choices[int(value)])
        named = f" ({self.known[value]})" if self.known.get(value) else ""
        return self.says.format(figures(value)) + named


def figures(value: float) -> str:
    """Return a number in four figures, or as many as tell it from 1."""
    from_one = abs(value - 1)
    enough = 4 if from_one == 0 or from_one > 1e-2 else 3 - int(np.floor(np.log10(from_one)))
    return f"{value:.{min(enough, 12)}g}"


def grid(low: float, high: float, count: int) -> tuple[float, ...]:
    """Return values that grow by one ratio, from low > 0 to high."""
    return tuple(np.geomspace(low, high, count).tolist())


def choice(of: int) -> tuple[float, ...]:
    """Return the values of a choice of so many."""
    return tuple(float(number) for number in range(of))
