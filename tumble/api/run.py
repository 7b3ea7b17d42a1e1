"""`tumble.run`: the trajectory of one scene in one engine."""

import pandas as pd

from tumble.api.contestants import ContestantLike, contestant_list
from tumble.api.limits import limits, step
from tumble.api.result import with_units
from tumble.api.scene import SceneLike, questions
from tumble.compare.engines import OWN, OWN_ON_PLANE
from tumble.compare.run.engines.registry import BadEngine
from tumble.compare.run.flight import check_step
from tumble.compare.run.running_engines import TIME_LIMIT_S
from tumble.compare.run.starting import started
from tumble.compare.run.worker import MEMORY_LIMIT, Failure
from tumble.compare.tables.trajectory import trajectory_frame


def run(
    scene: SceneLike,
    contestant: ContestantLike | None = None,
    *,
    dt: float | None = None,
    time_limit: float = TIME_LIMIT_S,
    memory_limit: int = MEMORY_LIMIT,
    progress: bool = True,
) -> pd.DataFrame:
    """Run one scene in one engine.

    Parameters
    ----------
    scene : a name, a path, a table as in TOML, or a `Scene`.
    contestant : ENGINE[@RELEASE][:METHOD], FILE[:METHOD], or a function as `tumble.engine` takes it; None:
        `tumble`, in a scene with a plane `tumble:events`.
    dt : step [s]; None: the scene's own.
    time_limit : of each run [s].
    memory_limit : of each engine's process [B].
    progress : draw a bar in a terminal or a notebook.

    Returns
    -------
    pandas.DataFrame
        The trajectory, one row a sample, first t = 0, with the columns of `tumble run`; `attrs` has the `units`, the
        `findings` of the engine's own audit, and `steps`.

    Raises
    ------
    UserError
        For a scene, an engine, a method or a step that cannot be used, and where the engine does not finish.

    Examples
    --------
    >>> import tumble
    >>> motion = tumble.run("two-hits", "tumble:exact", progress=False)
    >>> motion.t_s.iloc[-1], motion.attrs["units"]["v0x_m"]
    (np.float64(2.0), 'm')
    """
    dt, limit = step(dt), limits(time_limit, memory_limit, progress)
    (asked,) = questions([scene])
    check_step(asked, dt)
    if contestant is None:
        contestant = OWN if asked.plane is None else OWN_ON_PLANE
    with started(contestant_list([contestant]), **limit) as (running_engine,):
        method = running_engine.methods[0]
        answer = running_engine.simulate(asked, method, dt or asked.step)
        if isinstance(answer, Failure):
            raise BadEngine(f"{running_engine.title}:{method} on {asked.name}: {answer}")
    found = with_units(trajectory_frame(answer, asked.body))
    found.attrs |= {"findings": answer.notes, "steps": answer.steps}
    return found
