"""Mistakes with what a program starts from."""

import numpy as np

from tools.random_programs.algebra import ZERO, conjugate, matrix, scale, times
from tools.random_programs.mistakes.kind import even, is_turned, mistake, moves, one_of, spins
from tools.random_programs.scene import Scene
from tools.random_programs.scheme import Scheme
from tools.random_programs.simulation import Simulation

DEGREE = np.pi / 180
SWAPS = {"x z y": (0, 2, 1), "y x z": (1, 0, 2), "z y x": (2, 1, 0)}


def _turned_and(test):
    return lambda scene, scheme: is_turned(scene, scheme) and test(scene, scheme)


def _slow(scene: Scene, scheme: Scheme) -> bool:
    """Whether 57 times the spin still is a spin that the step can follow."""
    return spins(scene, scheme) and float(np.linalg.norm(scene.w)) / DEGREE * scheme.step < 1.5


@mistake("start", "start velocity missing", moves)
def _(sim: Simulation) -> None:
    sim.v = sim.vector(ZERO)


@mistake("start", "start velocity reversed", moves)
def _(sim: Simulation) -> None:
    sim.v = scale(-1, sim.v)


@mistake("start", "start velocity in body axes", _turned_and(moves))
def _(sim: Simulation) -> None:
    sim.v = times(matrix(sim.q), sim.v)


@mistake("start", "start velocity in other axes", moves, axes=one_of(*SWAPS))
def _(sim: Simulation, axes: str) -> None:
    sim.v = sim.vector(np.array(sim.v)[list(SWAPS[axes])])


@mistake("start", "start spin missing", spins)
def _(sim: Simulation) -> None:
    sim.w = sim.vector(ZERO)


@mistake("start", "start spin reversed", spins)
def _(sim: Simulation) -> None:
    sim.w = scale(-1, sim.w)


@mistake("start", "start spin in body axes", _turned_and(spins))
def _(sim: Simulation) -> None:
    sim.w = times(matrix(sim.q), sim.w)


@mistake("start", "start spin in other axes", spins, axes=one_of(*SWAPS))
def _(sim: Simulation, axes: str) -> None:
    sim.w = sim.vector(np.array(sim.w)[list(SWAPS[axes])])


@mistake("start", "start spin taken for degrees", spins)
def _(sim: Simulation) -> None:
    sim.w = scale(sim.number(DEGREE), sim.w)


@mistake("start", "start spin turned into degrees", _slow)
def _(sim: Simulation) -> None:
    sim.w = scale(sim.number(1 / DEGREE), sim.w)


@mistake("start", "start attitude missing", is_turned)
def _(sim: Simulation) -> None:
    sim.q = tuple(map(sim.number, (1, 0, 0, 0)))  # type: ignore[assignment]


@mistake("start", "start attitude inverted", is_turned)
def _(sim: Simulation) -> None:
    sim.q = conjugate(sim.q)


@mistake("start", "start attitude read x y z w", is_turned)
def _(sim: Simulation) -> None:
    w, x, y, z = sim.q
    sim.q = (z, w, x, y)


@mistake("start", "start position missing", lambda scene, scheme: bool(scene.x.any()))
def _(sim: Simulation) -> None:
    sim.x = sim.vector(ZERO)


@mistake("start", "another start position", along=one_of(0, 1, 2), by=even(0.01, 1.0))
def _(sim: Simulation, along: int, by: float) -> None:
    x = np.array(sim.x)
    x[along] += by
    sim.x = sim.vector(x)
