"""Contestants as Python values: names, paths, and functions of the program that calls."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from tumble.api.engines import Function, engine
from tumble.scenarios.refusal import UserError

ContestantLike = str | Path | Any


def contestant_list(contestants: ContestantLike | Iterable[ContestantLike]) -> list[Any]:
    """Return contestants as studies take them.

    Parameters
    ----------
    contestants : one or several: a name, a path, a function or an engine object.

    Returns
    -------
    list of str or Function

    Raises
    ------
    UserError
        For what is none of these.
    """
    one = isinstance(contestants, str | Path | Function) or callable(contestants) or hasattr(contestants, "METHODS")
    return [contestant(each) for each in ([contestants] if one else contestants)]


def contestant(value: ContestantLike) -> Any:
    """Return one contestant as studies take it.

    Parameters
    ----------
    value : a name, a path, a function or an engine object.

    Returns
    -------
    str or Function
    """
    if isinstance(value, Function):
        return value
    if isinstance(value, str):
        return value
    if isinstance(value, Path):
        return str(value)
    if callable(value) or hasattr(value, "METHODS"):
        return engine(value)
    raise UserError(f"{value!r}: must be ENGINE[:METHOD], a path, or a function step(state, dt, body)")
