"""The flights of all throws, by as many threads as there are cores, and the proof of them on a sample."""

import os
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from tumble.scenarios.frames import Array
from tumble.scenarios.scene import Scene
from tumble.scenarios.truth.bulk.bodies import bodies, readings
from tumble.scenarios.truth.bulk.kernel import STATE, Bodies, Inputs, throws
from tumble.scenarios.truth.rational import Fraction
from tumble.scenarios.truth.resolution import PATTERNS, SHARES, rounding, settle
from tumble.scenarios.truth.rotation import exact
from tumble.scenarios.truth.throw import read_throw

# Digits of the principal axes, four times those of the flights; and vertices that a thread takes at a time.
BITS, AT_A_TIME = 424, 2**18
# The error of 32 digits over what the inputs' last bits do, which are 53 bits coarser than theirs: 2^-47 was the most
# seen, of brick, needle and near-symmetric bodies, near the axes and the separatrix, for 1 to 1e9 radians.
SHARE_OF_FLOOR = 2.0**-36
# How many throws, or instants, are drawn to be worked out again with as many digits as it takes, besides the most
# delicate one; and at how many instants of each throw.
SAMPLE, INSTANTS = 16, 4


class Flights(NamedTuple):
    """states (R, N, 13), vertices [m], (R, N, n, 3), bound and floor [m], (R, N): nan where 32 digits do not do."""

    states: Array
    vertices: Array
    bound: Array
    input_error: Array


def all_flights(mp: Any, scene: Scene, on_share: Callable[[float], object] = lambda share: None) -> Flights | None:
    """Return the flights of a free scene without blows; None where one of the sample is not what its error says.

    mp: mpmath context, whose precision is set here; tell: is told what share of them is done.
    """
    mp.prec = BITS
    times = np.array((scene.rows, np.zeros(len(scene.rows))))[..., np.newaxis]
    inputs = signed(bodies(mp, readings(replace(scene, times=scene.times[-1:]), 0), times))
    rows, count, points = len(scene.rows), len(scene.start), len(scene.body.points)
    at_a_time = max(1, AT_A_TIME // (rows * points))
    flights = Flights(
        np.empty((rows, count, STATE)), np.empty((rows, count, points, 3)), *np.empty((2, rows, count))
    )  # fmt: skip

    def work_out(first: int) -> int:
        part = slice(first, first + at_a_time)
        (vertices, _), states, input_error = simulate(as_written(scene.start[part]), inputs)
        input_error[:, ~np.isfinite(vertices.sum(axis=(0, 2, 3)) + states.sum(axis=(0, 2)))] = np.nan
        bound = SHARE_OF_FLOOR * input_error + rounding(vertices)
        for every, own in zip(flights, (states, vertices, bound, input_error), strict=True):
            every[:, part] = own
        return min(first + at_a_time, count)

    with ThreadPoolExecutor(os.cpu_count()) as threads:
        # No more wait in line than are at work: whoever interrupts this process waits for these alone.
        underway: deque[Future[int]] = deque()
        for first in range(0, count, at_a_time):
            underway.append(threads.submit(work_out, first))
            if len(underway) > (os.cpu_count() or 1):
                on_share(underway.popleft().result() / count)
        for part in underway:
            on_share(part.result() / count)
    return flights if proven(mp, scene, inputs, drawn(flights.input_error)) else None


def proven(mp: Any, scene: Scene, inputs: Inputs, sample: np.ndarray) -> bool:
    """Return whether the errors of some throws are what they are said to be, at some instants, the last among them."""
    rows = len(scene.rows)
    some = np.random.default_rng(rows).choice(rows, min(INSTANTS, rows), replace=False)
    instants = np.union1d(some, (0, rows - 1))
    brief = replace(scene, times=scene.rows[instants])
    body = inputs.bodies._replace(times=np.ascontiguousarray(inputs.bodies.times[..., instants, :]))
    vertices, _, input_error = simulate(as_written(scene.start[sample]), inputs._replace(bodies=body))
    return all(
        (off_by(mp, brief, int(row), vertices[:, :, place]) <= SHARE_OF_FLOOR * input_error[:, place]).all()
        for place, row in enumerate(sample)
    )


def signed(body: Bodies) -> Inputs:
    """Return the inputs of throws whose starts are changed by signs of their own."""
    signs = [np.random.default_rng(pattern).choice((-1.0, 1.0), STATE) for pattern in range(PATTERNS)]
    return Inputs(body, np.array(SHARES), np.array(signs), np.empty((0, 0, STATE)))


def simulate(starts: Array, inputs: Inputs) -> tuple[Array, Array, Array]:
    """Return vertices as pairs, (2, R, N, n, 3), states, (R, N, 13), and floor, (R, N), of starts, (N, 2, STATE)."""
    rows, points = inputs.bodies.times.shape[-2], inputs.bodies.points.shape[-2]
    vertices, states = np.empty((2, rows, len(starts), points, 3)), np.empty((rows, len(starts), STATE))
    input_error = np.empty((rows, len(starts)))
    throws(starts, inputs, vertices, states, input_error)
    return vertices, states, input_error


def as_written(starts: Array) -> Array:
    """Return starts in doubles, (N, STATE), as pairs, (N, 2, STATE)."""
    return np.stack((starts, np.zeros_like(starts)), axis=1)


def drawn(input_error: Array) -> np.ndarray:
    """Return a sample of throws, (R, N), that are known: some by chance, and the one that its inputs move most."""
    known = np.flatnonzero(np.isfinite(input_error).all(axis=0))
    if not len(known):
        return known
    some = np.random.default_rng(len(known)).choice(known, min(SAMPLE, len(known)), replace=False)
    return np.union1d(some, known[[input_error[:, known].max(axis=0).argmax()]])


def off_by(mp: Any, scene: Scene, row: int, vertices: Array) -> Array:
    """Return how far vertices that are told as pairs, (2, R, n, 3), are from the many-digit closed form's [m], (R,)."""
    throw = read_throw(scene, row)
    _, finer = settle(mp, throw)
    off = np.empty(vertices.shape[1:])
    for instant, pose in enumerate(finer.poses):
        for vertex, point in enumerate(throw.points):
            for axis, true in enumerate(pose.x + pose.axes @ point):
                high, low = vertices[:, instant, vertex, axis].tolist()
                off[instant, vertex, axis] = float(exact(true) - Fraction(high) - Fraction(low))
    return np.linalg.norm(off, axis=-1).max(axis=-1)
