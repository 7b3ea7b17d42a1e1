"""What is found: mistakes with their values, and what they leave of a trajectory."""

from dataclasses import dataclass
from typing import NamedTuple

from tumble.compare.grade.hypotheses.hypothesis import Hypothesis


class Mistake(NamedTuple):
    """A hypothesis with its value."""

    hypothesis: Hypothesis
    value: float = 0.0

    @property
    def said(self) -> str:
        """What it says."""
        return self.hypothesis.said(self.value)

    @property
    def is_known(self) -> bool:
        """Whether its value is one with a name."""
        return self.value in self.hypothesis.known


Mistakes = tuple[Mistake, ...]


@dataclass(frozen=True, eq=False)
class Explanation:
    """Mistakes that together make a trajectory, and what they leave of it.

    rms_m, max_m: of the vertices at the rows kept [m]; nothing, noise: whether that is at the floor, or noise; weight:
    less is better; weighed_m: rms_m where each row counts by how well it is known.
    """

    mistakes: Mistakes
    rms_m: float
    max_m: float
    nothing: bool
    noise: bool
    weight: float
    weighed_m: float

    @property
    def names(self) -> frozenset[str]:
        """The names of its mistakes."""
        return frozenset(mistake.hypothesis.name for mistake in self.mistakes)

    @property
    def is_whole(self) -> bool:
        """Whether it leaves nothing but rounding or noise."""
        return self.nothing or self.noise


def with_value(mistakes: Mistakes, hypothesis: Hypothesis, value: float) -> Mistakes:
    """Return mistakes with one of them at another value."""
    return tuple(Mistake(m.hypothesis, value) if m.hypothesis is hypothesis else m for m in mistakes)


def value_of(mistakes: Mistakes, hypothesis: Hypothesis) -> float:
    """Return the value of one of some mistakes."""
    return next(mistake.value for mistake in mistakes if mistake.hypothesis is hypothesis)
