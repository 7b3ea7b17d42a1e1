"""Mistakes of a step: the Euler methods, each by the size, sign and shape of the drift that it leaves."""

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from tumble.compare.grade.hypotheses.hypothesis import Hypothesis, Question, choice, grid
from tumble.compare.grade.model.kernel.dynamics import (
    EXPLICIT,
    EXPONENTIAL,
    HEUN,
    IMPLICIT,
    IN_WORLD,
    MATRIX,
    MOMENTUM,
    ORDER_2,
    ORDER_3,
    ORDER_4,
    QUATERNION,
    RUNGE_KUTTA,
    SMOOTH,
    VERLET,
    WORLD,
    Scheme,
)
from tumble.compare.grade.model.program_model import Account

# A flight of more steps than this takes longer than it is worth, and of more than this where its step has a name.
MOST_STEPS, MOST_KNOWN_STEPS = 5_000, 10_000
# Values tried first, and how much shorter than the longest the shortest is.
TRIED, RANGE = 7, 200
RARELY = (2, 3, 4, 5, 8, 10, 16, 20, 25, 30, 32, 50, 60, 64, 100, 120, 128, 240, 500, 1000)
METHODS = {
    "midpoint method": ORDER_2, "Heun's method": HEUN, "velocity Verlet": VERLET,
    "Runge-Kutta of order 3": ORDER_3, "Runge-Kutta of order 4": ORDER_4,
}  # fmt: skip
WORLD_AXES = ", w in world axes"
BODY, KEPT, IMPLICITLY = ", w in body axes", ", the angular momentum kept", ", the gyroscopic term implicit"
TURNED, FIRST_ORDER = ", turned by rotations", ", q to first order"


def steps(question: Question) -> Iterator[Hypothesis]:
    """Yield explicit and symplectic Euler as engines and students write them, and what they forget besides.

    With the angular momentum kept L is constant between impulses; otherwise w is stepped by Euler's equations, as in
    PyBullet's default body and in MuJoCo's Euler, or with their implicit gyroscopic term.  With a symplectic step w
    in body axes and w in world axes are the same: the body turns about it.
    """
    if _longest(question) * MOST_KNOWN_STEPS < question.duration:
        return  # rows are so dense that no step between them can be flown
    explicit, symplectic = "explicit Euler with a step of {} s", "symplectic Euler with a step of {} s"
    equal = np.ptp(question.account.moments) == 0
    for attitude, turns in ((QUATERNION, ""), (EXPONENTIAL, TURNED)):
        for spin, kept in ((WORLD, ""), (EXPLICIT, BODY), (MOMENTUM, KEPT))[: 1 if equal else 3]:
            yield _euler(
                question, "explicit Euler", explicit + kept + turns, attitude, spin, variant=bool(kept or turns)
            )
    for attitude, turns in ((EXPONENTIAL, ""), (QUATERNION, FIRST_ORDER)):
        for spin, kept in ((EXPLICIT, ""), (MOMENTUM, KEPT), (IMPLICIT, IMPLICITLY))[: 1 if equal else 3]:
            yield _euler(
                question,
                "symplectic Euler",
                symplectic + kept + turns,
                attitude,
                spin,
                semi=True,
                variant=bool(kept or turns),
            )
    for spin, kept in ((WORLD, ""), (EXPLICIT, BODY), (MOMENTUM, KEPT))[: 1 if equal else 3]:
        never = f"{explicit}{kept}, the quaternion never normalised"
        yield _euler(question, "not normalised", never, QUATERNION, spin, normalises=0, variant=bool(kept))
    if question.kind != "pose":
        shears = "explicit Euler on the rotation matrix with a step of {} s: the shape is not rigid"
        yield _euler(question, "matrix Euler", shears, MATRIX, MOMENTUM)
    kinds = [(name, method, "") for name, method in METHODS.items()]
    kinds += [(name, method + IN_WORLD, WORLD_AXES) for name, method in METHODS.items() if method != VERLET]
    for name, method, axes in kinds:
        says = f"{name} with a step of {{}} s{axes}"
        hypothesis = _euler(question, name, says, RUNGE_KUTTA, method, variant=bool(axes))
        # So little is wrong that any step would fit: only those that programs take are believed.
        if hypothesis.known:
            yield replace(hypothesis, rare=True, values=tuple(sorted(hypothesis.known)), only_known=True)
    yield Hypothesis(
        "normalised rarely",
        "normalisation",
        "the quaternion normalised every {} steps only",
        lambda account, number: replace(account, scheme=account.scheme._replace(normalises=RARELY[int(number)])),
        choice(len(RARELY)),
        tuple(map(str, RARELY)),
        rare=True,
    )
    yield from _falls(question)


def _euler(
    question: Question,
    name: str,
    says: str,
    attitude: int,
    spin: int,
    semi: bool = False,
    normalises: int = 1,
    variant: bool = False,
) -> Hypothesis:
    longest = _longest(question)
    shortest = max(longest / RANGE, question.duration / MOST_STEPS)
    return Hypothesis(
        name,
        "steps",
        says,
        lambda account, step: replace(
            account, scheme=Scheme(step, attitude, spin, semi, 1.0 if semi else 0.0, normalises)
        ),
        grid(min(shortest, longest / 2), longest, TRIED),
        known={
            h: used
            for h, used in question.steps.items()
            if question.duration / MOST_KNOWN_STEPS <= h < question.spacing_s * 1.01
        },
        unit="s",
        variant=variant,
    )


def _longest(question: Question) -> float:
    """Return the longest step that is tried [s]: no longer than from row to row."""
    return min(0.1 * question.duration, 0.5 * question.turn_s, question.spacing_s)


def _falls(question: Question) -> Iterator[Hypothesis]:
    """Yield how else a step moves the centre of mass, where that makes a difference: where a force acts on it."""
    if not question.account.gravity.any() and question.scene.is_free:
        return

    def falls(account: Account, fall: Callable[[float], float]) -> Account:
        if account.scheme.attitude == SMOOTH:
            return account
        return replace(account, scheme=account.scheme._replace(fall=fall(account.scheme.fall)))

    for says, fall in (
        ("by x += v dt + a dt^2/2", lambda _: 0.5),
        ("by the other velocity: the new one for the old, or the old for the new", lambda fall: 1.0 - fall),
    ):
        yield Hypothesis(
            "another step of x",
            "position step",
            f"centre of mass moved in these steps {says}",
            lambda account, _, fall=fall: falls(account, fall),
        )
