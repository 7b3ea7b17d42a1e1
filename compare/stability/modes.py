"""The stiffest mode of a scene: the one that limits the step.

A scene is linearised about a state: twelve numbers, the shift x [m] and velocity v [m/s] in world axes, the small turn
phi [rad] and the angular velocity w [rad/s] in body axes,

    x' = v,   phi' = w - w0 x phi,   m v' = F,   I w' = tau + (I w) x w,

with forces and torques differentiated numerically.  The mode with the largest eigenvalue is the one that limits a step.
"""

import math
from dataclasses import dataclass

import numpy as np

from tumble.scenarios.frames import Array, cross_matrix, quaternion_product, rotation_matrix
from tumble.scenarios.impulse import jump
from tumble.scenarios.scene import Scene

DIFFERENCE = math.sqrt(np.finfo(float).eps)  # of the body's size, of a radian, and of as much in a second


@dataclass(frozen=True)
class Mode:
    """The stiffest mode, u'' + damping u' + stiffness u = 0 [1/s, 1/s2]; rate [rad/s]: its largest |eigenvalue|."""

    rate: float
    damping: float = 0.0
    stiffness: float = 0.0


def start_after_impulses(scene: Scene) -> Array:
    """Return the state of the first throw after the impulses of t = 0, (1, 13)."""
    states = scene.start[:1]
    for impulse in scene.impulses:
        if impulse.time == 0.0:
            states = jump(impulse, states, scene.body)
    return states


def stiffest_mode(scene: Scene) -> Mode:
    """Return the mode of the largest |eigenvalue| at the start of the first throw, of rate 0 where there is none."""
    matrix = linearised(scene, start_after_impulses(scene)[0])
    eigenvalues, vectors = np.linalg.eig(matrix)
    largest = int(np.argmax(np.abs(eigenvalues)))
    if scene.is_free:
        return Mode(float(abs(eigenvalues[largest])))
    u = vectors[:6, largest]
    weighted = u.conj() * np.repeat((scene.body.mass, *scene.body.moments), (3, 1, 1, 1))
    stiffness, damping = (-weighted @ block @ u / (weighted @ u) for block in (matrix[6:, :6], matrix[6:, 6:]))
    return Mode(float(abs(eigenvalues[largest])), max(0.0, float(damping.real)), max(0.0, float(stiffness.real)))


def linearised(scene: Scene, state: Array) -> Array:
    """Return the matrix A of y' = A y, y = (x, phi, v, w), (12, 12), at one state, (13,)."""
    moments, axes = scene.body.moments, rotation_matrix(state[3:7])
    w_body = axes.T @ state[10:13]
    matrix = np.zeros((12, 12))
    matrix[0:3, 6:9] = matrix[3:6, 9:12] = np.eye(3)
    matrix[3:6, 3:6] = -cross_matrix(w_body)
    matrix[9:12, 9:12] = (cross_matrix(moments * w_body) - cross_matrix(w_body) * moments) / moments[:, None]
    if not scene.is_free:
        matrix[6:12] += pulled(scene, state, axes)
    return matrix


def pulled(scene: Scene, state: Array, axes: Array) -> Array:
    """Return the derivatives of the accelerations that forces give, (6, 12), by central differences."""
    from tumble.scenarios.wrench import wrench  # it loads a compiler, which a free scene does not need

    size = scene.body.reach
    steps = DIFFERENCE * np.repeat((size, 1.0, size, 1.0), 3)
    sides = [moved(state, axes, sign * np.diag(steps)) for sign in (1.0, -1.0)]
    ahead, behind = map(wrench(scene), sides)
    # The torque is needed in the axes of the rotated body, R exp(phi~).
    for wrenches, states in zip((ahead, behind), sides, strict=True):
        wrenches[:, 3:6] = np.einsum("nji,nj->ni", rotation_matrix(states[:, 3:7]), wrenches[:, 3:6])
    inertia = np.repeat((scene.body.mass, *scene.body.moments), (3, 1, 1, 1))
    return ((ahead - behind) / (2 * steps[:, None]) / inertia).T


def moved(state: Array, axes: Array, changes: Array) -> Array:
    """Return a state, (13,), moved by each of n small x, phi, v and w, (n, 12); (n, 13)."""
    x, turn, v, w_body = np.split(changes, 4, axis=1)
    turns = np.hstack((np.ones((len(changes), 1)), turn / 2))
    q = quaternion_product(state[3:7], turns / np.linalg.norm(turns, axis=1, keepdims=True))
    w = np.einsum("nij,nj->ni", rotation_matrix(q), axes.T @ state[10:13] + w_body)
    return np.hstack((state[0:3] + x, q, state[7:10] + v, w))
