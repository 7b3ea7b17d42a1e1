"""What truth costs: the catalogue's, many throws, many instants.

    python tests/bench/truth.py [-o FILE.csv]

Processor time of this process and its threads, kernels compiled beforehand; and the wall time of the catalogue's truths
as `tumble compare` works them out, a process a core, their start included: of use where nothing else is at work.
"""

import re
import time
from dataclasses import replace

import numpy as np
from figures import figure, output_option, show

from tumble.compare.run.truths import Truths
from tumble.scenarios.read import catalogue, read_scene, scene_of, scene_path
from tumble.scenarios.scene import Scene, frozen_array
from tumble.scenarios.truth import truth

PASSES, THROWS, INSTANTS = 3, 1_000_000, 100_000


def cpu_s(scenes: list[Scene]) -> list[float]:
    """Return the processor time of the scenes' truths, each pass [s]."""
    for scene in scenes:
        truth(replace(scene, start=scene.start[:100], times=scene.times[-500:]))
    taken = []
    for _ in range(PASSES):
        before = time.process_time()
        for scene in scenes:
            truth(scene)
        taken.append(time.process_time() - before)
    return taken


def together_s(scenes: list[Scene]) -> list[float]:
    """Return the wall time of the scenes' truths in processes of their own, each pass [s]."""
    taken = []
    for _ in range(PASSES):
        before = time.perf_counter()
        with Truths(scenes) as truths:
            for future in truths.futures:
                future.result()
        taken.append(time.perf_counter() - before)
    return taken


def thrown(count: int) -> Scene:
    """Return the catalogue's ensemble with so many throws."""
    path = scene_path("many-throws")
    return scene_of(re.sub("throws = .*", f"throws = {count}", path.read_text()), path, "many-throws")


def dense(name: str, count: int) -> Scene:
    """Return a scene looked at so many times."""
    scene = read_scene(name)
    return replace(scene, times=frozen_array(np.linspace(0, scene.duration, count + 1)[1:]))


def main() -> None:
    """Measure, print and write."""
    output = output_option(__doc__.splitlines()[0])
    scenes = [read_scene(name) for name in catalogue()]
    rows = [
        figure("truths of the catalogue, processor time", "", "s", 4, cpu_s(scenes)),
        figure("truths of the catalogue, wall time on all cores", "", "s", 2, together_s(scenes)),
        figure(f"truth of {THROWS:,} throws, processor time", "", "s", 120, cpu_s([thrown(THROWS)])),
        figure(f"truth at {INSTANTS:,} instants, processor time", "", "s", 60, cpu_s([dense("two-hits", INSTANTS)])),
    ]
    show(rows, output)


if __name__ == "__main__":
    main()
