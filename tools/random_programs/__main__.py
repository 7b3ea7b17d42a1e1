"""Draws random programs, runs `tumble grade` on their files, and counts how often it is right.

    .venv/bin/python -m tools.random_programs [--count 300] [--seed N | --seed date] [-o FOLDER] [--docs]

The seed is new in every run and printed.  FOLDER gets `random-programs.csv` and `random-programs.md`, and in `files/`
the file, the scene, the true facts and the answer of each program.  `--only 17` draws and grades that program alone and
prints its details; `--draw` grades nothing; `--evaluate` evaluates the answers stored in FOLDER again, and grades only
files that have changed; `--docs` writes the figures
into docs/confusion.md and docs/grade.md.
"""

import argparse
import json
import os
import secrets
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict
from datetime import UTC, datetime
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from tools.random_programs import contact, names, pages, program, scene, score, table
from tools.random_programs.contact import Answer
from tools.random_programs.dialect import Dialect
from tools.random_programs.program import Case, Program, Truth
from tools.random_programs.scene import Scene, Tether
from tools.random_programs.scheme import Scheme

DOCS = Path(__file__).parents[2] / "docs"
DRAW, GRADE, EVALUATE = "draw", "grade", "evaluate"
Job = tuple[int, int, dict[str, Scene], Path, str]


def written(case: Case, truth: Truth, folder: Path) -> tuple[Path, Path, list[str]]:
    """Write the file of a case, its scene and its true facts; return the first two, and options for the command."""
    name = f"{case.number:04d}"
    file = folder / f"{name}.{'jsonl' if case.dialect.json else 'csv'}"
    options = case.dialect.options(truth.rows)
    file.write_text(case.text(truth.rows), encoding="utf-8")
    scene.save(case.scene, folder / f"{name}.toml")
    about = {
        "seed": case.seed,
        "number": case.number,
        "options": options,
        "scheme": asdict(case.program.scheme),
        "mistakes": [asdict(planted) for planted in case.program.planted],
        "dialect": asdict(case.dialect),
        "noise": case.noise,
        "max_error_m": truth.error_m,
        "error_over_noise": truth.error,
        "facts": [asdict(fact) for fact in truth.facts],
    }
    (folder / f"{name}.json").write_text(json.dumps(about, indent=2) + "\n", encoding="utf-8")
    return file, folder / f"{name}.toml", options


def row_of(case: Case, truth: Truth, answer: Answer) -> table.Row:
    """Return the row of a case and its answer."""
    kind = score.kind_of(case, truth)
    own = case.program.scheme
    damping, reading = own.damping, own.reading
    damps = f"{damping.where}, {damping.how}" if damping.linear or damping.angular else "none"
    late = {0: "", 1: "late", -1: "early"}.get(reading.late, f"{reading.late} ticks late")
    is_split = own.method == "split"
    return table.Row(
        case.number,
        case.scene.name,
        kind,
        score.assessed(case, truth, answer, kind),
        answer.verdict,
        json.dumps([fact.label for fact in truth.significant]),
        names.in_words(answer.best),
        " | ".join(map(names.in_words, answer.explanations[1:])),
        " | ".join(answer.engines),
        truth.error,
        truth.error_m,
        answer.max_error_m,
        None if answer.residual_m is None else answer.residual_m / float(np.median(truth.noise_m)),
        answer.confidence,
        answer.cpu_s,
        len(truth.rows.t),
        case.noise,
        float(np.median(truth.noise_m)),
        case.dialect.digits,
        "single" if own.single else "double",
        case.dialect.kind,
        own.method,
        own.gyroscopic if is_split else "",
        own.turning if is_split else "",
        damps if is_split else "",
        ", ".join(filter(None, (reading.between, late))) or "each tick",
        json.dumps([planted.label for planted in case.program.planted]),
        answer.failure,
    )


def done(job: Job) -> tuple[table.Row | None, str]:
    """Draw a case, write it, grade it and assess the answer; return its row and its details."""
    number, seed, catalogue, folder, what = job
    case, truth = program.drawn(number, seed, catalogue)
    before = {file: file.read_text(encoding="utf-8") for file in folder.glob(f"{number:04d}.*") if file.is_file()}
    files = written(case, truth, folder)
    if what == DRAW:
        return None, about(case, truth, None)
    stored = folder / f"{number:04d}.answer.json"
    same = stored in before and all(file.read_text(encoding="utf-8") == before.get(file) for file in files[:2])
    if what == GRADE or not same:
        stored.write_text(json.dumps(contact.asked(*files), indent=2) + "\n", encoding="utf-8")
    row = row_of(case, truth, contact.answer_of(json.loads(stored.read_text(encoding="utf-8"))))
    return row, about(case, truth, row)


def about(case: Case, truth: Truth, row: table.Row | None) -> str:
    """Return the details of a case in lines."""
    lines = [f"program {case.number} of seed {case.seed}: {case.scene.name}, {case.program.scheme}", f"{case.dialect}"]
    if case.noise:
        lines.append(f"measured with noise of {case.noise:g} of the body's size")
    lines.append(f"{len(truth.rows.t)} rows, off by {truth.error_m:.3g} m, {truth.error:.3g} times the noise")
    lines += [f"  true: {fact}" for fact in truth.facts]
    if row:
        lines.append(f"  {row.kind}, {row.assessed}: {row.verdict} ({row.cpu_s:.1f} s of processor time) {row.failure}")
        lines.append(f"  said: {row.said}  alike: {row.alike}")
    return "\n".join(lines)


def warm(folder: Path) -> None:
    """Grade a file with each combination of forces, so that every kernel is compiled."""
    box = np.array((0.6, 0.35, 0.15))
    at_rest = np.zeros(3)
    for gravity, tether, drag in product((False, True), repeat=3):
        one = Scene(
            "warm",
            1.0,
            2.0,
            scene.box_inertia(2.0, box),
            scene.corners(box),
            at_rest,
            np.array((1.0, 0.0, 0.0, 0.0)),
            np.array((1.0, 2.0, 0.5)),
            np.array((1.0, 4.0, -2.0)),
            np.array((0.0, -9.81 * gravity, 0.0)),
            box,
            tethers=(Tether(7, np.array((0.0, 2.0, 0.0)), 20.0, 0.5),) * tether,
            drag=(0.5 * drag, 0.02 * drag),
        )
        planted = (program.Planted("Magnus force", {"by": 0.1}),)
        case = Case(0, 0, one, Program(Scheme(1 / 60, 1 / 60, "explicit Euler"), planted), Dialect(6))
        contact.graded(*written(case, program.truth_of(case), folder))


def all_done(jobs: Sequence[Job], processes: int) -> Iterator[tuple[table.Row | None, str]]:
    """Yield the results of `done`, in the order of the jobs."""
    if processes == 1 or len(jobs) == 1:
        yield from map(done, jobs)
        return
    with ProcessPoolExecutor(processes) as pool:
        yield from pool.map(done, jobs)


def say(line: str) -> None:
    """Print a line at once."""
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()


def seed_of(text: str) -> int:
    """Return a seed: the number, or today's date."""
    if text == "date":
        return int(datetime.now(UTC).strftime("%Y%m%d"))
    return int(text)


def options_of(words: Sequence[str] | None) -> argparse.Namespace:
    """Return the options of the command."""
    parser = argparse.ArgumentParser(prog="python -m tools.random_programs", description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--count", type=int, default=300, help="number of programs (default: 300)")
    parser.add_argument("--seed", type=seed_of, help="a number, or `date` for today's date (default: random)")
    parser.add_argument("--only", type=int, action="append", help="grade only this program, and print its details")
    parser.add_argument(
        "--draw", dest="what", action="store_const", const=DRAW, help="write the files without grading them"
    )
    parser.add_argument(
        "--evaluate", dest="what", action="store_const", const=EVALUATE, help="evaluate the answers stored in FOLDER"
    )
    parser.set_defaults(what=GRADE)
    parser.add_argument("--processes", type=int, default=2, help="programs graded in parallel (default: 2)")
    parser.add_argument("--docs", action="store_true", help="write the figures into docs/")
    parser.add_argument("-o", "--output", type=Path, help="folder for the tables and files")
    return parser.parse_args(words)


def main(words: Sequence[str] | None = None) -> int:
    """Draw, grade and count; return 1 if a file was not read."""
    options = options_of(words)
    seed = secrets.randbelow(2**31) if options.seed is None else options.seed
    say(f"seed {seed}")
    catalogue = {name: scene.read(contact.scene_text(name), name) for name in program.CATALOGUE}
    numbers = options.only or range(options.count)
    rows = []
    with TemporaryDirectory() as scratch:
        folder = options.output / "files" if options.output else Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
        if options.what == GRADE and not options.only:
            with TemporaryDirectory() as other:
                warm(Path(other))
        jobs = [(number, seed, catalogue, folder, options.what) for number in numbers]
        for row, details in all_done(jobs, options.processes):
            if row:
                rows.append(row)
            if row and not options.only:
                say(f"{row.number}: {row.kind}, {row.assessed} ({row.cpu_s:.1f} s)")
            else:
                say(details)
    if rows and not options.only:
        page = table.markdown(rows, seed)
        if options.output:
            (options.output / "random-programs.csv").write_text(table.csv_text(rows), encoding="utf-8")
            (options.output / "random-programs.md").write_text(page, encoding="utf-8")
        if options.docs:
            for name, change in (("confusion.md", pages.in_confusion), ("grade.md", pages.in_guide)):
                (DOCS / name).write_text(change((DOCS / name).read_text("utf-8"), rows, seed), encoding="utf-8")
            (DOCS / "random-programs.csv").write_text(table.csv_text(rows), encoding="utf-8")
        say(page)
    failed = [row for row in rows if row.failure]
    for row in failed:
        say(f"{row.number}: {row.failure}")
    return 1 if failed else 0


if __name__ == "__main__":
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    sys.exit(main())
