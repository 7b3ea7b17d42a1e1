"""Refusals in the words of the lab's controls: its users have typed no key and no option."""

import re

from tumble.compare.grade.read.columns import BadTrajectory
from tumble.scenarios.impulse import RayMissed
from tumble.scenarios.read import BadScene

OWN_THROW = "Scene's own throw"  # the button
CONTROLS = {"body.mass": "Mass", "body.size": "Size", "gravity": "Gravity", "step": "Step", "duration": "Duration"}
OF_A_KEY = re.compile(r"[^:]*: (?P<key>[a-z.]+)(?:\[(?P<axis>[0-2])\])? = (?P<value>[^:]*): (?P<why>.*)", re.DOTALL)
OPTION = re.compile(r"--[a-z]")


class Refused(ValueError):
    """A command that the lab refuses; the text is the one line for the user."""


def in_words(error: Exception) -> str:
    """Return the line that says why something was refused."""
    line = str(error)
    if isinstance(error, BadScene):
        found = OF_A_KEY.fullmatch(line)
        if found and found["key"] in CONTROLS:
            axis = "" if found["axis"] is None else f" {'xyz'[int(found['axis'])]}"
            control = f"{CONTROLS[found['key']]}{axis}"
            return f"{control}: {found['value']} is not allowed, it {found['why']}. Nothing was changed."
    if isinstance(error, RayMissed) or (isinstance(error, BadScene) and line.endswith("the ray misses the body")):
        return "With this value the impulse would miss the body. Nothing was changed."
    if isinstance(error, BadTrajectory) and OPTION.search(line):
        return (
            f"{line}. These options exist on the command line only: rename the columns in the file, or save the scene "
            "here and run tumble grade FILE --scene SCENE.toml with the option."
        )
    return line
