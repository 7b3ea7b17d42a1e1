"""`tumble.report`: everything on one self-contained page."""

from pathlib import Path

from tumble.api.contestants import Contestants, contestant_list
from tumble.api.limits import limits, step
from tumble.api.result import Result, call
from tumble.api.scene import Scenes, is_empty, questions
from tumble.compare.run.running_engines import TIME_LIMIT_S
from tumble.compare.run.worker import MEMORY_LIMIT
from tumble.compare.tables.files import write_whole
from tumble.report_tables import report_tables
from tumble.scenarios.read import catalogue


def report(
    scenes: Scenes = (),
    contestants: Contestants = (),
    *,
    dt: float | None = None,
    every_method: bool = False,
    file: str | Path | None = None,
    time_limit: float = TIME_LIMIT_S,
    memory_limit: int = MEMORY_LIMIT,
    progress: bool = True,
) -> Result:
    """Run all studies of the report.

    Parameters
    ----------
    scenes : one or several: a name, a path, a table as in TOML, or a `Scene`.
        Empty: the whole catalogue.
    contestants : one or several: ENGINE[@RELEASE][:METHOD], FILE[:METHOD], or a function as `tumble.engine` takes it.
        Empty: every installed engine.
    dt : step [s]; None: each scene's own.
    every_method : every method of every engine, not only each engine's defaults and best.
    file : where the page is written, if anywhere; `Result.page` returns its text.
    time_limit : of each run [s].
    memory_limit : of each engine's process [B].
    progress : draw a bar in a terminal or a notebook.

    Returns
    -------
    Result
        All tables of the page.

    Raises
    ------
    UserError
        For a scene, an engine or a method that cannot be used.

    Examples
    --------
    >>> import tumble
    >>> result = tumble.report("die-straight", "tumble:exact", progress=False)
    >>> result.page().startswith("<!doctype html>")
    True
    """
    whole = is_empty(scenes)
    tables = report_tables(
        questions(catalogue() if whole else scenes),
        contestant_list(contestants),
        dt=step(dt),
        every_method=every_method,
        whole_catalogue=whole,
        command=call("report", scenes, contestants, dt=dt),
        **limits(time_limit, memory_limit, progress),
    )
    result = Result(tables)
    if file is not None:
        write_whole(Path(file), result.page())
    return result
