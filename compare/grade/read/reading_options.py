"""What is said of how a file is to be read, by options or by the name of a program, and what is left to be asked."""

import shlex
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from tumble.compare.grade.read.block import Block
from tumble.compare.grade.read.columns import AnglesUnread, Answer, BadTrajectory, Unsaid, parsed
from tumble.compare.grade.read.conventions import WORLD, Reading
from tumble.compare.grade.read.suggestions import map_option
from tumble.compare.grade.read.trajectory import Trajectory
from tumble.scenarios.scene import Scene

# Questions about one file: columns, units, the scalar, the decimal sign, the clock, angles.
MOST_QUESTIONS = 8
# Any order of turns, to read what does not depend on it.
ANY_ORDER = "xyz"


@dataclass(frozen=True)
class Said:
    """What is said of one file: names of columns, column -> name, its decimal sign, which of several descriptions."""

    mapping: Mapping[str, str] = field(default_factory=dict)
    decimal: str = "."
    by: str | None = None
    reading: Reading = field(default_factory=Reading)

    def opened(self, path: Path, scene: Scene) -> Trajectory:
        """Return the file as it is read then.  Raises BadTrajectory."""
        return Trajectory(path, scene, self.mapping, self.by, self.decimal, replace(self.reading, notes=[]))

    def first_rows(self, path: Path, scene: Scene) -> tuple[Trajectory, Block]:
        """Return the file and its first rows, of one throw.  Raises BadTrajectory."""
        trajectory = self.opened(path, scene)
        block = next(trajectory.blocks())
        return trajectory, block.throw(int(block.throws[0]))

    def answered(self, answer: Answer) -> "Said":
        """Return what is said with a question answered."""
        start = self.reading.start if answer.start is None else answer.start
        return replace(
            self,
            mapping={**self.mapping, **answer.mapping},
            decimal=answer.decimal or self.decimal,
            reading=replace(self.reading, start=start),
        )

    def read_as(self, **conventions: str | float | None) -> "Said":
        """Return what is said with other conventions: fields of a Reading."""
        return replace(self, reading=replace(self.reading, **conventions))  # type: ignore[arg-type]

    def with_angles(self, named: Mapping[str, tuple[str, str]], unit: str) -> "Said":
        """Return what is said with columns for angles, of a unit where their names do not say it."""
        angles = {column: f"{angle}_{said or unit}" for column, (angle, said) in named.items()}
        unsaid = {column: name for column, name in angles.items() if parsed(column) != parsed(name)}
        return replace(self, mapping={**self.mapping, **unsaid})

    def options(self, before: "Said") -> str:
        """Return the options that say what is said beyond something, as a shell takes them."""
        reading, old = self.reading, before.reading
        words = [
            f"--{name} {shlex.quote(str(value))}"
            for name, value, known in (
                ("euler", reading.euler, old.euler),
                ("axes", reading.axes, old.axes),
                ("start", reading.start, old.start),
                ("spin", reading.spin if reading.spin != WORLD else None, old.spin),
                ("decimal", self.decimal if self.decimal != "." else None, before.decimal),
            )
            if value is not None and value != known
        ]
        words += [map_option(*pair) for pair in self.mapping.items() if before.mapping.get(pair[0]) != pair[1]]
        return " ".join(words)


@dataclass
class Inquiry:
    """Questions about one file, in the order in which they came up, and what is said once all are answered.

    angles: the question about angles, if there was one; refusal: what is bad whatever is answered.
    """

    asked: list[Unsaid]
    said: Said
    angles: AnglesUnread | None = None
    refusal: BadTrajectory | None = None


def inquire(path: Path, scene: Scene, said: Said) -> Inquiry:
    """Return all that a file does not say, the clock before the angles; each question is taken as likely answered."""
    found = Inquiry([], said)
    for _ in range(MOST_QUESTIONS):
        trial = found.said if found.angles is None else found.said.read_as(euler=ANY_ORDER)
        try:
            trial.first_rows(path, scene)
            break
        except AnglesUnread as question:
            found.angles, found.said = question, found.said.with_angles(question.named, "deg")
        except Unsaid as question:
            answered = found.said.answered(question.answer)
            found.asked.append(question)
            if answered == found.said:
                break
            found.said = answered
        except BadTrajectory as refusal:
            found.refusal = refusal
            if (clock := _clock_question(path, scene, trial)) is not None:
                found.asked.append(clock)
                found.said = found.said.answered(clock.answer)
            break
    return found


def _clock_question(path: Path, scene: Scene, said: Said) -> Unsaid | None:
    """Return what is to be asked of the clock of a file with a bad row, if anything."""
    try:
        said.opened(path, scene).check_clock()
    except Unsaid as question:
        return question
    except BadTrajectory:  # a header that cannot be read: the refusal says why
        pass
    return None
