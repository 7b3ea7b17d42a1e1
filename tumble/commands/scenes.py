"""`tumble scenes`: the catalogue."""

import sys
from argparse import Namespace

from reports.catalogue import scene_list
from scenarios.read import catalogue, read_scene, scene_path, scene_text


def main(options: Namespace) -> int:
    """List every scene with its title and what it needs, or print one as it is written."""
    if options.scene:
        sys.stdout.write(scene_text(scene_path(options.scene), options.scene))
        return 0
    sys.stdout.writelines(f"{line}\n" for line in scene_list([read_scene(name) for name in catalogue()]))
    return 0
