"""`tumble.ablate`: the time saved by switching off features that a scene does not need."""

from tumble.api.contestants import Contestants, contestant_list
from tumble.api.limits import limits
from tumble.api.result import Result, call, text_of
from tumble.api.scene import Scenes, questions
from tumble.compare.ablation.optional_features import SCENES
from tumble.compare.ablation.results import ablation_tables
from tumble.compare.ablation.study import ablate_scenes
from tumble.compare.run.running_engines import TIME_LIMIT_S
from tumble.compare.run.worker import MEMORY_LIMIT
from tumble.reports.ablation import ablation_text


def ablate(
    scenes: Scenes = SCENES,
    contestants: Contestants = (),
    *,
    time_limit: float = TIME_LIMIT_S,
    memory_limit: int = MEMORY_LIMIT,
    progress: bool = True,
) -> Result:
    """Measure every contestant with and without the features that each scene does not need.

    Parameters
    ----------
    scenes : one or several: a name, a path, a table as in TOML, or a `Scene`.
    contestants : one or several: ENGINE[@RELEASE][:METHOD], FILE[:METHOD], or a function as `tumble.engine` takes it.
        Empty: every installed engine.
    time_limit : of each run [s].
    memory_limit : of each engine's process [B].
    progress : draw a bar in a terminal or a notebook.

    Returns
    -------
    Result
        Tables `ablation`, `engines`, `findings`, `conditions`.

    Raises
    ------
    UserError
        For a scene, an engine or a method that cannot be used.

    Examples
    --------
    >>> import tumble
    >>> result = tumble.ablate("die-straight", "tumble:rk4", progress=False)
    >>> bool(result.ablation.max_difference_m.max() <= 1e-12)
    True
    """
    found = ablate_scenes(
        questions(scenes),
        contestant_list(contestants),
        **limits(time_limit, memory_limit, progress),
    )
    tables = ablation_tables(found.ablations, found.engines, call("ablate", scenes, contestants))
    return Result(tables, text_of(piece for one in found.ablations for piece in ablation_text(one)))
