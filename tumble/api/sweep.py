"""`tumble.sweep`: error against run time."""

from tumble.api.contestants import Contestants, contestant_list
from tumble.api.limits import limits
from tumble.api.result import Result, call, text_of
from tumble.api.scene import Scenes, questions
from tumble.compare.judge.cost import REFERENCE
from tumble.compare.run.running_engines import TIME_LIMIT_S
from tumble.compare.run.worker import MEMORY_LIMIT
from tumble.compare.sweep.study import sweep_scenes
from tumble.compare.sweep.work_precision import YARDSTICK, Sweep
from tumble.reports.sweep_text import sweep_text


def sweep(
    scenes: Scenes = YARDSTICK,
    contestants: Contestants = (),
    *,
    reference: str = REFERENCE,
    observable: str | None = None,
    time_limit: float = TIME_LIMIT_S,
    memory_limit: int = MEMORY_LIMIT,
    progress: bool = True,
) -> Result:
    """Measure error and run time of every contestant over a sequence of steps or tolerances.

    Parameters
    ----------
    scenes : one or several: a name, a path, a table as in TOML, or a `Scene`.
    contestants : one or several: ENGINE[@RELEASE][:METHOD], FILE[:METHOD], or a function as `tumble.engine` takes it.
        Empty: every installed engine.
    reference : ENGINE:METHOD that run times are divided by.
    observable : observable whose error is measured above a plane, as in contact.csv, of a vector without its
        component, such as "velocity after impact".  None: each scene's main one.
    time_limit : of each run [s].
    memory_limit : of each engine's process [B].
    progress : draw a bar in a terminal or a notebook.

    Returns
    -------
    Result
        Tables `work_precision`, `observable_cost`, `accuracy_cost`, `orders`, `equivalent`, `timing`, `runs`,
        `findings`, `conditions`.

    Raises
    ------
    UserError
        For a scene, an engine or a method that cannot be used.

    Examples
    --------
    >>> import tumble
    >>> tumble.sweep("two-hits", "tumble:rk4", progress=False).orders.order.round().tolist()
    [4.0]
    """
    found: list[Sweep] = []
    tables = sweep_scenes(
        questions(scenes),
        contestant_list(contestants),
        reference=reference,
        observable=observable,
        command=call("sweep", scenes, contestants),
        **limits(time_limit, memory_limit, progress),
        finished=found.append,
    )
    return Result(tables, text_of(piece for one in found for piece in sweep_text(one, reference)))
