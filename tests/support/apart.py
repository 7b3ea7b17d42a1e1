"""Engines in environments of their own, for tests: installed once in the user's cache, and flown through a worker."""

from contextlib import contextmanager

import numpy as np

from tumble.compare.run.engines.brick import scene
from tumble.compare.run.engines.examine import examined
from tumble.compare.run.engines.installing import install
from tumble.compare.run.engines.registry import BadEngine
from tumble.compare.run.flight import Trajectory
from tumble.compare.run.running_engines import launched
from tumble.scenarios.frames import Array


@contextmanager
def engine(name: str, *methods: str):
    """Give the engine as a participant, installed where it is not."""
    import pytest

    try:
        install(name)
    except BadEngine as error:
        pytest.skip(str(error))  # which fails in CI
    with launched([f"{name}:{method}" for method in methods] or [name], 60.0) as (running_engine,):
        yield running_engine


def broken_laws(name: str, *methods: str) -> dict[str, dict[str, str]]:
    """Return the laws that are broken, by what and how, and see that those that bind were asked."""
    with engine(name, *methods) as running_engine:
        found = list(examined(running_engine))
    assert sum(bool(one.holds) for one in found) >= 6
    return {one.check: one.broken for one in found if one.broken}


def throw(v=(0.0, 0.0, 0.0), w=(0.0, 0.0, 0.0), x=(0.0, 0.0, 0.0)) -> Array:
    """Return one throw from the identity attitude, (1, 13)."""
    return np.array([[*x, 1.0, 0.0, 0.0, 0.0, *v, *w]])


def flight(running_engine, start: Array, dt: float, duration: float, **body) -> Trajectory:
    """Return a flight of the triaxial box, or of that mass and moments, looked at at the end."""
    from dataclasses import replace

    question = replace(scene(start, **body), duration=duration, times=np.array([duration]), step=dt)
    found = running_engine.simulate(question, running_engine.methods[0], dt)
    assert isinstance(found, Trajectory), found
    return found
