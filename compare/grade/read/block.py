"""Rows of a trajectory as numbers, and the body's axes and vertices in them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tumble.compare.grade.read.columns import CENTRE, MATRIX, QUATERNION, Description
from tumble.scenarios.frames import Array, quaternion_product, rotation_matrix
from tumble.scenarios.scene import Scene

CONJUGATE = (1.0, -1.0, -1.0, -1.0)


@dataclass(frozen=True, eq=False)
class Block:
    """Rows of one file, each of one throw at one time.

    lines: their lines in the file, (n,); throws: (n,); times [s], (n,); rounding: of the times [s], (n,); values:
    quantity -> values in SI, (n,).
    """

    lines: np.ndarray
    throws: np.ndarray
    times: Array
    rounding: Array
    values: dict[str, Array]

    def of(self, names: Sequence[str]) -> Array:
        """Return these quantities side by side, (n, len(names))."""
        return np.stack([self.values[name] for name in names], axis=1)

    def throw(self, throw: int) -> "Block":
        """Return the rows of one throw."""
        if (self.throws == throw).all():
            return self
        return self.some(self.throws == throw)

    def some(self, rows: np.ndarray | slice) -> "Block":
        """Return some of the rows."""
        values = {name: column[rows] for name, column in self.values.items()}
        return Block(self.lines[rows], self.throws[rows], self.times[rows], self.rounding[rows], values)


def axes_of(block: Block, kind: str, file_axes: Array, stretched: bool = True) -> Array:
    """Return the matrices from principal axes to world in the file, (n, 3, 3), rotations or not.

    stretched: a quaternion that is not of unit length scales them by its square, as in a program without normalisation.
    """
    if kind == "matrix":
        axes = block.of(MATRIX).reshape(-1, 3, 3)
    else:
        q = block.of(QUATERNION)
        square = (q * q).sum(axis=1)
        axes = rotation_matrix(q / np.sqrt(square)[:, None])
        if stretched:
            axes *= square[:, None, None]
    return axes @ rotation_matrix(file_axes * CONJUGATE)


def principal_attitudes(block: Block, file_axes: Array) -> Array:
    """Return the attitudes of the principal axes from the file's quaternions, normalised, (n, 4)."""
    q = block.of(QUATERNION)
    return quaternion_product(q / np.linalg.norm(q, axis=1)[:, None], file_axes * CONJUGATE)


def vertices_of(block: Block, description: Description, scene: Scene, stretched: bool = True) -> Array:
    """Return the vertices in the file [m], (n, K, 3); relative to the centre of mass if the file has no centre."""
    if description.kind == "vertices":
        names = [f"v{number}{axis}" for number in description.vertices for axis in "xyz"]
        return block.of(names).reshape(len(block.times), -1, 3)
    axes = axes_of(block, description.kind, scene.body.file_axes, stretched)
    points = scene.body.points
    # One matrix product: numpy's einsum takes ten times as long.
    turned = np.swapaxes((axes.reshape(-1, 3) @ points.T).reshape(-1, 3, len(points)), 1, 2)
    return block.of(CENTRE)[:, None] + turned if description.has_centre else turned
