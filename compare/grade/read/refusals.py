"""The one line that says all that a file leaves unsaid, with the options that would say it."""

from pathlib import Path

from tumble.compare.grade.read.columns import BadTrajectory, Unsaid
from tumble.compare.grade.read.convention_fit import FITS, best_fits, euler_offer, off
from tumble.compare.grade.read.programs import fitting
from tumble.compare.grade.read.reading_options import Said, inquire
from tumble.scenarios.scene import Scene


def refusal(path: Path, scene: Scene, said: Said, first: Unsaid) -> BadTrajectory:
    """Return what to say of a file that does not say how it is to be read; first: the question that came up first."""
    found = inquire(path, scene, said)
    fits = best_fits(path, scene, found.said, found.angles) if found.angles and not found.refusal else []
    misfits = bool(fits) and fits[0].error > FITS
    # Units of a program, such as centimetres, are no convention of angles.
    programs = fitting(path, scene, said) if misfits else []
    as_one = f"it fits as {programs[0].capitalize()} writes it: --like {programs[0]}" if programs else ""
    questions = [*found.asked, *([found.angles] if found.angles else [])]
    if len(questions) < 2:
        offer = euler_offer(scene, said, found.angles, fits) if found.angles and not as_one else as_one
        return BadTrajectory("; ".join(filter(None, (str(first), offer))))
    parts = [f"{said.reading.name or path}: not said: {'; '.join(question.asks for question in questions)}"]
    likely = (fits[0].said if fits else found.said).options(said)
    if as_one:
        parts.append(as_one)
    elif likely:
        parts.append(f"likely: {likely}")
    if misfits and not as_one:
        parts.append(f"no convention of the angles fits, the nearest is {off(fits[0].error)}")
    elif len(fits) > 1 and not misfits:
        parts.append(f"{len(fits)} conventions of the angles fit")
    if found.refusal:
        parts.append(f"then {found.refusal}")
    return BadTrajectory("; ".join(parts))
