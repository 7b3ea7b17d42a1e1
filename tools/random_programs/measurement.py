"""Measurement noise, as of a motion-capture system: how large it is drawn, and what it does to rows."""

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from tools.random_programs.algebra import product
from tools.random_programs.scene import Scene
from tools.random_programs.simulation import Rows

# Share of programs whose rows are measured; range of the noise's standard deviation over the body's size.
MEASURED = 0.2
LEAST, MOST = 1e-5, 1e-3


def drawn(random: np.random.Generator) -> float:
    """Return the standard deviation of a file's noise over the body's size; 0 for most files."""
    if random.random() >= MEASURED:
        return 0.0
    return float(f"{np.exp(random.uniform(np.log(LEAST), np.log(MOST))):.2g}")


def measured(rows: Rows, scene: Scene, noise: float, of_vertices: bool, random: np.random.Generator) -> Rows:
    """Return rows with noise: of each coordinate of each vertex, or of the centre and of the attitude."""
    sigma, count = noise * scene.size_m, len(rows.t)
    if of_vertices:
        return replace(rows, scatter=sigma * random.normal(size=(count, len(rows.points), 3)))
    x = rows.x + sigma * random.normal(size=(count, 3))
    turns = Rotation.from_rotvec(sigma / scene.reach * random.normal(size=(count, 3)))
    q = np.stack(product(tuple(turns.as_quat(scalar_first=True).T), tuple(rows.q.T)), axis=1)  # type: ignore[arg-type]
    axes = None if rows.own_axes is None else turns.as_matrix() @ rows.own_axes
    return replace(rows, x=x, q=q, own_axes=axes)


def moved_m(scene: Scene, noise: float, of_vertices: bool) -> float:
    """Return how far the noise moves vertices (root mean square) [m]."""
    sigma = noise * scene.size_m
    if of_vertices:
        return float(np.sqrt(3) * sigma)
    return float(sigma * np.sqrt(3 + 2 * np.square(scene.points / scene.reach).sum(axis=1).mean()))
