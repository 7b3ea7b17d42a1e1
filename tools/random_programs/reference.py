"""The motion of a scene to twelve digits: scipy's DOP853 on Euler's equations in body axes, from impulse to impulse."""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from tools.random_programs.scene import Impulse, Scene
from tools.random_programs.simulation import Rows

RELATIVE, ABSOLUTE = 1e-12, 1e-13


def reference(scene: Scene, instants: np.ndarray) -> Rows:
    """Return the rows of a right program at instants [s] that increase; one at an impulse's is after it."""
    inverse = np.linalg.inv(scene.inertia)
    state = np.concatenate((scene.x, scene.q, scene.v, _axes(scene.q).T @ scene.w))
    stops = sorted(scene.impulses, key=lambda impulse: impulse.time)
    found, now = np.empty((len(instants), 13)), 0.0
    begin = 0
    for impulse in (*stops, None):
        end = np.inf if impulse is None else impulse.time
        row = len(instants) if impulse is None else int(np.searchsorted(instants, end))
        wanted = np.append(instants[begin:row], () if impulse is None else (end,))
        if len(wanted):
            states = _integrated(scene, inverse, state, now, wanted)
            found[begin:row] = states[: row - begin]
            state, now = states[-1], float(wanted[-1])
        if impulse is not None:
            state = _struck(scene, inverse, state, impulse)
        begin = row
    q = found[:, 3:7] / np.linalg.norm(found[:, 3:7], axis=1)[:, None]
    rotation = Rotation.from_quat(q, scalar_first=True)
    return Rows(instants, found[:, :3], q, found[:, 7:10], rotation.apply(found[:, 10:]), scene.points)


def _integrated(scene: Scene, inverse: np.ndarray, state: np.ndarray, now: float, wanted: np.ndarray) -> np.ndarray:
    """Return states at instants, (n, 13)."""
    later = wanted > now
    states = np.tile(state, (len(wanted), 1))
    if later.any():
        done = solve_ivp(
            lambda _, y: _slope(scene, inverse, y),
            (now, float(wanted[-1])),
            state,
            "DOP853",
            wanted[later],
            rtol=RELATIVE,
            atol=ABSOLUTE,
            max_step=0.02,
        )
        states[later] = done.y.T
    return states


def _slope(scene: Scene, inverse: np.ndarray, y: np.ndarray) -> np.ndarray:
    q, v, w = y[3:7], y[7:10], y[10:13]
    force, torque = scene.mass * scene.gravity - scene.drag[0] * v, -scene.drag[1] * w
    if scene.tethers:
        axes = _axes(q)
        for tether in scene.tethers:
            place = scene.points[tether.vertex]
            away = y[:3] + axes @ place - tether.anchor
            moves = v + axes @ np.cross(w, place)
            if tether.rest_length:
                size = np.linalg.norm(away)
                unit = away / size
                pull = -(tether.stiffness * (size - tether.rest_length) + tether.damping * (moves @ unit)) * unit
            else:
                pull = -tether.stiffness * away - tether.damping * moves
            force, torque = force + pull, torque + np.cross(place, axes.T @ pull)
    a, b, c, d = q
    p, r, s = w
    turns = 0.5 * np.array(
        (-b * p - c * r - d * s, a * p + c * s - d * r, a * r + d * p - b * s, a * s + b * r - c * p)
    )
    momentum = scene.inertia @ w
    spins = inverse @ (torque - np.cross(w, momentum))
    return np.concatenate((v, turns, force / scene.mass, spins))


def _struck(scene: Scene, inverse: np.ndarray, state: np.ndarray, impulse: Impulse) -> np.ndarray:
    axes = _axes(state[3:7])
    place = scene.body_point(impulse)
    if place is None:
        place = axes.T @ (impulse.point - state[:3])
    after = state.copy()
    after[7:10] += impulse.value / scene.mass
    after[10:13] += inverse @ np.cross(place, axes.T @ impulse.value)
    return after


def _axes(q: np.ndarray) -> np.ndarray:
    return Rotation.from_quat(q, scalar_first=True).as_matrix()
