"""The scheme with which an integrator takes the gyroscopic torque, found only from what a free run conserves.

A step of Euler's equations in body axes leaves L + dt L x w, and L x w stands at right angles to L: taken explicitly it
lengthens |L| at every step, and energy grows with it; taken implicitly it shortens both; set back to its length, |L|
stays and the energy alone is off; by the midpoint rule both stay (Hairer, Lubich and Wanner, IV.1).
"""

import numpy as np

from tumble.compare.judge import mechanics
from tumble.scenarios.frames import Array
from tumble.scenarios.scene import Body

# A step rounds several numbers: a change below this many roundings a step counts as conserved.
ROUNDINGS = 4.0
# A relative change of the angular velocity below this is none.
STOOD = 1e-6
# Halving the step halves what is of first order, and leaves a quarter of what is of second.
HIGHER = 2.8


def gyroscopic_scheme(coarse: Array, fine: Array, body: Body, steps: int, rounding: float) -> str:
    """Return one of compare.engines.GYROSCOPIC_NAMES, `keeps-momentum` where energy is kept too, '' for none of them.

    coarse, fine: states of a free body of unequal moments that turns about no axis of its own, (R, 13), the second in
    steps of half the size; steps: of all the first; rounding: what one moves a number of size 1.
    What falls faster than the step does is of a higher order, and none of these.
    """
    kept = ROUNDINGS * steps * rounding
    w = coarse[:, 10:13]
    if np.linalg.norm(w - w[0], axis=1).max() <= max(kept, STOOD) * np.linalg.norm(w[0]):
        return "none"
    longer, more = drifts(coarse, body)
    longer_fine, more_fine = drifts(fine, body)
    if abs(longer) <= kept:
        return "keeps-momentum" if abs(more) <= kept or abs(more) > HIGHER * abs(more_fine) else "rescaled"
    if abs(longer) > HIGHER * abs(longer_fine):
        return ""
    return "explicit" if longer > 0 and more > 0 else "implicit"


def drifts(states: Array, body: Body) -> tuple[float, float]:
    """Return by what share |L| and the energy of the spin have grown at the end."""
    length = np.linalg.norm(mechanics.angular_momentum(states, body), axis=-1)
    energy = mechanics.spin_energy(states, body)
    return float(length[-1] / length[0] - 1.0), float(energy[-1] / energy[0] - 1.0)
