"""The figures of a run in the documentation: a section of docs/confusion.md, and a paragraph of docs/grade.md."""

import textwrap
from collections.abc import Sequence

from tools.random_programs.program import DIGITS, MEASUREMENT
from tools.random_programs.score import FALSE_CORRECT, HITS, HONEST, NAMED, UNNAMED, WRONG
from tools.random_programs.table import Row, labels, listed, named, of_noise, reliability, share, summary

SECTION, NEXT = "## Random programs", "## Held out"
PARAGRAPH = "**What that means for your own file.**"
# Least and largest number of mistakes in a file, and what both are called.
NUMBERS = ((1, 1, "1"), (2, 2, "2"), (3, 3, "3"), (4, 99, "4 and more"))
WIDTH = 150


def in_confusion(page: str, rows: Sequence[Row], seed: int) -> str:
    """Return docs/confusion.md with the section in the place of the one that it has."""
    before, _, rest = page.partition(SECTION)
    _, heading, after = rest.partition(NEXT)
    return f"{before}{section(rows, seed)}\n{heading}{after}"


def in_guide(page: str, rows: Sequence[Row], seed: int) -> str:
    """Return docs/grade.md with the paragraph in the place of the one that it has."""
    before, _, rest = page.partition(PARAGRAPH)
    _, _, after = rest.partition("\n\n")
    wrapped = textwrap.fill(f"{PARAGRAPH} {paragraph(rows, seed)}", WIDTH, break_on_hyphens=False)
    return f"{before}{wrapped}\n\n{after}"


def section(rows: Sequence[Row], seed: int) -> str:
    """Return the section."""
    lines = [
        SECTION,
        "",
        f"Made by `python -m tools.random_programs --count {len(rows)} --seed {seed} --docs`;",
        "`random-programs.csv` has every row. Its grammar of schemes, mistakes, scenes and files shares no code with",
        "`tumble grade` and is wider than what it knows. A fifth of the files has noise, as of a motion-capture",
        "system: Gaussian, with a standard deviation of 1e-5 to 1e-3 of the body's size. A mistake counts as planted",
        f"if it moves vertices by more than {MEASUREMENT.significant:g} times the noise (root mean square), in the",
        f"other files by more than {DIGITS.significant:g} times what digits and precision leave open. An answer is",
        "right if it names every such mistake with its value and nothing else; it makes the same motion if its",
        "program writes the same file.",
        "",
        *summary(rows),
        "",
        "How often mistakes that all have names were found, by their number (right, alike or the same motion):",
        "",
        "| mistakes | digits alone | with noise |",
        "|---|---|---|",
    ]
    for low, high, what in NUMBERS:
        cells = (share(*found(of_noise(rows, is_measured), low, high)) for is_measured in (False, True))
        lines.append(f"| {what} | {' | '.join(cells)} |")
    lines += ["", "How often answers were right, by the `confidence` in `--json`:", "", *reliability(rows)]
    if any(row.assessed in (WRONG, FALSE_CORRECT) for row in rows):
        lines += ["", "Answers that were firmly wrong; a residual is over the noise or what the digits leave open:", ""]
        lines += listed(rows)
    return "\n".join(lines) + "\n"


def found(rows: Sequence[Row], low: int, high: int) -> tuple[int, int]:
    """Return the number of files whose mistakes, so many and all with names, were found, and of such files."""
    some = [row for row in named(rows) if low <= len(labels(row)) <= high]
    return sum(row.assessed in HITS for row in some), len(some)


def paragraph(rows: Sequence[Row], seed: int) -> str:
    """Return what the figures mean for a reader's file."""
    digits, noise = of_noise(rows, False), of_noise(rows, True)
    one, two, more = (_of(found(digits, low, high)) for low, high in ((1, 1), (2, 2), (3, 99)))
    unnamed = [row for row in rows if row.kind == UNNAMED]
    honest = sum(row.assessed in (HONEST, *HITS) for row in unnamed)
    firm = [row for row in rows if row.kind in (NAMED, UNNAMED) and row.verdict == "explained"]
    right, correct = sum(row.assessed in HITS for row in firm), sum(row.assessed == FALSE_CORRECT for row in rows)
    return (
        f"`python -m tools.random_programs --count {len(rows)} --seed {seed}` draws programs from a grammar that is "
        "wider than the list above; another seed draws others. Files with five to nine digits, whose mistakes all have "
        f"names here, were explained rightly in {_of(found(digits, 1, 99))} cases: {one} with one mistake, {two} with "
        f"two, {more} with more, most others of which were explained in part. With noise of 1e-5 to 1e-3 of the body's "
        f"size they were in {_of(found(noise, 1, 99))}. Of mistakes that have no name, {_of((honest, len(unnamed)))} "
        f"were reported as not explained, or in part. Of the answers that are called explained, "
        f"{_of((right, len(firm)))} were right; {correct or 'no'} wrong file{'s' if correct > 1 else ''} "
        f"{'were' if correct > 1 else 'was'} called correct. `confidence` in `--json` says how likely an explanation "
        "is to be right, and is empty for any other answer ([confusion.md](confusion.md) has its table). `--search 12` "
        'finds more. If you suspect several mistakes, fix the one that helps most and grade again. "Explained in '
        'part" names what helps most, and often some of the mistakes; it is a place to begin, not a diagnosis.'
    )


def _of(pair: tuple[int, int]) -> str:
    return f"{pair[0]} of {pair[1]}"
