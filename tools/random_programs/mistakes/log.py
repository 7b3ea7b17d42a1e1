"""Mistakes with what is written down of a body that moves as it should."""

from dataclasses import replace

import numpy as np

from tools.random_programs.algebra import matrices, quaternions
from tools.random_programs.mistakes.kind import even, falls, is_turned, mistake, moves, one_of, spins
from tools.random_programs.mistakes.start import SWAPS
from tools.random_programs.scene import Scene
from tools.random_programs.scheme import Scheme
from tools.random_programs.simulation import Rows, Simulation

UNITS = {"cm for m": 100.0, "mm for m": 1000.0, "feet for m": 1 / 0.3048}


def _box(scene: Scene, scheme: Scheme) -> bool:
    return scene.size is not None


def _turns(scene: Scene, scheme: Scheme) -> bool:
    return spins(scene, scheme) or is_turned(scene, scheme) or bool(scene.impulses)


def _runs(scene: Scene, scheme: Scheme) -> bool:
    return moves(scene, scheme) or falls(scene, scheme)


def _away(scene: Scene, scheme: Scheme) -> bool:
    return bool(np.linalg.norm(scene.x) > 0.05) and _turns(scene, scheme)


def _swap(axes: str) -> np.ndarray:
    """Return the rotation that swaps two axes and reverses one, as between y up and z up."""
    names = np.eye(3)[list(SWAPS[axes])]
    names[-1] *= -1
    return names


# --- written otherwise ----------------------------------------------------------------------------------------------


@mistake("log", "quaternion x y z w under w x y z", _turns)
def _(sim: Simulation) -> None:
    sim.rewrites.append(lambda rows: with_q(rows, rows.q[:, [1, 2, 3, 0]]))


@mistake("log", "quaternion w x y z under x y z w", _turns)
def _(sim: Simulation) -> None:
    sim.rewrites.append(lambda rows: with_q(rows, rows.q[:, [3, 0, 1, 2]]))


@mistake("log", "conjugate", _turns)
def _(sim: Simulation) -> None:
    sim.rewrites.append(lambda rows: with_q(rows, rows.q * (1, -1, -1, -1)))


@mistake("log", "a sign of the quaternion's vector", _turns, part=one_of(1, 2, 3))
def _(sim: Simulation, part: int) -> None:
    signs = np.ones(4)
    signs[part] = -1
    sim.rewrites.append(lambda rows: with_q(rows, rows.q * signs))


@mistake("log", "whole angle for half", _turns)
def _(sim: Simulation) -> None:
    sim.rewrites.append(lambda rows: with_axes(rows, rows.axes @ rows.axes))


@mistake("log", "a vertex logged for the centre", lambda s, p: _box(s, p) and _turns(s, p), vertex=one_of(*range(8)))
def _(sim: Simulation, vertex: int) -> None:
    sim.rewrites.append(lambda rows: replace(rows, x=rows.vertices[:, vertex]))


@mistake("log", "another point logged", _turns, along=one_of(0, 1, 2), share=even(0.05, 0.6))
def _(sim: Simulation, along: int, share: float) -> None:
    at = share * sim.scene.reach * np.eye(3)[along]
    sim.rewrites.append(lambda rows: replace(rows, x=rows.x + rows.axes @ at))


@mistake("log", "another unit of length", lambda s, p: bool(s.x.any()) or _runs(s, p), unit=one_of(*UNITS))
def _(sim: Simulation, unit: str) -> None:
    sim.rewrites.append(lambda rows: replace(rows, x=UNITS[unit] * rows.x))


@mistake("log", "only the centre in other axes", lambda s, p: bool(s.x.any()) or _runs(s, p), axes=one_of(*SWAPS))
def _(sim: Simulation, axes: str) -> None:
    sim.rewrites.append(lambda rows: replace(rows, x=rows.x[:, list(SWAPS[axes])]))


@mistake("log", "only the attitude in other axes", _turns, axes=one_of(*SWAPS))
def _(sim: Simulation, axes: str) -> None:
    names = _swap(axes)
    sim.rewrites.append(lambda rows: with_axes(rows, names @ rows.axes @ names.T))


@mistake("log", "other axes", _turns, axes=one_of(*SWAPS))
def _(sim: Simulation, axes: str) -> None:
    names = _swap(axes)
    sim.rewrites.append(lambda rows: replace(with_axes(rows, names @ rows.axes @ names.T), x=rows.x @ names.T))


@mistake("log", "turned about the origin", _away)
def _(sim: Simulation) -> None:
    """The start's position is turned with the body."""
    first, x = matrices(np.array(sim.scene.q)[None])[0], sim.scene.x
    sim.rewrites.append(lambda rows: replace(rows, x=rows.axes @ first.T @ x + rows.x - x))


@mistake("log", "turning axes", axis=one_of(0, 1, 2), turn=even(0.05, 1.0))
def _(sim: Simulation, axis: int, turn: float) -> None:
    """Axes that turn by so much [rad] until the end."""
    rate = turn / sim.scene.duration

    def rewrite(rows: Rows) -> Rows:
        cos, sin = np.cos(rate * rows.t), np.sin(rate * rows.t)
        turns = np.tile(np.eye(3), (len(rows.t), 1, 1))
        first, second = (axis + 1) % 3, (axis + 2) % 3
        turns[:, first, first], turns[:, first, second] = cos, sin
        turns[:, second, first], turns[:, second, second] = -sin, cos
        return replace(with_axes(rows, turns @ rows.axes), x=np.einsum("nij,nj->ni", turns, rows.x))

    sim.rewrites.append(rewrite)


# --- without a name when this was written ---------------------------------------------------------------------------


@mistake("log", "attitude late, centre on time", spins, rows_late=one_of(1, 2, 5))
def _(sim: Simulation, rows_late: int) -> None:
    sim.rewrites.append(lambda rows: with_q(rows, rows.q[_late(rows, rows_late)]))


@mistake("log", "centre late, attitude on time", _runs, rows_late=one_of(1, 2, 5))
def _(sim: Simulation, rows_late: int) -> None:
    sim.rewrites.append(lambda rows: replace(rows, x=rows.x[_late(rows, rows_late)]))


@mistake("log", "centre through a low-pass filter", _runs, time=even(0.01, 0.2))
def _(sim: Simulation, time: float) -> None:
    sim.rewrites.append(lambda rows: replace(rows, x=_filtered(rows.t, rows.x, time)))


@mistake("log", "attitude through a low-pass filter", spins, time=even(0.01, 0.2))
def _(sim: Simulation, time: float) -> None:
    def rewrite(rows: Rows) -> Rows:
        q = rows.q.copy()
        for row in range(1, len(q)):
            q[row] *= 1 if q[row] @ q[row - 1] >= 0 else -1
        q = _filtered(rows.t, q, time)
        return with_q(rows, q / np.linalg.norm(q, axis=1)[:, None])

    sim.rewrites.append(rewrite)


@mistake("log", "scalar made of the vector, without its sign", _turns)
def _(sim: Simulation) -> None:
    """Three numbers are kept; w = sqrt(1 - x^2 - y^2 - z^2) is never negative."""
    sim.rewrites.append(lambda rows: with_q(rows, np.column_stack((np.abs(rows.q[:, 0]), rows.q[:, 1:]))))


@mistake("log", "pitch past the vertical lost", _turns)
def _(sim: Simulation) -> None:
    """An attitude of roll, pitch and yaw whose pitch is taken from asin and whose other angles from atan, not atan2."""

    def rewrite(rows: Rows) -> Rows:
        m = rows.axes
        with np.errstate(divide="ignore", invalid="ignore"):
            roll, yaw = np.arctan(m[:, 2, 1] / m[:, 2, 2]), np.arctan(m[:, 1, 0] / m[:, 0, 0])
        pitch = np.arcsin(np.clip(-m[:, 2, 0], -1, 1))
        return with_axes(rows, _turn(2, yaw) @ _turn(1, pitch) @ _turn(0, roll))

    sim.rewrites.append(rewrite)


@mistake("log", "floor at zero", lambda s, p: falls(s, p) and s.x[np.abs(s.gravity).argmax()] > -0.5)
def _(sim: Simulation) -> None:
    """The centre is never written below 0, and moves on."""
    axis = int(np.abs(sim.scene.gravity).argmax())

    def rewrite(rows: Rows) -> Rows:
        x = rows.x.copy()
        x[:, axis] = np.maximum(x[:, axis], 0.0)
        return replace(rows, x=x)

    sim.rewrites.append(rewrite)


@mistake("log", "a world that repeats itself", _runs, edge=one_of(2.0, 5.0, 10.0))
def _(sim: Simulation, edge: float) -> None:
    sim.rewrites.append(lambda rows: replace(rows, x=(rows.x + edge / 2) % edge - edge / 2))


@mistake("log", "matrices interpolated", spins, rows_apart=one_of(4, 6, 10))
def _(sim: Simulation, rows_apart: int) -> None:
    """Key frames every few rows, between which the numbers of the matrix are interpolated."""

    def rewrite(rows: Rows) -> Rows:
        keys = np.append(np.arange(0, len(rows.t) - 1, rows_apart), len(rows.t) - 1)
        m = np.stack(
            [np.interp(rows.t, rows.t[keys], rows.axes[keys, i, j]) for i in range(3) for j in range(3)], axis=1
        ).reshape(-1, 3, 3)
        x = np.stack([np.interp(rows.t, rows.t[keys], rows.x[keys, i]) for i in range(3)], axis=1)
        columns = m / np.linalg.norm(m, axis=1)[:, None]
        return replace(with_axes(rows, columns), x=x)

    sim.rewrites.append(rewrite)


@mistake("state", "far from the origin in single precision", _runs, away=one_of(1e4, 1e5, 1e6))
def _(sim: Simulation, away: float) -> None:
    """The world's origin is far off, and the position is kept in single precision there."""

    def lose(dt: float) -> None:
        sim.x = sim.vector(np.array([np.float32(part + away) for part in sim.x], float) - away)

    sim.after.append(lose)


@mistake("state", "velocity in half precision", _runs)
def _(sim: Simulation) -> None:
    sim.after.append(lambda dt: setattr(sim, "v", sim.vector(np.array(sim.v, np.float16))))


@mistake("state", "angular velocity in eighths", spins)
def _(sim: Simulation) -> None:
    """As where a network message keeps few bits of it."""
    sim.after.append(lambda dt: setattr(sim, "w", sim.vector(np.round(np.array(sim.w, float) * 8) / 8)))


def with_q(rows: Rows, q: np.ndarray) -> Rows:
    """Return rows with other quaternions."""
    return replace(rows, q=q, own_axes=None)


def with_axes(rows: Rows, axes: np.ndarray) -> Rows:
    """Return rows with other matrices, and quaternions of them where they are rotations."""
    return replace(rows, own_axes=axes, q=quaternions(axes))


def _late(rows: Rows, by: int) -> np.ndarray:
    return np.maximum(np.arange(len(rows.t)) - by, 0)


def _filtered(t: np.ndarray, values: np.ndarray, time: float) -> np.ndarray:
    """Return values after a first-order filter [s]."""
    seen = values.copy()
    for row in range(1, len(t)):
        seen[row] += (seen[row - 1] - seen[row]) * np.exp(-(t[row] - t[row - 1]) / time)
    return seen


def _turn(axis: int, angle: np.ndarray) -> np.ndarray:
    turns = np.tile(np.eye(3), (len(angle), 1, 1))
    first, second = (axis + 1) % 3, (axis + 2) % 3
    turns[:, first, first] = turns[:, second, second] = np.cos(angle)
    turns[:, second, first], turns[:, first, second] = np.sin(angle), -np.sin(angle)
    return turns
