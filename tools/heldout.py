"""Makes the second half of docs/confusion.md, heldout.csv, and the README's figures: what the search was not tuned on.

    .venv/bin/python -m tools.heldout [FOLDER ...]

Mistakes without a name (tests/support/unnamed.py) and with one (planted.py) are simulated by tests/support/programs.py,
which shares no code with the models that recognise mistakes.  Then the tests' files of real engines, and those in each
FOLDER, laid out as tools/foreign.py reads it, are graded, some also without their engine's line in the table.
It takes ten minutes on two cores.
"""

import re
import sys
from argparse import ArgumentParser
from collections import Counter
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

ROOT = Path(__file__).parents[1]
DOCS, TESTS = ROOT / "docs", ROOT / "tests"
sys.path[:0] = [str(TESTS / "support")]

from planted import CASES  # noqa: E402
from programs import read, write  # noqa: E402
from unnamed import MISTAKES  # noqa: E402

from tools.foreign import ForeignRow, Job, jobs_of  # noqa: E402
from tools.foreign import row as foreign_row  # noqa: E402
from tumble.compare.grade.grade import Grade, grade  # noqa: E402
from tumble.compare.grade.hypotheses.engine_schemes import ENGINES  # noqa: E402
from tumble.compare.grade.verdicts import EXPLAINED_PARTLY, EXPLAINED_WHOLLY  # noqa: E402
from tumble.compare.tables.files import write_whole  # noqa: E402
from tumble.compare.tables.frames import csv_text, frame  # noqa: E402
from tumble.compare.tables.schema import Table  # noqa: E402
from tumble.notes import progress  # noqa: E402
from tumble.scenarios.read import read_scene  # noqa: E402

FOREIGN = TESTS / "compare" / "grade" / "foreign"
SCENES = {
    "two-hits": ROOT / "scenarios" / "catalogue" / "two-hits.toml",
    "struck": FOREIGN / "scenes" / "struck.toml",
}
PROCESSES = 2
HEADING = "## Held out: files that the search was not tuned on"
WRONG, NEAREST, UNEXPLAINED, CORRECT = "wrong, firmly", "nearest, but not all", "not explained", "false correct"
RIGHT, NEAR, OTHER = "right", "near", "nearest, another"
UNNAMED, NAMED, ENGINE, LEFT_OUT = "planted", "named", "engine", "left out"
# Also true of the program with planted mistakes, if its steps have an effect.
PROGRAM = {"runge-kutta-4"}
# For files of a program, the engines that are removed from the table: those whose names begin so.
SCHEMES = {
    "ammo": "ammo.js", "cannon-es": "cannon-es", "dart": "DART", "drake": "Drake", "havok": "Havok", "jolt": "Jolt",
    "newton": "Newton", "oimo": "oimo", "panda_bullet": "Bullet", "panda_ode": "ODE", "pybullet": "PyBullet",
    "rapierjs": "Rapier", "sapien": "PhysX",
}  # fmt: skip
LEFT_OUT_FILES = "*.brick.60.csv"


@dataclass(frozen=True)
class HeldOutRow:
    """One file: its source, what is true of it, the answer, and its outcome."""

    source: str
    case: str
    scene: str
    outcome: str
    verdict: str
    answer: str
    max_error_m: float
    residual_m: float | None


def outcome(graded: Grade, right: set[str]) -> str:
    """Return the outcome of an answer; right: the right names, none if the mistake has no name."""
    diagnosis = graded.diagnosis
    names = {mistake.hypothesis.name for mistake in diagnosis.best.mistakes} if diagnosis else set()
    if graded.verdict.startswith("correct"):
        return CORRECT
    if graded.verdict == EXPLAINED_WHOLLY:
        return RIGHT if names & right and names <= right | PROGRAM else WRONG
    if graded.verdict == EXPLAINED_PARTLY:
        return (NEAR if names & right else OTHER) if right else NEAREST
    return UNEXPLAINED


def planted(job: tuple[str, str, str]) -> HeldOutRow:
    """Simulate a mistake, with a name or without, on a scene, grade the file and score the answer."""
    source, mistake, scene = job
    throw = read(SCENES[scene])
    right = CASES[mistake].names if source == NAMED else set()
    flight = CASES[mistake].rows(throw) if source == NAMED else list(MISTAKES[mistake](throw).rows())
    with TemporaryDirectory() as folder:
        file = Path(folder) / "planted.csv"
        write(file, flight, throw.vertices, form=("{:.9g}" if source == NAMED else "{:.6g}").format)
        graded = grade(file, read_scene(str(SCENES[scene])), {})
    diagnosis = graded.diagnosis
    return HeldOutRow(
        source,
        mistake,
        scene,
        outcome(graded, right),
        graded.verdict,
        "; ".join(one.text for one in diagnosis.best.mistakes) if diagnosis else "",
        graded.measured.worst_m,
        diagnosis.best.max_m if diagnosis else None,
    )


def of_engine(job: tuple[str, Job]) -> HeldOutRow:
    """Return the result of tools/foreign.py for a file, with its engine in the table or without."""
    source, foreign = job
    program, scene, rate, _ = foreign[0].name.rsplit(".", 3)
    own = SCHEMES[program.partition("+")[0]] if source == LEFT_OUT else None
    one: ForeignRow = foreign_row(foreign, [law for law in ENGINES if own is None or not law.engine.startswith(own)])
    case, answer = f"{program} at {rate} Hz", one.engines or one.answer
    return HeldOutRow(source, case, scene, one.outcome, one.verdict, answer, one.max_error_m, one.residual_m)


def files(folders: Sequence[Path], pattern: str) -> list[Job]:
    """Return the files of folders without planted mistakes, each once."""
    found = {job[0].name: job for folder in folders for job in jobs_of(folder, pattern)}
    return [job for name, job in sorted(found.items()) if not name.startswith(("plant-", "digits-"))]


def all_rows(folders: Sequence[Path]) -> Iterator[HeldOutRow]:
    """Yield the rows of planted mistakes, then of engines."""
    mistakes = [(UNNAMED, mistake, scene) for mistake in MISTAKES for scene in SCENES]
    mistakes += [(NAMED, mistake, case.scene) for mistake, case in CASES.items()]
    engines = [(ENGINE, job) for job in files(folders, "*.csv")]
    known = [
        job for job in files(folders, LEFT_OUT_FILES) if job[0].name.partition(".")[0].partition("+")[0] in SCHEMES
    ]
    engines += [(LEFT_OUT, job) for job in known if job[2]["gyroscopic"] or job[2]["step_s"]]
    with ProcessPoolExecutor(PROCESSES) as pool, progress(len(mistakes) + len(engines)) as on_progress:
        for work, jobs in ((planted, mistakes), (of_engine, engines)):
            for row in pool.map(work, jobs):
                on_progress(row.case)
                yield row


def counted(rows: Sequence[HeldOutRow]) -> str:
    """Return the number of each outcome, in words."""
    return ", ".join(f"{count} {outcome}" for outcome, count in Counter(row.outcome for row in rows).most_common())


def errors(row: HeldOutRow) -> str:
    """Return the error of a file, and the residual of the answer."""
    return f"{row.max_error_m:.2g}" + ("" if row.residual_m is None else f", {row.residual_m:.2g}")


def listed(rows: Sequence[HeldOutRow], first: str) -> Iterator[str]:
    """Yield a table of rows."""
    yield from ("", f"| {first} | scene | error, left [m] | outcome | answer |", "|---|---|---|---|---|")
    for row in rows:
        yield f"| {row.case} | `{row.scene}` | {errors(row)} | {row.outcome} | {row.answer} |"
    yield ""


def half(rows: Sequence[HeldOutRow]) -> str:
    """Return the second half of docs/confusion.md."""
    unnamed, named, engines, left_out = (
        [row for row in rows if row.source == source] for source in (UNNAMED, NAMED, ENGINE, LEFT_OUT)
    )
    honest = sum(row.outcome in (NEAREST, UNEXPLAINED) for row in unnamed)
    files, firm, right = confident(rows)
    lines = [
        HEADING,
        "",
        "Made by `tools/heldout.py`; `heldout.csv` has every row. `tests/support/programs.py`, which simulates the",
        "planted mistakes, shares no code with the models that recognise them. Answers are in the words of the release",
        "that made the table.",
        "",
        f"**Confident answers**: of {files} files of planted mistakes and of",
        f"engines without their line in the table, {firm} were explained, {right} of them",
        "correctly. There are too few for a better estimate of the odds.",
        "",
        f"**Mistakes without a name in `tumble grade`**: {len(MISTAKES)}, on {len(SCENES)} scenes each, written with",
        "six significant digits. The right answer is that they are not explained, or explained in part.",
        f"That was the answer for **{honest} of {len(unnamed)}** ({counted(unnamed)}).",
        *listed(unnamed, "mistake"),
        f"**Mistakes with a name**, one for each that the program can make: of {len(named)}, {counted(named)}.",
        "Those that were not right:",
        *listed([row for row in named if row.outcome != RIGHT], "mistake"),
        "**Engines that are not in the table**: files of engines whose line was removed from it,",
        f"{len(left_out)}: {counted(left_out)}.",
        "An answer is right if it has every part of the scheme; a scheme that another engine shares is named after it.",
        *listed(left_out, "file"),
        f"**Engines at their defaults**: of {len(engines)} files that real engines wrote, {counted(engines)}.",
        "These are not fully held out: the scheme of each engine in `compare/grade/hypotheses/engine_schemes.py`",
        "was known before its files were graded; the lines of Havok, PhysX's damping and Panda3D's Bullet were",
        "corrected from their own files; and the files in `tests/compare/grade/foreign` must be right for the tests",
        "to pass. Files that were not right:",
        *listed([row for row in engines if row.outcome != "right"], "file"),
    ]
    return "\n".join(lines).rstrip() + "\n"


def confident(rows: Sequence[HeldOutRow]) -> tuple[int, int, int]:
    """Return the number of held-out files, of those called explained, and of those of them that are right."""
    held_out = [row for row in rows if row.source != ENGINE]
    firm = [row for row in held_out if row.verdict == EXPLAINED_WHOLLY]
    return len(held_out), len(firm), sum(not row.outcome.startswith("wrong") for row in firm)


def in_readme(page: str, rows: Sequence[HeldOutRow]) -> str:
    """Return the README with the figures of held-out files."""
    files, firm, right = confident(rows)
    page, count = re.subn(r"on \d+ held-out files", f"on {files} held-out files", page)
    page, counted = re.subn(r"\d+ of \d+ confident answers", f"{right} of {firm} confident answers", page)
    assert (count, counted) == (1, 1)
    return page


def main() -> None:
    """Write the table and the second half of the page."""
    parser = ArgumentParser(
        prog="tools.heldout", description="Make docs/heldout.csv and the second half of docs/confusion.md."
    )
    parser.add_argument(
        "folders", metavar="FOLDER", type=Path, nargs="*", help="more files, laid out as tools/foreign.py reads them"
    )
    made = list(all_rows([FOREIGN, *parser.parse_args().folders]))
    write_whole(DOCS / "heldout.csv", csv_text(frame(Table("", HeldOutRow), made)))
    page = DOCS / "confusion.md"
    first, _, _ = page.read_text(encoding="utf-8").partition(HEADING)
    write_whole(page, f"{first.rstrip()}\n\n{half(made)}")
    write_whole(ROOT / "README.md", in_readme((ROOT / "README.md").read_text(encoding="utf-8"), made))


if __name__ == "__main__":
    main()
