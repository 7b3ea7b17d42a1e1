"""Who makes the same mistake: contestants that agree with each other better than either is right."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from compare.judge.agreement import AgreementRow
from reports.numerals import figure


@dataclass(frozen=True)
class Family:
    """Contestants of which each agrees with another, in which scenes, how far they are apart, and how far off [m]."""

    members: tuple[str, ...]
    scenes: tuple[str, ...]
    apart_m: float
    least_error_m: float
    largest_error_m: float


def joined(pairs: Iterable[tuple[str, str]]) -> list[tuple[str, ...]]:
    """Return the groups that pairs make when every pair is in one group."""
    groups: list[set[str]] = []
    for pair in pairs:
        group = set(pair).union(*(other for other in groups if not other.isdisjoint(pair)))
        groups = [other for other in groups if other.isdisjoint(group)] + [group]
    return [tuple(sorted(group)) for group in groups]


def of_one_scene(rows: Sequence[AgreementRow], scene: str) -> list[tuple[str, ...]]:
    """Return the members of every family of one scene."""
    return joined((row.contestant_a, row.contestant_b) for row in rows if row.scene == scene)


def families(rows: Sequence[AgreementRow]) -> list[Family]:
    """Return every family, those of different engines first, then by the number of scenes."""
    found: dict[tuple[str, ...], list[AgreementRow]] = {}
    for scene in dict.fromkeys(row.scene for row in rows):
        for members in of_one_scene(rows, scene):
            own = [row for row in rows if row.scene == scene and row.contestant_a in members]
            found.setdefault(members, []).extend(own)
    made = [
        Family(
            members,
            tuple(dict.fromkeys(row.scene for row in own)),
            max(row.apart_m for row in own),
            min(min(row.error_a_m, row.error_b_m) for row in own),
            max(max(row.error_a_m, row.error_b_m) for row in own),
        )
        for members, own in found.items()
    ]
    return sorted(made, key=lambda family: (-engines(family.members), -len(family.scenes), family.members))


def engines(members: Iterable[str]) -> int:
    """Return how many engines the contestants are of."""
    return len({member.partition(":")[0] for member in members})


def verdicts(rows: Sequence[AgreementRow]) -> list[str]:
    """Return a sentence for each family of different engines, where it shows best; the furthest off first."""
    best: dict[tuple[str, ...], AgreementRow] = {}
    for row in rows:
        if engines((row.contestant_a, row.contestant_b)) > 1:
            members = next(group for group in of_one_scene(rows, row.scene) if row.contestant_a in group)
            best[members] = min(best.get(members, row), row, key=lambda row: row.apart_m / row.error_a_m)
    return [
        f"{row.contestant_a} and {row.contestant_b} agree {agreement(row)} in {row.scene}, and both are "
        f"{figure(max(row.error_a_m, row.error_b_m))} m from the truth: agreement of engines is no evidence."
        for row in sorted(best.values(), key=lambda row: -row.error_a_m)
    ]


def agreement(row: AgreementRow) -> str:
    """Return in words how well two agree."""
    return f"to {figure(row.apart_m)} m" if row.apart_m else "to the last digit"
