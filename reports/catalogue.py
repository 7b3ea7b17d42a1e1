"""The catalogue as text: every scene, and what it needs."""

import shutil
import sys
import textwrap
from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from tumble.scenarios.format import visible
from tumble.scenarios.mass import mesh
from tumble.scenarios.needs import needs
from tumble.scenarios.scene import Scene


def body_lines(scene: Scene) -> Iterator[str]:
    """Yield mass, volume, centre, moments and axes of a scene's body, as comments of TOML.

    Parameters
    ----------
    scene : the scene

    Yields
    ------
    one line each, with SI units
    """
    body = scene.body
    yield "# Computed from [body]:"
    yield f"# mass     {body.mass:.9g} kg"
    if len(body.faces):
        given = body.points if scene.written is None or scene.written.points is None else scene.written.points
        solid = mesh(body.mass, given, body.faces)
        yield f"# volume   {abs(solid.volume):.9g} m3, density {body.mass / abs(solid.volume):.6g} kg/m3"
        if body.shape == "mesh":
            yield f"# centre   {_numbers(solid.centre)} m, of mass, in the mesh file's own coordinates"
            yield f"# extent   {_numbers(np.ptp(given, axis=0))} m, along the mesh file's axes"
    yield f"# moments  {_numbers(body.moments)} kg m2, about the principal axes"
    if body.file_axes[0] != 1.0:
        yield f"# axes     {_numbers(body.file_axes)}, quaternion w x y z from the file's axes to the principal ones"
    yield f"# vertices {len(body.points)}, the furthest {body.reach:.6g} m from the centre of mass"


def _numbers(values: Iterable[float]) -> str:
    return "[" + ", ".join(f"{value + 0.0:.9g}" for value in values) + "]"


def scene_list(scenes: Sequence[Scene]) -> Iterator[str]:
    """Yield the catalogue: name and needs of each scene, and below them its title.

    As wide as the terminal; in a pipe, where lines are searched, all that a scene needs is on the line of its name.

    Parameters
    ----------
    scenes : the scenes, at least one

    Yields
    ------
    two paragraphs for each scene, in the given order
    """
    margin = 2 + max(len(scene.name) for scene in scenes)
    width = shutil.get_terminal_size().columns if sys.stdout.isatty() else sys.maxsize
    for scene in scenes:
        for head, text in ((scene.name, ", ".join(needs(scene)) or "nothing"), ("", scene.title)):
            first, further = f"{head:{margin}}", " " * margin
            yield textwrap.fill(visible(text), width, initial_indent=first, subsequent_indent=further)
