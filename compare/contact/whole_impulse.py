"""The impact law of time-stepping methods: Newton's restitution, and Coulomb's friction of the impulse as a whole.

Where the slip turns or ends during an impact this is another law than Coulomb's at every instant of it (Routh,
Keller), which is the truth here; where it does not, both are one.  Source: Moreau, "Unilateral contact and dry
friction in finite freedom dynamics" (1988), section 10.
"""

import math
from typing import Any

import numpy as np

from tumble.compare.contact.directions import plane_axes
from tumble.scenarios.frames import Array, rotation_matrix
from tumble.scenarios.scene import Body, Plane
from tumble.scenarios.truth.contact.record import ContactEvent

# Directions of the slip after the impact among which the one that agrees with itself is bracketed.
DIRECTIONS = 720


def after_whole_impulse(body: Body, plane: Plane, event: ContactEvent) -> tuple[Array, Array]:
    """Return the velocity [m/s] and the spin [rad/s] after an impact by this law, (3,) each; nan where it has none."""
    axes, lever = rotation_matrix(event.before[3:7]), event.place - event.before[0:3]
    inverse = axes @ np.diag(1 / body.moments) @ axes.T
    skew = np.cross(np.eye(3), lever)
    response = np.eye(3) / body.mass + skew.T @ inverse @ skew
    impulse = whole_impulse(response, event.velocity_before, plane)
    return event.before[7:10] + impulse / body.mass, event.before[10:13] + inverse @ np.cross(lever, impulse)


def whole_impulse(response: Array, velocity: Array, plane: Plane) -> Array:
    """Return the impulse [N s], (3,); response: change of the point's velocity per impulse [1/kg], (3, 3)."""
    normal, along = plane.normal, np.stack(plane_axes(plane.normal))
    wanted = -plane.restitution * (velocity @ normal) * normal - velocity
    sticking: Array = np.linalg.solve(response, wanted).astype(float)
    pressing = sticking @ normal
    if np.linalg.norm(sticking - pressing * normal) <= plane.friction * pressing:
        return sticking

    def slipping(angle: float) -> tuple[Array, float]:
        """Return the impulse against a slip, and how far the slip that it leaves is turned from it [m/s]."""
        slip = np.array([math.cos(angle), math.sin(angle)])
        push = normal - plane.friction * slip @ along
        impulse = (wanted @ normal) / (normal @ response @ push) * push
        left = along @ (velocity + response @ impulse)
        return impulse, (slip[0] * left[1] - slip[1] * left[0]) if left @ slip > 0 else math.nan

    angles = np.linspace(0, 2 * np.pi, DIRECTIONS + 1)
    turned = np.array([slipping(angle)[1] for angle in angles])
    changes = np.flatnonzero(turned[:-1] * turned[1:] <= 0)
    if not len(changes):
        return np.full(3, math.nan)
    from scipy.optimize import brentq  # slow to load

    first = int(changes[0])
    root: Any = brentq(lambda angle: slipping(angle)[1], angles[first], angles[first + 1])
    return slipping(root)[0]
