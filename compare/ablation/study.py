"""The study of `tumble ablate`: scenes and contestants in, the cost of features that a scene does not need out."""

from collections.abc import Sequence
from dataclasses import dataclass

from tumble.compare.ablation.optional_features import Ablation, ablate
from tumble.compare.run.local import Asked
from tumble.compare.run.progress import Display, no_display
from tumble.compare.run.running_engines import TIME_LIMIT_S, flights
from tumble.compare.run.starting import started
from tumble.compare.run.worker import MEMORY_LIMIT
from tumble.compare.tables.engines import engine_row
from tumble.compare.tables.shared import EngineRow
from tumble.scenarios.scene import Scene


@dataclass(frozen=True, eq=False)
class Ablated:
    """The ablation of each scene, and the engines that took part."""

    ablations: tuple[Ablation, ...]
    engines: tuple[EngineRow, ...]


def ablate_scenes(
    scenes: Sequence[Scene],
    contestants: Sequence[Asked] = (),
    *,
    time_limit: float = TIME_LIMIT_S,
    memory_limit: int = MEMORY_LIMIT,
    display: Display = no_display,
) -> Ablated:
    """Measure every contestant with and without the features that each scene does not need.

    Parameters
    ----------
    scenes : the scenes
    contestants : ENGINE[@RELEASE][:METHOD] or FILE[:METHOD] of each; empty: the engines installed with Tumble
    time_limit : for each run [s]
    memory_limit : for each engine's process [B]
    display : shows progress

    Returns
    -------
    the ablations, in the order of the scenes

    Raises
    ------
    BadEngine : an engine or a method is unknown
    """
    with (
        started(contestants, time_limit, memory_limit, display) as running_engines,
        display(flights(running_engines, scenes) + len(scenes)) as on_progress,
    ):
        ablations = tuple(ablate(running_engines, scene, on_progress) for scene in scenes)
        return Ablated(ablations, tuple(map(engine_row, running_engines)))
