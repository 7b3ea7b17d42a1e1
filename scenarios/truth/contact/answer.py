"""The truth of a scene with a plane, in the columns that every truth has, and the records of its contacts."""

from typing import Any

import numpy as np

from tumble.scenarios.forces import GRAVITY, PLANE, acting
from tumble.scenarios.frames import Array
from tumble.scenarios.scene import Body, Scene
from tumble.scenarios.truth import NoTruth, ShareCallback, rounded_vertices
from tumble.scenarios.truth.contact.motion import Changed, Motion, changed_timelines, motion_of, moves_of, poses_of
from tumble.scenarios.truth.contact.record import ContactRecord, recorded, state_of
from tumble.scenarios.truth.resolution import movements, rounding

HOW = "exact: closed forms between events, certified instants, Taylor series in the impulse"


def on_plane(
    mp: Any, scene: Scene, with_input_error: bool, on_share: ShareCallback
) -> tuple[list[Array], list[str], list[str], tuple[ContactRecord, ...]]:
    """Return states, vertices, bound and input error of all throws, how they were made, why some end, and records.

    Raises NoTruth, RayMissed.
    """
    others = [law.name for law in acting(scene) if law not in (GRAVITY, PLANE)]
    if others:
        raise NoTruth(f"the truth above a plane has gravity and impulses alone: leave out {' and '.join(others)}")
    columns, records, reasons = [], [], []
    for row in range(len(scene.start)):
        motion = motion_of(mp, scene, row)
        changed = changed_timelines(mp, scene, row, motion) if with_input_error else []
        columns.append(_row(mp, scene, row, motion, changed))
        records.append(recorded(motion, changed))
        reasons.append(motion.finer.why)
        on_share((row + 1) / len(scene.start))
    stacked = [np.stack(column, axis=1) for column in zip(*columns, strict=True)]
    how = HOW if is_convex(scene.body) else f"{HOW}; the convex hull of the mesh meets the plane"
    return stacked, [how], reasons, tuple(records)


def is_convex(body: Body) -> bool:
    """Return whether no point of a body's surface is outside of any of its faces' planes, but for rounding."""
    if not len(body.faces):
        return True
    first, second, third = (body.points[body.faces[:, corner]] for corner in range(3))
    normals = np.cross(second - first, third - first)
    sizes = np.linalg.norm(normals, axis=1)
    beyond = body.points @ normals.T - (first * normals).sum(axis=1)
    return bool((beyond <= 1e-9 * body.reach * sizes).all())


def _row(mp: Any, scene: Scene, row: int, motion: Motion, changed: list[Changed]) -> tuple[Array, Array, Array, Array]:
    """Return states (R, 13), vertices (R, n, 3), bound and input error (R,) of one throw."""
    mp.prec = motion.bits
    setting, throw = motion.setting, motion.setting.throw
    finer, rougher = (poses_of(setting, one) for one in (motion.finer, motion.rougher))
    known = min(len(finer), len(rougher))
    finer, rougher = finer[:known], rougher[:known]
    states = np.array([state_of(motion, pose) for pose in finer]).reshape(-1, 13)
    before = scene.start[row, 3:7]
    for q in states[:, 3:7]:
        q *= 1 if before @ q >= 0 else -1
        before = q
    vertices = rounded_vertices(finer, throw.points, motion.bits) if finer else np.empty((0, len(throw.points), 3))
    bound = movements(finer, rougher, throw.points, throw.points)[:, 0] + rounding(vertices) + _laid(motion)
    moved = np.zeros(len(finer))
    for other in changed[1:]:
        moves = moves_of(motion, changed[0], other)[: len(finer)]
        moved[: len(moves)] = np.maximum(moved[: len(moves)], moves)
        # A changed motion that takes another course says that beyond it the inputs decide.
        moved[len(moves) :] = np.inf

    def all_rows(values: Array, unknown: float) -> Array:
        return np.concatenate((values, np.full((len(throw.times) - len(values), *values.shape[1:]), unknown)))

    return all_rows(states, np.nan), all_rows(vertices, np.nan), all_rows(bound, np.inf), all_rows(moved, np.inf)


def _laid(motion: Motion) -> float:
    """Return how far a vertex was moved to lay a body that starts on the plane within rounding exactly there [m]."""
    if not motion.finer.phases:
        return 0.0
    start, points = motion.setting.start, motion.setting.throw.points
    return float(movements([start], [motion.finer.phases[0].at(motion.setting.mp.zero)], points, points)[0, 0])
