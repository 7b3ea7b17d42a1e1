"""Makes docs/mistakes.md: every stable name that `diagnosis.csv` and `--json` may say.

    .venv/bin/python -m tools.mistakes_page

What is tried depends on the scene and the file, so the names are those of scenes that leave room for everything; a
test compares them with the names in the code.
"""

from argparse import ArgumentParser
from collections.abc import Iterator
from itertools import product
from pathlib import Path

import numpy as np

from tumble.compare.grade.hypotheses.engine_schemes import combinations, table
from tumble.compare.grade.hypotheses.hypothesis import Hypothesis, Question
from tumble.compare.grade.hypotheses.mistakes import hypotheses
from tumble.compare.grade.hypotheses.scheme_hypotheses import Laws
from tumble.compare.grade.model.program_model import truthful
from tumble.compare.grade.results import parameters, stable_name
from tumble.compare.tables.files import write_whole
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


def questions() -> Iterator[Question]:
    """Yield what is asked of each kind of file of each scene, of files with and without the centre."""
    for text, kind, centred in product(SCENES, KINDS, (True, False)):
        scene = scene_of(text, Path("room.toml"), "room.toml")
        account = truthful(scene, 0)
        first = np.array((0.1, 0.2, 0.3, 0.8, 0.6, 0.0, 0.0))
        offset = np.array((0.3, 0.15, 0.05))
        yield Question(
            scene,
            account,
            kind,
            ROWS,
            scene.duration,
            0.3,
            SPACING_S,
            first,
            centred,
            offset,
            drift=np.ones((2, 3)),
        )


def tried() -> Iterator[Hypothesis]:
    """Yield every mistake that is tried, and every one that laws of engines and their combinations are said by."""
    for question in questions():
        yield from hypotheses(question)
        laws = Laws(question)
        for flown in (*table(question), *combinations(question)):
            yield from (mistake.hypothesis for mistake in laws.mistakes(flown))


def names() -> dict[str, dict[str, str]]:
    """Return the unit of each parameter of each mistake, by stable names in order."""
    found: dict[str, dict[str, str]] = {}
    for hypothesis in set(tried()):
        found.setdefault(stable_name(hypothesis), {}).update(parameters(hypothesis))
    return {name: dict(sorted(found[name].items())) for name in sorted(found, key=str.lower)}


def page() -> str:
    """Return docs/mistakes.md."""
    known = names()
    lines = [
        "# The names of mistakes",
        "",
        "What stands under `mistake`, `parameter` and `unit` in `diagnosis.csv` and in `tumble grade --json`:",
        f"{len(known)} names, made by `tools/mistakes_page.py` from the mistakes that are tried.",
        "They stay as they are ([compatibility.md](compatibility.md)).",
        "A mistake has one row for each parameter that can be told in the scene, and one row without a parameter",
        "where it has no number. A `choice` is a word.",
        "",
        "| mistake | parameters, and units |",
        "|---|---|",
    ]
    for name, own in known.items():
        said = [f"`{parameter}`" + (f" [{unit}]" if unit else "") for parameter, unit in own.items() if parameter]
        lines.append(f"| `{name}` | {', '.join(said)} |")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    ArgumentParser(prog="tools.mistakes_page", description="Make docs/mistakes.md.").parse_args()
    write_whole(PAGE, page())
