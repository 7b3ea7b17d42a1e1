"""Mistakes with an impulse: how long it acts, where, how strongly; and with a start velocity that one has left."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from compare.grade.account import Account
from compare.grade.hypotheses import STEPS, Hypothesis, Question, choice, grid
from compare.grade.stepping import POINT_MOVES, POINT_STAYS, TORQUE_STAYS
from scenarios.frames import Array

# Bodies of more vertices than this are meshes, whose vertices nobody takes for one another.
MOST_VERTICES = 27
N_S_AS_N = {1.0: "N s read as N"}
# What becomes of the place where a force acts that lasts.
HELD = {POINT_MOVES: "", POINT_STAYS: " at a point that stays in the world", TORQUE_STAYS: " with a constant torque"}


def impulses(question: Question) -> Iterator[Hypothesis]:
    """Yield what a scene with impulses, or one that starts as a blow has left it, leaves room for."""
    if question.account.impulses:
        yield from _lasting(question)
        yield from _landing(question)
        yield from _strength(question)
    elif question.account.start[7:10].any():
        yield Hypothesis(
            "impulse as force",
            "impulse",
            "impulse used as a constant force: velocity grows from 0 by the start's own in {} s, without end",
            _velocity_grows,
            grid(0.1 * question.duration, 10 * question.duration, 13),
            known=N_S_AS_N,
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
        )
    yield Hypothesis(
        "impulse moves as force",
        "impulse",
        "impulse used as a constant force over {} s for the centre of mass, though at once for the rotation",
        lambda account, seconds: _stroke(account, lasts=seconds, turns=False),
        grid(short, 2 * flight, 15),
        known=N_S_AS_N,
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
    if question.account.mass != 1.0:
        yield Hypothesis(
            "mass left out",
            "strength",
            "impulse not divided by the mass: v += J",
            lambda account, _: replace(account, mass=1.0),
        )


def _stroke(account: Account, **changes: object) -> Account:
    return replace(account, stroke=account.stroke._replace(**changes))  # type: ignore[arg-type]
