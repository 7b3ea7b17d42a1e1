"""The one-line error that lists every open question about a file, with the options that answer them."""

from pathlib import Path

from tumble.compare.grade.read.columns import AmbiguousFile, BadTrajectory
from tumble.compare.grade.read.convention_fit import FITS, best_fits, euler_suggestion, misfit_text
from tumble.compare.grade.read.programs import fitting_programs
from tumble.compare.grade.read.reading_options import ReadingOptions, open_questions
from tumble.scenarios.scene import Scene


def refusal(path: Path, scene: Scene, options: ReadingOptions, first: AmbiguousFile) -> BadTrajectory:
    """Return the error for a file that can be read in several ways.

    Parameters
    ----------
    path, scene : the file and the scene that it is graded against
    options : the user's options
    first : the first open question

    Returns
    -------
    the error; its message is one line that lists all open questions and the options that answer them
    """
    found = open_questions(path, scene, options)
    fits = best_fits(path, scene, found.options, found.angles) if found.angles and not found.error else []
    no_fit = bool(fits) and fits[0].error > FITS
    # A program's units, such as centimetres, are not part of any convention of angles.
    programs = fitting_programs(path, scene, options) if no_fit else []
    as_program = f"it fits as {programs[0].capitalize()} writes it: --like {programs[0]}" if programs else ""
    questions = [*found.questions, *([found.angles] if found.angles else [])]
    if len(questions) < 2:
        by_angles = found.angles and not as_program
        suggestion = euler_suggestion(scene, options, found.angles, fits) if by_angles and found.angles else as_program
        return BadTrajectory("; ".join(filter(None, (str(first), suggestion))))
    name = options.conventions.name or path
    parts = [f"{name}: ambiguous: {'; '.join(question.topic for question in questions)}"]
    likely = (fits[0].options if fits else found.options).command_line(options)
    if as_program:
        parts.append(as_program)
    elif likely:
        parts.append(f"likely: {likely}")
    if no_fit and not as_program:
        parts.append(f"no convention of angles fits; the nearest is {misfit_text(fits[0].error)}")
    elif len(fits) > 1 and not no_fit:
        parts.append(f"{len(fits)} conventions of angles fit")
    if found.error:
        parts.append(f"then {found.error}")
    return BadTrajectory("; ".join(parts))
