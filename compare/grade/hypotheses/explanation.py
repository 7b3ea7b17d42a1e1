"""An explanation: mistakes with their values, and the residual that they leave."""

from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from tumble.compare.grade.hypotheses.hypothesis import Hypothesis

# A value that differs from the right one by a smaller share was fitted to something else.
NEARLY_RIGHT = 1e-4
# So was a rate, over the largest one that is tried.
NEARLY_NOTHING = 1e-6
# Significant digits of a value that a person writes. A fitted value has as few only if that is no chance.
PLAIN = 4
# Largest number of steps after which something happens; a time differs from whole steps by less than this share of one.
TICKS, OF_A_STEP = 60, 1e-6
# A step divides an interval if their ratio is as near to a whole number.
WHOLE = 0.02


def in_digits(value: float, digits: int) -> float:
    """Return a value in so many significant digits."""
    return float(f"{value:.{digits - 1}e}")


class Mistake(NamedTuple):
    """A hypothesis with its value."""

    hypothesis: Hypothesis
    value: Any = 0.0

    @property
    def text(self) -> str:
        """Its text, with the value."""
        return self.hypothesis.text_with(self.value)

    @property
    def has_named_value(self) -> bool:
        """Whether its value has a name."""
        return self.value in self.hypothesis.named_values

    @property
    def has_plain_value(self) -> bool:
        """Whether its value is a number that a person writes, such as 0.5 or 0.25, or a vector of these and zeros."""
        if isinstance(self.value, float):
            return self.value == in_digits(self.value, PLAIN)
        return bool(self.hypothesis.scale) and 0.0 in self.value and all(x == in_digits(x, PLAIN) for x in self.value)

    def is_nearly_right(self, near: float = NEARLY_RIGHT) -> bool:
        """Whether its value was fitted and is nearly that of a right program; near: share, of factors and of 0."""
        hypothesis = self.hypothesis
        if not hypothesis.fitted or self.has_named_value:
            return False
        if hypothesis.scale:
            right = np.array(hypothesis.values[0])
            near = NEARLY_RIGHT if right.any() else near
            return float(np.abs(self.value - right).max()) < near * hypothesis.scale
        if hypothesis.unit and hypothesis.neutral == 0.0:
            share = NEARLY_RIGHT if hypothesis.unit == "s" else NEARLY_NOTHING
            return abs(self.value) < share * max(map(abs, hypothesis.bounds))
        return not hypothesis.unit and abs(self.value - 1) < near

    def is_slower_than(self, rate: float) -> bool:
        """Whether it is a growth or decay at a smaller fitted rate [1/s]."""
        hypothesis = self.hypothesis
        is_rate = hypothesis.unit == "1/s" and hypothesis.neutral == 0.0
        return is_rate and not self.has_named_value and abs(self.value) < rate


Mistakes = tuple[Mistake, ...]


@dataclass(frozen=True, eq=False)
class Explanation:
    """Mistakes that together reproduce a trajectory, and the residual.

    Parameters
    ----------
    mistakes : the mistakes; empty: the trajectory without a mistake
    rms_m : root mean square residual of the vertices at the sampled rows [m]
    max_m : largest residual of a vertex at the sampled rows [m]
    within_floor : whether the residual is within the floor
    is_noise : whether the residual is noise
    weight : information criterion; smaller is better
    weighted_rms_m : root mean square residual with each row weighted by its precision [m]
    in_digits : the same over the floor of the printed digits alone, without single precision
    in_double : the same over the floor of the digits and of noise, without single precision
    in_floors : the same over the floor with single precision, if the program may have it
    in_common : the same over the floor that a search has for every program
    plain_cost : what plain values, for the fitted ones, have added to the weight
    drift : rates that explain a part of the error, too, but are taken for rounding
    """

    mistakes: Mistakes
    rms_m: float
    max_m: float
    within_floor: bool
    is_noise: bool
    weight: float
    weighted_rms_m: float
    in_digits: float = np.inf
    in_double: float = np.inf
    in_floors: float = np.inf
    in_common: float = np.inf
    plain_cost: float = 0.0
    drift: Mistakes = ()

    @property
    def names(self) -> frozenset[str]:
        """The names of its mistakes."""
        return frozenset(mistake.hypothesis.name for mistake in self.mistakes)

    @property
    def fitted(self) -> list[Mistake]:
        """Its mistakes whose values are fitted and have no name."""
        return [m for m in self.mistakes if m.hypothesis.fitted and not m.has_named_value]

    @property
    def odd_values(self) -> int:
        """The number of fitted values that nobody writes.

        Times of whole steps are not among them, nor what rows show by themselves.
        """
        return sum(not (m.has_plain_value or m.hypothesis.measured or self._is_whole_steps(m)) for m in self.fitted)

    def _is_whole_steps(self, mistake: Mistake) -> bool:
        """Whether a value is a time of a whole number of the program's steps."""
        step = next((m.value for m in self.mistakes if m.hypothesis.part == "steps"), 0.0)
        if not step or mistake.hypothesis.unit != "s":
            return False
        count = round(mistake.value / step)
        return 0 < abs(count) <= TICKS and abs(mistake.value - count * step) < OF_A_STEP * step

    @property
    def is_vague(self) -> bool:
        """Whether one of its mistakes explains a part of almost any error."""
        return any(mistake.hypothesis.vague for mistake in self.mistakes)

    @property
    def is_whole(self) -> bool:
        """Whether it leaves only rounding or noise."""
        return self.within_floor or self.is_noise

    def without_drift(self, rate: float) -> "Explanation":
        """Return the explanation whose growth or decay at a smaller rate [1/s] is none of its mistakes."""
        drift = tuple(m for m in self.mistakes if m.is_slower_than(rate))
        return replace(self, mistakes=tuple(m for m in self.mistakes if m not in drift), drift=drift) if drift else self


def with_value(mistakes: Mistakes, hypothesis: Hypothesis, value: Any) -> Mistakes:
    """Return mistakes with another value for one of them."""
    return tuple(Mistake(m.hypothesis, value) if m.hypothesis is hypothesis else m for m in mistakes)


def value_of(mistakes: Mistakes, hypothesis: Hypothesis) -> Any:
    """Return the value of a hypothesis in some mistakes."""
    return next(mistake.value for mistake in mistakes if mistake.hypothesis is hypothesis)


def step_divides(mistakes: Mistakes, interval_s: float) -> bool:
    """Return whether the step of a program, if it has one, divides its tick, or an interval [s] if it has no tick.

    A clock of another rate has intervals that are not those of the rows.
    """
    values = {m.hypothesis.part: m.value for m in mistakes}
    if "steps" not in values or "clock rate" in values:
        return True
    count = values.get("clock tick", interval_s) / values["steps"]
    return round(count) > 0 and abs(count - round(count)) <= WHOLE
