"""What one impact of one point does: Newton's restitution along the normal, Coulomb's friction along the plane.

The impulse P along the normal grows from zero; the velocity u of the point changes by K per impulse, K = 1/m + the
lever's share of the inverse inertia, and friction is mu against the slip while there is slip, at most mu without.
The impact is over when u_n = -e u_n(0).  Sources: Routh, "Dynamics of a System of Rigid Bodies", Elementary Part
(1905), arts. 181-198, for motion in a plane; Keller, J. Appl. Mech. 53 (1986) 1, and Bhatt & Koechling, J. Appl. Mech.
62 (1995) 893, in space.
K is positive definite, so every impact ends: Chatterjee & Ruina, J. Appl. Mech. 65 (1998) 939.
"""

from typing import Any, NamedTuple

import numpy as np

from tumble.scenarios.truth.contact.setting import Setting, tangents
from tumble.scenarios.truth.contact.slip_flow import SlipFlow, outgoing, sticking_friction
from tumble.scenarios.truth.flight import Pose
from tumble.scenarios.truth.inertia import Numbers
from tumble.scenarios.truth.rational import cross

FRICTIONLESS, SLIPS, STICKS, REVERSES = "frictionless", "slips", "sticks", "slips back"


class Impact(NamedTuple):
    """What an impact did.

    impulse [N s], (3,), world; the point's velocity before and after [m/s], (3,); the pose after;
    modes, in order: of FRICTIONLESS, SLIPS, STICKS, REVERSES, which is slip against its first direction; energy_lost
    [J], negative where the law adds some, as Newton's restitution with friction can: Kane & Levinson, "Dynamics"
    (1985), section 5.8.
    """

    impulse: Numbers
    before: Numbers
    after: Numbers
    pose: Pose
    modes: tuple[str, ...]
    energy_lost: Any


def velocity_at(pose: Pose, lever: Numbers) -> Numbers:
    """Return the velocity of a point of the body [m/s], (3,); lever: from the centre of mass, world axes [m], (3,)."""
    return pose.v + cross(pose.w_world, lever)


def response(setting: Setting, pose: Pose, lever: Numbers) -> Numbers:
    """Return K, how a point's velocity changes per impulse there [1/kg], (3, 3): 1/m - [r] I^-1 [r]."""
    x, y, z = lever
    zero = 0 * x
    skew = np.array(((zero, -z, y), (z, zero, -x), (-y, x, zero)))
    matrix = skew @ setting.inverse_world(pose) @ skew.T
    matrix[np.diag_indices(3)] += 1 / setting.mass
    return matrix


def impact(setting: Setting, pose: Pose, lever: Numbers) -> Impact:
    """Return the impact of a point that approaches the plane; lever: from the centre of mass, world axes [m], (3,)."""
    mp, normal = setting.mp, setting.normal
    before = velocity_at(pose, lever)
    first, second = tangents(mp, normal, setting.along(before))
    frame = np.array((normal, first, second))
    K = frame @ response(setting, pose, lever) @ frame.T
    u = frame @ before
    if not setting.friction:
        after, modes = _frictionless(setting, K, u), (FRICTIONLESS,)
    else:
        after, modes = _with_friction(setting, K, u)
    impulse = frame.T @ _solved(K, after - u)
    w = pose.w_world + setting.inverse_world(pose) @ cross(lever, impulse)
    then = Pose(pose.x, pose.axes, pose.v + impulse / setting.mass, w)
    after = frame.T @ after
    return Impact(impulse, before, after, then, modes, -(impulse @ (before + after)) / 2)


def _frictionless(setting: Setting, K: Numbers, u: Numbers) -> Numbers:
    return u - K[:, 0] * ((1 + setting.restitution) * u[0] / K[0, 0])


def _with_friction(setting: Setting, K: Numbers, u: Numbers) -> tuple[Numbers, tuple[str, ...]]:
    """Return the velocity after, (3,), along normal and tangents, and the modes."""
    mp, mu, target = setting.mp, setting.friction, -setting.restitution * u[0]
    drift, matrix = K[1:, 0], K[1:, 1:]
    modes: tuple[str, ...] = ()
    rising = u[0]
    if u[1]:
        modes = (SLIPS,)
        flow = SlipFlow(mp, drift, matrix * mu, u[1:])
        gauge, constant = _normal_velocity(K, u)
        slid, reached = flow.until(gauge, constant - target)
        if reached:
            back = (REVERSES,) if slid.velocity @ u[1:] < 0 else ()
            return np.array((target, *slid.velocity)), modes + back
        rising = gauge @ np.array((*slid.velocity, slid.passed)) + constant
    friction = sticking_friction(drift, matrix)
    if friction @ friction <= mu * mu:
        return np.array((target, mp.zero, mp.zero)), (*modes, STICKS)
    direction, rate = outgoing(mp, drift, matrix * mu)
    climb = K[0, 0] - mu * (K[0, 1:] @ direction)
    passed = (target - rising) / climb
    return np.array((target, *(direction * (rate * passed)))), (*modes, REVERSES if modes else SLIPS)


def _normal_velocity(K: Numbers, u: Numbers) -> tuple[Numbers, Any]:
    """Return factors, (3,), and a constant that make u_n of (s1, s2, P) while the point slips.

    s = s0 + d P - M F and u_n = u_n0 + K_nn P - K_nt F, where F is the impulse of friction.
    """
    drift, matrix = K[1:, 0], K[1:, 1:]
    share = -sticking_friction(K[0, 1:], matrix)  # K_nt M^-1
    return np.array((*share, K[0, 0] - share @ drift)), u[0] - share @ u[1:]


def _solved(matrix: Numbers, vector: Numbers) -> Numbers:
    """Return matrix^-1 vector of a symmetric matrix, (3, 3)."""
    cofactors = np.array([cross(matrix[row - 2], matrix[row - 1]) for row in range(3)])
    return cofactors @ vector / (matrix[0] @ cofactors[0])
