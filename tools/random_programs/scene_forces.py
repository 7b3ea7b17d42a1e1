"""Answers about the forces that a scene has, as programs: other coefficients, other laws of drag and of tethers."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from tools.random_programs.algebra import (
    ZERO,
    Quaternion,
    Vector,
    add,
    along,
    cross,
    dot,
    matrix,
    minus,
    norm,
    scale,
    times,
)
from tools.random_programs.contact import Claim
from tools.random_programs.names import MAIN
from tools.random_programs.program import Case
from tools.random_programs.scene import Scene, Tether
from tools.random_programs.simulation import Load, Simulation

Plant = Callable[[Simulation], None]
Makes = Callable[[Claim, Case], Iterator[Plant]]


@dataclass(frozen=True)
class Spring:
    """How a program computes a tether.

    arm, lever: where it is attached, and the lever of its torque, from x, the attitude, the attitude at the start and
    the point in body axes, world axes; is_of_centre: the damper has the velocity of the centre; is_along: it has only
    the part along the line; pulls_only: there is no force at less than the rest length; force: on the centre, from the
    force and the mass; at: where it is attached, body axes, if at no vertex.
    """

    tether: Tether
    arm: Callable[[Vector, Quaternion, Quaternion, Vector], Vector] = lambda x, q, first, p: times(matrix(q), p)
    lever: Callable[[Vector, Quaternion, Quaternion, Vector], Vector] | None = None
    is_of_centre: bool = False
    is_along: bool | None = None
    pulls_only: bool = False
    force: Callable[[Vector, float], Vector] = lambda force, mass: force
    at: np.ndarray | None = None


def hang(sim: Simulation, springs: list[Spring]) -> None:
    """Put springs in the place of the tethers of a run."""
    laws = [law for law in sim.laws if not hasattr(law, "tether")]
    sim.laws = [*laws, *(_law(sim, spring) for spring in springs)]


def _law(sim: Simulation, spring: Spring) -> Callable[[Vector, Quaternion, Vector, Vector], Load]:
    tether, first = spring.tether, sim.q
    place = sim.vector(sim.scene.points[tether.vertex] if spring.at is None else spring.at)
    is_along = bool(tether.rest_length) if spring.is_along is None else spring.is_along

    def pull(x: Vector, q: Quaternion, v: Vector, w: Vector) -> Load:
        arm = spring.arm(x, q, first, place)
        away = minus(add(x, arm), sim.vector(tether.anchor))
        moves = v if spring.is_of_centre else add(v, cross(w, arm))
        unit = scale(1 / norm(away), away)
        if is_along:
            moves = scale(dot(moves, unit), unit)
        force = along(scale(-tether.stiffness * (norm(away) - tether.rest_length), unit), -tether.damping, moves)
        if spring.pulls_only and norm(away) < tether.rest_length:
            force = ZERO
        lever = arm if spring.lever is None else spring.lever(x, q, first, place)
        return spring.force(force, sim.mass), cross(lever, force)

    pull.tether = tether  # type: ignore[attr-defined]
    return pull


def _springs(**changes: object) -> Makes:
    """Return the translation of a name that changes each tether's law."""

    def make(claim: Claim, case: Case) -> Iterator[Plant]:
        yield lambda sim: hang(sim, [Spring(tether, **changes) for tether in sim.scene.tethers])  # type: ignore[arg-type]

    return make


def _tethers(change: Callable[[Tether, Scene, float], Tether]) -> Makes:
    """Return the translation of a name that changes the numbers of each tether, but not the damper's law."""

    def make(claim: Claim, case: Case) -> Iterator[Plant]:
        value = float(claim.number(*MAIN) or 0.0)
        yield lambda sim: hang(
            sim,
            [
                Spring(change(tether, sim.scene, value), is_along=bool(tether.rest_length))
                for tether in sim.scene.tethers
            ],
        )

    return make


def _drag(change: Callable[[float, float, float], tuple[float, float]]) -> Makes:
    """Return the translation of a name that changes the coefficients of the drag."""

    def make(claim: Claim, case: Case) -> Iterator[Plant]:
        value = float(claim.number(*MAIN) or 0.0)

        def plant(sim: Simulation) -> None:
            linear, angular = change(*sim.scene.drag, value)
            _with_drag(sim, lambda x, q, v, w: (scale(-linear, v), scale(-angular, w)))

        yield plant

    return make


def _drag_law(law: Callable[[Simulation, Quaternion, Vector, Vector], Load]) -> Makes:
    """Return the translation of a name that has another law of drag."""

    def make(claim: Claim, case: Case) -> Iterator[Plant]:
        yield lambda sim: _with_drag(sim, lambda x, q, v, w: law(sim, q, v, w))

    return make


def _with_drag(sim: Simulation, law: Callable[[Vector, Quaternion, Vector, Vector], Load]) -> None:
    sim.laws = [law if each == sim.drag else each for each in sim.laws]


def _inertia_times(sim: Simulation, q: Quaternion, w: Vector) -> Vector:
    axes = np.array(matrix(q))
    return sim.vector(axes @ np.array(sim.inertia) @ axes.T @ np.array(w))


def _moment(axis: int) -> Makes:
    def make(claim: Claim, case: Case) -> Iterator[Plant]:
        by = np.ones(3)
        by[axis] = float(claim.number(*MAIN) or 1.0)
        yield lambda sim: sim.set_inertia(sim.scene.inertia * np.sqrt(np.outer(by, by)))

    return make


def _own_edges(claim: Claim, case: Case) -> Iterator[Plant]:
    edges = case.scene.size
    assert edges is not None
    yield lambda sim: sim.set_inertia(case.scene.mass / 6 * np.diag(np.square(edges)))


def _below(number: int) -> Makes:
    """Return the translation of a threshold of the velocity, or of the spin."""

    def make(claim: Claim, case: Case) -> Iterator[Plant]:
        least = float(claim.number(*MAIN, "speed") or 0.0)

        def limit(v: Vector, w: Vector) -> tuple[Vector, Vector]:
            found = [v, w]
            if norm(found[number]) < least:
                found[number] = ZERO
            return found[0], found[1]

        yield lambda sim: sim.limits.append(limit)

    return make


def _without_length(claim: Claim, case: Case) -> Iterator[Plant]:
    yield lambda sim: hang(sim, [Spring(replace(tether, rest_length=0.0)) for tether in sim.scene.tethers])


def _other_damper(claim: Claim, case: Case) -> Iterator[Plant]:
    yield lambda sim: hang(sim, [Spring(tether, is_along=not tether.rest_length) for tether in sim.scene.tethers])


def _vertex(claim: Claim, case: Case) -> Iterator[Plant]:
    number = int(str(claim.parameters["choice"]).split()[-1])
    yield lambda sim: hang(sim, [Spring(replace(tether, vertex=number)) for tether in sim.scene.tethers])


def _relaxed(claim: Claim, case: Case) -> Iterator[Plant]:
    for is_along in (True, False):

        def plant(sim: Simulation, is_along: bool = is_along) -> None:
            springs = []
            for tether in sim.scene.tethers:
                end = add(sim.x, times(matrix(sim.q), sim.vector(sim.scene.points[tether.vertex])))
                length = norm(minus(end, sim.vector(tether.anchor)))
                springs.append(Spring(replace(tether, rest_length=length), is_along=is_along))
            hang(sim, springs)

        yield plant


def _nowhere(x: Vector, q: Quaternion, first: Quaternion, p: Vector) -> Vector:
    return ZERO


def _unturned(x: Vector, q: Quaternion, first: Quaternion, p: Vector) -> Vector:
    return p


def _as_at_first(x: Vector, q: Quaternion, first: Quaternion, p: Vector) -> Vector:
    return times(matrix(first), p)


def _from_origin(x: Vector, q: Quaternion, first: Quaternion, p: Vector) -> Vector:
    return add(x, times(matrix(q), p))


MAKES: dict[str, Makes] = {
    "linear-drag-wrong-magnitude": _drag(lambda c, a, by: (by * c, a)),
    "linear-drag-missing": _drag(lambda c, a, by: (0.0, a)),
    "linear-drag-reversed": _drag(lambda c, a, by: (-c, a)),
    "angular-drag-wrong-magnitude": _drag(lambda c, a, by: (c, by * a)),
    "angular-drag-missing": _drag(lambda c, a, by: (c, 0.0)),
    "angular-drag-reversed": _drag(lambda c, a, by: (c, -a)),
    "drag-wrong-magnitude": _drag(lambda c, a, by: (by * c, by * a)),
    "drag-quadratic": _drag_law(
        lambda sim, q, v, w: (scale(-sim.scene.drag[0] * norm(v), v), scale(-sim.scene.drag[1], w))
    ),
    "angular-drag-quadratic": _drag_law(
        lambda sim, q, v, w: (scale(-sim.scene.drag[0], v), scale(-sim.scene.drag[1] * norm(w), w))
    ),
    "angular-drag-not-divided-by-inertia": _drag_law(
        lambda sim, q, v, w: (scale(-sim.scene.drag[0], v), scale(-sim.scene.drag[1], _inertia_times(sim, q, w)))
    ),
    "tether-stiffness-wrong-magnitude": _tethers(lambda t, s, by: replace(t, stiffness=by * t.stiffness)),
    "tether-stiffness-missing": _tethers(lambda t, s, by: replace(t, stiffness=0.0)),
    "tether-stiffness-reversed": _tethers(lambda t, s, by: replace(t, stiffness=-t.stiffness)),
    "tether-damping-wrong-magnitude": _tethers(lambda t, s, by: replace(t, damping=by * t.damping)),
    "tether-damping-missing": _tethers(lambda t, s, by: replace(t, damping=0.0)),
    "tether-damping-reversed": _tethers(lambda t, s, by: replace(t, damping=-t.damping)),
    "tether-rest-length-missing": _without_length,
    "tether-anchor-at-origin": _tethers(lambda t, s, by: replace(t, anchor=np.zeros(3))),
    "tether-anchor-from-start": _tethers(lambda t, s, by: replace(t, anchor=t.anchor + s.x)),
    "tether-at-wrong-vertex": _vertex,
    "tether-relaxed-at-start": _relaxed,
    "tether-damps-centre": _springs(is_of_centre=True),
    "tether-damper-direction": _other_damper,
    "tether-pulls-only": _springs(pulls_only=True),
    "tether-not-divided-by-mass": _springs(force=lambda force, mass: scale(mass, force)),
    "tether-torque-missing": _springs(lever=_nowhere),
    "tether-lever-not-rotated": _springs(lever=_unturned),
    "tether-lever-from-origin": _springs(lever=_from_origin),
    "tether-point-not-rotated": _springs(arm=_unturned),
    "tether-point-from-start-attitude": _springs(arm=_as_at_first),
    "tether-at-centre-of-mass": _springs(at=np.zeros(3)),
    "inertia-of-own-edges": _own_edges,
    "speed-threshold": _below(0),
    "spin-threshold": _below(1),
} | {f"wrong-moment-of-inertia-{name}": _moment(axis) for axis, name in enumerate("xyz")}
