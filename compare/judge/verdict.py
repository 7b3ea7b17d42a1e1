"""One word for what became of a flight, from its numbers: states, truth, and what the engine's audit says.

    refused        there is no flight: the engine lacks a force or a package, or raised
    no-return      there is no flight: out of time, or its process died
    diverged       not finite any more, or more than BLOWN_UP times the energy
    reset          put back to some start in the middle of the flight
    frozen         nothing moved although it should
    clamped        a velocity sits at one number, where physics has it go on
    lost-torque    the angular velocity stands still where it should turn
    under-rotated  the attitude lags behind an angular velocity that is right
    drifting       energy or angular momentum leaves its band, or the body its shape
    damped         energy is lost that physics keeps
    stable         none of these; how accurate it is, its error says

A flight that a clamp or a reset keeps finite is not stable: those are asked before the energy is.  Without a truth
the energy of a scene with no damping is still known, that of one with damping only not to grow; then momentum,
lost torque and under-rotation are not judged, unless the audit names them.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tumble.compare.judge import mechanics
from tumble.compare.judge.balance import BAND, Balance, energies
from tumble.compare.judge.errors import Run, largest, lost_torque, quietly
from tumble.compare.run.status import Failure, Status
from tumble.scenarios.forces import acting, can_turn
from tumble.scenarios.frames import Array, rotation_matrix, vertices
from tumble.scenarios.needs import needs
from tumble.scenarios.scene import Body

# A growth that ends is not without end: from the first to the last quarter of a flight it does not come to this.
TENFOLD = 10.0
OUT_OF_BOUNDS, BLOWN_UP = 1e2, 1e3
# How far a velocity that is right may be off, of itself; and how far an attitude may lag, of the whole turn.
RIGHT, LAG = 1e-3, 1e-2
# So often must the largest velocity be the same to rounding before that is taken for a limit.
SITS, SAME_LENGTH = 3, 1e-12
HIDES_NOTHING = 1e9  # times the energy: rounding can stop a velocity too, once everything else has run away
SLOW = 0.1  # of the speed that all the energy of the scene would give
STRETCHED = 1e-2
# What an engine's audit may decide: only it can see them.  How much a damping takes, the numbers show.
AUDITED = ("reset", "clamped", "frozen", "lost-torque", "under-rotated")
AT_REST_AT_THE_ORIGIN = np.array((0.0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0))


@dataclass(frozen=True)
class Verdict:
    """The word, the reason in words, and the energy at the end over what physics leaves there.

    energy_ratio: of the spin where the body is free and turns; where damping takes energy, what is too much is counted
    in units of the energy at the start.  None where there is no flight.
    """

    word: str
    why: str = ""
    energy_ratio: float | None = None


@quietly()
def verdict(run: Run) -> Verdict:
    """Return the verdict on one run; its truth may be None."""
    if isinstance(run.answer, Failure):
        no_return = run.answer.status is Status.TIMEOUT or run.answer.process_died
        return Verdict("no-return" if no_return else "refused", run.answer.reason)
    if run.answer.diverged_at is not None:
        return Verdict("diverged", f"not finite from {run.answer.diverged_at:.4g} s on", np.inf)
    balances = list(energies(run))
    ratio = balances[0].ratio
    for word, finder in FINDERS.items():
        why = next((found.text for found in run.answer.findings if found.kind == word and word in AUDITED), "")
        why = why or finder(run, balances)
        if why:
            return Verdict(word, why, ratio)
    return Verdict("stable", "", ratio)


def bounded(run: Run, said: Verdict) -> bool:
    """Whether nothing in a flight with that verdict grows without end, as far as its length can tell."""
    if said.word in HOLDS:
        return True
    if said.word != "drifting":
        return False
    return not deformed(run) and all(each.growth <= TENFOLD for each in energies(run))


def blown_up(run: Run, balances: list[Balance]) -> str:
    """Say so where the energy is beyond all bounds."""
    worst = max(balances, key=lambda each: each.top)
    return f"{worst.name} {worst.top:.2g} times that at the start" if worst.top > BLOWN_UP else ""


def was_reset(run: Run, balances: list[Balance]) -> str:
    """Say so where the body is back at the first state, or at rest at the origin, after it had moved."""
    states, truth = run.flight.states, run.truth
    blank = (states == AT_REST_AT_THE_ORIGIN).all(axis=-1)
    first = (states == states[0]).all(axis=-1)
    had_moved = np.logical_or.accumulate(~(blank | first), axis=0)
    back = (blank | first) & had_moved
    if truth is not None:
        back &= np.abs(truth.vertices - run.flight.vertices).max(axis=(-1, -2)) > truth.resolution
    return f"back at a start at {run.flight.times[np.argmax(back.any(axis=1))]:.4g} s" if back.any() else ""


def is_clamped(run: Run, balances: list[Balance]) -> str:
    """Say so where the largest velocity of a flight is one number time and again, and physics has another there.

    A body that has come to rest, or to a steady spin, has one velocity too: so it must not be slow, and an angular
    velocity must be seen to change its direction.
    A fall that drag brings to one speed is not judged.  Without a truth only the start can tell what physics keeps.
    """
    states, truth = run.flight.states, run.truth
    brakes = any(law.stored is None for law in acting(run.scene))
    if (brakes and run.scene.gravity is not None) or max(each.top for each in balances) > HIDES_NOTHING:
        return ""
    energy = max(each.scale for each in balances)
    for name, unit, part, inertia in (
        ("v", "m/s", slice(7, 10), run.scene.body.mass),
        ("w", "rad/s", slice(10, 13), run.scene.body.moments.max()),
    ):
        slow = SLOW * math.sqrt(2 * energy / inertia)
        for what, law in (("every component of {}", np.abs), ("|{}|", lengths)):
            seen = law(states[1:, :, part])
            known = law(states[:1, :, part] if truth is None else truth.states[1:, :, part])
            limit = float(seen.max())
            sits = (abs(seen - limit) <= SAME_LENGTH * limit) & (abs(known - limit) > RIGHT * limit)
            where = states[1:, :, part][sits.any(axis=-1)]
            if len(where) >= SITS and limit > slow and (name == "v" or np.ptp(where, axis=0).max() > RIGHT * limit):
                return f"{what.format(name)} stops at {limit:.6g} {unit}"
    return ""


def lengths(vectors: Array) -> Array:
    """Return the lengths of vectors (..., 3), as (..., 1)."""
    return np.linalg.norm(vectors, axis=-1, keepdims=True)


def is_frozen(run: Run, balances: list[Balance]) -> str:
    """Say so where no vertex ever moved and some truly do, or the state itself has a velocity."""
    flight = run.flight
    if not (flight.vertices == flight.vertices[0]).all():
        return ""
    if run.truth is not None:
        moved = np.abs(run.truth.vertices - run.truth.vertices[0]).max() > run.truth.resolution.max()
    else:
        moved = bool(flight.states[0, :, 7:13].any())
    return "the body never moved" if moved else ""


def has_lost_torque(run: Run, balances: list[Balance]) -> str:
    """Say so where the angular velocity stands still and the true one turns."""
    if run.truth is None or can_turn(run.scene) or "gyroscopic" not in needs(run.scene):
        return ""
    lost = lost_torque(run.scene, run.flight.states, run.truth.states)
    return "the angular velocity stands still where the true one turns" if lost else ""


def is_under_rotated(run: Run, balances: list[Balance]) -> str:
    """Say so where the attitude at the first sample lags behind while the angular velocity is right up to there."""
    if run.truth is None or len(run.flight.times) < 2:
        return ""
    states, true, time = run.flight.states[1], run.truth.states[1], float(run.flight.times[1])
    w, w_true = states[:, 10:13], true[:, 10:13]
    rate = np.linalg.norm(w_true, axis=-1)
    right = np.linalg.norm(w - w_true, axis=-1) <= RIGHT * rate
    behind = np.einsum("nij,nkj->nik", rotation_matrix(true[:, 3:7]), rotation_matrix(states[:, 3:7]))
    lag = np.einsum("ni,ni->n", rotation_vector(behind), w_true) / np.where(rate > 0, rate, 1.0)
    lags = right & (rate > 0) & (lag > LAG * rate * time)
    if not lags.any():
        return ""
    worst = int(np.argmax(np.where(lags, lag, 0.0)))
    return f"turned {lag[worst]:.3g} rad too little of {rate[worst] * time:.3g} while w is right"


def rotation_vector(matrices: Array) -> Array:
    """Return axis times angle of rotation matrices (n, 3, 3) [rad], (n, 3); of a half turn, none."""
    skew = (matrices - np.swapaxes(matrices, 1, 2)) / 2
    axis = np.stack((skew[:, 2, 1], skew[:, 0, 2], skew[:, 1, 0]), axis=-1)
    sine, cosine = np.linalg.norm(axis, axis=-1), (np.trace(matrices, axis1=1, axis2=2) - 1) / 2
    return axis * (np.arctan2(sine, cosine) / np.where(sine > 0, sine, 1.0))[:, None]


def is_drifting(run: Run, balances: list[Balance]) -> str:
    """Say so where energy grows or, of a free body that loses none, momentum leaves its band, or the body its shape."""
    for each in balances:
        if each.top > OUT_OF_BOUNDS:
            return f"{each.name} up to {each.top:.3g} times that at the start"
        if each.grows:
            return f"{each.name} grows: {each.ratio:.3g} times at the end"
    if any(each.falls for each in balances):
        return ""
    return off_momentum(run) or deformed(run)


def off_momentum(run: Run) -> str:
    """Say so where a free body's angular momentum leaves its band."""
    off = off_by(run, mechanics.angular_momentum) if run.scene.is_free else 0.0
    return f"angular momentum off by {off:.2g} of it" if off > BAND else ""


def off_by(run: Run, law: Callable[[Array, Body], Array]) -> float:
    """Return how far a momentum goes from the true one, or without a truth from the first, over its size."""
    states, body = run.flight.states, run.scene.body
    true = law(states[:1] if run.truth is None else run.truth.states, body)
    off, scale = largest(law(states, body) - true), largest(true)
    return off / scale if scale else off


def deformed(run: Run) -> str:
    """Say so where the vertices are not where the state has them: an attitude that is no rotation any more."""
    flight, body = run.flight, run.scene.body
    size = body.reach
    off = float(np.linalg.norm(flight.vertices - vertices(flight.states, body.points), axis=-1).max())
    return (
        f"no rigid body any more: vertices {off / size:.2g} of its size out of place" if off > STRETCHED * size else ""
    )


def is_damped(run: Run, balances: list[Balance]) -> str:
    """Say so where energy is lost that physics keeps, or a free body's speed is."""
    for each in balances:
        if each.falls:
            return f"{each.name} falls: {each.ratio:.3g} times at the end"
    return ""


Finder = Callable[[Run, list[Balance]], str]

HOLDS = ("stable", "damped")

# In the order in which they are asked.
FINDERS: dict[str, Finder] = {
    "reset": was_reset,
    "frozen": is_frozen,
    "clamped": is_clamped,
    "diverged": blown_up,
    "lost-torque": has_lost_torque,
    "under-rotated": is_under_rotated,
    "drifting": is_drifting,
    "damped": is_damped,
}
WORDS = ("refused", "no-return", *FINDERS, "stable")
# Of flights that end with numbers which look right and are not.
SILENT = tuple(word for word in FINDERS if word != "diverged")
