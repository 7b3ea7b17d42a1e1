"""The catalogue as text: what there is to fly, and what it needs."""

import shutil
import sys
import textwrap
from collections.abc import Iterator, Sequence

from scenarios.format import visible
from scenarios.needs import needs
from scenarios.scene import Scene


def scene_list(scenes: Sequence[Scene]) -> Iterator[str]:
    """Yield the catalogue: name and needs of each scene, and below them its title.

    As wide as the terminal; in a pipe, where lines are searched, all that a scene needs is on the line of its name.
    """
    margin = 2 + max(len(scene.name) for scene in scenes)
    width = shutil.get_terminal_size().columns if sys.stdout.isatty() else sys.maxsize
    for scene in scenes:
        for head, text in ((scene.name, ", ".join(needs(scene)) or "nothing"), ("", scene.title)):
            first, further = f"{head:{margin}}", " " * margin
            yield textwrap.fill(visible(text), width, initial_indent=first, subsequent_indent=further)
