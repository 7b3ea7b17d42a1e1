"""The force laws that a scene may have, one entry each: what acts, what it stores, what it takes, what makes it stiff.

A law's formula is in `tumble.scenarios.scene`, beside its numbers.  The truth, our solver and `tumble.scenarios.wrench`
each write it anew, in other variables; whatever else is asked of a law is asked here.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from tumble.scenarios.frames import Array, vertices


@dataclass(frozen=True, eq=False)
class Law:
    """A force law.

    Parameters
    ----------
    name
        what a scene needs and an engine lists in its FEATURES
    part
        the field of Scene that has its numbers, or a tuple of them
    stored
        energy [J] that one of them stores in states (..., 13); None if it stores none
    takes
        whether one of them dissipates energy
    turns
        whether one of them can start a rotation, or move its axis
    stiffness
        largest stiffness of one of them [N/m]
    numbers
        label with unit -> field, for each of its strengths
    """

    name: str
    part: str
    stored: Callable[[Any, Any, Array], Array] | None = None
    takes: Callable[[Any], bool] = lambda one: False
    turns: Callable[[Any], bool] = lambda one: False
    stiffness: Callable[[Any, Any], float] = lambda one, scene: 0.0
    numbers: dict[str, str] = field(default_factory=dict)

    @property
    def identity(self) -> str:
        """What tells it from the others."""
        return self.name

    def all_of(self, scene: Any) -> tuple[Any, ...]:
        """Return the numbers of each of its kind that the scene has."""
        part = getattr(scene, self.part)
        return part if isinstance(part, tuple) else () if part is None else (part,)

    def scaled(self, scene: Any, by: float, *keys: str) -> Any:
        """Return a scene that has the law with its strengths, or those keys of them, times a factor."""
        keys = keys or tuple(self.numbers.values())
        found = tuple(
            replace(one, **{key: by * getattr(one, key) for key in keys}) if keys else by * one
            for one in self.all_of(scene)
        )
        return replace(scene, **{self.part: found if isinstance(getattr(scene, self.part), tuple) else found[0]})


def height(gravity: Array, scene: Any, states: Array) -> Array:
    """Return -m g.x [J]."""
    return -scene.body.mass * (states[..., 0:3] @ gravity)


def stretch(tether: Any, scene: Any, states: Array) -> Array:
    """Return k (|d| - l0)^2 / 2 [J]."""
    length = np.linalg.norm(vertices(states, tether.point_body[None])[..., 0, :] - tether.anchor, axis=-1)
    return tether.stiffness / 2 * (length - tether.rest_length) ** 2


def dent(floor: Any, scene: Any, states: Array) -> Array:
    """Return the sum of k y^2 / 2 over the vertices below the floor [J]."""
    depth = np.minimum(vertices(states, scene.body.points) @ floor.normal - floor.height, 0.0)
    return floor.stiffness / 2 * (depth**2).sum(axis=-1)


GRAVITY = Law("gravity", "gravity", stored=height)
TETHER = Law(
    "tether",
    "tethers",
    stored=stretch,
    takes=lambda tether: bool(tether.damping),
    turns=lambda tether: bool(tether.point_body.any()),
    stiffness=lambda tether, scene: tether.stiffness,
    numbers={"tether stiffness [N/m]": "stiffness", "tether damping [N s/m]": "damping"},
)
DRAG = Law(
    "drag",
    "drag",
    takes=lambda drag: True,
    numbers={"linear drag [N s/m]": "linear", "angular drag [N m s/rad]": "angular"},
)
FLOOR = Law(
    "floor",
    "floor",
    stored=dent,
    takes=lambda floor: bool(floor.damping),
    turns=lambda floor: True,
    stiffness=lambda floor, scene: floor.stiffness * len(scene.body.points),
    numbers={"floor stiffness [N/m]": "stiffness", "floor damping [N s/m]": "damping"},
)
PLANE = Law(
    "plane",
    "plane",
    takes=lambda plane: plane.restitution < 1 or plane.friction > 0,
    turns=lambda plane: True,
)
LAWS = (GRAVITY, TETHER, DRAG, FLOOR, PLANE)


def acting(scene: Any) -> tuple[Law, ...]:
    """Return the laws that act in a scene.

    Parameters
    ----------
    scene

    Returns
    -------
    laws
    """
    return tuple(law for law in LAWS if law.all_of(scene))


def takes_energy(scene: Any) -> bool:
    """Return whether any force in a scene dissipates energy.

    Parameters
    ----------
    scene

    Returns
    -------
    answer
    """
    return any(law.takes(one) for law in LAWS for one in law.all_of(scene))


def can_turn(scene: Any) -> bool:
    """Return whether any force in a scene can start a rotation, or move its axis.

    Parameters
    ----------
    scene

    Returns
    -------
    answer
    """
    return any(law.turns(one) for law in LAWS for one in law.all_of(scene))


def stiffness(scene: Any) -> float:
    """Return the stiffness of all springs of a scene together.

    Parameters
    ----------
    scene

    Returns
    -------
    stiffness : N/m
    """
    return sum(law.stiffness(one, scene) for law in LAWS for one in law.all_of(scene))


def stored(scene: Any, states: Array, but: Law | None = None) -> Array:
    """Return the potential energy that the forces of a scene store.

    Parameters
    ----------
    scene
    states : (..., 13)
    but
        a law to leave out

    Returns
    -------
    energy : (...), J
    """
    held = np.zeros(states.shape[:-1])
    for law in LAWS:
        if law.stored and law is not but:
            held += sum(law.stored(one, scene, states) for one in law.all_of(scene))
    return held
