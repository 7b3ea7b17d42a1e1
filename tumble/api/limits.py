"""What every study takes beside its scenes and contestants, refused where it is no positive number."""

import math
from numbers import Real
from typing import TypedDict

from tumble.api.progress import display
from tumble.compare.run.progress import Display
from tumble.scenarios.refusal import UserError


class Limits(TypedDict):
    """Limits of each run, time [s] and memory [B], and what shows the progress."""

    time_limit: float
    memory_limit: int
    display: Display


def limits(time_limit: float, memory_limit: int, progress: bool) -> Limits:
    """Return the limits of a study.

    Parameters
    ----------
    time_limit : of each run [s].
    memory_limit : of each engine's process [B].
    progress : whether the caller wants a bar.

    Returns
    -------
    Limits

    Raises
    ------
    UserError
        For a limit that is no positive number.
    """
    return {
        "time_limit": positive("time_limit", time_limit, "seconds"),
        "memory_limit": int(positive("memory_limit", memory_limit, "bytes")),
        "display": display(progress),
    }


def step(dt: float | None) -> float | None:
    """Return a step.

    Parameters
    ----------
    dt : step [s], or None.

    Returns
    -------
    float or None

    Raises
    ------
    UserError
        For a step that is no positive number.
    """
    return None if dt is None else positive("dt", dt, "seconds")


def positive(name: str, value: float, unit: str) -> float:
    """Return a positive number.  Raises UserError."""
    if not isinstance(value, Real) or not 0.0 < value < math.inf:
        raise UserError(f"{name} = {value!r}: must be a positive number of {unit}")
    return value
