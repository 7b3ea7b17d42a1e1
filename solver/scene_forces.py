"""The forces of a scene as the solver takes them: numbers in rows, None for a force that is absent."""

from collections.abc import Container
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from tumble.solver.forces import LAWS, Forces

# Laws without strength, to keep where a scene has none: a slack tether off the centre, a floor out of reach.
WITHOUT_STRENGTH = {
    "gravity": (0.0, 0.0, 0.0),
    "tethers": np.eye(1, 9),
    "drag": (0.0, 0.0),
    "floor": (-1e300, 0.0, 1.0, 0.0, 0.0, 0.0),
}


def forces_of(scene: Any, keep: Container[str] = frozenset()) -> Forces:
    """Return a scene's forces as the solver takes them.

    Parameters
    ----------
    scene : what it says of the body and of each force
    keep : forces that are there without strength if the scene has none: gravity, tether, drag, floor

    Returns
    -------
    the forces
    """
    acting: dict[str, Any] = {}
    for law in LAWS:
        acting[law] = _numbers(getattr(scene, law))
        if acting[law] is None and law.removesuffix("s") in keep:
            acting[law] = WITHOUT_STRENGTH[law]
    if scene.drag is not None:
        acting["drag"] = tuple(coefficient or None for coefficient in acting["drag"])
    points = None if acting["floor"] is None else np.array(scene.body.points)
    return Forces(scene.body.mass, **acting, points=points)


def _numbers(law: Any) -> Any:
    """Return a law's numbers in a row, or, where there may be several of its kind, an array of rows; None for none."""
    if law is None or (isinstance(law, tuple) and not law):
        return None
    if isinstance(law, tuple):
        return np.array([_numbers(one) for one in law])
    parts = [getattr(law, field.name) for field in fields(law)] if is_dataclass(law) else [law]
    return tuple(np.hstack(parts).tolist())
