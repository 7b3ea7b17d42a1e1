"""Makes the second half of docs/confusion.md, and heldout.csv: mistakes and engines' files the search was not tuned on.

    .venv/bin/python docs/heldout.py [FOLDER ...]

Ten mistakes that `tumble grade` has no name for are flown on two scenes each by tests/support/programs.py, which
shares nothing with the models that recognise mistakes, and written in six figures.  Then the files of real engines
that the tests have, and those in each FOLDER, which is as docs/foreign.py reads it, are judged.  It takes five
minutes on two cores.
"""

import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

HERE = Path(__file__).parent
TESTS = HERE.parent / "tests"
sys.path[:0] = [str(HERE), str(TESTS / "support")]

from foreign import ForeignRow  # noqa: E402
from foreign import rows as foreign_rows  # noqa: E402
from programs import Program, Simulation, cross, read, write  # noqa: E402

from compare.grade.verdict import EXPLAINED_PARTLY, EXPLAINED_WHOLLY, grade  # noqa: E402
from compare.tables.files import write_whole  # noqa: E402
from compare.tables.frames import csv_text, frame  # noqa: E402
from compare.tables.schema import Table  # noqa: E402
from scenarios.read import read_scene  # noqa: E402
from tumble.notes import progress  # noqa: E402

FOREIGN = TESTS / "compare" / "grade" / "foreign"
SCENES = {
    "two-hits": HERE.parent / "scenarios" / "catalogue" / "two-hits.toml",
    "struck": FOREIGN / "scenes" / "struck.toml",
}
# Steps too fine to be seen in six figures, and rows of them.
STEP_S, EVERY = 0.001, 25
PROCESSES = 2
HEADING = "## Held out: what the search was not tuned on"
WRONG, NEAREST, UNEXPLAINED, CORRECT = "wrong, firmly", "nearest, but not all", "not explained", "false correct"


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
    left_m: float | None


class Spoilt(Simulation):
    """A right program but for what subclasses do; now: the time of the step [s]."""

    def __init__(self, throw):
        """Begin a flight."""
        super().__init__(throw, Program(dt=STEP_S, every=EVERY))
        self.count, self.right, self.parts = 0, self.inertia, []

    @property
    def now(self):
        """The time that the flight has reached [s]."""
        return self.count * STEP_S

    def rk4(self, dt):
        """Take a step."""
        super().rk4(dt)
        self.count += 1


class WrongSideEachTenth(Spoilt):
    """In every tenth step the attitude is turned on the wrong side."""

    def rk4(self, dt):
        """Take a step."""
        self.program = replace(self.program, wrong_side=self.count % 10 == 9)
        super().rk4(dt)


class InertiaBackEachOther(Spoilt):
    """In every other step Euler's equations have the inertia tensor turned the wrong way."""

    def angular(self, R, w, torque):
        """Return dw/dt."""
        return super().angular(R.T if self.count % 2 else R, w, torque)


class RampedGravity(Spoilt):
    """Gravity grows from nothing to all of it in 0.4 s."""

    def forces(self, x, R, v, w):
        """Return force and torque."""
        force, torque = super().forces(x, R, v, w)
        return force - max(0.0, 1 - self.now / 0.4) * self.mass * self.gravity, torque


class DriftingInertia(Spoilt):
    """The first moment of inertia grows by a fifth each second."""

    def rk4(self, dt):
        """Take a step."""
        self.inertia = self.right * (1 + 0.2 * self.now * np.array([[1.0, 0, 0], [0, 0, 0], [0, 0, 0]]))
        self.inverse = np.linalg.inv(self.inertia)
        super().rk4(dt)


class HalfVelocity(Spoilt):
    """The velocity is kept in half precision."""

    def rk4(self, dt):
        """Take a step."""
        super().rk4(dt)
        self.v = self.v.astype(np.float16).astype(float)


class SpreadImpulse(Spoilt):
    """An impulse is spread over three ticks of 1/50 s: a half, a fifth, three tenths."""

    def strike(self, impulse):
        """Apply the parts that are due, and put the others off."""
        self.parts += [(self.count + 20 * tick, impulse, share) for tick, share in enumerate((0.5, 0.2, 0.3))]

    def rk4(self, dt):
        """Take a step."""
        for due, impulse, share in self.parts:
            if due == self.count:
                self.program = replace(self.program, strength=share)
                super().strike(impulse)
        super().rk4(dt)


class SpeedTorque(Spoilt):
    """A torque acts that grows with the velocity, and along it."""

    def forces(self, x, R, v, w):
        """Return force and torque."""
        force, torque = super().forces(x, R, v, w)
        return force, torque + 0.005 * v


class Magnus(Spoilt):
    """A force acts across velocity and spin, as on a ball."""

    def forces(self, x, R, v, w):
        """Return force and torque."""
        force, torque = super().forces(x, R, v, w)
        return force + 0.02 * self.mass * cross(w, v), torque


class HalfGyroscopic(Spoilt):
    """Half of the gyroscopic term is there."""

    def angular(self, R, w, torque):
        """Return dw/dt."""
        in_body = R.T @ w
        return R @ self.inverse @ (R.T @ torque - 0.5 * cross(in_body, self.inertia @ in_body))


class FilteredPosition(Spoilt):
    """What is logged of the position has gone through a first-order filter of 0.05 s."""

    def rows(self):
        """Yield rows."""
        seen, before = None, 0.0
        for t, x, *others in super().rows():
            seen = x if seen is None else x + (seen - x) * np.exp(-(t - before) / 0.05)
            before = t
            yield t, seen, *others


MISTAKES = {
    "every tenth step turned on the wrong side": WrongSideEachTenth,
    "inertia turned the wrong way in every other step": InertiaBackEachOther,
    "gravity ramped up in 0.4 s": RampedGravity,
    "a moment of inertia that drifts by 0.2 /s": DriftingInertia,
    "velocity in half precision": HalfVelocity,
    "impulse spread unevenly over three ticks": SpreadImpulse,
    "torque along the velocity": SpeedTorque,
    "Magnus force": Magnus,
    "half of the gyroscopic term": HalfGyroscopic,
    "position through a first-order filter": FilteredPosition,
}


def planted(job: tuple[str, str]) -> HeldOutRow:
    """Fly a mistake on a scene, grade the file and judge what was said: a firm answer cannot be right."""
    mistake, scene = job
    throw = read(SCENES[scene])
    with TemporaryDirectory() as folder:
        file = Path(folder) / "planted.csv"
        flight = list(MISTAKES[mistake](throw).rows())
        write(file, flight, throw.vertices, form="{:.6g}".format)
        graded = grade(file, read_scene(str(SCENES[scene])), {})
    diagnosis = graded.diagnosis
    judged = {EXPLAINED_WHOLLY: WRONG, EXPLAINED_PARTLY: NEAREST}.get(graded.verdict, UNEXPLAINED)
    return HeldOutRow(
        "planted",
        mistake,
        scene,
        CORRECT if graded.verdict.startswith("correct") else judged,
        graded.verdict,
        "; ".join(one.said for one in diagnosis.best.mistakes) if diagnosis else "",
        graded.measured.worst_m,
        diagnosis.best.max_m if diagnosis else None,
    )


def engines(folders: Sequence[Path]) -> list[HeldOutRow]:
    """Return what docs/foreign.py finds of the files of folders in which nobody planted a mistake, each file once."""
    made = {one.file: one for folder in folders for one in foreign_rows(folder, "*.csv", PROCESSES)}
    return [of_engine(one) for file, one in sorted(made.items()) if not file.startswith(("plant-", "digits-"))]


def of_engine(one: ForeignRow) -> HeldOutRow:
    """Return the row of what docs/foreign.py found."""
    program, scene, rate, _ = one.file.rsplit(".", 3)
    case, said = f"{program} at {rate} Hz", one.engines or one.said
    return HeldOutRow("engine", case, scene, one.judged, one.verdict, said, one.max_error_m, one.left_m)


def all_rows(folders: Sequence[Path]) -> Iterator[HeldOutRow]:
    """Yield the rows of planted mistakes, then of engines."""
    jobs = [(mistake, scene) for mistake in MISTAKES for scene in SCENES]
    with ProcessPoolExecutor(PROCESSES) as pool, progress(len(jobs)) as tick:
        for row in pool.map(planted, jobs):
            tick(row.case)
            yield row
    yield from engines(folders)


def counted(rows: Sequence[HeldOutRow]) -> str:
    """Return how many rows are judged what."""
    return ", ".join(f"{count} {judged}" for judged, count in Counter(row.judged for row in rows).most_common())


def errors(row: HeldOutRow) -> str:
    """Return how far off a file is, and what the answer leaves of it."""
    return f"{row.max_error_m:.2g}" + ("" if row.left_m is None else f", {row.left_m:.2g}")


def half(rows: Sequence[HeldOutRow]) -> str:
    """Return the second half of docs/confusion.md."""
    own = [row for row in rows if row.source == "planted"]
    foreign = [row for row in rows if row.source == "engine"]
    honest = sum(row.judged in (NEAREST, UNEXPLAINED) for row in own)
    lines = [
        HEADING,
        "",
        "Made by `docs/heldout.py`; every row is in `heldout.csv`.",
        "",
        f"**Mistakes that `tumble grade` has no name for**: {len(MISTAKES)}, on {len(SCENES)} scenes each, flown by",
        "`tests/support/programs.py`, which shares nothing with its models, and written in six figures. The right",
        "answer is that they are not explained, or that what is named is the nearest and not all.",
        f"So it was with **{honest} of {len(own)}** ({counted(own)}).",
        "",
        "| mistake | scene | error, left [m] | answer | named |",
        "|---|---|---|---|---|",
    ]
    for row in own:
        lines.append(f"| {row.case} | {row.scene} | {errors(row)} | {row.judged} | {row.said} |")
    lines += [
        "",
        f"**Engines at their defaults**: of {len(foreign)} files that real engines wrote, {counted(foreign)}.",
        "These are not held out in full: the law of each engine in `compare/grade/engines.py` was known before its",
        "files were judged, the lines of Havok, of PhysX's damping and of Panda3D's Bullet were corrected by files of",
        "theirs, and the files in `tests/compare/grade/foreign` must be right for the tests to pass. No engine that",
        "the table has not got is among them. Those that were not right:",
        "",
        "| file | scene | judged | error, left [m] | said |",
        "|---|---|---|---|---|",
    ]
    lines += [
        f"| {row.case} | {row.scene} | {row.judged} | {errors(row)} | {row.said} |"
        for row in foreign
        if row.judged != "right"
    ]
    return "\n".join(lines) + "\n"


def main() -> None:
    """Write the table and the second half of the page."""
    made = list(all_rows([FOREIGN, *map(Path, sys.argv[1:])]))
    write_whole(HERE / "heldout.csv", csv_text(frame(Table("", HeldOutRow), made)))
    page = HERE / "confusion.md"
    first, _, _ = page.read_text(encoding="utf-8").partition(HEADING)
    write_whole(page, f"{first.rstrip()}\n\n{half(made)}")


if __name__ == "__main__":
    main()
