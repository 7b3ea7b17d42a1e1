"""Checks of a free body's motion: it turns about its axes, and half the step comes nearer.

A failure names the mistake that leads to where the body is.
"""

import math
from collections.abc import Callable, Iterator
from itertools import pairwise
from types import ModuleType
from typing import Any

import numpy as np

from tumble.compare.engines import EULER
from tumble.compare.run.contestant import MethodName
from tumble.compare.run.engines.brick import MOMENTS, THROWS, Broken, by_other_roundings, flown, rounding
from tumble.compare.run.engines.free_body import MISREADINGS, moved, to_world
from tumble.scenarios.frames import Array, quaternion_product, turned_by

# A spin about each principal axis [rad/s], and the step of it [s]; its time is 1 s.
SPINS, SPIN_STEP = np.array([2.3, -1.9, 3.1]), 1 / 256
# A tumbling flight's time [s] and its numbers of steps; an order is read from errors below the largest [rad], where
# higher orders are not seen, and so many times what rounding leaves.
TUMBLE_S, HALVED, LARGEST, CLEAR = 1.0, [2**k for k in range(1, 11)], 0.1, 100.0
# An order is within this of what is stated; an error that falls at all falls as the step.
ORDER_WITHIN, LEAST_ORDER = 0.3, 0.7
# What a method that chooses its own steps is asked to keep to, and how near one comes that takes none.
TOLERANCES, WITHOUT_STEPS = (1e-3, 1e-5, 1e-7), 1e-6
# A mistake explains a motion if it leaves this much of its error.
EXPLAINED = 0.05


def spins_steadily(engine: ModuleType, method: str) -> None:
    """A spin about a principal axis goes on, and the attitude turns about it."""
    start = THROWS.copy()
    start[:, 10:13] = to_world(start[:, 3:7], np.diag(SPINS))
    states = flown(engine, method, start, (round(1 / SPIN_STEP), SPIN_STEP))
    half = start[:, 10:13] / 2
    turn = np.hstack((np.cos(np.abs(SPINS) / 2)[:, np.newaxis], np.sinc(SPINS / 2 / np.pi)[:, np.newaxis] * half))
    expected = quaternion_product(turn, start[:, 3:7])
    # A method of order one is off by a step's turn of what it turns, once by its spin and once by its attitude.
    within = 2 * np.abs(SPINS) * SPIN_STEP * np.abs(SPINS) + by_other_roundings(engine, method)
    off = turned_apart(states, expected)
    spun = np.linalg.norm(states[:, 10:13] - start[:, 10:13], axis=1)
    for axis in range(3):
        if not off[axis] <= within[axis]:
            raise Broken(
                f"1 s of {SPINS[axis]:g} rad/s about principal axis {axis} ends {off[axis]:.2g} rad away from where "
                f"that leads{misread(states, start, 1.0)}"
            )
        if not spun[axis] <= within[axis]:
            raise Broken(
                f"{SPINS[axis]:g} rad/s about principal axis {axis} alone have become "
                f"{np.round(states[axis, 10:13], 4).tolist()} rad/s after 1 s, and were "
                f"{np.round(start[axis, 10:13], 4).tolist()}{misread(states, start, 1.0)}"
            )


def turned_apart(states: Array, expected: Array) -> Array:
    """Return by how much attitudes of states and quaternions differ [rad], (N,); inf of what is no attitude."""
    q = states[:, 3:7] / np.linalg.norm(states[:, 3:7], axis=1, keepdims=True)
    angles = np.linalg.norm(turned_by(expected, q), axis=1)
    return np.where(np.isfinite(angles), angles, np.inf)


def misread(states: Array, start: Array, time: float) -> str:
    """Return the mistake that leads where an engine's free bodies are after a time [s], '' where none of them does."""
    right = turned_apart(states, moved(start[:, 3:7], start[:, 10:13], MOMENTS, time)[0]).max()
    for mistake in MISREADINGS:
        led, _ = mistake.moved(start[:, 3:7], start[:, 10:13], MOMENTS, time)
        if turned_apart(states, led).max() < EXPLAINED * right:
            return f": {mistake.words}"
    return ""


def comes_nearer_with_the_step(engine: ModuleType, method: str) -> None:
    """Half the step, smaller error: the motion of a free body, to the order that is stated."""
    plain = str(MethodName.parse(method).without_tolerance)
    if stated(engine, "GYROSCOPIC", method) == "none":
        raise NotImplementedError("it states that it leaves the gyroscopic torque out")
    expected, _ = moved(THROWS[:, 3:7], THROWS[:, 10:13], MOMENTS, TUMBLE_S)

    def error(asked: str, n: int) -> tuple[float, Array]:
        states = flown(engine, asked, THROWS, (n, TUMBLE_S / n))
        return float(turned_apart(states, expected).max()), states

    if plain in getattr(engine, "WHOLE", ()):
        demand_near(*error(method, 1), max(WITHOUT_STEPS, CLEAR * rounding(engine)), "in one step")
    elif plain in getattr(engine, "ADAPTIVE", ()):
        off = [error(f"{plain}@{tolerance:g}", 1) for tolerance in TOLERANCES]
        demand_near(*off[-1], max(off[0][0] / 10, CLEAR * TOLERANCES[-1]), f"at a tolerance of {TOLERANCES[-1]:g}")
    else:
        demand_order(lambda n: error(method, n), rounding(engine), stated_order(engine, method))


def demand_near(off: float, states: Array, within: float, how: str) -> None:
    """Raise Broken where a tumbling flight ends further from where it leads than that [rad]."""
    if not off <= within:
        raise Broken(
            f"{how} a tumbling brick is {off:.2g} rad off after {TUMBLE_S:g} s{misread(states, THROWS, TUMBLE_S)}"
        )


def demand_order(error: Callable[[int], tuple[float, Array]], eps: float, stated: float | None) -> None:
    """Raise Broken where errors [rad] of n steps do not fall with the step, or not to the order that is stated."""
    errors, states = [], THROWS
    for n in HALVED:
        off, states = error(n)
        errors.append(off)
        if off < CLEAR * eps * n:
            break
    n = HALVED[len(errors) - 1]
    slopes = [*orders(errors, eps)]
    if not slopes and errors[-1] < CLEAR * eps * n:
        return  # it has hardly an error to fall
    order = slopes[-1] if slopes else 0.0
    if order < LEAST_ORDER:
        raise Broken(
            f"half the step leaves the error of a tumbling brick as it is: {errors[-2]:.2g} rad with {n // 2} steps in "
            f"{TUMBLE_S:g} s, {errors[-1]:.2g} rad with {n}{misread(states, THROWS, TUMBLE_S)}"
        )
    # One halving from large steps to rounding may show more than the order, which is that of small steps.
    most = math.inf if len(slopes) == 1 else ORDER_WITHIN
    if stated is not None and not -ORDER_WITHIN <= order - stated <= most:
        raise Broken(f"the error of a tumbling brick falls by order {order:.2f}, and {stated:g} is stated")


def orders(errors: list[float], eps: float) -> Iterator[float]:
    """Yield the orders by which errors of halved steps fall, from small errors that are clear of rounding."""
    for (coarse, fine), n in zip(pairwise(errors), HALVED[1:], strict=False):
        if coarse <= LARGEST and fine >= CLEAR * eps * n:
            yield math.log2(coarse / fine)


def stated_order(engine: ModuleType, method: str) -> float | None:
    """Return the order that an engine states of a method, also by its gyroscopic torque, None where it does not."""
    return stated(engine, "ORDERS", method) or EULER.get(stated(engine, "GYROSCOPIC", method))


def stated(engine: ModuleType, table: str, method: str) -> Any:
    """Return what an engine's table has of a method, or of the one that it is where no force is held, or None."""
    found = getattr(engine, table, {})
    return found.get(method, found.get(method.removesuffix("+held")))
