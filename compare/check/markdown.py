"""The summary as Markdown for a pull-request comment; text from engines and scenes is in code spans, unparsed."""

import re
from collections.abc import Iterator, Sequence
from itertools import groupby

from tumble.compare.check.changes import VERDICTS, Outcome
from tumble.compare.check.words import behaviours, by_cell, rerun, sentence, sentences, versions
from tumble.scenarios.format import visible

HEADINGS = {
    "incomparable": "Scene changed",
    "worse": "Worse",
    "gone": "No longer measured",
    "changed": "Changed",
    "better": "Better",
    "new": "New",
}
# Columns whose values have text of engines or scenes.
FOREIGN = ("status", "truth", "time_ratio")
# Verdicts on a cell that only one of the two records has.
PRESENCE = ("gone", "new")
# A comment on GitHub ends at 65,536 characters.
MOST_CHARACTERS = 60_000


def summary(outcome: Outcome, against: Sequence[str]) -> str:
    """Return the summary of a check as Markdown.

    Parameters
    ----------
    outcome : what changed
    against : the options that name baseline and tolerances in the command that reruns a cell

    Returns
    -------
    at most MOST_CHARACTERS characters
    """
    lines: list[str] = []
    left = MOST_CHARACTERS
    pieces = list(paragraphs(outcome, against))
    for number, piece in enumerate(pieces):
        left -= len(piece) + 1
        if left < 0:
            lines.append(f"\n{len(pieces) - number} more lines: give scenes and contestants to see them.")
            break
        lines.append(piece)
    return "\n".join(lines) + "\n"


def paragraphs(outcome: Outcome, against: Sequence[str]) -> Iterator[str]:
    """Yield the summary line by line."""
    yield f"## tumble check: {verdict(outcome)}"
    yield ""
    yield counts(outcome)
    if changed := [code(line) for line in versions(outcome)]:
        yield f"\nVersions: {', '.join(changed)}."
    if found := list(behaviours([change for change in outcome.changes if change.verdict not in PRESENCE])):
        yield "\n### Behaviour\n"
        for each in found:
            words = formatted(each.column, each.words)
            yield f"- {code(each.contestant)} {words} ({each.verdict}) on {listed(each.scenes)}"
    for kind, cells in groupby(by_cell(outcome.changes).values(), key=lambda changes: changes[0].verdict):
        yield f"\n### {HEADINGS[kind]}\n"
        if kind in PRESENCE:
            for each in behaviours([changes[0] for changes in cells]):
                yield f"- {code(each.contestant)} on {listed(each.scenes)}: {code(each.words)}"
        else:
            for changes in cells:
                first = changes[0]
                who = f"{code(first.contestant)} on {code(first.scene)}" if first.engine else code(first.scene)
                yield f"- {who}: {'; '.join(formatted(each.column, sentence(each)) for each in sentences(changes))}"
                yield f"  {code(rerun(outcome.candidate, first, against))}"


def verdict(outcome: Outcome) -> str:
    """Return the overall verdict."""
    found = {change.verdict for change in outcome.changes}
    return next((HEADINGS[each].lower() for each in VERDICTS if each in found), "nothing changed")


def counts(outcome: Outcome) -> str:
    """Return how many cells there are of each verdict; a cell counts by its worst change."""
    firsts = [changes[0].verdict for changes in by_cell(outcome.changes).values()]
    counted = [f"{firsts.count(each)} {HEADINGS[each].lower()}" for each in VERDICTS if each in firsts]
    return ", ".join([*counted, f"{outcome.unchanged} unchanged"]) + "."


def code(text: str) -> str:
    """Return text as a code span: control characters made visible, and fenced by more backticks than it holds."""
    shown = visible(text)
    fence = "`" * (1 + max(map(len, re.findall("`+", shown)), default=0))
    pad = " " if shown[:1] in " `" or shown[-1:] in " `" else ""
    return f"{fence}{pad}{shown}{pad}{fence}"


def listed(names: Sequence[str]) -> str:
    """Return names, each in a code span."""
    return ", ".join(map(code, names))


def formatted(column: str, sentence: str) -> str:
    """Return a sentence, in a code span if it may have text of an engine or a scene."""
    return code(sentence) if column in FOREIGN else sentence
