"""Mistakes with impulses: how strong, where, when and for how long they act."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from tools.random_programs.algebra import ZERO, Vector, add, along, cross, matrix, scale, times, times_transposed
from tools.random_programs.mistakes.kind import Draw, even, is_struck, mistake, one_of
from tools.random_programs.scene import Impulse, Scene
from tools.random_programs.scheme import Scheme
from tools.random_programs.simulation import Load, Simulation


def _several(scene: Scene, scheme: Scheme) -> bool:
    return len(scene.impulses) > 1


def _later(scene: Scene, scheme: Scheme) -> bool:
    return any(impulse.time > 0 for impulse in scene.impulses)


def _turned(scene: Scene, scheme: Scheme) -> bool:
    return is_struck(scene, scheme) and (abs(scene.q[0]) < 0.99 or _later(scene, scheme))


def _turned_on_body(scene: Scene, scheme: Scheme) -> bool:
    return _turned(scene, scheme) and all(impulse.point is None for impulse in scene.impulses)


def _away(scene: Scene, scheme: Scheme) -> bool:
    return is_struck(scene, scheme) and bool(scene.x.any())


def _which(random: np.random.Generator, scene: Scene, scheme: Scheme) -> int:
    return int(random.integers(len(scene.impulses)))


def _ticks(*counts: int) -> Draw:
    """Return a draw of a time of this many ticks [s]."""
    return lambda random, scene, scheme: int(random.choice(counts)) * scheme.dt


def _sized(sim: Simulation, size: Callable[[Impulse], float]) -> None:
    """Multiply impulses by a factor."""
    right = sim.value
    sim.value = lambda impulse: scale(sim.number(size(impulse)), right(impulse))


@mistake("impulse", "impulse missing", is_struck)
def _(sim: Simulation) -> None:
    sim.impulses = []


@mistake("impulse", "one impulse missing", _several, which=_which)
def _(sim: Simulation, which: int) -> None:
    del sim.impulses[which]


@mistake("impulse", "impulse doubled", is_struck)
def _(sim: Simulation) -> None:
    _sized(sim, lambda _: 2.0)


@mistake("impulse", "impulse reversed", is_struck)
def _(sim: Simulation) -> None:
    _sized(sim, lambda _: -1.0)


@mistake("impulse", "impulse of another size", is_struck, factor=even(0.2, 4.0))
def _(sim: Simulation, factor: float) -> None:
    _sized(sim, lambda _: factor)


@mistake("impulse", "impulse times dt", is_struck, factor=lambda random, scene, scheme: scheme.dt)
def _(sim: Simulation, factor: float) -> None:
    _sized(sim, lambda _: factor)


@mistake("impulse", "one impulse of another size", _several, which=_which, factor=even(0.2, 4.0))
def _(sim: Simulation, which: int, factor: float) -> None:
    wrong = sim.impulses[which]
    _sized(sim, lambda impulse: factor if impulse is wrong else 1.0)


@mistake("impulse", "mass left out", lambda scene, scheme: is_struck(scene, scheme) and abs(scene.mass - 1) > 0.05)
def _(sim: Simulation) -> None:
    right = sim.push

    def push(J: Vector, arm: Vector) -> None:
        before = sim.v
        right(J, arm)
        sim.v = add(before, J)

    sim.push = push


@mistake("impulse", "impulse divided by another mass", is_struck, factor=even(0.2, 5.0))
def _(sim: Simulation, factor: float) -> None:
    right = sim.push

    def push(J: Vector, arm: Vector) -> None:
        before = sim.v
        right(J, arm)
        sim.v = along(before, 1 / (sim.number(factor) * sim.mass), J)

    sim.push = push


@mistake("impulse", "impulse only turns", is_struck)
def _(sim: Simulation) -> None:
    right = sim.push

    def push(J: Vector, arm: Vector) -> None:
        before = sim.v
        right(J, arm)
        sim.v = before

    sim.push = push


@mistake("impulse", "impulse at the centre", is_struck)
def _(sim: Simulation) -> None:
    sim.lever = lambda impulse: sim.vector(ZERO)


@mistake("impulse", "impulse lever reversed", is_struck)
def _(sim: Simulation) -> None:
    right = sim.lever
    sim.lever = lambda impulse: scale(-1, right(impulse))


@mistake("impulse", "impulse point from the origin", _away)
def _(sim: Simulation) -> None:
    right = sim.lever
    sim.lever = lambda impulse: add(right(impulse), sim.x)


@mistake("impulse", "impulse lever not turned", _turned_on_body)
def _(sim: Simulation) -> None:
    sim.lever = lambda impulse: sim.vector(sim.scene.body_point(impulse))


@mistake(
    "impulse",
    "impulse lever as at the start",
    lambda scene, scheme: _later(scene, scheme) and _turned_on_body(scene, scheme),
)
def _(sim: Simulation) -> None:
    sim.lever = lambda impulse: times(sim.first, sim.vector(sim.scene.body_point(impulse)))


@mistake(
    "impulse",
    "impulse at another vertex",
    lambda scene, scheme: is_struck(scene, scheme) and scene.size is not None,
    vertex=one_of(*range(8)),
)
def _(sim: Simulation, vertex: int) -> None:
    sim.lever = lambda impulse: times(matrix(sim.q), sim.vector(sim.points[vertex]))


@mistake("impulse", "impulse in body axes", _turned)
def _(sim: Simulation) -> None:
    right = sim.value
    sim.value = lambda impulse: times(matrix(sim.q), right(impulse))


@mistake("impulse", "impulse torque in body axes", _turned)
def _(sim: Simulation) -> None:
    sim.push = lambda J, arm: _push(sim, J, times(matrix(sim.q), times(sim.inverse, cross(arm, J))))


@mistake(
    "impulse",
    "impulse at another time",
    lambda scene, scheme: len(scene.impulses) == 1,
    late=_ticks(1, 2, 3, 5, 10),
)
def _(sim: Simulation, late: float) -> None:
    sim.impulses = [replace(impulse, time=impulse.time + late) for impulse in sim.impulses]


@mistake("impulse", "impulse as force", is_struck, lasts=_ticks(1, 2, 5, 10, 20))
def _(sim: Simulation, lasts: float) -> None:
    _force(sim, lasts, lasts)


@mistake("impulse", "impulse as force without end", is_struck)
def _(sim: Simulation) -> None:
    _force(sim, 1.0, np.inf)


@mistake("impulse", "impulse inertia not turned", lambda scene, scheme: _turned(scene, scheme) and scene.is_triaxial)
def _(sim: Simulation) -> None:
    sim.push = lambda J, arm: _push(sim, J, times(sim.inverse, cross(arm, J)))


# --- without a name when this was written ---------------------------------------------------------------------------


@mistake("impulse", "impulse without inertia", is_struck)
def _(sim: Simulation) -> None:
    """w += r x J, the tensor left out."""
    sim.push = lambda J, arm: _push(sim, J, cross(arm, J))


@mistake("impulse", "impulse torque over the mass", is_struck)
def _(sim: Simulation) -> None:
    """w += r x J / m, the mass for the tensor."""
    sim.push = lambda J, arm: _push(sim, J, scale(1 / sim.mass, cross(arm, J)))


@mistake("impulse", "impulse with a mean inertia", lambda scene, scheme: is_struck(scene, scheme) and scene.is_triaxial)
def _(sim: Simulation) -> None:
    """The impulse is divided by the mean moment; Euler's equations have the tensor."""
    mean = sim.number(np.trace(sim.scene.inertia) / 3)
    sim.push = lambda J, arm: _push(sim, J, scale(1 / mean, cross(arm, J)))


@mistake("impulse", "impulse fired twice, the second later", is_struck, later=_ticks(1, 2, 5))
def _(sim: Simulation, later: float) -> None:
    sim.impulses = sim.impulses + [replace(impulse, time=impulse.time + later) for impulse in sim.impulses]


@mistake("impulse", "impulse in uneven parts", is_struck, apart=_ticks(1, 2, 5))
def _(sim: Simulation, apart: float) -> None:
    """A half, a fifth and three tenths, one after the other."""
    sim.impulses = [
        replace(impulse, time=impulse.time + number * apart, value=share * impulse.value)
        for impulse in sim.impulses
        for number, share in enumerate((0.5, 0.2, 0.3))
    ]


@mistake("impulse", "impulse clamped per component", is_struck, share=even(0.2, 0.7))
def _(sim: Simulation, share: float) -> None:
    right = sim.value
    most = share * max(float(np.abs(impulse.value).max()) for impulse in sim.impulses)
    sim.value = lambda impulse: sim.vector(np.clip(right(impulse), -most, most))


@mistake("impulse", "impulse snapped to the largest axis", is_struck)
def _(sim: Simulation) -> None:
    """Only the largest component is left, with the length of all."""
    right = sim.value

    def snapped(impulse: Impulse) -> Vector:
        J = np.array(right(impulse))
        one = np.zeros(3)
        largest = int(np.abs(J).argmax())
        one[largest] = np.sign(J[largest]) * np.linalg.norm(J)
        return sim.vector(one)

    sim.value = snapped


# --- how ------------------------------------------------------------------------------------------------------------


def _push(sim: Simulation, J: Vector, spin: Vector) -> None:
    sim.v, sim.w = along(sim.v, 1 / sim.mass, J), add(sim.w, spin)


def _force(sim: Simulation, over: float, lasts: float) -> None:
    """Apply J / over [N] for this time [s] at the point of the body that the impulse hits."""

    def strike(impulse: Impulse) -> None:
        force = scale(1 / sim.number(over), sim.value(impulse))
        inside = times_transposed(matrix(sim.q), sim.lever(impulse))
        until = impulse.time + lasts - 1e-6 * sim.dt

        def law(x: Vector, q: tuple, v: Vector, w: Vector) -> Load:
            if sim.now >= until:
                return sim.vector(ZERO), sim.vector(ZERO)
            return force, cross(times(matrix(q), inside), force)

        sim.laws.append(law)

    sim.strike = strike
