"""What an impact costs by `tumble:events`, against what was asked: 5 us, the flight up to it and its search included.

python tests/bench/contact.py [-o FILE.csv]
"""

import numpy as np
from figures import FigureRow, figure, lower_deciles, output_option, show, thread_clock

from tumble.compare.engines import tumble
from tumble.scenarios.read import read_scene
from tumble.solver.contact.throw import IMPACTS

SCENES = ("ball-drop-half", *(f"die-corner-{kind}" for kind in ("smooth", "planar", "sticks", "space")), "die-thrown")
THROWS, ROUNDS, PASSES, ASKED_US = 1000, 10, 2, 5.0


def main() -> None:
    """Print the figures, and write them."""
    output = output_option(__doc__.splitlines()[0])
    tasks, impacts = {}, {}
    for name in SCENES:
        scene = read_scene(name)
        world, starts = tumble.build(scene, "events"), np.repeat(scene.start, THROWS, axis=0)

        def run(world=world, starts=starts, duration=scene.duration):
            world.flight.write(starts)
            world.flight.advance(1, duration)

        run()
        tasks[name], impacts[name] = (run, thread_clock), world.flight.rows[:, IMPACTS].sum()
    passes = [lower_deciles(tasks, ROUNDS) for _ in range(PASSES)]
    rows: list[FigureRow] = [
        figure(f"{name}, an impact", "", "us", ASKED_US, [1e6 * times[name] / impacts[name] for times in passes])
        for name in SCENES
    ]
    show(rows, output)


if __name__ == "__main__":
    main()
