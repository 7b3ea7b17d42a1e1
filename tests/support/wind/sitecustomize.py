"""A wind, a constant force at the centre of mass, for every process that Python starts with this folder on its path.

It is what CONTRIBUTING says a force is: a term in the solver, a key in the scene, an entry in the table of laws, a law
in the truth.  Each is registered in one place, before anything else of Tumble is imported.
"""

import dataclasses
import sys
from fractions import Fraction
from typing import NamedTuple

import msgspec
import numpy as np

from tumble.scenarios import build, forces, scene
from tumble.scenarios import format as scene_format
from tumble.scenarios.truth import throw
from tumble.scenarios.truth.forced import laws
from tumble.solver import forces as terms
from tumble.solver.compilation import inner, scalar
from tumble.solver.vectors import Vector, add


def instead(old, new):
    """Let every module that has imported the one have the other."""
    for module in [module for name, module in sys.modules.items() if name != __name__]:
        for name in [name for name, value in vars(module).items() if value is old]:
            setattr(module, name, new)


# The scene: its numbers, the key that gives them, and their entry in the table of laws.


@dataclasses.dataclass(frozen=True, eq=False)
class Scene(scene.Scene):
    """A scene with a wind [N], (3,), world axes, None where there is none."""

    wind: np.ndarray | None = None


key = ("wind", scene_format.Vector, scene_format.ORIGIN)
instead(scene.Scene, Scene)
instead(scene_format.File, msgspec.defstruct("File", [key], bases=(scene_format.File,), kw_only=True))
build.PULLS["wind"] = lambda file, body: scene.frozen_array(file.wind) if any(file.wind) else None
law = forces.Law("wind", "wind", stored=lambda wind, scene, states: -(states[..., 0:3] @ wind))
instead(forces.LAWS, (*forces.LAWS, law))


# The truth: its exact numbers, and its law.

Throw = NamedTuple("Throw", [*throw.Throw.__annotations__.items(), ("wind", throw.Numbers)])
read_throw, pull = throw.read_throw, laws.pull


def read_windy(scene, row, read=Fraction):
    """Return a throw with the wind's exact numbers."""
    wind = np.zeros(3) if scene.wind is None else scene.wind
    return Throw(*read_throw(scene, row, read), throw.exact_numbers(wind, read))


def pull_and_wind(throw, motion, gauges, pressing):
    """Return F + wind, and the torque as it is."""
    force, torque = pull(throw, motion, gauges, pressing)
    return laws.Pull(force + throw.wind, torque)


instead(read_throw, read_windy)
instead(pull, pull_and_wind)


# The solver: its numbers, and its term.

Forces = NamedTuple("Forces", [*terms.Forces.__annotations__.items(), ("wind", Vector | None)])
Forces.__new__.__defaults__ = (None,) * (len(Forces._fields) - 1)
Forces.__module__ = terms.__name__
wrench, NOTHING = terms.wrench, terms.NOTHING


@inner
def blown(wind):
    """Return F = wind."""
    if wind is None:
        return NOTHING
    return wind


@scalar
def wrench_and_wind(x, q, v, w_body, forces):
    """Return F + wind, and the torque as it is."""
    force, torque = wrench(x, q, v, w_body, forces)
    return add(force, blown(forces.wind)), torque


instead(terms.Forces, Forces)
instead(terms.LAWS, (*terms.LAWS, "wind"))
instead(terms.wrench, wrench_and_wind)
