"""`tumble scenes`: the catalogue."""

import sys
from argparse import Namespace

from tumble.reports.catalogue import body_lines, scene_list
from tumble.scenarios.read import catalogue, contact_catalogue, read_scene, scene_path, scene_text


def main(options: Namespace) -> int:
    """List every scene with its title and what it needs, or print one as TOML.

    For a file of the user's also the mass properties of its body; a scene of the catalogue is printed to be changed.
    """
    names = [*catalogue(), *contact_catalogue()]
    if options.scene:
        text, lines = scene_text(scene_path(options.scene), options.scene), []
        if options.scene not in names:
            lines = ["", *body_lines(read_scene(options.scene, to_run=False))]
        sys.stdout.write(text if text.endswith("\n") else f"{text}\n")
        sys.stdout.writelines(f"{line}\n" for line in lines)
        return 0
    sys.stdout.writelines(f"{line}\n" for line in scene_list([read_scene(name) for name in names]))
    return 0
