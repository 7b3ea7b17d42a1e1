"""Explanations by mistakes that do nothing, of which a test says what they leave."""

from tumble.compare.grade.hypotheses.explanation import Explanation, Mistake, Mistakes
from tumble.compare.grade.hypotheses.hypothesis import Hypothesis


def hypothesis(name: str) -> Hypothesis:
    """Return a mistake that does nothing."""
    return Hypothesis(name, name, name, lambda program, _: program)


def mistakes_of(letters: str) -> Mistakes:
    """Return a mistake for each letter."""
    return tuple(map(Mistake, map(hypothesis, letters)))


def explanation(letters: str, left: float, nothing: bool = False, in_common: float | None = None) -> Explanation:
    """Return an explanation by a mistake for each letter; nothing: what is left is within the floor."""
    common = left if in_common is None else in_common
    return Explanation(mistakes_of(letters), left, left, nothing, False, 0.0, left, in_common=common)
