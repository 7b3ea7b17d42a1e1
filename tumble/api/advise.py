"""`tumble.advise`: the cheapest engine, method and step within a tolerance."""

from argparse import ArgumentTypeError

from tumble.api.contestants import Contestants, contestant_list
from tumble.api.limits import limits
from tumble.api.result import Result, call, text_of
from tumble.api.scene import Scenes, questions
from tumble.compare.judge.cost import REFERENCE
from tumble.compare.run.provenance import conditions
from tumble.compare.run.running_engines import TIME_LIMIT_S
from tumble.compare.run.worker import MEMORY_LIMIT
from tumble.compare.sweep.results import measured
from tumble.compare.sweep.study import advise_scenes
from tumble.compare.tables.frames import frame
from tumble.compare.tables.shared import CONDITIONS
from tumble.parser import metres
from tumble.reports.sweep_text import advice_text
from tumble.scenarios.refusal import UserError


def advise(
    scenes: Scenes,
    contestants: Contestants = (),
    *,
    tolerance: float | str,
    beyond_samples: bool = False,
    time_limit: float = TIME_LIMIT_S,
    memory_limit: int = MEMORY_LIMIT,
    progress: bool = True,
) -> Result:
    """Find the cheapest engine, method and step that stays within an error.

    Parameters
    ----------
    scenes : one or several: a name, a path, a table as in TOML, or a `Scene`.
    contestants : one or several: ENGINE[@RELEASE][:METHOD], FILE[:METHOD], or a function as `tumble.engine` takes it.
        Empty: every installed engine.
    tolerance : largest acceptable vertex error, a number [m] or a length with its unit, `"1mm"`.
    beyond_samples : also try fixed steps longer than the sampling interval.
    time_limit : of each run [s].
    memory_limit : of each engine's process [B].
    progress : draw a bar in a terminal or a notebook.

    Returns
    -------
    Result
        `answer` has the advice; tables as `tumble.sweep` has them.

    Raises
    ------
    UserError
        For a scene, an engine, a method or a tolerance that cannot be used.

    Examples
    --------
    >>> import tumble
    >>> advice = tumble.advise("two-hits", ["tumble:exact", "tumble:rk4"], tolerance="1pm", progress=False)
    >>> "tumble:exact" in advice.answer
    True
    """
    tolerance_m = length(tolerance)
    found, named = advise_scenes(
        questions(scenes),
        tolerance_m,
        contestant_list(contestants),
        beyond_samples=beyond_samples,
        **limits(time_limit, memory_limit, progress),
    )
    command = call("advise", scenes, contestants, tolerance=tolerance)
    tables = measured(found, REFERENCE) | {CONDITIONS.file: frame(CONDITIONS, conditions(command))}
    return Result(tables, text_of(piece for one in found for piece in advice_text(one, tolerance_m, named)))


def length(tolerance: float | str) -> float:
    """Return a tolerance [m].  Raises UserError unless it is a positive length."""
    try:
        return metres(str(tolerance))
    except ArgumentTypeError as error:
        raise UserError(f"tolerance = {error}") from None
