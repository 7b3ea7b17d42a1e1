"""How a file is to be read: the user's options, and the questions that they leave open."""

import shlex
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from tumble.compare.grade.read.block import Block
from tumble.compare.grade.read.columns import AmbiguousAngles, AmbiguousFile, BadTrajectory, Suggestion, parsed
from tumble.compare.grade.read.conventions import WORLD, Conventions
from tumble.compare.grade.read.suggestions import map_option
from tumble.compare.grade.read.trajectory import Trajectory
from tumble.scenarios.scene import Scene

# At most this many questions about one file: columns, units, scalar, decimal sign, clock, angles.
MOST_QUESTIONS = 8
# Any rotation order: it reads the columns whose meaning does not depend on the order.
ANY_ORDER = "xyz"


@dataclass(frozen=True)
class ReadingOptions:
    """Options for reading one file.

    Parameters
    ----------
    mapping : name by column, as `mapping_of` returns it
    decimal : decimal sign
    by : the description to grade if the file has several; None: not given
    conventions : the conventions of the file
    """

    mapping: Mapping[str, str] = field(default_factory=dict)
    decimal: str = "."
    by: str | None = None
    conventions: Conventions = field(default_factory=Conventions)

    def opened(self, path: Path, scene: Scene) -> Trajectory:
        """Return the file, read with these options.  Raises BadTrajectory."""
        return Trajectory(path, scene, self.mapping, self.by, self.decimal, replace(self.conventions, notes=[]))

    def first_rows(self, path: Path, scene: Scene) -> tuple[Trajectory, Block]:
        """Return the file and its first rows, of one throw.  Raises BadTrajectory."""
        trajectory = self.opened(path, scene)
        block = next(trajectory.blocks())
        return trajectory, block.throw(int(block.throws[0]))

    def with_suggestion(self, suggestion: Suggestion) -> "ReadingOptions":
        """Return these options and a suggested answer to a question."""
        start = self.conventions.start if suggestion.start is None else suggestion.start
        return replace(
            self,
            mapping={**self.mapping, **suggestion.mapping},
            decimal=suggestion.decimal or self.decimal,
            conventions=replace(self.conventions, start=start),
        )

    def with_conventions(self, **conventions: str | float | None) -> "ReadingOptions":
        """Return these options with other values for some fields of Conventions."""
        return replace(self, conventions=replace(self.conventions, **conventions))  # type: ignore[arg-type]

    def with_angles(self, named: Mapping[str, tuple[str, str]], unit: str) -> "ReadingOptions":
        """Return these options with columns mapped to angles; unit: of angles whose column names have none."""
        angles = {column: f"{angle}_{own_unit or unit}" for column, (angle, own_unit) in named.items()}
        unnamed = {column: name for column, name in angles.items() if parsed(column) != parsed(name)}
        return replace(self, mapping={**self.mapping, **unnamed})

    def command_line(self, given: "ReadingOptions") -> str:
        """Return what these options add to the given ones, quoted for a shell."""
        conventions, old = self.conventions, given.conventions
        words = [
            f"--{name} {shlex.quote(str(value))}"
            for name, value, before in (
                ("euler", conventions.euler, old.euler),
                ("axes", conventions.axes, old.axes),
                ("start", conventions.start, old.start),
                ("spin", conventions.spin if conventions.spin != WORLD else None, old.spin),
                ("decimal", self.decimal if self.decimal != "." else None, given.decimal),
            )
            if value is not None and value != before
        ]
        words += [map_option(*pair) for pair in self.mapping.items() if given.mapping.get(pair[0]) != pair[1]]
        return " ".join(words)


@dataclass
class OpenQuestions:
    """The questions that a file leaves open, in order, and the options that answer them all.

    angles: the question about Euler angles, if there is one; error: what is wrong with the file whatever the answers.
    """

    questions: list[AmbiguousFile]
    options: ReadingOptions
    angles: AmbiguousAngles | None = None
    error: BadTrajectory | None = None


def open_questions(path: Path, scene: Scene, options: ReadingOptions) -> OpenQuestions:
    """Return the questions that a file leaves open, the clock before the angles.

    Each question is given its suggested answer before the next one is looked for.
    """
    found = OpenQuestions([], options)
    for _ in range(MOST_QUESTIONS):
        trial = found.options if found.angles is None else found.options.with_conventions(euler=ANY_ORDER)
        try:
            trial.first_rows(path, scene)
            break
        except AmbiguousAngles as question:
            found.angles, found.options = question, found.options.with_angles(question.named, "deg")
        except AmbiguousFile as question:
            answered = found.options.with_suggestion(question.suggestion)
            found.questions.append(question)
            if answered == found.options:
                break
            found.options = answered
        except BadTrajectory as error:
            found.error = error
            if (clock := _clock_question(path, scene, trial)) is not None:
                found.questions.append(clock)
                found.options = found.options.with_suggestion(clock.suggestion)
            break
    return found


def _clock_question(path: Path, scene: Scene, options: ReadingOptions) -> AmbiguousFile | None:
    """Return the question about the clock of a file that has a bad row, or None."""
    try:
        options.opened(path, scene).check_clock()
    except AmbiguousFile as question:
        return question
    except BadTrajectory:  # a header that cannot be read: the error says why
        pass
    return None
