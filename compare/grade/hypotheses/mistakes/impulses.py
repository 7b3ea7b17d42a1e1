"""Mistakes with an impulse: how long it acts, where, how strongly; and with a start velocity that one has left."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from tumble.compare.grade.hypotheses.hypothesis import STEPS, Hypothesis, Question, choice, grid
from tumble.compare.grade.hypotheses.mistakes.one_impulse import MOST_VERTICES, one_impulse
from tumble.compare.grade.model.kernel.dynamics import (
    AS_AT_THE_START,
    NOT_TURNED,
    POINT_MOVES,
    POINT_STAYS,
    TORQUE_STAYS,
    TORQUE_UNTURNED,
)
from tumble.compare.grade.model.program_model import Account
from tumble.scenarios.frames import Array
from tumble.scenarios.scene import Impulse

N_S_AS_N = {1.0: "N s read as N"}
# What becomes of the place where a force acts that lasts.
HELD = {POINT_MOVES: "", POINT_STAYS: " at a point that stays in the world", TORQUE_STAYS: " with a constant torque"}


def impulses(question: Question) -> Iterator[Hypothesis]:
    """Yield what a scene with impulses, or one that starts as a blow has left it, leaves room for."""
    if question.account.impulses:
        yield from _lasting(question)
        yield from _landing(question)
        yield from _strength(question)
        yield from one_impulse(question)
    elif question.account.start[7:10].any():
        yield Hypothesis(
            "impulse as force",
            "impulse",
            "impulse used as a constant force: velocity grows from 0 by the start's own in {} s, without end",
            _velocity_grows,
            grid(0.1 * question.duration, 10 * question.duration, 13),
            known=N_S_AS_N,
            unit="s",
        )


def _velocity_grows(account: Account, seconds: float) -> Account:
    start = account.start.copy()
    start[7:10] = 0.0
    return replace(account, start=start, gravity=account.gravity + account.start[7:10] / seconds)


def _lasting(question: Question) -> Iterator[Hypothesis]:
    flight = question.duration - min(impulse.time for impulse in question.account.impulses)
    if flight <= 0:
        return
    short, long = 0.002 * flight, 0.1 * flight
    for held, where in HELD.items():
        yield Hypothesis(
            "impulse as force",
            "impulse",
            f"impulse used as a constant force over {{}} s{where}",
            lambda account, seconds, held=held: _stroke(account, lasts=seconds, held=held),
            grid(long, 2 * flight, 13),
            known=N_S_AS_N,
            unit="s",
        )
        yield Hypothesis(
            "impulse as force without end",
            "impulse",
            f"impulse used as a constant force of as many N as it has N s, without end{where}",
            lambda account, _, held=held: _stroke(account, lasts=1.0, ends=False, held=held),
        )
    for held, where in HELD.items():
        yield Hypothesis(
            "impulse as force over a step",
            "impulse",
            f"impulse used as a force over a first step of {{}} s{where}: what follows lags by half of it",
            lambda account, seconds, held=held: _stroke(account, lasts=seconds, held=held),
            grid(short, long, 9),
            known=STEPS,
            variant=held != POINT_MOVES,
            unit="s",
        )
    yield Hypothesis(
        "impulse moves as force",
        "impulse",
        "impulse used as a constant force over {} s for the centre of mass, though at once for the rotation",
        lambda account, seconds: _stroke(account, lasts=seconds, turns=False),
        grid(short, 2 * flight, 15),
        known=N_S_AS_N,
        unit="s",
    )


def _landing(question: Question) -> Iterator[Hypothesis]:
    account, points = question.account, question.scene.body.points
    for name, says, sign, share in (
        ("impulse at the centre", "impulse applied at the centre of mass, so that it does not turn", 0.0, 0.0),
        ("impulse point from the origin", "point of the impulse not taken from the centre of mass", 1.0, 0.0),
        ("impulse lever reversed", "torque of the impulse of the wrong sign, F x r", -1.0, 1.0),
    ):
        arm = (sign, share, 0.0, 0.0, 0.0)
        yield Hypothesis(name, "lever", says, lambda account, _, arm=arm: _stroke(account, arm=arm))
    for name, says, levers in (
        ("impulse lever not turned", "lever of the impulse in body axes, not turned to the world", NOT_TURNED),
        ("impulse lever as at the start", "lever of the impulse turned as it was at the start", AS_AT_THE_START),
    ):
        yield Hypothesis(
            name, "lever", says, lambda account, _, levers=levers: _stroke(account, levers=levers), rare=True
        )
    yield Hypothesis(
        "impulse only turns",
        "strength",
        "impulse only turns the body: its centre of mass is not pushed",
        lambda account, _: _stroke(account, moves=False),
        rare=True,
    )
    yield Hypothesis(
        "impulse torque in body axes",
        "lever",
        "torque of the impulse taken to be in body axes: I^-1 (r x J) without a turn",
        lambda account, _: replace(account, struck=TORQUE_UNTURNED),
        rare=True,
    )
    if any(_is_turned(impulse, account) for impulse in account.impulses):
        yield Hypothesis(
            "impulse in body axes",
            "strength",
            "impulse taken in body axes",
            lambda account, _: _stroke(account, in_body=True),
            rare=True,
        )
    if account.impulses[-1].time > 0:
        yield Hypothesis(
            "impulse point not moved",
            "lever",
            "point of the impulse taken from where the centre of mass was at the start",
            lambda account, _: _stroke(account, arm=(1.0, 0.0, *account.start[0:3].tolist())),
        )
    others = [number for number, point in enumerate(points) if not _all_at(account, point)]
    if len(points) <= MOST_VERTICES:
        yield Hypothesis(
            "impulse at another vertex",
            "lever",
            "impulse applied at {}",
            lambda account, number: _at(account, points[others[int(number)]]),
            choice(len(others)),
            tuple(f"vertex {number}" for number in others),
            of_scene=True,
        )


def _all_at(account: Account, point_body: Array) -> bool:
    places = (impulse.point_body for impulse in account.impulses)
    return all(place is not None and np.array_equal(place, point_body) for place in places)


def _at(account: Account, point_body: Array) -> Account:
    moved = (replace(impulse, point_world=None, point_body=point_body) for impulse in account.impulses)
    return replace(account, impulses=tuple(moved))


def _strength(question: Question) -> Iterator[Hypothesis]:
    for name, says, strength in (
        ("impulse missing", "impulse missing", 0.0),
        ("impulse doubled", "impulse applied twice", 2.0),
        ("impulse reversed", "impulse of the wrong sign", -1.0),
    ):
        yield Hypothesis(
            name, "strength", says, lambda account, _, strength=strength: _stroke(account, strength=strength)
        )
    mass = question.account.mass
    if mass != 1.0:
        yield Hypothesis(
            "mass left out",
            "strength",
            "impulse not divided by the mass: v += J",
            lambda account, _: replace(account, mass=1.0),
        )
    sizes = {1e-3: "kg taken for g", 1e3: "g taken for kg", 1 / mass: "1/m", mass: "m"}
    steps = {step: f"a step of {name}" for step, name in STEPS.items()}
    yield Hypothesis(
        "impulse of another size",
        "strength",
        "impulse {} times what it is, or mass and inertia so much less than the scene says",
        lambda account, strength: _stroke(account, strength=strength),
        grid(1e-4, 1e4, 49),
        known={size: name for size, name in (steps | sizes).items() if size != 1.0},
        rare=True,
        of_scene=True,
    )
    lengths = [float(np.linalg.norm(impulse.value)) for impulse in question.account.impulses]
    if len(lengths) > 1 and not np.allclose(lengths, lengths[0]):
        unit = tuple(
            replace(impulse, value=impulse.value / length)
            for impulse, length in zip(question.account.impulses, lengths, strict=True)
        )
        yield Hypothesis(
            "impulses of unit length",
            "strength",
            "only the direction of each impulse is used: all are of 1 N s",
            lambda account, _: replace(account, impulses=unit),
            rare=True,
        )
    yield Hypothesis(
        "another mass",
        "mass",
        "impulse divided by {} times the mass that the scene says, though the inertia is right",
        lambda account, factor: replace(account, mass=factor * account.mass),
        grid(1e-3, 1e3, 37),
        known={1e3: "kg taken for g", 1e-3: "g taken for kg"},
        rare=True,
        of_scene=True,
    )


def _is_turned(impulse: Impulse, account: Account) -> bool:
    """Whether an impulse in body axes would be another one."""
    axes = account.flown(np.array([impulse.time]))[0, 3:12].reshape(3, 3)
    return not np.allclose(axes @ impulse.value, impulse.value)


def _stroke(account: Account, **changes: object) -> Account:
    return replace(account, stroke=account.stroke._replace(**changes))  # type: ignore[arg-type]
