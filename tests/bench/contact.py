"""What an impact costs by `tumble:events`, against what was asked: 5 us, the flight up to it and its search included.

python tests/bench/contact.py [-o FILE.csv]
"""

import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
from figures import FigureRow, figure, lower_deciles, output_option, show, thread_clock

from tumble.compare.engines import tumble
from tumble.scenarios.read import read_scene, scene_of
from tumble.scenarios.scene import Scene
from tumble.solver.contact.throw import FREE, IMPACTS, KIND

sys.path[:0] = [str(Path(__file__).parents[1] / "support")]

from random_contact import drawn  # noqa: E402

SCENES = ("ball-drop-half", *(f"die-corner-{kind}" for kind in ("smooth", "planar", "sticks", "space")), "die-thrown")
FAMILIES = ("cube thrown", "box thrown", "box thrown without friction", "oblique tensor thrown", "disc thrown")
SEEDS = range(777_000, 777_030)
THROWS, ROUNDS, PASSES, ASKED_US = 1000, 10, 2, 5.0
# Random scenes, of which each is thrown so often, and the instants at which they are looked at.
REPEATED, INSTANTS = 30, 32

Run = Callable[[], float]


def throws(scene: Scene, repeated: int, duration: float) -> Run:
    """Return what throws a scene and returns the number of impacts."""
    world, starts = tumble.build(scene, "events"), np.repeat(scene.start, repeated, axis=0)

    def run() -> float:
        world.flight.write(starts)
        world.flight.advance(1, duration)
        return float(world.flight.rows[:, IMPACTS].sum())

    return run


def random_throws(family: str) -> list[Run]:
    """Return throws of random scenes, each as long as it flies between impacts: no lasting contact, no time steps."""
    found = []
    for seed in SEEDS:
        scene = scene_of(drawn(family, seed), Path(f"{seed}.toml"), family)
        flight, flies = tumble.build(scene, "events").flight, 0.0
        flight.write(scene.start)
        for number in range(1, INSTANTS + 1):
            flight.advance(1, scene.duration / INSTANTS)
            if flight.rows[0, KIND] != FREE:
                break
            flies = number * scene.duration / INSTANTS if flight.rows[0, IMPACTS] else 0.0
        if flies:
            found.append(throws(scene, REPEATED, flies))
    return found


def main() -> None:
    """Print the figures, and write them."""
    output = output_option(__doc__.splitlines()[0])
    scenes = {name: read_scene(name) for name in SCENES}
    runs = {name: [throws(scene, THROWS, scene.duration)] for name, scene in scenes.items()}
    runs |= {f"random scenes, {family}": random_throws(family) for family in FAMILIES}
    impacts = {name: sum(run() for run in own) for name, own in runs.items()}
    tasks = {name: (lambda own=own: [run() for run in own], thread_clock) for name, own in runs.items()}
    passes = [lower_deciles(tasks, ROUNDS) for _ in range(PASSES)]
    rows: list[FigureRow] = [
        figure(f"{name}, an impact", "", "us", ASKED_US, [1e6 * one[name] / impacts[name] for one in passes])
        for name in runs
    ]
    show(rows, output)


if __name__ == "__main__":
    main()
