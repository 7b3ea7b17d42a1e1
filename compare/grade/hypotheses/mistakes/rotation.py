"""Mistakes with inertia, with Euler's equations, and with what the angular velocity means."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import permutations

import numpy as np

from tumble.compare.grade.hypotheses.hypothesis import Hypothesis, Question, choice, grid
from tumble.compare.grade.model.kernel.dynamics import (
    FROZEN,
    MIXED_BODY,
    MIXED_MOMENTUM,
    MIXED_WORLD,
    NEVER_TURNED,
    TURNED_BACK,
)
from tumble.compare.grade.model.program_model import Account
from tumble.scenarios.frames import rotation_matrix

DEGREE = np.pi / 180
# Inertia that is so much larger or smaller than it should be is rare.
FAR = 31.6


def rotation(question: Question) -> Iterator[Hypothesis]:
    """Yield what is wrong with how the body turns."""
    account = question.account
    if account.impulses:
        yield from _inertia_size()
    if np.ptp(account.moments) > 0:
        yield from _unequal_moments(question)
    yield from _frames(question)
    yield from _turning()
    if account.start[10:13].any():
        yield from _start_spin(account)


def _inertia_size() -> Iterator[Hypothesis]:
    """Yield what shows only where something strikes the body: free rotation does not depend on the size of inertia."""
    # Far ones are tried alone and on top of others only: a body that spins a thousand times as fast takes long to fly.
    far = (*grid(1e-3, 1 / FAR, 16), *grid(FAR, 1e3, 16))
    for values, is_far in ((grid(1 / FAR, FAR, 31), False), (far, True)):
        yield Hypothesis(
            "another inertia",
            "inertia size",
            "inertia {} times what it is",
            lambda account, factor: replace(account, moments=factor * account.moments),
            values,
            known={} if is_far else {0.25: "half edges taken for edges", 4.0: "edges taken for half edges"},
            rare=is_far,
            variant=is_far,
        )


def _turning() -> Iterator[Hypothesis]:
    """Yield that the attitude turns faster or slower than the angular velocity says."""
    for name, says, factor in (
        ("half of q' missing", "attitude turned twice as fast: q' = w q without the half", 2.0),
        ("half of q' twice", "attitude turned half as fast: q' = w q / 4", 0.5),
    ):
        yield Hypothesis(
            name, "turning", says, lambda account, _, factor=factor: replace(account, turning=factor), rare=True
        )


def _frames(question: Question) -> Iterator[Hypothesis]:
    """Yield that w is in other axes than those the attitude is turned in; what is kept, w or L, makes a difference."""
    world = "attitude turned with Q w~ where w is in world axes: it must be w~ Q"
    body = "attitude turned with w~ Q where w is in body axes: it must be Q w~"
    variants = [(world, MIXED_MOMENTUM), (body, MIXED_BODY)]
    if np.ptp(question.account.moments) > 0:
        variants.append((f"{world} (w by Euler's equations)", MIXED_WORLD))
    for says, mixed in variants:
        yield Hypothesis(
            "angular velocity in the wrong frame",
            "frame",
            says,
            lambda account, _, mixed=mixed: replace(account, mixed=mixed),
        )


def _unequal_moments(question: Question) -> Iterator[Hypothesis]:
    account, moments = question.account, question.account.moments
    yield Hypothesis(
        "inertia of a sphere",
        "inertia",
        "inertia of a sphere: three equal moments, their mean",
        lambda account, _: replace(account, moments=np.full(3, account.moments.mean())),
    )
    orders = [order for order in permutations(range(3)) if (moments[list(order)] != moments).any()]
    yield Hypothesis(
        "inertia of permuted axes",
        "inertia",
        "moments of inertia given to the wrong axes: x y z have those of {}",
        lambda account, number: replace(account, moments=account.moments[list(orders[int(number)])]),
        choice(len(orders)),
        tuple(" ".join("xyz"[axis] for axis in order) for order in orders),
    )
    for name, says, tensor in (
        (
            "inertia never turned",
            "inertia tensor never turned with the body: Euler's equations in world axes",
            NEVER_TURNED,
        ),
        ("inertia frozen at the start", "inertia tensor in world axes kept as it was at the start", FROZEN),
        ("inertia turned the wrong way", "inertia tensor turned the wrong way: R^T I R", TURNED_BACK),
    ):
        yield Hypothesis(
            name,
            "inertia axes",
            says,
            lambda account, _, tensor=tensor: replace(account, tensor=tensor, struck=tensor),
            rare=True,
        )
    if account.impulses:
        for name, says, tensor in (
            ("inertia not turned in the impulse", "not turned with the body", NEVER_TURNED),
            ("inertia frozen in the impulse", "as it was at the start", FROZEN),
            ("inertia turned the wrong way in the impulse", "turned the wrong way, R^T I R,", TURNED_BACK),
        ):
            yield Hypothesis(
                name,
                "inertia axes",
                f"inertia tensor {says} where an impulse acts",
                lambda account, _, tensor=tensor: replace(account, struck=tensor),
                rare=True,
            )
    yield Hypothesis(
        "inverse for inertia",
        "inertia",
        "inertia and its inverse taken for one another",
        lambda account, _: replace(account, moments=1.0 / account.moments),
        rare=True,
    )
    yield Hypothesis(
        "gyroscopic term missing",
        "gyroscopic",
        "gyroscopic term missing: the angular velocity keeps still",
        lambda account, _: replace(account, gyroscopic=0.0),
    )
    yield Hypothesis(
        "gyroscopic term reversed",
        "gyroscopic",
        "gyroscopic term of the wrong sign",
        lambda account, _: replace(account, gyroscopic=-1.0),
    )


def _start_spin(account: Account) -> Iterator[Hypothesis]:
    if (_in_body(account, 0.0).start != account.start).any():
        yield Hypothesis(
            "start's spin in body axes", "spin", "angular velocity of the start taken in body axes", _in_body
        )
    for name, says, factor in (
        ("degrees for radians", "angular velocity of the start, in rad/s, taken for degrees", DEGREE),
        ("radians for degrees", "angular velocity of the start turned into degrees: 57 times too fast", 1 / DEGREE),
    ):
        yield Hypothesis(name, "spin", says, lambda account, _, factor=factor: _spun(account, factor))


def _in_body(account: Account, _: float) -> Account:
    start = account.start.copy()
    start[10:13] = rotation_matrix(start[3:7]) @ start[10:13]
    return replace(account, start=start)


def _spun(account: Account, factor: float) -> Account:
    start = account.start.copy()
    start[10:13] *= factor
    return replace(account, start=start)
