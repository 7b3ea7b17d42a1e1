"""Grades readings with noise, true and wrong, of random scenes that a program of its own simulates.

    .venv/bin/python -m tools.sensor_noise [--files 200] [--seed N]

A true file must be right to its noise, or show no mistake above it if the noise would hide some; a wrong file must not
be right, and is explained where its mistake is named.  The program, `tests/support/sensor_programs.py`, shares nothing
with `tumble grade`.
"""

import sys
import tempfile
from argparse import ArgumentParser
from collections import Counter
from pathlib import Path

import numpy as np

sys.path[:0] = [str(Path(__file__).parents[1] / "tests/support")]

from sensor_programs import MISTAKES, Imu, Motion, combined, random_scene, random_times, readings, toml, write  # noqa: E402

from tumble.compare.grade.sensor_grade import SensorGrade  # noqa: E402
from tumble.compare.grade.study import grade_file  # noqa: E402
from tumble.compare.grade.verdicts import NO_MISTAKE_SEEN, RIGHT  # noqa: E402
from tumble.reports.sensor_grade import sensor_headline  # noqa: E402
from tumble.scenarios.read import scene_of  # noqa: E402

# A mistake that changes no reading by more than this is none [m/s2 or rad/s].
NO_EFFECT = 1e-9
# Standard deviations of the noise, drawn between these on a log scale [m/s2], [rad/s].
ACCELEROMETER_NOISE, GYRO_NOISE = (3e-3, 0.3), (3e-4, 0.03)


def graded(folder: Path, rng: np.random.Generator, program: Imu) -> SensorGrade:
    """Return the grade of a random file that a program with some noise writes.

    Scenes in which a wrong program reads what a right one does are drawn again.
    """
    while True:
        scene = random_scene(rng)
        times, motion = random_times(rng, scene), Motion(scene)
        rows = readings(scene, motion, times, program, rng)
        if program == Imu() or np.ptp(rows - readings(scene, motion, times, Imu(), rng), axis=0).max() > NO_EFFECT:
            break
    for columns, limits in ((slice(0, 3), ACCELEROMETER_NOISE), (slice(3, 6), GYRO_NOISE)):
        rows[:, columns] += np.exp(rng.uniform(*np.log(limits))) * rng.standard_normal((len(rows), 3))
    file = folder / "imu.csv"
    write(file, times, rows, digits=8)
    found = grade_file(str(file), scene_of(toml(scene), folder / "scene.toml", "scene.toml")).sensor
    assert found is not None
    return found


def main() -> int:
    """Grade the files, and count the verdicts."""
    parser = ArgumentParser(prog="tools.sensor_noise", description="Grade readings with noise, true and wrong.")
    parser.add_argument("--files", type=int, default=200, help="files of each sort (default: %(default)s)")
    parser.add_argument("--seed", type=int, help="seed of the random files (default: a fresh one)")
    options = parser.parse_args()
    seed = int(np.random.SeedSequence().entropy) % 2**32 if options.seed is None else options.seed  # type: ignore[arg-type]
    report(f"seed {seed}")
    rng = np.random.default_rng(seed)
    false_wrong, false_right, named = 0, 0, 0
    verdicts: dict[str, Counter[str]] = {"true": Counter(), "wrong": Counter()}
    with tempfile.TemporaryDirectory() as folder:
        for number in range(options.files):
            found = graded(Path(folder), rng, Imu())
            verdicts["true"][found.verdict] += 1
            if found.verdict not in (*RIGHT, NO_MISTAKE_SEEN):
                false_wrong += 1
                report(f"true file {number}: {sensor_headline(found)}")
            mistake = str(rng.choice(list(MISTAKES)))
            found = graded(Path(folder), rng, combined(mistake))
            verdicts["wrong"][found.verdict] += 1
            if found.verdict in RIGHT:
                false_right += 1
            if mistake in names(found):
                named += 1
            elif found.verdict != NO_MISTAKE_SEEN:
                report(f"wrong file {number}, {mistake}: {sensor_headline(found)}")
    for sort, counts in verdicts.items():
        report(f"{sort}: {dict(counts)}")
    report(f"true files that were wrong: {false_wrong}; wrong files that were right: {false_right}, named: {named}")
    return int(false_wrong > 0 or false_right > 0)


def names(found: SensorGrade) -> set[str]:
    """Return the mistakes in every explanation that is reported."""
    wrong = [device.diagnosis for device in found.devices if device.diagnosis and device.mistakes]
    return {name for each in wrong for explanation in (each.best, *each.alike) for name in explanation.names}


def report(line: str) -> None:
    """Print a line at once."""
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()


if __name__ == "__main__":
    sys.exit(main())
