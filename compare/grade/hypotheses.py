"""What a hypothesis is: a mistake, what it changes in a truthful account, what is to be fitted, how it is said."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from compare.grade.account import Account
from scenarios.frames import Array
from scenarios.scene import Scene

# Steps that programs take, and what those say who ship them.
STEPS = {
    1 / 30: "1/30 s", 0.02: "Unity's default", 1 / 60: "1/60 s", 0.01: "0.01 s", 1 / 120: "1/120 s",
    0.005: "0.005 s", 1 / 240: "PyBullet's default", 0.002: "MuJoCo's default", 0.001: "0.001 s",
}  # fmt: skip


class Change(Protocol):
    """Gives the account of a program with the mistake; value: what was fitted or chosen, 0 where nothing is."""

    def __call__(self, account: Account, value: float, /) -> Account: ...  # noqa: D102


@dataclass(frozen=True, eq=False)
class Question:
    """What a hypothesis may know before it is tried.

    account: of a program without mistakes; kind: what the file shows; rows: so many; duration: to the last of them [s];
    turn_s: the time in which the body turns by a radian [s].
    """

    scene: Scene
    account: Account
    kind: str
    rows: int
    duration: float
    turn_s: float


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """A mistake.

    name: for tables; variants of one mistake share it.  part: of the program, where one mistake is made at most.
    says: in words, with a place for the value.  values: tried first, () where there is nothing to fit.
    choices: names of the values, which then are all there are.  known: values with a name, which cost little to assume.
    only_known: no others are believed.  sought: where the flight jumps as the value changes, the value that instants as
    written and as the physics had reached them [s], (S,), speak for; None where it is smooth.
    variant: differs little from the one of its name that stands before it and is none.
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
        if not self.values:
            return self.says
        named = f" ({self.known[value]})" if value in self.known else ""
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
