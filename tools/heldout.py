"""Makes the second half of docs/confusion.md, and heldout.csv: mistakes and engines' files the search was not tuned on.

    .venv/bin/python -m tools.heldout [FOLDER ...]

Mistakes without a name (tests/support/unnamed.py) and with one (planted.py) are flown by tests/support/programs.py,
which shares nothing with the models that recognise mistakes.  Then the files of real engines that the tests have, and
those in each FOLDER, which is as tools/foreign.py reads it, are judged, some of them also without their engine's law.
It takes ten minutes on two cores.
"""

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
from tumble.compare.grade.grade import EXPLAINED_PARTLY, EXPLAINED_WHOLLY, Grade, grade  # noqa: E402
from tumble.compare.grade.hypotheses.engine_schemes import ENGINES  # noqa: E402
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
HEADING = "## Held out: what the search was not tuned on"
WRONG, NEAREST, UNEXPLAINED, CORRECT = "wrong, firmly", "nearest, but not all", "not explained", "false correct"
RIGHT, NEAR, OTHER = "right", "near", "nearest, another"
UNNAMED, NAMED, ENGINE, LEFT_OUT = "planted", "named", "engine", "left out"
# What is true of the program that is spoilt, where its steps can be seen.
PROGRAM = {"Runge-Kutta of order 4"}
# What is taken out of the table of laws for files of a program: the laws of engines that begin so.
LAWS = {
    "ammo": "ammo.js", "cannon-es": "cannon-es", "dart": "DART", "drake": "Drake", "havok": "Havok", "jolt": "Jolt",
    "newton": "Newton", "oimo": "oimo", "panda_bullet": "Bullet", "panda_ode": "ODE", "pybullet": "PyBullet",
    "rapierjs": "Rapier", "sapien": "PhysX",
}  # fmt: skip
LEFT_OUT_FILES = "*.brick.60.csv"


@dataclass(frozen=True)
class HeldOutRow:
    """One file: who wrote it, what is true of it, what was said, and how that is judged."""

    source: str
    case: str
    scene: str
    judged: str
    verdict: str
    said: str
    max_error_m: float
    residual_m: float | None


def judged(graded: Grade, right: set[str]) -> str:
    """Return how an answer is judged by the names that are right; none are where the mistake has no name."""
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
    """Fly a mistake, with a name or without, on a scene, grade the file and judge what was said."""
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
        judged(graded, right),
        graded.verdict,
        "; ".join(one.said for one in diagnosis.best.mistakes) if diagnosis else "",
        graded.measured.worst_m,
        diagnosis.best.max_m if diagnosis else None,
    )


def of_engine(job: tuple[str, Job]) -> HeldOutRow:
    """Return what tools/foreign.py finds of a file, with its engine's laws in the table or without."""
    source, foreign = job
    program, scene, rate, _ = foreign[0].name.rsplit(".", 3)
    own = LAWS[program.partition("+")[0]] if source == LEFT_OUT else None
    one: ForeignRow = foreign_row(foreign, [law for law in ENGINES if own is None or not law.engine.startswith(own)])
    case, said = f"{program} at {rate} Hz", one.engines or one.said
    return HeldOutRow(source, case, scene, one.judged, one.verdict, said, one.max_error_m, one.residual_m)


def files(folders: Sequence[Path], pattern: str) -> list[Job]:
    """Return the files of folders in which nobody planted a mistake, each once."""
    found = {job[0].name: job for folder in folders for job in jobs_of(folder, pattern)}
    return [job for name, job in sorted(found.items()) if not name.startswith(("plant-", "digits-"))]


def all_rows(folders: Sequence[Path]) -> Iterator[HeldOutRow]:
    """Yield the rows of planted mistakes, then of engines."""
    mistakes = [(UNNAMED, mistake, scene) for mistake in MISTAKES for scene in SCENES]
    mistakes += [(NAMED, mistake, case.scene) for mistake, case in CASES.items()]
    engines = [(ENGINE, job) for job in files(folders, "*.csv")]
    known = [job for job in files(folders, LEFT_OUT_FILES) if job[0].name.partition(".")[0].partition("+")[0] in LAWS]
    engines += [(LEFT_OUT, job) for job in known if job[2]["gyroscopic"] or job[2]["step_s"]]
    with ProcessPoolExecutor(PROCESSES) as pool, progress(len(mistakes) + len(engines)) as on_progress:
        for work, jobs in ((planted, mistakes), (of_engine, engines)):
            for row in pool.map(work, jobs):
                on_progress(row.case)
                yield row


def counted(rows: Sequence[HeldOutRow]) -> str:
    """Return how many rows are judged what."""
    return ", ".join(f"{count} {judged}" for judged, count in Counter(row.judged for row in rows).most_common())


def errors(row: HeldOutRow) -> str:
    """Return how far off a file is, and what the answer leaves of it."""
    return f"{row.max_error_m:.2g}" + ("" if row.residual_m is None else f", {row.residual_m:.2g}")


def listed(rows: Sequence[HeldOutRow], first: str) -> Iterator[str]:
    """Yield a table of rows."""
    yield from ("", f"| {first} | scene | error, left [m] | judged | said |", "|---|---|---|---|---|")
    for row in rows:
        yield f"| {row.case} | {row.scene} | {errors(row)} | {row.judged} | {row.said} |"
    yield ""


def half(rows: Sequence[HeldOutRow]) -> str:
    """Return the second half of docs/confusion.md."""
    unnamed, named, engines, left_out = (
        [row for row in rows if row.source == source] for source in (UNNAMED, NAMED, ENGINE, LEFT_OUT)
    )
    honest = sum(row.judged in (NEAREST, UNEXPLAINED) for row in unnamed)
    firm = [row for row in (*unnamed, *named, *left_out) if row.verdict == EXPLAINED_WHOLLY]
    false = [row for row in firm if row.judged.startswith("wrong")]
    lines = [
        HEADING,
        "",
        "Made by `tools/heldout.py`; every row is in `heldout.csv`. `tests/support/programs.py`, which flies what is",
        "planted, shares nothing with the models that recognise it.",
        "",
        f"**What is told firmly**: of {len(unnamed) + len(named) + len(left_out)} files of planted mistakes and of",
        f"engines without their line in the table, {len(firm)} were explained firmly,",
        f"{len(firm) - len(false)} of them by what is there.",
        "Too few to know odds better than that: an answer that is not firm is told as the nearest, or not at all.",
        "",
        f"**Mistakes that `tumble grade` has no name for**: {len(MISTAKES)}, on {len(SCENES)} scenes each,",
        "written in six figures. The right answer is that they are not explained, or that what is named is the nearest",
        "and not all.",
        f"So it was with **{honest} of {len(unnamed)}** ({counted(unnamed)}).",
        *listed(unnamed, "mistake"),
        f"**Mistakes with a name**, one for each that the program can make: of {len(named)}, {counted(named)}.",
        "Those that were not right:",
        *listed([row for row in named if row.judged != RIGHT], "mistake"),
        "**Engines that are not in the table**: files whose engine's laws were taken out of it,",
        f"{len(left_out)}: {counted(left_out)}.",
        "What is right is each part of the law; a scheme that another engine has as well is named by that engine.",
        *listed(left_out, "file"),
        f"**Engines at their defaults**: of {len(engines)} files that real engines wrote, {counted(engines)}.",
        "These are not fully held out: the scheme of each engine in `compare/grade/hypotheses/engine_schemes.py`",
        "was known before its files were graded; the lines of Havok, PhysX's damping and Panda3D's Bullet were",
        "corrected from their own files; and the files in `tests/compare/grade/foreign` must be right for the tests",
        "to pass. Files that were not right:",
        *listed([row for row in engines if row.judged != "right"], "file"),
    ]
    return "\n".join(lines).rstrip() + "\n"


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


if __name__ == "__main__":
    main()
