"""Groups of contestants that agree."""

from collections.abc import Iterable


def joined(pairs: Iterable[tuple[str, str]]) -> list[tuple[str, ...]]:
    """Return the groups that pairs make when every pair is in one group."""
    groups: list[set[str]] = []
    for pair in pairs:
        group = set(pair).union(*(other for other in groups if not other.isdisjoint(pair)))
        groups = [other for other in groups if other.isdisjoint(group)] + [group]
    return [tuple(sorted(group)) for group in groups]
