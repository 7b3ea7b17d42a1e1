"""The one line that says all that a file leaves unsaid, with the options that would say it."""

from pathlib import Path

from compare.grade.columns import BadTrajectory, Unsaid
from compare.grade.fit import FITS, best_fits, euler_offer
from compare.grade.said import Said, inquire
from scenarios.scene import Scene


def refusal(path: Path, scene: Scene, said: Said, first: Unsaid) -> BadTrajectory:
    """Return what to say of a file that does not say how it is to be read; first: the question that came up first."""
    found = inquire(path, scene, said)
    fits = best_fits(path, scene, found.said, found.angles) if found.angles and not found.refusal else []
    offer = euler_offer(scene, said, found.angles, fits) if found.angles else ""
    questions = [*found.asked, *([found.angles] if found.angles else [])]
    if len(questions) < 2:
        return BadTrajectory("; ".join(filter(None, (str(first), offer))))
    likely = (fits[0].said if fits else found.said).options(said)
    line = f"{said.reading.name or path}: not said: {'; '.join(question.asks for question in questions)}"
    line += f"; likely: {likely}" if likely else ""
    if fits and fits[0].error > FITS:
        line += f"; no convention of the angles fits, the nearest is {fits[0].error:.0%} of the body off"
    elif len(fits) > 1:
        line += f"; {len(fits)} conventions of the angles fit"
    return BadTrajectory(line + (f"; then {found.refusal}" if found.refusal else ""))
