"""Scores `tumble grade` on trajectories of other programs whose properties are known.

    .venv/bin/python -m tools.foreign FOLDER [PATTERN] [-o FILE.csv]

FOLDER holds `csv/NAME.SCENE.HZ.csv`, `scenes/SCENE.toml` for what is not in the catalogue, and `truth.csv`: of each
file the step [s], the gyroscopic scheme, damping [1/s] and lag [s] that have an effect in it, and `also` for anything
else.  An empty cell stands for no effect.  The outcome of a file is one of:

right: all of it and nothing else, firmly.  extras: all of it, and something else.  nearest: all of it, as a partial
explanation.  in part: some of it.  wrong: none of it.  not explained: no mistake is named.  false correct: a wrong file
is called correct, or noise.  Planted mistakes are compared with NAMES.
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

from tumble.compare.grade.grade import Grade, grade
from tumble.compare.grade.hypotheses import names
from tumble.compare.grade.hypotheses.engine_schemes import ENGINES, EngineScheme
from tumble.compare.grade.search.diagnosis import Diagnosis
from tumble.compare.grade.verdicts import EXPLAINED_PARTLY, EXPLAINED_WHOLLY
from tumble.compare.tables.files import write_whole
from tumble.compare.tables.frames import csv_text, frame
from tumble.compare.tables.schema import Table
from tumble.scenarios.read import read_scene

# `also` of a planted mistake in truth.csv -> the right names.
NAMES = {
    "the body never moves": {"body-never-moves", "body-stops"},
    "the quaternion's half is missing": {"half-angle-missing"},
    "Euler's equations with the body tensor in world axes": {"inertia-never-rotated"},
    "rows interpolated between ticks": {"interpolated-rows"},
    "lever of the impulses in body axes, not turned to the world": {"impulse-lever-not-rotated"},
    "a corner was logged for the centre": {"wrong-point-logged"},
    "impulses divided by 1000 times the mass": {"impulse-wrong-magnitude"},
    "body mirrored": {"wrong-body-axes"},
    "force -c |v| v": {"quadratic-drag"},
    "the second impulse acts late": {"impulse-at-wrong-time"},
    "|w| capped at 7 rad/s in every step": {"spin-cap"},
    "the start velocity was not set": {"start-velocity-missing"},
}
# `gyroscopic` of truth.csv -> the scheme's key in `engine_schemes.GYROSCOPIC`, where they differ.
SCHEMES = {"ode": "backward"}
NOTHING = "nothing"
NEAR = 0.01


@dataclass(frozen=True)
class ForeignRow:
    """One file: what is true, the answer, its outcome, and the time that it took."""

    file: str
    outcome: str
    verdict: str
    expected: str
    answer: str
    engines: str
    max_error_m: float
    residual_m: float | None
    wall_s: float


def expected(truth: dict[str, str]) -> dict[str, float | str]:
    """Return the properties of a file that have an effect in it."""
    seen: dict[str, float | str] = {}
    for key, column in (("step", "step_s"), ("lag", "log_lag_s")):
        if truth[column]:
            seen[key] = float(truth[column])
    for kind in ("linear", "angular"):
        if truth[f"{kind}_damping_per_s"]:
            seen[f"{kind} damping"] = float(truth[f"{kind}_damping_per_s"])
    if truth["gyroscopic"]:
        seen["gyroscopic"] = SCHEMES.get(truth["gyroscopic"], truth["gyroscopic"])
    if truth["damping_law"]:
        seen["damping law"] = truth["damping_law"]
    return seen


def found(diagnosis: Diagnosis) -> dict[str, float | str]:
    """Return what was named, with the keys of `expected`; other mistakes by their names."""
    named: dict[str, float | str] = {}
    for mistake in diagnosis.best.mistakes:
        name, details = mistake.hypothesis.name, dict(mistake.hypothesis.details)
        match name:
            case names.GYROSCOPIC_TERM_MISSING:
                named["gyroscopic"] = "none"
            case names.LINEAR_DAMPING | names.ANGULAR_DAMPING:
                named[name.replace("-", " ")] = mistake.value
            case names.PYBULLET_DAMPING:
                named["damping law"] = "PyBullet default"
            case names.LOG_LAG | names.CLOCK_OFFSET:
                named["lag"] = abs(mistake.value)
                if "interpolated" in mistake.text:
                    named["step"] = mistake.value
            case names.SYMPLECTIC_EULER:
                named["step"] = mistake.value
                if details.get("gyroscopic") and details["gyroscopic"] != "explicit":
                    named["gyroscopic"] = details["gyroscopic"]
            case names.IMPULSE_OVER_ONE_STEP if mistake.value == named.get("step", mistake.value):
                pass  # engines are given impulses in this way
            case _:
                named[name] = mistake.value
    return named


def agree(one: float | str, other: float | str) -> bool:
    """Whether two values are the same, numbers to one in a hundred."""
    if isinstance(one, str) or isinstance(other, str):
        return one == other
    return abs(one - other) <= NEAR * abs(one)


def outcome(graded: Grade, truth: dict[str, str]) -> str:
    """Return the outcome of a file."""
    named = found(graded.diagnosis) if graded.diagnosis else {}
    if graded.verdict not in (EXPLAINED_WHOLLY, EXPLAINED_PARTLY):
        named = {}
    also, seen = truth["also"], expected(truth)
    firmly = graded.verdict == EXPLAINED_WHOLLY
    if also and also in NAMES:
        hit = NAMES[also] & named.keys()
        if not named:
            return "false correct" if graded.verdict.startswith("correct") else "not explained"
        if not hit:
            return "wrong" if firmly else "wrong, as nearest"
        return ("right" if firmly else "nearest") if len(named) == len(hit) else "extras"
    if not seen and (not also or also == NOTHING or "error-controlled" in also):
        return "right" if not named else "wrong" if firmly else "wrong, as nearest"
    if "not correct" in also:
        return "false correct" if graded.verdict.startswith("correct") else "right"
    if graded.verdict.startswith("correct"):
        return "false correct"
    if not named:
        return "not explained"
    hit = [key for key, value in seen.items() if key in named and agree(value, named[key])]
    more = named.keys() - seen.keys()
    if graded.diagnosis and graded.diagnosis.best.within_floor and "step" not in named:
        hit += ["step"] if "step" in seen else []  # the residual is rounding: any step would do
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


def row(job: Job, engines: Sequence[EngineScheme] = ENGINES) -> ForeignRow:
    """Grade one file with the schemes of some engines and score the answer.  job: the file, its scene, what is true."""
    file, scene, truth = job
    own = read_scene(str(scene) if scene.exists() else scene.stem)
    begin = perf_counter()
    graded = grade(file, own, {}, engines=engines)
    wall_s = perf_counter() - begin
    diagnosis = graded.diagnosis
    named = "; ".join(mistake.text for mistake in diagnosis.best.mistakes) if diagnosis else ""
    return ForeignRow(
        file.name,
        outcome(graded, truth),
        graded.verdict,
        "; ".join(f"{key} {value}" for key, value in expected(truth).items()) or truth["also"],
        named,
        " | ".join(diagnosis.engines) if diagnosis else "",
        graded.measured.worst_m,
        diagnosis.best.max_m if diagnosis else None,
        wall_s,
    )


def jobs_of(folder: Path, pattern: str) -> list[Job]:
    """Return the files of a folder whose properties are known."""
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
    """Print the files that are not right, and the number of each outcome."""
    parser = ArgumentParser()
    parser.add_argument("folder", type=Path)
    parser.add_argument("pattern", nargs="?", default="*.csv")
    parser.add_argument("-o", "--output", type=Path)
    parser.add_argument("-p", "--processes", type=int, default=1)
    options = parser.parse_args()
    made = []
    for one in rows(options.folder, options.pattern, options.processes):
        made.append(one)
        if one.outcome != "right":
            left = "" if one.residual_m is None else f", {one.max_error_m:.2g} m -> {one.residual_m:.2g} m"
            say(f"{one.file}: {one.outcome} ({one.verdict}{left}, {one.wall_s:.1f} s)")
            say(f"    true: {one.expected}\n    answer: {one.answer}")
    for planted in (False, True):
        some = [one for one in made if one.file.startswith("plant-") == planted]
        if some:
            counts = Counter(one.outcome for one in some).most_common()
            named = ", ".join(f"{n} {what}" for what, n in counts)
            say(f"{'planted' if planted else 'engines'}: {len(some)}: {named}")
    say(f"median {median(one.wall_s for one in made):.2f} s, longest {max(one.wall_s for one in made):.1f} s")
    if options.output:
        write_whole(options.output, csv_text(frame(Table("", ForeignRow), made)))


if __name__ == "__main__":
    main()
