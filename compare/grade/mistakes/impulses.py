"""Mistakes with an impulse: how long it acts, where, how strongly; and with a start velocity that one has left."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from compare.grade.account import Account
from compare.grade.hypotheses import STEPS, Hypothesis, Question, choice, grid
from compare.grade.stepping import POINT_MOVES, POINT_STAYS, TORQUE_STAYS
from scenarios.frames import Array
from scenarios.scene import Impulse

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
        yield from _each(question)
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
    yield Hypothesis(
        "impulse lever not turned",
        "lever",
        "lever of the impulse in body axes, not turned to the world",
        lambda account, _: _stroke(account, unturned=True),
        rare=True,
    )
    turned = tuple(_in_body(impulse, account) for impulse in account.impulses)
    if any((one.value != other.value).any() for one, other in zip(turned, account.impulses, strict=True)):
        yield Hypothesis(
            "impulse in body axes",
            "strength",
            "impulse taken in body axes",
            lambda account, _: replace(account, impulses=turned),
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
        "impulse {} times what it is, or mass and inertia so much less",
        lambda account, strength: _stroke(account, strength=strength),
        grid(1e-4, 1e4, 49),
        known={size: name for size, name in (steps | sizes).items() if size != 1.0},
        rare=True,
    )
    yield Hypothesis(
        "another mass",
        "mass",
        "impulse divided by {} times the mass, though the inertia is right",
        lambda account, factor: replace(account, mass=factor * account.mass),
        grid(1e-3, 1e3, 37),
        known={1e3: "kg taken for g", 1e-3: "g taken for kg"},
        rare=True,
    )


def _each(question: Question) -> Iterator[Hypothesis]:
    """Yield mistakes with one impulse of several, and with the time of any."""
    impulses = question.account.impulses
    centre = np.zeros(3)
    for number, impulse in enumerate(impulses):
        which = f"impulse {number + 1}" if len(impulses) > 1 else "the impulse"
        times = np.linspace(-impulse.time, question.duration - impulse.time, 25)
        yield Hypothesis(
            "impulse at another time",
            "impulse time",
            f"{which} acts {{}} s after its time",
            lambda account, late, number=number: _changed(account, number, late=late),
            tuple(times.tolist()),
            known={step: name for step, name in STEPS.items() if step < times[-1]},
            rare=True,
            unit="s",
        )
        if len(impulses) == 1:
            continue
        for name, says, factor in (
            ("one impulse missing", "missing", 0.0),
            ("one impulse doubled", "applied twice", 2.0),
            ("one impulse reversed", "of the wrong sign", -1.0),
        ):
            yield Hypothesis(
                name,
                "one impulse",
                f"{which} {says}",
                lambda account, _, number=number, factor=factor: _changed(account, number, factor=factor),
                rare=True,
            )
        yield Hypothesis(
            "one impulse of another size",
            "one impulse",
            f"{which} {{}} times what it is",
            lambda account, factor, number=number: _changed(account, number, factor=factor),
            grid(1e-3, 1e3, 25),
            rare=True,
        )
        yield Hypothesis(
            "one impulse at the centre",
            "one impulse",
            f"{which} applied at the centre of mass",
            lambda account, _, number=number: _changed(account, number, point=centre),
            rare=True,
        )
        if impulse.point_body is not None:
            reversed_ = -impulse.point_body
            yield Hypothesis(
                "one impulse lever reversed",
                "one impulse",
                f"torque of {which} of the wrong sign",
                lambda account, _, number=number, point=reversed_: _changed(account, number, point=point),
                rare=True,
            )


def _changed(
    account: Account, number: int, late: float = 0.0, factor: float = 1.0, point: Array | None = None
) -> Account:
    """Return the account with one impulse later, of another size or at another point of the body."""
    impulses = list(account.impulses)
    old = impulses[number]
    new = replace(old, time=old.time + late, value=factor * old.value)
    impulses[number] = new if point is None else replace(new, point_world=None, point_body=point)
    return replace(account, impulses=tuple(sorted(impulses, key=lambda impulse: impulse.time)))


def _in_body(impulse: Impulse, account: Account) -> Impulse:
    """Return an impulse whose value was meant in body axes."""
    axes = account.flown(np.array([impulse.time]))[0, 3:12].reshape(3, 3)
    return replace(impulse, value=axes @ impulse.value)


def _stroke(account: Account, **changes: object) -> Account:
    return replace(account, stroke=account.stroke._replace(**changes))  # type: ignore[arg-type]
