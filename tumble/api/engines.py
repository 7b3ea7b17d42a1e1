"""Engines: the list of them, and functions of the calling program as engines."""

from collections.abc import Callable, Collection
from functools import update_wrapper
from typing import TYPE_CHECKING, Any, overload

import pandas as pd

from tumble.api.limits import limits
from tumble.api.result import described
from tumble.compare.engines import CHECKS, CONTACT_CHECKS
from tumble.compare.run.engines import registry
from tumble.compare.run.engines.examine import examined
from tumble.compare.run.local import LocalEngine
from tumble.compare.run.running_engines import TIME_LIMIT_S
from tumble.compare.run.starting import started
from tumble.compare.run.worker import MEMORY_LIMIT, Failure
from tumble.compare.tables.engines import engine_row
from tumble.compare.tables.frames import frame
from tumble.compare.tables.shared import ENGINES
from tumble.scenarios.refusal import UserError, nearest

if TYPE_CHECKING:
    from tumble.api.contestants import Contestants

Step = Callable[..., Any]
PRECISIONS = ("double", "single")


class Engine(LocalEngine):
    """A function of the calling program as a contestant; it can still be called.

    It runs in this process: a crash or an endless loop there ends the caller, and its times are those of Python.
    """

    def __init__(self, step: Step, name: str, **stated: Any) -> None:
        super().__init__(name, LocalEngine.of_step(step, name, **stated).module)
        self._step = step
        update_wrapper(self, step, updated=())

    def __call__(self, *arguments: Any) -> Any:
        """Return what the function returns."""
        return self._step(*arguments)

    def __repr__(self) -> str:
        return f"<tumble engine {self.name!r}>"


@overload
def engine(function: Step) -> Engine: ...
@overload
def engine(
    function: None = None,
    *,
    name: str | None = None,
    features: Collection[str] = (),
    precision: str = "double",
    order: float | None = None,
    gyroscopic: str | None = None,
    exempt: dict[str, str] | None = None,
) -> Callable[[Step], Engine]: ...
def engine(
    function: Step | None = None,
    *,
    name: str | None = None,
    features: Collection[str] = (),
    precision: str = "double",
    order: float | None = None,
    gyroscopic: str | None = None,
    exempt: dict[str, str] | None = None,
) -> Engine | Callable[[Step], Engine]:
    """Make a contestant of a function step(state, dt, body).

    Parameters
    ----------
    function : takes the state (13,): x [m], q (w x y z, body to world), v [m/s], w [rad/s], world axes; the step dt
        [s]; and the body with `mass` [kg], `moments` [kg m2] about its axes, `points` [m], (n, 3), and `gravity`
        [m/s2].  It returns the state dt later, or changes the one it is given.
    name : in tables; None: the function's name.
    features : force laws it has: `"gravity"`.
    precision : "double" or "single".
    order : of convergence, if it is known: by which power of the step the error falls.
    gyroscopic : how it treats the gyroscopic term, a name of `tumble engines`, if it is known.
    exempt : checks that it is meant to fail, and why.

    Returns
    -------
    Engine
        A contestant for `tumble.compare` and the other functions; a decorator if no function is given.

    Raises
    ------
    UserError
        For a name that an engine of ours has, and for a precision, a feature, a gyroscopic term or a check that does
        not exist.

    Examples
    --------
    >>> import tumble
    >>> @tumble.engine(features={"gravity"})
    ... def drifts(state, dt, body):
    ...     state[0:3] += dt * state[7:10]
    ...     state[7:10] += dt * body.gravity
    >>> tumble.compare("die-straight", drifts, film=False).runs.status.tolist()
    ['ok']
    """
    if function is None:
        return lambda step: _named(step, name, features, precision, order, gyroscopic, exempt)
    return _named(function, name, features, precision, order, gyroscopic, exempt)


def _named(
    step: Step,
    name: str | None,
    features: Collection[str],
    precision: str,
    order: float | None,
    gyroscopic: str | None,
    exempt: dict[str, str] | None,
) -> Engine:
    if not callable(step):
        raise UserError(f"{step!r}: must be a function step(state, dt, body)")
    if precision not in PRECISIONS:
        raise UserError(f"precision = {precision!r}: must be {' or '.join(map(repr, PRECISIONS))}")
    own = name or getattr(step, "__name__", type(step).__name__)
    if own in registry.names():
        raise UserError(f"{own}: an engine of ours has this name; give another with name=")
    made = Engine(
        step,
        own,
        FEATURES=registry.words(features),
        ABOUT={"precision": precision},
        ORDERS={} if order is None else {"step": order},
        GYROSCOPIC={} if gyroscopic is None else {"step": gyroscopic},
        EXEMPT=exempt or {},
    )
    registry.engine_info(own, made.module)  # refused here, at the line that made it
    return made


def engines(contestants: "Contestants" = ()) -> pd.DataFrame:
    """Return the engines that take part here, and why others are missing.

    Parameters
    ----------
    contestants : one or several: ENGINE[@RELEASE], FILE, or a function as `tumble.engine` takes it.
        Empty: every engine that Tumble knows.

    Returns
    -------
    pandas.DataFrame
        Columns as `tumble columns engines` has them: engine, status, why, version, precision, methods, features.

    Raises
    ------
    UserError
        For an engine that cannot be used.

    Examples
    --------
    >>> import tumble
    >>> tumble.engines("mujoco")[["engine", "precision"]].values.tolist()
    [['mujoco', 'double']]
    """
    from tumble.api.contestants import contestant_list

    with started(contestant_list(contestants) or registry.names()) as running_engines:
        return described(ENGINES.file, frame(ENGINES, map(engine_row, running_engines)))


class EngineCheck:
    """What came of the contract checks of one engine; true if none failed.

    Parameters
    ----------
    table : one row a check and method: `check`, `method`, `outcome` ("passed", "failed", "skipped", or "known"
        where it fails as the engine's file states) and `why`.
    """

    def __init__(self, table: pd.DataFrame) -> None:
        self.table = table

    def __bool__(self) -> bool:
        return not self.table.outcome.eq("failed").any()

    def __repr__(self) -> str:
        broken = self.table[self.table.outcome == "failed"]
        checked = self.table[self.table.outcome == "passed"].check.nunique()
        if self:
            return f"{checked} checks passed"
        rows = zip(broken["check"], broken["method"], broken["why"], strict=True)
        return "\n".join(f"FAILED {check} ({method}): {why}" for check, method, why in rows)

    def _repr_html_(self) -> str:
        return self.table.to_html(index=False)


def check_engine(
    contestant: Any,
    *,
    time_limit: float = TIME_LIMIT_S,
    memory_limit: int = MEMORY_LIMIT,
    progress: bool = True,
    only: str | None = None,
) -> EngineCheck:
    """Check that an engine satisfies the engine contract.

    Parameters
    ----------
    contestant : ENGINE[:METHOD], FILE[:METHOD], or a function as `tumble.engine` takes it.
    time_limit : of each check [s].
    memory_limit : of the engine's process [B].
    progress : draw a bar in a terminal or a notebook.
    only : the one check to make; None: all of them.

    Returns
    -------
    EngineCheck

    Raises
    ------
    UserError
        For an engine that cannot be used, or is not installed, and for a check that does not exist.

    Examples
    --------
    >>> import tumble
    >>> def still(state, dt, body):
    ...     return state
    >>> bool(tumble.check_engine(still))
    False
    """
    from tumble.api.contestants import contestant_list

    if only is not None and only not in (known := [*CHECKS, *CONTACT_CHECKS]):
        raise UserError(f"only = {only!r}: {nearest(str(only), known)}")
    limit = limits(time_limit, memory_limit, progress)
    with started(contestant_list([contestant]), **limit) as (running_engine,):
        if isinstance(running_engine.info, Failure):
            raise UserError(f"{running_engine.title}: {running_engine.info}")
        rows = [
            (one.check, method, outcome, why)
            for one in examined(running_engine, only)
            for outcome, found in (
                ("passed", dict.fromkeys(one.holds, "")),
                ("failed", one.broken),
                ("skipped", one.not_asked),
                ("known", one.known),
            )
            for method, why in found.items()
        ]
    return EngineCheck(pd.DataFrame(rows, columns=["check", "method", "outcome", "why"]))
