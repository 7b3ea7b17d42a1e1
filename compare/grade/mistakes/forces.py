"""Mistakes with what acts all the time: gravity, damping that nobody asked for, a force of the scene left out."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from compare.grade.account import Account
from compare.grade.hypotheses import Hypothesis, Question, choice, grid
from compare.grade.stepping import AFTER_FORCES, AS_FORCE, LAST

STANDARD = 9.81  # m/s2
SIZES = {9.8: "9.8 m/s2", 9.80665: "9.80665 m/s2", 10.0: "10 m/s2"}
AXES = ("+x", "-x", "+y", "-y", "+z", "-z")
DIRECTIONS = tuple(sign * axis for axis in np.eye(3) for sign in (1.0, -1.0))
# 1/s, where nobody says otherwise.
LINEAR = {0.04: "as PyBullet, but without its quadratic part", 0.05: "Jolt's default", 0.1: "Godot's default"}
ANGULAR = {**LINEAR, 0.05: "PhysX's, Unity's and Jolt's default"}
BULLET = 0.04
# When a step damps, which makes no difference to a smooth flight.
DAMPS = {AS_FORCE: "", AFTER_FORCES: ", after the forces of a step", LAST: ", after a step has moved the body"}


def forces(question: Question) -> Iterator[Hypothesis]:
    """Yield what is wrong with forces."""
    yield from _gravity(question)
    yield from _damping(question)
    yield from _left_out(question)


def _gravity(question: Question) -> Iterator[Hypothesis]:
    gravity = question.account.gravity
    size = float(np.linalg.norm(gravity))
    if not size:
        yield Hypothesis(
            "gravity added",
            "gravity",
            f"gravity of {STANDARD} m/s2 along {{}}, which the scene has not got",
            lambda account, number: replace(account, gravity=STANDARD * DIRECTIONS[int(number)]),
            choice(len(AXES)),
            AXES,
        )
        return
    for name, says, factor in (
        ("gravity missing", "gravity missing", 0.0),
        ("gravity doubled", "gravity applied twice", 2.0),
        ("gravity reversed", "gravity of the wrong sign", -1.0),
    ):
        yield Hypothesis(
            name, "gravity", says, lambda account, _, factor=factor: replace(account, gravity=factor * gravity)
        )
    others = [number for number, direction in enumerate(DIRECTIONS) if abs(direction @ gravity) < 0.9 * size]
    yield Hypothesis(
        "gravity along another axis",
        "gravity",
        "gravity along {}",
        lambda account, number: replace(account, gravity=size * DIRECTIONS[others[int(number)]]),
        choice(len(others)),
        tuple(AXES[number] for number in others),
    )
    yield Hypothesis(
        "gravity of another size",
        "gravity",
        "gravity {} times what it is",
        lambda account, factor: replace(account, gravity=factor * gravity),
        grid(0.5, 1.6, 9),
        known={other / size: name for other, name in SIZES.items() if other != size},
    )


def _damping(question: Question) -> Iterator[Hypothesis]:
    rates = grid(1e-3 / question.duration, 4 / question.duration, 11)
    kinds = ("linear damping", "velocity", 0, LINEAR), ("angular damping", "angular velocity", 2, ANGULAR)
    for damps, when in DAMPS.items():
        for name, what, place, known in kinds:
            yield Hypothesis(
                name,
                name,
                f"{name}: {what} decays at {{}} /s{when}",
                lambda account, rate, place=place, damps=damps: _damped(account, {place: rate}, damps),
                rates,
                known=known,
                variant=damps != AS_FORCE,
            )
        yield Hypothesis(
            "damping as PyBullet's default",
            "linear damping",
            f"PyBullet's default damping: a = -{BULLET} (1 + |v|) v, and the same for w{when}",
            lambda account, _, damps=damps: _damped(account, dict.fromkeys(range(4), BULLET), damps),
            variant=damps != AS_FORCE,
        )


def _damped(account: Account, rates: dict[int, float], damps: int) -> Account:
    d0, d1, d2, d3 = (rates.get(place, rate) for place, rate in enumerate(account.damping))
    return replace(account, damping=(d0, d1, d2, d3), damps=damps)


def _left_out(question: Question) -> Iterator[Hypothesis]:
    """Yield that a force of the scene is missing: it stays without strength, so that no kernel is compiled for it."""
    here = question.account.forces
    without: dict[str, object] = {}
    if here.tethers is not None:
        without["tethers"] = here.tethers * np.repeat((1.0, 0.0, 1.0), (6, 2, 1))
    if here.drag is not None:
        without["drag"] = tuple(coefficient and 0.0 for coefficient in here.drag)
    if here.floor is not None:
        without["floor"] = (*here.floor[:4], 0.0, 0.0)
    for name, rest in without.items():
        said = name.removesuffix("s")
        yield Hypothesis(
            f"{said} missing",
            said,
            f"{said} missing",
            lambda account, _, name=name, rest=rest: replace(account, forces=account.forces._replace(**{name: rest})),
        )
