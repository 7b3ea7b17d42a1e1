"""Mistakes of a step: the Euler methods, each by the size, sign and shape of the drift that it leaves."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from compare.grade.hypotheses import STEPS, Hypothesis, Question, grid
from compare.grade.stepping import EXPLICIT, EXPONENTIAL, IMPLICIT, MATRIX, MOMENTUM, QUATERNION, Scheme

# A flight of more steps than this takes longer than it is worth.
MOST_STEPS = 10_000
# Values tried first, and how much shorter than the longest the shortest is.
TRIED, RANGE = 7, 200
PLAIN, KEPT, IMPLICITLY = "", ", the angular momentum kept", ", the gyroscopic term implicit"


def steps(question: Question) -> Iterator[Hypothesis]:
    """Yield explicit and symplectic Euler as engines and students write them, and what they forget besides.

    With the angular momentum kept L is constant between impulses; otherwise w is stepped by Euler's equations, as in
    PyBullet's default body and in MuJoCo's Euler, or with their implicit gyroscopic term.
    """
    equal = np.ptp(question.account.moments) == 0
    explicit, symplectic = "explicit Euler with a step of {} s", "symplectic Euler with a step of {} s"
    yield _euler(question, "explicit Euler", explicit, QUATERNION, EXPLICIT)
    yield _euler(question, "symplectic Euler", symplectic, EXPONENTIAL, EXPLICIT)
    if not equal:
        yield _euler(question, "explicit Euler", explicit + KEPT, QUATERNION, MOMENTUM)
        yield _euler(question, "symplectic Euler", symplectic + KEPT, EXPONENTIAL, MOMENTUM)
        yield _euler(question, "symplectic Euler", symplectic + IMPLICITLY, EXPONENTIAL, IMPLICIT)
    never = f"{explicit}, the quaternion never normalised"
    yield _euler(question, "not normalised", never, QUATERNION, EXPLICIT, lengthens=True)
    if question.kind != "pose":
        shears = "explicit Euler on the rotation matrix with a step of {} s: the shape is not rigid"
        yield _euler(question, "matrix Euler", shears, MATRIX, MOMENTUM)


def _euler(question: Question, name: str, says: str, attitude: int, spin: int, lengthens: bool = False) -> Hypothesis:
    longest = min(0.1 * question.duration, 0.5 * question.turn_s)
    shortest = max(longest / RANGE, question.duration / MOST_STEPS)
    return Hypothesis(
        name,
        "steps",
        says,
        lambda account, step: replace(account, scheme=Scheme(step, attitude, spin, attitude == EXPONENTIAL, lengthens)),
        grid(min(shortest, longest / 2), longest, TRIED),
        known={step: used for step, used in STEPS.items() if shortest < step < 2 * longest},
    )
