"""Contestants as Python values: names, paths, and functions of the program that calls."""

from collections.abc import Iterable
from pathlib import Path
from types import ModuleType
from typing import Any

from tumble.api.engines import Engine, Step, engine
from tumble.compare.run.local import Asked, LocalEngine
from tumble.scenarios.refusal import UserError

ContestantLike = str | Path | Engine | ModuleType | Step
Contestants = ContestantLike | Iterable[ContestantLike]


def contestant_list(contestants: Contestants) -> list[Asked]:
    """Return contestants as studies take them.

    Parameters
    ----------
    contestants : one or several: ENGINE[@RELEASE][:METHOD], FILE[:METHOD], a path, a function as `tumble.engine` takes
        it, or an object with METHODS, FEATURES, ABOUT, build, write, advance and read, as an engine file has them.

    Returns
    -------
    list of Asked

    Raises
    ------
    UserError
        For what is none of these.
    """
    one = isinstance(contestants, str | Path) or callable(contestants) or hasattr(contestants, "METHODS")
    one = one or not isinstance(contestants, Iterable)  # refused below
    return [_contestant(each) for each in ([contestants] if one else contestants)]  # type: ignore[union-attr, list-item]


def _contestant(value: Any) -> Asked:
    if isinstance(value, LocalEngine | str):
        return value
    if isinstance(value, Path):
        return str(value)
    if hasattr(value, "METHODS"):
        return LocalEngine(getattr(value, "__name__", type(value).__name__), value)
    if callable(value):
        return engine(value)
    raise UserError(
        f"{value!r}: must be ENGINE[:METHOD], a path, a function step(state, dt, body), or an engine object"
    )
