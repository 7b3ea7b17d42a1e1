"""A step of the stiff methods on the tethers of the catalogue, at the step of each scene, and with nothing acting.

    python tests/bench/stiff.py [-o FILE.csv]

Lower decile of interleaved rounds, by the thread's own clock; every sample begins at the start of its scene.
"""

from collections.abc import Callable

import numpy as np
from figures import figure, lower_deciles, output_option, show, thread_clock

from tumble.compare.engines import tumble as engine
from tumble.scenarios.read import read_scene

SCENES = (
    "tether-undamped",
    "tether-critical",
    "tether-overdamped",
    "rod-stiff",
    "drag-stiff",
    "floor-stiff",
    "yardstick",
)
METHODS = "gauss6", "radau5"
STEPS, PASSES, ROUNDS = 500, 3, 20
# What a step on a tether may take [us].
ASKED_US = 1.0


def flight(name: str, method: str) -> Callable[[], object]:
    """Return the first steps of a scene, compiled already."""
    scene = read_scene(name)
    world = engine.build(scene, method)

    def call() -> None:
        engine.write(world, scene.start)
        engine.advance(world, STEPS, scene.step)

    call()
    return call


def main() -> None:
    """Measure, print and write."""
    output = output_option(__doc__.splitlines()[0])
    tasks = {(name, method): (flight(name, method), thread_clock) for name in SCENES for method in METHODS}
    passes = [lower_deciles(tasks, ROUNDS) for _ in range(PASSES)]
    rows = [
        figure(
            f"{method}, a step of {name}",
            "",
            "us",
            ASKED_US if name.startswith("tether") else None,
            np.array([found[name, method] for found in passes]) / STEPS * 1e6,
        )
        for name, method in tasks
    ]
    show(rows, output)


if __name__ == "__main__":
    main()
