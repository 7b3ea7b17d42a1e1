"""The shortest engine: a file with one function, step(state, dt, body), as an engine of tumble.compare.engines.

state: x [m], q (w x y z), v [m/s], w [rad/s], (13,), in world axes; it returns the state dt [s] later, or changes the
one it was given.  body has mass [kg], moments [kg m2] about its principal axes, which are the body axes, points [m],
(n, 3), gravity [m/s2], (3,), which is not zero only where the file says FEATURES = {"gravity"}, and, where it says
"plane", the scene's plane (point, normal, restitution, friction) and the body's size, radius or disc [m]; else None.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from types import ModuleType, SimpleNamespace

import numpy as np

from tumble.scenarios.frames import Array
from tumble.scenarios.scene import Scene

# What such a file may say of its function beside that, each a dict with the key "step", as in tumble.compare.engines.
STATED = ("GYROSCOPIC", "ORDERS", "EXEMPT")

Step = Callable[[Array, float, SimpleNamespace], Array | None]


@dataclass(eq=False)
class World:
    """The states, (N, 13), and what the function is told of the body."""

    body: SimpleNamespace
    states: Array = field(default_factory=lambda: np.empty((0, 13)))


class StepEngine(ModuleType):
    """An engine file that has no more than the function."""

    METHODS = ("step",)

    def __init__(self, module: ModuleType) -> None:
        super().__init__(module.__name__)
        self._step: Step = module.step
        self.FEATURES = getattr(module, "FEATURES", ())
        self.ABOUT = {"version": "", "precision": "double", **getattr(module, "ABOUT", {})}
        for name in STATED:
            setattr(self, name, getattr(module, name, {}))

    def build(self, scene: Scene, method: str) -> World:
        """Return a world of the scene's body."""
        gravity = np.zeros(3) if scene.gravity is None else np.array(scene.gravity)
        about = {"moments": np.array(scene.body.moments), "points": np.array(scene.body.points), "gravity": gravity}
        body = scene.body
        touching = {"plane": scene.plane, "size": body.size, "radius": body.radius, "disc": body.disc}
        return World(SimpleNamespace(mass=scene.body.mass, **about, **touching))

    def write(self, world: World, states: Array) -> None:
        """Put the throws into these states."""
        world.states = states.copy()

    def advance(self, world: World, n: int, dt: float) -> None:
        """Call the function n times for every throw."""
        step, body = self._step, world.body
        for row, state in enumerate(world.states):
            for _ in range(n):
                changed = step(state, dt, body)
                state = state if changed is None else changed
            world.states[row] = state

    def read(self, world: World) -> Array:
        """Return the states."""
        return world.states.copy()
