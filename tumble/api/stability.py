"""`tumble.stability`: stability maps, the largest stable step of each method, and extreme cases."""

from tumble.api.contestants import Contestants, contestant_list
from tumble.api.limits import limits
from tumble.api.result import Result, call, text_of
from tumble.api.scene import Scenes, is_empty, questions
from tumble.compare.run.worker import MEMORY_LIMIT
from tumble.compare.stability.results import pieces
from tumble.compare.stability.schemas import CONTACT_MAP, CONTACT_STEPS, EXTREMES
from tumble.compare.stability.study import RUN_LIMIT_S, map_scenes
from tumble.compare.stability.tasks import default_scenes
from tumble.compare.tables.frames import rows
from tumble.reports.stability_text import stability_text


def stability(
    scenes: Scenes = (),
    contestants: Contestants = (),
    *,
    time_limit: float = RUN_LIMIT_S,
    memory_limit: int = MEMORY_LIMIT,
    progress: bool = True,
) -> Result:
    """Map the stability of every contestant, and run extreme cases.

    Parameters
    ----------
    scenes : one or several: a name, a path, a table as in TOML, or a `Scene`.
        Extreme cases, by their names, such as "spin-1e4", are run as they are; the others are mapped,
        those with a plane over friction and angle.
        Empty: the stiff scenes of the catalogue and all extreme cases, which take minutes.
    contestants : one or several: ENGINE[@RELEASE][:METHOD], FILE[:METHOD], or a function as `tumble.engine` takes it.
        Empty: every installed engine.
    time_limit : of each run [s].
    memory_limit : of each engine's process [B].
    progress : draw a bar in a terminal or a notebook.

    Returns
    -------
    Result
        Tables `stability`, `limits`, `extremes`, `contact_map`, `contact_steps`, `findings`, `conditions`.

    Raises
    ------
    UserError
        For a scene, an engine or a method that cannot be used.

    Examples
    --------
    >>> import tumble
    >>> tumble.stability("spin-1e2", "tumble:exact", progress=False).extremes.verdict.tolist()
    ['stable']
    """
    tables = map_scenes(
        questions(default_scenes() if is_empty(scenes) else scenes),
        contestant_list(contestants),
        command=call("stability", scenes, contestants),
        **limits(time_limit, memory_limit, progress),
    )
    extreme, cells, steps = (rows(table, tables[table.file]) for table in (EXTREMES, CONTACT_MAP, CONTACT_STEPS))
    return Result(tables, text_of(stability_text(pieces(tables), extreme, cells, steps)))
