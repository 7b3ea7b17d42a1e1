"""The study of `tumble compare`: scenes and contestants in, comparisons with the reference out."""

from collections.abc import Sequence
from dataclasses import dataclass

from tumble.compare.comparison.against_truth import Comparison, compare
from tumble.compare.comparison.in_parts import contestants_of
from tumble.compare.run.flight import check_step
from tumble.compare.run.local import Asked
from tumble.compare.run.progress import Display, no_display
from tumble.compare.run.running_engines import TIME_LIMIT_S, flights
from tumble.compare.run.starting import started
from tumble.compare.run.worker import MEMORY_LIMIT
from tumble.compare.tables.engines import engine_row
from tumble.compare.tables.shared import EngineRow
from tumble.scenarios.ensemble import parts_in
from tumble.scenarios.scene import Scene


@dataclass(frozen=True, eq=False)
class Compared:
    """The comparison of each scene, and the engines that took part."""

    comparisons: tuple[Comparison, ...]
    engines: tuple[EngineRow, ...]


def compare_scenes(
    scenes: Sequence[Scene],
    contestants: Sequence[Asked] = (),
    *,
    dt: float | None = None,
    time_limit: float = TIME_LIMIT_S,
    memory_limit: int = MEMORY_LIMIT,
    display: Display = no_display,
) -> Compared:
    """Run every scene with every contestant and compare the vertices with the reference.

    Parameters
    ----------
    scenes : the scenes
    contestants : ENGINE[@RELEASE][:METHOD] or FILE[:METHOD] of each; empty: the engines installed with Tumble
    dt : step [s]; None: each scene's own
    time_limit : for each run [s]
    memory_limit : for each engine's process [B]
    display : shows progress

    Returns
    -------
    the comparisons, in the order of the scenes

    Raises
    ------
    BadEngine : an engine or a method is unknown
    BadStep : the step does not suit a scene
    RayMissed : the ray of a later impulse misses the true body
    """
    for scene in scenes:
        check_step(scene, dt)
    sensing = [scene for scene in scenes if scene.sensors]
    with (
        started(contestants, time_limit, memory_limit, display) as running_engines,
        display(
            flights(running_engines, scenes)
            + flights(running_engines, sensing)
            + len(scenes)
            + sum(parts_in(scene) * len(contestants_of(running_engines, scene)) for scene in scenes if scene.ensemble)
        ) as on_progress,
    ):
        comparisons = compare(running_engines, scenes, dt, on_progress)
        return Compared(tuple(comparisons), tuple(map(engine_row, running_engines)))
