"""`tumble scenes`: the catalogue."""

from argparse import Namespace

from reports.terminal import console, scene_list
from scenarios.read import catalogue, read_scene


def main(options: Namespace) -> int:
    """List every scene with its title and what it needs."""
    console().print(scene_list([read_scene(name) for name in catalogue()]))
    return 0
