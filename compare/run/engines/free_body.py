"""The motion of a free body, by nothing but numpy: what an engine's own motion is compared with in its process.

Euler's equations and the attitude's, extrapolated to order 16; also as programs get them wrong.
Source: Gragg, "On extrapolation algorithms for ordinary initial value problems" (1965); Hairer, Norsett, Wanner,
"Solving Ordinary Differential Equations I", II.9, eqs. (9.10) and (9.13).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tumble.scenarios.frames import Array, quaternion_product, rotation_matrix

# Steps of the midpoint rule that are extrapolated from, and how far a body turns in one extrapolation [rad].
HALVES, TURN = range(2, 18, 2), 0.5
CONJUGATE = np.array([1.0, -1.0, -1.0, -1.0])


def moved(q: Array, w: Array, moments: Array, time: float, gyroscopic: float = 1.0) -> tuple[Array, Array]:
    """Return attitude and angular velocity of free bodies after a time [s], to some 1e-13.

    q: body to world, (N, 4); w [rad/s], world axes, (N, 3); moments [kg m2], (3,); gyroscopic: what (I w) x w is
    multiplied by, which is 1 in physics.
    """
    state = np.hstack((q, to_body(q, w)))
    count = int(np.ceil(time * np.linalg.norm(w, axis=1).max(initial=1.0) / TURN))
    for _ in range(count):
        state = extrapolated(lambda y: slope(y, moments, gyroscopic), state, time / count)
        state[:, :4] /= np.linalg.norm(state[:, :4], axis=1, keepdims=True)
    return state[:, :4], to_world(state[:, :4], state[:, 4:])


def slope(state: Array, moments: Array, gyroscopic: float) -> Array:
    """Return the rate of attitude and of angular velocity in body axes, (N, 7): q' = q w / 2, I w' = (I w) x w."""
    q, w = state[:, :4], state[:, 4:]
    spin = np.hstack((np.zeros((len(w), 1)), w))
    return np.hstack((quaternion_product(q, spin) / 2, gyroscopic * np.cross(moments * w, w) / moments))


def extrapolated(rate: Callable[[Array], Array], start: Array, step: float) -> Array:
    """Return the state after a step: midpoint rules of more and more substeps, extrapolated to none."""
    table: list[Array] = []
    for number, count in enumerate(HALVES):
        h = step / count
        before, now = start, start + h * rate(start)
        for _ in range(count - 1):
            before, now = now, before + 2 * h * rate(now)
        row = [now]
        for back in range(1, number + 1):
            ratio = (count / HALVES[number - back]) ** 2 - 1
            row.append(row[-1] + (row[-1] - table[back - 1]) / ratio)
        table = row
    return table[-1]


@dataclass(frozen=True)
class Misreading:
    """What a program takes attitude and angular velocity for, how it writes them again, and its gyroscopic term."""

    words: str
    taken: Callable[[Array, Array], tuple[Array, Array]] = lambda q, w: (q, w)
    written: Callable[[Array, Array], tuple[Array, Array]] = lambda q, w: (q, w)
    gyroscopic: float = 1.0

    def moved(self, q: Array, w: Array, moments: Array, time: float) -> tuple[Array, Array]:
        """Return what such a program makes of free bodies after a time [s]."""
        return self.written(*moved(*self.taken(q, w), moments, time, self.gyroscopic))


def to_world(q: Array, w: Array) -> Array:
    """Return vectors in the world's axes, of those in the body's, (N, 3)."""
    return np.einsum("nij,nj->ni", rotation_matrix(q), w)


def to_body(q: Array, w: Array) -> Array:
    """Return vectors in the body's axes, of those in the world's, (N, 3)."""
    return np.einsum("nji,nj->ni", rotation_matrix(q), w)


MISREADINGS = (
    Misreading(
        "its quaternions are x y z w, and must be w x y z",
        lambda q, w: (np.roll(q, 1, axis=1), w),
        lambda q, w: (np.roll(q, -1, axis=1), w),
    ),
    Misreading(
        "its quaternions lead from world to body, and must lead from body to world",
        lambda q, w: (q * CONJUGATE, w),
        lambda q, w: (q * CONJUGATE, w),
    ),
    Misreading(
        "its angular velocity is in body axes, and must be in world axes",
        lambda q, w: (q, to_world(q, w)),
        lambda q, w: (q, to_body(q, w)),
    ),
    Misreading("its gyroscopic torque has the wrong sign: I w' = (I w) x w in body axes", gyroscopic=-1.0),
    Misreading("it has no gyroscopic torque: I w' = (I w) x w in body axes", gyroscopic=0.0),
)
