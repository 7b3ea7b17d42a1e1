"""Mistakes with forces: gravity, damping, caps, forces of the scene and forces that it does not have."""

import numpy as np

from tools.random_programs.algebra import (
    ZERO,
    Quaternion,
    Vector,
    capped,
    cross,
    dot,
    matrix,
    norm,
    scale,
    times,
    times_transposed,
)
from tools.random_programs.mistakes.kind import even, falls, instant, mistake, moves, one_of, spins
from tools.random_programs.scene import Scene
from tools.random_programs.scheme import Scheme
from tools.random_programs.simulation import Load, Simulation

EARTH = (9.81, 9.8, 9.80665, 10.0, 1.62)


def _weightless(scene: Scene, scheme: Scheme) -> bool:
    return not scene.gravity.any()


def _runs(scene: Scene, scheme: Scheme) -> bool:
    return moves(scene, scheme) or falls(scene, scheme)


def _tethered(scene: Scene, scheme: Scheme) -> bool:
    return bool(scene.tethers)


def _dragged(scene: Scene, scheme: Scheme) -> bool:
    return scene.drag[0] > 0


def _another_size(random: np.random.Generator, scene: Scene, scheme: Scheme) -> float:
    size = float(np.linalg.norm(scene.gravity))
    factors = [one / size for one in EARTH if abs(one - size) > 1e-9] + [scene.mass, 0.5, 3.0]
    return float(random.choice([factor for factor in factors if abs(factor - 1) > 1e-4]))


def _fastest(random: np.random.Generator, scene: Scene, scheme: Scheme) -> float:
    """Return a cap that a body thrown so passes [m/s]."""
    fastest = float(np.linalg.norm(scene.v + scene.gravity * scene.duration)) + float(np.linalg.norm(scene.v))
    return float(f"{random.uniform(0.2, 0.5) * fastest:.2g}")


def _fastest_spin(random: np.random.Generator, scene: Scene, scheme: Scheme) -> float:
    return float(f"{random.uniform(0.4, 0.9) * np.linalg.norm(scene.w):.2g}")


def _up(scene: Scene) -> int:
    """Return which axis is up."""
    return int(np.abs(scene.gravity).argmax())


def _law(sim: Simulation, law) -> None:
    sim.laws.append(law)


def _nothing(sim: Simulation) -> Vector:
    return sim.vector(ZERO)


# --- gravity --------------------------------------------------------------------------------------------------------


@mistake("gravity", "gravity missing", falls)
def _(sim: Simulation) -> None:
    sim.gravity = _nothing(sim)


@mistake("gravity", "gravity doubled", falls)
def _(sim: Simulation) -> None:
    sim.gravity = scale(2, sim.gravity)


@mistake("gravity", "gravity reversed", falls)
def _(sim: Simulation) -> None:
    sim.gravity = scale(-1, sim.gravity)


@mistake("gravity", "gravity of another size", falls, factor=_another_size)
def _(sim: Simulation, factor: float) -> None:
    sim.gravity = sim.vector(factor * sim.scene.gravity)


@mistake("gravity", "gravity times dt", falls, factor=lambda random, scene, scheme: scheme.step)
def _(sim: Simulation, factor: float) -> None:
    sim.gravity = sim.vector(factor * sim.scene.gravity)


@mistake("gravity", "gravity along another axis", falls, by=one_of(1, 2))
def _(sim: Simulation, by: int) -> None:
    sim.gravity = sim.vector(np.roll(sim.scene.gravity, by))


@mistake("gravity", "gravity added", _weightless, along=one_of("-y", "-z"))
def _(sim: Simulation, along: str) -> None:
    sim.gravity = sim.vector(-9.81 * np.eye(3)["xyz".index(along[1])])


@mistake("gravity", "gravity late", falls, time=instant(0.02, 0.4))
def _(sim: Simulation, time: float) -> None:
    right = sim.weight

    def weight(x: Vector, q: Quaternion, v: Vector, w: Vector) -> Load:
        return right(x, q, v, w) if sim.now >= time - 1e-9 else (_nothing(sim), _nothing(sim))

    sim.laws[0] = weight


@mistake("gravity", "constant acceleration", along=one_of(0, 1, 2), by=even(0.05, 3.0))
def _(sim: Simulation, along: int, by: float) -> None:
    more = sim.vector(by * np.eye(3)[along])
    _law(sim, lambda x, q, v, w: (scale(sim.mass, more), _nothing(sim)))


# --- damping and caps -----------------------------------------------------------------------------------------------


@mistake("damping", "linear damping", _runs, rate=one_of(0.01, 0.05, 0.1, 0.2, 0.5, 1.0))
def _(sim: Simulation, rate: float) -> None:
    _law(sim, lambda x, q, v, w: (scale(-sim.number(rate) * sim.mass, v), _nothing(sim)))


@mistake("damping", "angular damping", spins, rate=one_of(0.01, 0.05, 0.1, 0.2, 0.5, 1.0))
def _(sim: Simulation, rate: float) -> None:
    """By the torque that has the spin decay at one rate about every axis, -c I w."""
    c = sim.number(rate)

    def law(x: Vector, q: Quaternion, v: Vector, w: Vector) -> Load:
        axes = matrix(q)
        return _nothing(sim), scale(-c, times(axes, times(sim.inertia, times_transposed(axes, w))))

    _law(sim, law)


@mistake("damping", "quadratic drag", _runs, rate=even(0.005, 0.2))
def _(sim: Simulation, rate: float) -> None:
    _law(sim, lambda x, q, v, w: (scale(-sim.number(rate) * sim.mass * norm(v), v), _nothing(sim)))


@mistake("damping", "drag torque", spins, share=even(0.02, 0.5))
def _(sim: Simulation, share: float) -> None:
    c = sim.number(share * float(sim.scene.moments.mean()))
    _law(sim, lambda x, q, v, w: (_nothing(sim), scale(-c, w)))


@mistake("damping", "speed cap", _runs, cap=_fastest)
def _(sim: Simulation, cap: float) -> None:
    sim.limits.append(lambda v, w: (capped(v, sim.number(cap)), w))


@mistake("damping", "spin cap", spins, cap=_fastest_spin)
def _(sim: Simulation, cap: float) -> None:
    sim.limits.append(lambda v, w: (v, capped(w, sim.number(cap))))


# --- forces of the scene --------------------------------------------------------------------------------------------


@mistake("scene's forces", "tether missing", _tethered)
def _(sim: Simulation) -> None:
    sim.laws = [law for law in sim.laws if not hasattr(law, "tether")]


@mistake("scene's forces", "drag missing", _dragged)
def _(sim: Simulation) -> None:
    sim.laws = [law for law in sim.laws if law != sim.drag]


# --- without a name when this was written ---------------------------------------------------------------------------


@mistake("scene's forces", "tether pulls at the centre", _tethered)
def _(sim: Simulation) -> None:
    def turnless(pull):
        return lambda x, q, v, w: (pull(x, q, v, w)[0], _nothing(sim))

    sim.laws = [turnless(law) if hasattr(law, "tether") else law for law in sim.laws]


@mistake("scene's forces", "tether of another stiffness", _tethered, factor=one_of(0.5, 0.8, 1.25, 2.0))
def _(sim: Simulation, factor: float) -> None:
    def stiffer(pull):
        def law(x: Vector, q: Quaternion, v: Vector, w: Vector) -> Load:
            force, torque = pull(x, q, v, w)
            return scale(sim.number(factor), force), scale(sim.number(factor), torque)

        return law

    sim.laws = [stiffer(law) if hasattr(law, "tether") else law for law in sim.laws]


@mistake("scene's forces", "drag's torque missing", lambda scene, scheme: scene.drag[1] > 0)
def _(sim: Simulation) -> None:
    sim.laws = [
        (lambda x, q, v, w: (sim.drag(x, q, v, w)[0], _nothing(sim))) if law == sim.drag else law for law in sim.laws
    ]


@mistake("gravity", "gravity in body axes", lambda scene, scheme: falls(scene, scheme))
def _(sim: Simulation) -> None:
    sim.laws[0] = lambda x, q, v, w: (scale(sim.mass, times(matrix(q), sim.gravity)), _nothing(sim))


@mistake("gravity", "gravity ramped up", falls, over=instant(0.1, 0.6))
def _(sim: Simulation, over: float) -> None:
    sim.laws[0] = lambda x, q, v, w: (
        scale(sim.mass * sim.number(min(1.0, (sim.now + 0.5 * sim.dt) / over)), sim.gravity),
        _nothing(sim),
    )


@mistake("gravity", "gravity accumulates", falls, share=even(0.002, 0.02))
def _(sim: Simulation, share: float) -> None:
    """The force is not cleared: each step adds a share of it to the next one's."""
    sim.laws[0] = lambda x, q, v, w: (scale(sim.mass * sim.number(1 + share * sim.count), sim.gravity), _nothing(sim))


@mistake("gravity", "gravity off the centre", falls, share=even(0.02, 0.5))
def _(sim: Simulation, share: float) -> None:
    """Gravity pulls at a point that is not the centre of mass, so it turns the body as well."""
    at = sim.vector(share * sim.points[0])

    def weight(x: Vector, q: Quaternion, v: Vector, w: Vector) -> Load:
        force = scale(sim.mass, sim.gravity)
        return force, cross(times(matrix(q), at), force)

    sim.laws[0] = weight


@mistake(
    "gravity", "a gust", along=one_of(0, 1, 2), by=even(0.5, 5.0), begin=instant(0.1, 0.4), lasts=instant(0.1, 0.3)
)
def _(sim: Simulation, along: int, by: float, begin: float, lasts: float) -> None:
    more = sim.vector(by * np.eye(3)[along])
    nothing = _nothing(sim)
    _law(sim, lambda x, q, v, w: (scale(sim.mass, more) if begin <= sim.now < begin + lasts else nothing, nothing))


@mistake("gravity", "a thrust in body axes", spins, along=one_of(0, 1, 2), by=even(0.2, 5.0))
def _(sim: Simulation, along: int, by: float) -> None:
    thrust = sim.vector(by * sim.scene.mass * np.eye(3)[along])
    _law(sim, lambda x, q, v, w: (times(matrix(q), thrust), _nothing(sim)))


@mistake(
    "damping", "Magnus force", lambda scene, scheme: spins(scene, scheme) and _runs(scene, scheme), by=even(0.01, 0.2)
)
def _(sim: Simulation, by: float) -> None:
    _law(sim, lambda x, q, v, w: (scale(sim.number(by) * sim.mass, cross(w, v)), _nothing(sim)))


@mistake("damping", "dry friction of the spin", spins, rate=even(0.05, 0.5))
def _(sim: Simulation, rate: float) -> None:
    """The spin loses as much each second, however fast it is."""
    loss = sim.number(rate * float(np.linalg.norm(sim.scene.w)) / sim.scene.duration)

    def slow(dt: float) -> None:
        size = norm(sim.w)
        sim.w = scale(max(0 * size, size - loss * dt) / size, sim.w) if size else sim.w

    _each_step(sim, slow)


@mistake("damping", "dry friction of the velocity", _runs, rate=even(0.1, 2.0))
def _(sim: Simulation, rate: float) -> None:
    loss = sim.number(rate)

    def slow(dt: float) -> None:
        size = norm(sim.v)
        sim.v = scale(max(0 * size, size - loss * dt) / size, sim.v) if size else sim.v

    _each_step(sim, slow)


@mistake("damping", "largest falling speed", falls, cap=_fastest)
def _(sim: Simulation, cap: float) -> None:
    """Only the velocity along gravity is capped."""
    axis, most = _up(sim.scene), sim.number(cap)

    def limit(v: Vector, w: Vector) -> tuple[Vector, Vector]:
        parts = list(v)
        parts[axis] = max(-most, min(most, parts[axis]))
        return (parts[0], parts[1], parts[2]), w

    sim.limits.append(limit)


@mistake("damping", "spin capped per component", spins, cap=lambda r, s, p: float(f"{0.6 * np.abs(s.w).max():.2g}"))
def _(sim: Simulation, cap: float) -> None:
    most = sim.number(cap)
    sim.limits.append(lambda v, w: (v, tuple(max(-most, min(most, part)) for part in w)))  # type: ignore[arg-type,return-value]


@mistake("damping", "slow spins stop", spins, below=even(0.05, 0.5))
def _(sim: Simulation, below: float) -> None:
    """A component of the spin that is below a share of the largest at the start is set to 0."""
    least = sim.number(below * float(np.abs(sim.scene.w).max()))
    sim.limits.append(lambda v, w: (v, tuple(part if abs(part) >= least else 0 * part for part in w)))  # type: ignore[arg-type,return-value]


@mistake("damping", "rotation about a world axis locked", spins, axis=one_of(0, 1, 2))
def _(sim: Simulation, axis: int) -> None:
    sim.limits.append(lambda v, w: (v, _without(w, axis)))


@mistake("damping", "rotation about a body axis locked", spins, axis=one_of(0, 1, 2))
def _(sim: Simulation, axis: int) -> None:
    def limit(v: Vector, w: Vector) -> tuple[Vector, Vector]:
        axes = matrix(sim.q)
        return v, times(axes, _without(times_transposed(axes, w), axis))

    sim.limits.append(limit)


@mistake("damping", "position along an axis locked", _runs, axis=one_of(0, 1, 2))
def _(sim: Simulation, axis: int) -> None:
    sim.limits.append(lambda v, w: (_without(v, axis), w))


@mistake("damping", "lift across the velocity", falls, by=even(0.003, 0.1))
def _(sim: Simulation, by: float) -> None:
    """A force along the body's z axis that grows with the square of the speed."""
    c = sim.number(by)

    def law(x: Vector, q: Quaternion, v: Vector, w: Vector) -> Load:
        up = times(matrix(q), sim.vector((0, 0, 1)))
        return scale(c * sim.mass * dot(v, v), up), _nothing(sim)

    _law(sim, law)


def _without(a: Vector, axis: int) -> Vector:
    parts = list(a)
    parts[axis] = 0 * parts[axis]
    return (parts[0], parts[1], parts[2])


def _each_step(sim: Simulation, change) -> None:
    sim.after.append(change)
