"""What truth costs: the catalogue's, many throws, many instants, stiff scenes.

    python tests/bench/truth.py [-o FILE.csv]

Processor time of this process and its threads, kernels compiled beforehand; and the wall time of the catalogue's truths
as `tumble compare` works them out, a process a core, their start included: of use where nothing else is at work.
"""

import re
import time
from dataclasses import replace

import numpy as np
from figures import FigureRow, figure, output_option, processor_s, show

from tumble.compare.run.truths import Truths
from tumble.scenarios.read import catalogue, read_scene, scene_of, scene_path
from tumble.scenarios.scene import Scene, frozen_array
from tumble.scenarios.truth import truth

PASSES, THROWS, INSTANTS = 2, 100_000, 100_000
STIFF = ("tether-undamped", "tether-critical", "tether-overdamped", "floor-stiff", "drag-stiff", "rod-stiff")
# An undamped tether [N/m] over a time [s]: 23,452 rad of its stiffest mode.
STIFFEST, STIFFEST_FOR = 1e8, 1.0


def cpu_s(scenes: list[Scene]) -> list[float]:
    """Return the processor time of the scenes' truths, each pass [s]."""
    for scene in scenes:
        truth(replace(scene, start=scene.start[:100], times=scene.times[-500:]))
    return [processor_s(lambda: [truth(scene) for scene in scenes]) for _ in range(PASSES)]


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


def changed(name: str, **keys: float) -> Scene:
    """Return a scene of the catalogue with other values of keys."""
    path = scene_path(name)
    text = path.read_text()
    for key, value in keys.items():
        text = re.sub(rf"^{key} = .*", f"{key} = {value}", text, flags=re.MULTILINE)
    return scene_of(text, path, name)


def stiffest() -> FigureRow:
    """Return what the reference of the stiffest tether takes, which must be known to its end."""
    scene = changed("tether-undamped", stiffness=STIFFEST, duration=STIFFEST_FOR)
    horizons: list[float] = []
    taken = processor_s(lambda: horizons.append(truth(scene).horizon))
    if horizons != [np.inf]:
        raise SystemExit(f"the reference of the stiffest tether ends at {horizons[0]} s")
    return figure(f"truth of tether-undamped, {STIFFEST:.0e} N/m, {STIFFEST_FOR:g} s", "", "s", 10, [taken])


def main() -> None:
    """Measure, print and write."""
    output = output_option(__doc__.splitlines()[0])
    scenes = [read_scene(name) for name in catalogue()]
    rows = [
        figure("truths of the catalogue, processor time", "", "s", 4, cpu_s(scenes)),
        figure("truths of the catalogue, wall time on all cores", "", "s", 2, together_s(scenes)),
        figure(f"truth of {THROWS:,} throws, processor time", "", "s", 12, cpu_s([thrown(THROWS)])),
        figure(f"truth at {INSTANTS:,} instants, processor time", "", "s", 60, cpu_s([dense("two-hits", INSTANTS)])),
        *(figure(f"truth of {name}, processor time", "", "s", 0.1, cpu_s([read_scene(name)])) for name in STIFF),
        stiffest(),
    ]
    show(rows, output)


if __name__ == "__main__":
    main()
