"""What the rows of contact come to: the verdict on each contestant, and the largest law error of a scene."""

import math
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from tumble.compare.contact.asked import BY_OWN_LAW
from tumble.compare.contact.schemas import VERDICT_WORDS, ContactRow
from tumble.compare.tables.shared import FindingRow

RIGHT = next(iter(VERDICT_WORDS))
SINKS, PYRAMID = "sinks by", "another law: pyramid"
# Law errors that agree to so many digits are equally large, and the first of them is named.
DIGITS = 2
COMPONENT = re.compile(r", [xyz]$")


@dataclass(frozen=True, eq=False)
class ContestantLaw:
    """One contestant in one scene: the gravest of its verdicts, and its largest law error.

    Parameters
    ----------
    scene : name of the scene
    engine : name of the engine
    method : METHOD[@TOLERANCE]
    verdict : the gravest, and beside a graver one the pyramid of its friction
    worst : row with the largest law error; None where every row is right
    share : that law error over the true value, of a component over its vector; 0 where there is none
    """

    scene: str
    engine: str
    method: str
    verdict: str
    worst: ContactRow | None
    share: float

    @property
    def contestant(self) -> str:
        """ENGINE:METHOD."""
        return f"{self.engine}:{self.method}" if self.method else self.engine

    @property
    def is_right(self) -> bool:
        """Whether every observable is right, but that the plane may yield."""
        return self.verdict.startswith(RIGHT)


def contestant_laws(rows: Iterable[ContactRow]) -> list[ContestantLaw]:
    """Return the verdict on each contestant in each scene.

    Parameters
    ----------
    rows : of contact.csv

    Returns
    -------
    one for each scene and contestant, in the order of the rows
    """
    own: dict[tuple[str, str, str], list[ContactRow]] = {}
    for row in rows:
        own.setdefault((row.scene, row.engine, row.method), []).append(row)
    return [ContestantLaw(*key, *law(each)) for key, each in own.items()]


def largest(laws: Iterable[ContestantLaw]) -> ContestantLaw:
    """Return the contestant with the largest law error, the first of several.

    Parameters
    ----------
    laws : verdicts on contestants, at least one

    Returns
    -------
    one of them
    """
    return max(laws, key=lambda one: float(f"{one.share:.{DIGITS}g}"))


def law(rows: Sequence[ContactRow]) -> tuple[str, ContactRow | None, float]:
    """Return the gravest verdict, beside it the pyramid, the row with the largest law error, and that error's share."""
    rows = [row for row in rows if not row.observable.endswith(BY_OWN_LAW)]
    verdict = worst_verdict([row.verdict for row in rows])
    if verdict.startswith(SINKS):
        return f"{RIGHT}, {verdict}", None, 0.0
    wrong = [row for row in rows if row.verdict != RIGHT and not row.verdict.startswith(SINKS)]
    shares = [(abs(error), row) for row in wrong if (error := law_share(row, rows)) is not None]
    largest_share, row = max(shares, key=lambda one: one[0], default=(0.0, None))
    pyramid = next((row.verdict for row in rows if row.verdict.startswith(PYRAMID)), verdict)
    said = verdict if pyramid == verdict else f"{verdict}; {pyramid}"
    return said, row or next(iter(wrong), None), largest_share


def worst_verdict(said: Sequence[str]) -> str:
    """Return the gravest of verdicts: in the order of VERDICT_WORDS but for the first, which is none."""
    return max(said, key=verdict_rank)


def verdict_rank(verdict: str) -> int:
    """Return how grave a verdict is: 0 of one that is right."""
    order = [RIGHT, *reversed(list(VERDICT_WORDS)[1:])]
    return max(place for place, word in enumerate(order) if verdict.startswith(word))


def law_share(row: ContactRow, rows: Iterable[ContactRow]) -> float | None:
    """Return a law error over the true value.

    Parameters
    ----------
    row : of contact.csv
    rows : of its scene and contestant

    Returns
    -------
    the share, of a component that of the whole vector; None where the true value is zero, or the law error unknown
    """
    return share(row, rows, row.law_error)


def step_share(row: ContactRow, rows: Iterable[ContactRow]) -> float | None:
    """Return the error that the step adds over the true value.

    Parameters
    ----------
    row, rows : as of `law_share`

    Returns
    -------
    the share, as of `law_share`
    """
    return share(row, rows, row.step_error)


def share(row: ContactRow, rows: Iterable[ContactRow], error: float | None) -> float | None:
    """Return an error of a row over the true value."""
    name = COMPONENT.sub("", row.observable)
    size = math.hypot(*(one.true for one in rows if one.blow == row.blow and COMPONENT.sub("", one.observable) == name))
    if error is None or size == 0 or row.unit == "s" or name.startswith("turn"):
        return None
    return error / size


def contact_findings(rows: Iterable[ContactRow]) -> Iterator[FindingRow]:
    """Yield the largest law error of each scene.

    Parameters
    ----------
    rows : of contact.csv

    Returns
    -------
    rows of findings.csv
    """
    scenes: dict[str, list[ContestantLaw]] = {}
    for one in contestant_laws(rows):
        scenes.setdefault(one.scene, []).append(one)
    for scene, laws in scenes.items():
        worst = largest(laws)
        if worst.share and worst.worst is not None:
            yield FindingRow(
                finding="largest law error",
                scene=scene,
                engine=worst.engine,
                method=worst.method,
                other=worst.worst.observable,
                value=worst.share,
                unit="1",
            )
