"""From a state to where the corners are: rotation matrices and vertices, in numpy.

The solver has quaternion algebra of its own; the two are kept apart so that neither can hide the other's mistake.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# The elements of a rotation matrix, row by row: 2 (pq - rs) and 2 (pq + rs), and on the diagonal 1 - 2 (pp + ss).
# A few calls for all nine: most batches here are small, and a call of numpy takes longer than their sums.
ELEMENTS = (
    "yy+zz", "xy-wz", "xz+wy",
    "xy+wz", "xx+zz", "yz-wx",
    "xz-wy", "yz+wx", "xx+yy",
)  # fmt: skip
P, Q, R, S = (np.array(["wxyz".index(element[at]) for element in ELEMENTS]) for at in (0, 1, 3, 4))
SIGNS = np.array([[float(f"{element[2]}1")] for element in ELEMENTS])


def rotation_matrix(q: Array) -> Array:
    """Return the matrix that turns body axes into world axes.

    Parameters
    ----------
    q : (..., 4)
        unit quaternions w x y z, body to world

    Returns
    -------
    matrices : (..., 3, 3)

    Notes
    -----
    Source: Shoemake, "Animating rotation with quaternion curves" (1985), eq. in the appendix.
    """
    q = np.asarray(q, dtype=float)
    parts = q.reshape(-1, 4).T
    turned = 2 * (parts[P] * parts[Q] + SIGNS * (parts[R] * parts[S]))
    turned[::4] = 1 - turned[::4]
    return np.ascontiguousarray(turned.T).reshape(*q.shape[:-1], 3, 3)


def quaternion_product(p: Array, q: Array) -> Array:
    """Return the Hamilton product p q.

    Parameters
    ----------
    p, q : (..., 4)
        quaternions w x y z

    Returns
    -------
    product : (..., 4)
    """
    pw, px, py, pz = np.moveaxis(np.asarray(p, dtype=float), -1, 0)
    qw, qx, qy, qz = np.moveaxis(np.asarray(q, dtype=float), -1, 0)
    return np.stack(
        (
            pw * qw - px * qx - py * qy - pz * qz,
            pw * qx + px * qw + py * qz - pz * qy,
            pw * qy - px * qz + py * qw + pz * qx,
            pw * qz + px * qy - py * qx + pz * qw,
        ),
        axis=-1,
    )


def cross_matrix(a: Array) -> Array:
    """Return the matrix of b -> a x b.

    Parameters
    ----------
    a : (3,)

    Returns
    -------
    (3, 3)
    """
    return np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]])


def turned_by(p: Array, q: Array) -> Array:
    """Return the rotation that takes one attitude to another.

    Parameters
    ----------
    p, q : (..., 4)
        unit quaternions w x y z, body to world

    Returns
    -------
    rotation vector : (..., 3), rad
        from p to q, the shorter way, world axes
    """
    away = quaternion_product(q, p * (1.0, -1.0, -1.0, -1.0))
    away = np.where(away[..., :1] < 0, -away, away)  # the shorter way round
    sine = np.linalg.norm(away[..., 1:], axis=-1, keepdims=True)
    ratio = np.divide(2 * np.arctan2(sine, away[..., :1]), sine, out=np.full_like(sine, 2.0), where=sine > 0)
    return ratio * away[..., 1:]


def vertices(states: Array, points: Array) -> Array:
    """Return the body's points in the world, p = x + R p0.

    Parameters
    ----------
    states : (..., 13)
    points : (n, 3), m
        body axes

    Returns
    -------
    positions : (..., n, 3), m
        world axes

    Notes
    -----
    Source: CE1051A report, eq. 2.12.
    """
    turned = np.einsum("...ij,nj->...ni", rotation_matrix(states[..., 3:7]), points)
    return states[..., None, 0:3] + turned
