"""Says how well `tumble grade` does on trajectories that other programs wrote, whose truth somebody established.

    .venv/bin/python -m tools.foreign FOLDER [PATTERN] [-o FILE.csv]

FOLDER holds `csv/NAME.SCENE.HZ.csv`, `scenes/SCENE.toml` for what is not in the catalogue, and `truth.csv`: of each
file the step [s], the gyroscopic scheme, damping [1/s] and lag [s] that are to be seen in it, and under `also` what
else.  A cell that is empty says that there is nothing of the kind to be seen.  What a file is judged to be:

right: all that is there, firmly, and nothing else.  extras: all of it, and something that is not there.  nearest: all
of it, told as what comes nearest.  in part: some of it.  wrong: none of it.  not explained: nothing is named.
false correct: what is wrong is called correct, or noise.  Planted mistakes are held against NAMES.
"""

import csv
import sys
from argparse import ArgumentParser
from collections import Counter
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from time import perf_counter

from tumble.compare.grade.grade import EXPLAINED_PARTLY, EXPLAINED_WHOLLY, Grade, grade
from tumble.compare.grade.hypotheses.engine_schemes import ENGINES, Law
from tumble.compare.grade.search.diagnosis import Diagnosis
from tumble.compare.tables.files import write_whole
from tumble.compare.tables.frames import csv_text, frame
from tumble.compare.tables.schema import Table
from tumble.scenarios.read import read_scene

# What truth.csv says of a planted mistake -> the names that are right.
NAMES = {
    "the body never moves": {"never moves", "stops"},
    "the quaternion's half is missing": {"half angle missing"},
    "Euler's equations with the body tensor in world axes": {"inertia never turned"},
    "rows interpolated between ticks": {"interpolated rows"},
    "lever of the impulses in body axes, not turned to the world": {"impulse lever not turned"},
    "a corner was logged for the centre": {"another point logged"},
    "impulses divided by 1000 times the mass": {"impulse of another size"},
    "body mirrored": {"other body axes"},
    "force -c |v| v": {"quadratic drag"},
    "the second impulse acts late": {"impulse at another time"},
    "|w| capped at 7 rad/s in every step": {"spin cap"},
    "the start velocity was not set": {"start velocity missing"},
}
NOTHING = "nothing"
NEAR = 0.01


@dataclass(frozen=True)
class ForeignRow:
    """One file: what is true, what was said, how that is judged, and how long it took."""

    file: str
    judged: str
    verdict: str
    expected: str
    said: str
    engines: str
    max_error_m: float
    residual_m: float | None
    wall_s: float


def expected(truth: dict[str, str]) -> dict[str, float | str]:
    """Return what is to be seen in a file."""
    seen: dict[str, float | str] = {}
    for key, column in (("step", "step_s"), ("lag", "log_lag_s")):
        if truth[column]:
            seen[key] = float(truth[column])
    for kind in ("linear", "angular"):
        if truth[f"{kind}_damping_per_s"]:
            seen[f"{kind} damping"] = float(truth[f"{kind}_damping_per_s"])
    if truth["gyroscopic"]:
        seen["gyroscopic"] = truth["gyroscopic"]
    if truth["damping_law"]:
        seen["damping law"] = truth["damping_law"]
    return seen


def found(diagnosis: Diagnosis) -> dict[str, float | str]:
    """Return what was named, in the words of `expected`; what has none there by its name."""
    said: dict[str, float | str] = {}
    for mistake in diagnosis.best.mistakes:
        name, details = mistake.hypothesis.name, dict(mistake.hypothesis.details)
        match name:
            case "gyroscopic term missing":
                said["gyroscopic"] = "none"
            case "linear damping" | "angular damping":
                said[name] = mistake.value
            case "damping as PyBullet's default":
                said["damping law"] = "PyBullet default"
            case "log lag" | "clock offset":
                said["lag"] = abs(mistake.value)
                if "interpolated" in mistake.hypothesis.says:
                    said["step"] = mistake.value
            case "symplectic Euler":
                said["step"] = mistake.value
                if details.get("gyroscopic") and details["gyroscopic"] != "explicit":
                    said["gyroscopic"] = details["gyroscopic"]
            case "impulse as force over a step" if mistake.value == said.get("step", mistake.value):
                pass  # so an engine is told of an impulse
            case _:
                said[name] = mistake.value
    return said


def agree(one: float | str, other: float | str) -> bool:
    """Whether two values are the same, numbers to one in a hundred."""
    if isinstance(one, str) or isinstance(other, str):
        return one == other
    return abs(one - other) <= NEAR * abs(one)


def judged(graded: Grade, truth: dict[str, str]) -> str:
    """Return the category of a file."""
    said = found(graded.diagnosis) if graded.diagnosis else {}
    if graded.verdict not in (EXPLAINED_WHOLLY, EXPLAINED_PARTLY):
        said = {}
    also, seen = truth["also"], expected(truth)
    firmly = graded.verdict == EXPLAINED_WHOLLY
    if also and also in NAMES:
        hit = NAMES[also] & said.keys()
        if not said:
            return "false correct" if graded.verdict.startswith("correct") else "not explained"
        if not hit:
            return "wrong" if firmly else "wrong, as nearest"
        return ("right" if firmly else "nearest") if len(said) == len(hit) else "extras"
    if not seen and (not also or also == NOTHING or "error-controlled" in also):
        return "right" if not said else "wrong" if firmly else "wrong, as nearest"
    if "not correct" in also:
        return "false correct" if graded.verdict.startswith("correct") else "right"
    if graded.verdict.startswith("correct"):
        return "false correct"
    if not said:
        return "not explained"
    hit = [key for key, value in seen.items() if key in said and agree(value, said[key])]
    more = said.keys() - seen.keys()
    if graded.diagnosis and graded.diagnosis.best.nothing and "step" not in said:
        hit += ["step"] if "step" in seen else []  # what is left is rounding: the step cannot be told from any other
    if "lag" in seen:
        more -= {"step"}
    if not hit:
        return "wrong" if firmly else "wrong, as nearest"
    if len(hit) < len(seen):
        return "in part"
    if more:
        return "extras"
    return "right" if firmly else "nearest"


Job = tuple[Path, Path, dict[str, str]]


def row(job: Job, engines: Sequence[Law] = ENGINES) -> ForeignRow:
    """Grade one file by the laws of some engines and judge what was said.  job: the file, its scene, what is true."""
    file, scene, truth = job
    own = read_scene(str(scene) if scene.exists() else scene.stem)
    begin = perf_counter()
    graded = grade(file, own, {}, engines=engines)
    wall_s = perf_counter() - begin
    diagnosis = graded.diagnosis
    said = "; ".join(mistake.said for mistake in diagnosis.best.mistakes) if diagnosis else ""
    return ForeignRow(
        file.name,
        judged(graded, truth),
        graded.verdict,
        "; ".join(f"{key} {value}" for key, value in expected(truth).items()) or truth["also"],
        said,
        " | ".join(diagnosis.engines) if diagnosis else "",
        graded.measured.worst_m,
        diagnosis.best.max_m if diagnosis else None,
        wall_s,
    )


def jobs_of(folder: Path, pattern: str) -> list[Job]:
    """Return the files of a folder whose truth is known."""
    with (folder / "truth.csv").open(newline="") as file:
        truths = {truth["file"]: truth for truth in csv.DictReader(file)}
    files = [file for file in sorted((folder / "csv").glob(pattern)) if file.name in truths]
    return [(file, folder / "scenes" / f"{file.name.split('.')[1]}.toml", truths[file.name]) for file in files]


def rows(folder: Path, pattern: str, processes: int) -> Iterator[ForeignRow]:
    """Yield the rows of all files, as they are done."""
    jobs = jobs_of(folder, pattern)
    if processes == 1:
        yield from map(row, jobs)
        return
    with ProcessPoolExecutor(processes) as pool:
        yield from pool.map(row, jobs)


def say(line: str) -> None:
    """Print a line at once."""
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()


def main() -> None:
    """Print what was not right, and how many of each."""
    parser = ArgumentParser()
    parser.add_argument("folder", type=Path)
    parser.add_argument("pattern", nargs="?", default="*.csv")
    parser.add_argument("-o", "--output", type=Path)
    parser.add_argument("-p", "--processes", type=int, default=1)
    options = parser.parse_args()
    made = []
    for one in rows(options.folder, options.pattern, options.processes):
        made.append(one)
        if one.judged != "right":
            left = "" if one.residual_m is None else f", {one.max_error_m:.2g} m -> {one.residual_m:.2g} m"
            say(f"{one.file}: {one.judged} ({one.verdict}{left}, {one.wall_s:.1f} s)")
            say(f"    true: {one.expected}\n    said: {one.said}")
    for planted in (False, True):
        some = [one for one in made if one.file.startswith("plant-") == planted]
        if some:
            counts = Counter(one.judged for one in some).most_common()
            said = ", ".join(f"{n} {what}" for what, n in counts)
            say(f"{'planted' if planted else 'engines'}: {len(some)}: {said}")
    say(f"median {median(one.wall_s for one in made):.2f} s, longest {max(one.wall_s for one in made):.1f} s")
    if options.output:
        write_whole(options.output, csv_text(frame(Table("", ForeignRow), made)))


if __name__ == "__main__":
    main()
