"""A world for each throw, for engines whose throws in one world would be solved together."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(eq=False)
class Apart:
    """A world for each throw."""

    worlds: list[Any]


def in_each(verb: Callable) -> Callable:
    """Return a verb of a world and numbers for Apart as well: prepare, advance."""

    @wraps(verb)
    def of_all(world: Any, *numbers: float) -> None:
        for one in world.worlds if isinstance(world, Apart) else (world,):
            verb(one, *numbers)

    return of_all


def to_each(write: Callable[[Any, Array], None]) -> Callable[[Any, Array], None]:
    """Return `write` for Apart as well: a throw's state, (1, 13), to each."""

    @wraps(write)
    def of_all(world: Any, states: Array) -> None:
        if isinstance(world, Apart):
            for one, state in zip(world.worlds, states, strict=True):
                write(one, state[np.newaxis])
        else:
            write(world, states)

    return of_all


def from_each(read: Callable[[Any], Array]) -> Callable[[Any], Array]:
    """Return `read` for Apart as well."""

    @wraps(read)
    def of_all(world: Any) -> Array:
        return np.vstack([read(one) for one in world.worlds]) if isinstance(world, Apart) else read(world)

    return of_all


def of_each(audit: Callable[[Any], Any]) -> Callable[[Any], list[tuple[str, str]]]:
    """Return `audit` for Apart as well."""

    @wraps(audit)
    def of_all(world: Any) -> list[tuple[str, str]]:
        return [found for one in (world.worlds if isinstance(world, Apart) else (world,)) for found in audit(one)]

    return of_all
