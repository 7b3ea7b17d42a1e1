"""With which angular velocity a body began, where another one than the scene's makes all of its attitudes."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from compare.grade.account import FINE, SEARCHING, Account
from compare.grade.offset import LEFT, MUCH
from compare.grade.residual import Kept
from scenarios.frames import Array

SPIN = slice(10, 13)
# The earliest rows, which are fitted first, and so many times as many in each round.
FIRST, MORE = 4, 3
ROUNDS = 6
# Of the spin, or of 1 rad/s where it is less: how far beside it another is tried, and a change that is none.
BESIDE = 1e-6
# Rows that are fitted: three numbers want no more.
ROWS = 48


def another_spin(account: Account, kept: Kept, points: Array, floors_m: Array) -> Array | None:
    """Return the w at the start, world axes [rad/s], (3,), that leaves nothing of how the body is turned, if one does.

    points: the vertices seen [m], (K, 3); floors_m: of each row's axes, (S, 3).
    """
    if len(points) < 4 or len(kept) < 2 * FIRST:
        return None
    some = np.unique(np.linspace(0, len(kept) - 1, ROWS).round().astype(int))
    rows = kept.some(np.union1d(some, np.arange(FIRST)))
    seen, floor = _turned(rows.vertices), float(np.median(floors_m))
    if np.abs(seen - _turned(rows.true)).max() < MUCH * floor:
        return None

    def left(spin: Array, count: int, fineness: float) -> Array:
        start = np.concatenate((account.start[: SPIN.start], spin, account.start[SPIN.stop :]))
        pose = replace(account, start=start).written(rows.times[:count], fineness)
        return (seen[:count] - _turned(np.einsum("tij,kj->tki", pose.axes, points))).ravel()

    spin, count = account.start[SPIN].copy(), FIRST
    while True:
        fineness = FINE if count == len(rows) else SEARCHING
        with np.errstate(all="ignore"):
            found = _descended(lambda tried, count=count, fineness=fineness: left(tried, count, fineness), spin)
        if found is None:
            return None
        spin = found
        if count == len(rows):
            break
        count = min(MORE * count, len(rows))
    return spin if np.sqrt(np.mean(left(spin, len(rows), FINE) ** 2)) < LEFT * floor else None


def _turned(places: Array) -> Array:
    """Return points about their middle [m]."""
    return places - places.mean(axis=1, keepdims=True)


def _descended(left: Callable[[Array], Array], spin: Array) -> Array | None:
    """Return the spin that leaves the least squares, by the method of Gauss and Newton; None where it goes nowhere."""
    for _ in range(ROUNDS):
        off = left(spin)
        beside = BESIDE * max(float(np.linalg.norm(spin)), 1.0)
        slopes = np.stack([(left(spin + beside * axis) - off) / beside for axis in np.eye(3)], axis=1)
        if not (np.isfinite(slopes).all() and np.isfinite(off).all()):
            return None
        change = np.linalg.lstsq(slopes, off, rcond=None)[0]
        spin = spin - change
        if np.linalg.norm(change) <= BESIDE * np.linalg.norm(spin):
            break
    return spin
