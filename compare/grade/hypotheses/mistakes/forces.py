"""Mistakes with what acts all the time: gravity, damping that nobody asked for, a force of the scene left out."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from tumble.compare.grade.hypotheses.hypothesis import STEPS, Hypothesis, Question, choice, grid
from tumble.compare.grade.model.kernel.dynamics import AFTER_FORCES, AS_FORCE, LAST
from tumble.compare.grade.model.program_model import Account, without_strength
from tumble.scenarios.forces import GRAVITY, acting

STANDARD = 9.81  # m/s2
SIZES = {9.8: "9.8 m/s2", 9.80665: "9.80665 m/s2", 10.0: "10 m/s2"}
# Instants at which the fastest speed is looked for.
PROBES = 64
AXES = ("+x", "-x", "+y", "-y", "+z", "-z")
DIRECTIONS = tuple(sign * axis for axis in np.eye(3) for sign in (1.0, -1.0))
# 1/s, as engines have them by default.
RATES = {0.01: "", 0.04: "", 0.05: "", 0.1: "", 0.5: "", 1.0: ""}
BULLET = 0.04
# rad/s and m/s that engines do not let a body pass by default.
SPIN_CAPS = {7.0: "Unity's", 47.12: "Rapier's and Jolt's at 60 Hz", 100.0: "PhysX's"}
SPEED_CAPS = {100.0: "", 400.0: "", 500.0: "Jolt's"}
# When a step damps, which makes no difference to a smooth flight.
DAMPS = {AS_FORCE: "", AFTER_FORCES: ", after the forces of a step", LAST: ", after a step has moved the body"}


def forces(question: Question) -> Iterator[Hypothesis]:
    """Yield what is wrong with forces."""
    yield from _gravity(question)
    yield from _damping(question)
    yield from _drag(question)
    yield from _brakes(question)
    yield from _caps(question)
    yield from _left_out(question)


def _gravity(question: Question) -> Iterator[Hypothesis]:
    gravity = question.account.gravity
    size = float(np.linalg.norm(gravity))
    if question.drift is not None and question.drift[1].any():
        more = question.drift[1]
        yield Hypothesis(
            "constant acceleration",
            "gravity",
            f"an acceleration of ({', '.join(f'{value:.4g}' for value in more)}) m/s2 that the scene has not got",
            lambda account, _: replace(account, gravity=account.gravity + more),
            rare=True,
            taken=3,
        )
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
    yield _late_gravity(question)


def _late_gravity(question: Question) -> Hypothesis:
    """Return that gravity begins to act only after a while, as after an engine's first step."""
    longest = 0.5 * question.duration
    known = {question.spacing_s: "one row"} | STEPS
    known = {instant: name for instant, name in known.items() if instant < longest}
    return Hypothesis(
        "gravity late",
        "gravity start",
        "gravity acts from t = {} s on",
        lambda account, instant: replace(account, falls_from=instant),
        tuple(sorted({*grid(min(0.002, 1e-2 * longest), longest, 9), *known})),
        known=known,
        rare=True,
        unit="s",
    )


def damping_rates(duration: float, most: float = 4.0) -> tuple[float, ...]:
    """Return rates [1/s] that show in a flight of this many seconds, in which a body loses `most` powers of e."""
    return grid(1e-3 / duration, most / duration, 11)


def _damping(question: Question) -> Iterator[Hypothesis]:
    rates = damping_rates(question.duration)
    kinds = ("linear damping", "velocity", 0), ("angular damping", "angular velocity", 2)
    for damps, when in DAMPS.items():
        for name, what, place in kinds:
            yield Hypothesis(
                name,
                name,
                f"{name}: {what} decays at {{}} /s{when}",
                lambda account, rate, place=place, damps=damps: _damped(account, {place: rate}, damps),
                rates,
                known=RATES,
                variant=damps != AS_FORCE,
                unit="1/s",
            )
        yield Hypothesis(
            "damping as PyBullet's default",
            "linear damping",
            f"PyBullet's default damping: a = -{BULLET} (1 + |v|) v, and the same for w{when}",
            lambda account, _, damps=damps: _damped(account, dict.fromkeys(range(4), BULLET), damps),
            variant=damps != AS_FORCE,
        )


def _damped(account: Account, rates: dict[int, float], damps: int) -> Account:
    d0, d1, d2, d3, d4 = (rates.get(place, rate) for place, rate in enumerate(account.damping))
    return replace(account, damping=(d0, d1, d2, d3, d4), damps=damps)


def _drag(question: Question) -> Iterator[Hypothesis]:
    """Yield damping that is no decay: with the square of a speed, or by a torque that inertia divides."""
    rates, moment = grid(1e-3 / question.duration, 10 / question.duration, 11), float(question.account.moments.mean())
    for name, part, says, place, unit, scale in (
        ("quadratic drag", "linear damping", "quadratic drag: a = -{} /m |v| v", 1, "1/m", 1.0),
        ("quadratic spin drag", "angular damping", "quadratic drag of the rotation: alpha = -{} |w| w", 3, "1", 1.0),
        ("drag torque", "angular damping", "a torque of -{} N m s times w, divided by the inertia", 4, "N m s", moment),
    ):
        yield Hypothesis(
            name,
            part,
            says,
            lambda account, rate, place=place: _damped(account, {place: rate}, account.damps),
            tuple(scale * rate for rate in rates),
            rare=True,
            unit=unit,
        )


def _brakes(question: Question) -> Iterator[Hypothesis]:
    """Yield damping along one axis only."""
    rates = damping_rates(question.duration)
    for kind, what, axes in (
        (0, "linear damping along {}", "velocity along {} decays at {{}} /s"),
        (1, "angular damping about the body's {}", "angular velocity about the body's {} decays at {{}} /s"),
        (2, "angular damping about {}", "angular velocity about the world's {} decays at {{}} /s"),
    ):
        for number, axis in enumerate("xyz"):
            yield Hypothesis(
                what.format(axis),
                what.format(axis),
                axes.format(axis),
                lambda account, rate, kind=kind, number=number: _braked(account, kind, number, rate),
                rates,
                known=RATES,
                rare=True,
                unit="1/s",
            )


def _braked(account: Account, kind: int, axis: int, rate: float) -> Account:
    brakes = [list(brake) for brake in account.brakes]
    brakes[kind][axis] = rate
    of_v, of_body, of_world = ((x, y, z) for x, y, z in brakes)
    return replace(account, brakes=(of_v, of_body, of_world))


def _caps(question: Question) -> Iterator[Hypothesis]:
    """Yield that speeds are not let past some value; of a flight that is slower nothing would be seen."""
    account = question.account
    rows = account.flown(np.linspace(0.0, question.duration, PROBES))
    for name, says, place, columns, known in (
        ("spin cap", "angular velocity not let past {} rad/s", 1, slice(15, 18), SPIN_CAPS),
        ("speed cap", "velocity not let past {} m/s", 0, slice(12, 15), SPEED_CAPS),
    ):
        fastest = float(np.linalg.norm(rows[:, columns], axis=1).max())
        if fastest > 0:
            yield Hypothesis(
                name,
                name,
                says,
                lambda account, cap, place=place: replace(
                    account, caps=(account.caps[0], cap) if place else (cap, account.caps[1])
                ),
                tuple(np.linspace(0.05, 1.0, 12) * fastest),
                known={cap: name for cap, name in known.items() if cap < fastest},
                rare=True,
                unit="rad/s" if place else "m/s",
            )


def _left_out(question: Question) -> Iterator[Hypothesis]:
    """Yield that a force of the scene is missing: it stays without strength, so that no kernel is compiled for it."""
    for law in acting(question.scene):
        if law is GRAVITY:
            continue
        rest = without_strength(law, question.scene)
        yield Hypothesis(
            f"{law.name} missing",
            law.name,
            f"{law.name} missing",
            lambda account, _, part=law.part, rest=rest: replace(
                account, forces=account.forces._replace(**{part: rest})
            ),
        )
