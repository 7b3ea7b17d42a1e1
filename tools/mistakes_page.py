"""Makes docs/mistakes.md: every name of a mistake in `diagnosis.csv` and `--json`.

    .venv/bin/python -m tools.mistakes_page

The mistakes that are tried depend on the scene and the file, so the names are collected from scenes in which everything
is possible; a test compares them with the names in the code.
"""

from argparse import ArgumentParser
from collections.abc import Iterator
from itertools import product
from pathlib import Path

import numpy as np

from tumble.compare.grade.hypotheses.contact_mistakes import SHOWN, ContactHypothesis, contact_hypotheses
from tumble.compare.grade.hypotheses.engine_schemes import engine_runs
from tumble.compare.grade.hypotheses.explanation import Mistake
from tumble.compare.grade.hypotheses.hypothesis import Context, Hypothesis
from tumble.compare.grade.hypotheses.mistakes import hypotheses
from tumble.compare.grade.hypotheses.names import RENAMED_MISTAKES, RENAMED_PARAMETERS
from tumble.compare.grade.hypotheses.scheme_hypotheses import SchemeHypotheses, Step
from tumble.compare.grade.hypotheses.sensor_mistakes import SensorHypothesis, sensor_hypotheses
from tumble.compare.grade.measure.speeds import SPEEDS
from tumble.compare.grade.model.contact_law import ContactLaw
from tumble.compare.grade.model.program_model import correct_program
from tumble.compare.grade.model.sensor_model import ACCELEROMETER, GYRO, SensorModel
from tumble.compare.grade.results import parameters
from tumble.compare.grade.search.proposals import Proposals, Run
from tumble.compare.tables.files import write_whole
from tumble.scenarios.frames import rotation_matrix
from tumble.scenarios.read import scene_of

PAGE = Path(__file__).parents[1] / "docs/mistakes.md"
BODY = """
title = "Room for every mistake"
duration = 2.0
samples = 40
step = 0.001
[body]
shape = "box"
size = [0.6, 0.3, 0.1]
mass = 1.7
position = [0.2, 1.0, -0.4]
orientation = [0.9, 0.1, -0.3, 0.3]
velocity = [0.4, 2.0, -0.7]
angular_velocity = [1.0, 2.0, -0.5]
"""
IMPULSES = "".join(
    f"[[impulse]]\ntime = {t}\nvalue = [0.7, -0.3, {z}]\nvertex = 5\n" for t, z in ((0.0, 1.1), (0.5, 2.0))
)
FORCES = """
[[tether]]
vertex = 7
anchor = [0.0, 2.0, 0.0]
stiffness = 60.0
damping = 0.4
[drag]
linear = 0.8
angular = 0.01
"""
FLOOR = "[floor]\nstiffness = 2e3\ndamping = 15.0\n"
GRAVITY = "gravity = [0.0, -9.81, 0.0]\n"
SCENES = (GRAVITY + BODY + IMPULSES, BODY + IMPULSES, GRAVITY + BODY + FORCES, GRAVITY + BODY + FLOOR)
KINDS = ("pose", "matrix", "vertices")
ROWS, SPACING_S = 40, 0.05


def contexts() -> Iterator[Context]:
    """Yield the context of each kind of file of each scene, with and without the position."""
    for text, kind, has_centre in product(SCENES, KINDS, (True, False)):
        scene = scene_of(text, Path("room.toml"), "room.toml")
        program = correct_program(scene, 0)
        first = np.array((0.1, 0.2, 0.3, 0.8, 0.6, 0.0, 0.0))
        offset = np.array((0.3, 0.15, 0.05))
        yield Context(
            scene,
            program,
            kind,
            ROWS,
            scene.duration,
            0.3,
            SPACING_S,
            first,
            has_centre,
            offset,
        )


# Largest speeds of a program, and those that rows reach [m/s, rad/s]: limits are below them.
FASTEST, REACHED = dict.fromkeys(SPEEDS, 10.0), dict.fromkeys(SPEEDS, (5.0,))


def tried() -> Iterator[Hypothesis]:
    """Yield every mistake that is tried, and every one that the schemes of engines and of a search consist of."""
    for context in contexts():
        yield from hypotheses(context)
        schemes = SchemeHypotheses(context)
        for stepped in engine_runs(context):
            yield from (mistake.hypothesis for mistake in schemes.mistakes(stepped))
        proposals = Proposals(context, list(hypotheses(context)))
        upon_step = (Mistake(schemes.step(Step("explicit", "exponential")), SPACING_S),)
        yield from (kind.hypothesis for kind in proposals.with_other_schemes(()))
        run = Run(1.0, SPACING_S, FASTEST, REACHED, rests_from=1.0)
        yield from (hypothesis for hypothesis, _ in proposals.with_one_more(upon_step, run))


def tried_of_sensors() -> Iterator[SensorHypothesis]:
    """Yield every mistake of a sensor that is tried."""
    tilt = rotation_matrix(np.array((0.8, 0.6, 0.0, 0.0)))
    for device in (ACCELEROMETER, GYRO):
        yield from sensor_hypotheses(SensorModel(device, np.array((0.1, 0.0, 0.0)), tilt), SPACING_S)


def tried_of_contact() -> tuple[ContactHypothesis, ...]:
    """Return every mistake of contact that is tried."""
    return (*SHOWN, *contact_hypotheses(ContactLaw(0.5, 0.5), np.array((1.0, 0.0, -9.0)), (1.0, 2.0)))


def names() -> dict[str, dict[str, str]]:
    """Return the unit of each parameter of each mistake, sorted by name."""
    found: dict[str, dict[str, str]] = {}
    for hypothesis in set(tried()):
        found.setdefault(hypothesis.name, {}).update(parameters(hypothesis))
    for sensor_hypothesis in tried_of_sensors():
        own = found.setdefault(sensor_hypothesis.name, {})
        for parameter in sensor_hypothesis.free_names or (sensor_hypothesis.parameter,):
            # A bias has the unit of its device.
            units = dict.fromkeys((*filter(None, (own.get(parameter),)), sensor_hypothesis.unit))
            own[parameter] = " or ".join(units)
    for contact_hypothesis in tried_of_contact():
        found.setdefault(contact_hypothesis.name, {}).update(contact_hypothesis.parameters or (("", ""),))
    return {name: dict(sorted(found[name].items())) for name in sorted(found, key=str.lower)}


def page() -> str:
    """Return docs/mistakes.md."""
    known = names()
    lines = [
        "# The names of mistakes",
        "",
        "The identifiers in the columns `mistake`, `parameter` and `unit` of `diagnosis.csv`,",
        f"`sensor-diagnosis.csv` and `contact-diagnosis.csv`, and in `tumble grade --json`: {len(known)} names,",
        "collected by `tools/mistakes_page.py` from the mistakes that are tried. They change only with the",
        "format of the tables ([compatibility.md](compatibility.md)).",
        "A mistake has one row for each parameter that has an effect in the scene, and one row without a parameter",
        "if it has no value. A `choice` is a word.",
        "",
        "| mistake | parameters, and units |",
        "|---|---|",
    ]
    for name, own in known.items():
        listed = [f"`{parameter}`" + (f" [{unit}]" if unit else "") for parameter, unit in own.items() if parameter]
        lines.append(f"| `{name}` | {', '.join(listed)} |")
    lines += ["", "## Names in format 2", "", "Format 3 renamed these mistakes and parameters.", ""]
    lines += ["| format 2 | format 3 |", "|---|---|"]
    lines += [f"| `{old}` | `{new}` |" for old, new in (RENAMED_MISTAKES | RENAMED_PARAMETERS).items()]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    ArgumentParser(prog="tools.mistakes_page", description="Make docs/mistakes.md.").parse_args()
    write_whole(PAGE, page())
