"""Taylor series of a free rotation in time, coefficient by coefficient.

A series is an array, one row a power of t/dt: scaled so, its terms are summed without multiplying by powers of a step.
Rows hold what a product needs side by side, so that the compiler can take four numbers at once.
"""

import numpy as np
from numpy.typing import NDArray

from solver.compilation import inner
from solver.quaternion import Quaternion
from solver.vectors import Vector

Array = NDArray[np.float64]


@inner
def put_momentum(series: Array, n: int, momentum: Vector) -> None:
    """Write the coefficient n of L_body into its row, (8,)."""
    x, y, z = momentum
    series[n, 0], series[n, 1], series[n, 2] = y, z, x
    series[n, 4], series[n, 5], series[n, 6] = z, x, y


@inner
def next_momentum(series: Array, n: int, step_gyroscopic: Vector) -> Vector:
    """Return the coefficient n + 1 of L_body from those up to n, for dL/dt = L x w.

    step_gyroscopic: dt times `solver.body.Body.gyroscopic`.  Source: Cauchy products; Jorba & Zou, "A software package
    for the numerical integration of ODEs by means of high-order Taylor methods" (2005), section 2.
    """
    yz, zx, xy = 0.0, 0.0, 0.0
    for k in range(n + 1):
        yz += series[k, 0] * series[n - k, 4]
        zx += series[k, 1] * series[n - k, 5]
        xy += series[k, 2] * series[n - k, 6]
    share = 1.0 / (n + 1)
    return (step_gyroscopic[0] * yz * share, step_gyroscopic[1] * zx * share, step_gyroscopic[2] * xy * share)


@inner
def put_quaternion(series: Array, n: int, q: Quaternion) -> None:
    """Write q i, q j and q k of the coefficient n of q into its row, (12,)."""
    w, x, y, z = q
    series[n, 0], series[n, 1], series[n, 2], series[n, 3] = -x, w, z, -y
    series[n, 4], series[n, 5], series[n, 6], series[n, 7] = -y, -z, w, x
    series[n, 8], series[n, 9], series[n, 10], series[n, 11] = -z, y, -x, w


@inner
def next_quaternion(quaternions: Array, half_turns: Array, n: int) -> Quaternion:
    """Return the coefficient n + 1 of q from those up to n of q and of dt w_body/2, (n + 1, 3), for dq/dt = q w~/2."""
    w, x, y, z = 0.0, 0.0, 0.0, 0.0
    for k in range(n + 1):
        ux, uy, uz = half_turns[n - k, 0], half_turns[n - k, 1], half_turns[n - k, 2]
        w += quaternions[k, 0] * ux + quaternions[k, 4] * uy + quaternions[k, 8] * uz
        x += quaternions[k, 1] * ux + quaternions[k, 5] * uy + quaternions[k, 9] * uz
        y += quaternions[k, 2] * ux + quaternions[k, 6] * uy + quaternions[k, 10] * uz
        z += quaternions[k, 3] * ux + quaternions[k, 7] * uy + quaternions[k, 11] * uz
    share = 1.0 / (n + 1)
    return (w * share, x * share, y * share, z * share)
