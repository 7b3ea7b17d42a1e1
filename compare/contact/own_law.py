"""A soft engine held to its own law: the central impact of a sphere, by the spring and damper that the engine states.

The law is integrated with gravity, to rounding; what is compared is read off as it is off an engine's run.  Of a body
that must rest on an incline it is the speed with which it creeps, where the engine states its friction at slow slip.
"""

import math

import numpy as np
from numpy.linalg import norm

from tumble.compare.contact.asked import BY_OWN_LAW, CREEP
from tumble.compare.contact.impacts import DEEPEST, REBOUND, Impact
from tumble.compare.run.flight import SoftLaw
from tumble.scenarios.scene import Scene

# Times of the spring and of its damper for which a contact is followed.
TIMES = 50.0
# Of a level plane, the rounding of how steep it is.
LEVEL = 1e-12


def own_numbers(law: SoftLaw, scene: Scene, impact: Impact) -> dict[str, float]:
    """Return the rebound speed [m/s] and the deepest penetration [m] of a sphere's impact by a law, by observable.

    Without the speed where the sphere stays on the plane.
    """
    plane, body = scene.plane, scene.body
    assert plane is not None
    speed = -float(impact.event.velocity_before @ plane.normal)
    pull = 0.0 if scene.gravity is None else float(scene.gravity @ plane.normal)
    found = central_impact(law, body.mass, speed, pull)
    return {name + BY_OWN_LAW: value for name, value in found.items()}


def own_creep(law: SoftLaw, scene: Scene) -> dict[str, float]:
    """Return the speed at which a body on a face creeps down an incline [m/s], by observable.

    All its points slip alike, so that friction's share of mu N is the same for all, whatever N is at each.  Nothing on
    a level plane, or where friction does not hold the body.
    """
    plane = scene.plane
    if scene.gravity is None or plane is None or not (law.slow and plane.friction):
        return {}
    load = -float(scene.gravity @ plane.normal)
    share = float(norm(scene.gravity + load * plane.normal)) / (plane.friction * load) if load > 0 else 1.0
    if not LEVEL < share < 1.0:
        return {}
    return {CREEP + BY_OWN_LAW: law.slow * share / math.sqrt(1.0 - share * share)}


def central_impact(law: SoftLaw, mass: float, speed: float, pull: float) -> dict[str, float]:
    """Return the same from mass [kg], speed of approach [m/s] and gravity along the normal [m/s2]."""
    from scipy.integrate import solve_ivp  # slow to load

    rate = law.rate(mass)
    slowest, length = 1 / rate + law.damping / law.stiffness, speed / rate

    def slope(t: float, state: np.ndarray) -> tuple[float, float]:
        y, v = state
        return v, pull + max(0.0, law.push(y, v, mass, pull))

    def leaves(t: float, state: np.ndarray) -> float:
        return law.push(state[0], state[1], mass, pull) if t else 1.0

    def turns(t: float, state: np.ndarray) -> float:
        return state[1]

    leaves.terminal, leaves.direction, turns.direction = True, -1, 1  # type: ignore[attr-defined]
    found = solve_ivp(
        slope, (0.0, TIMES * slowest), (0.0, -speed), "DOP853", events=(leaves, turns), rtol=1e-13, atol=1e-13 * length
    )
    numbers = {DEEPEST: -float(found.y_events[1][0, 0])}
    t, (y, v) = found.t[-1], found.y[:, -1]
    comes_out = len(found.t_events[0]) and (pull >= 0 or y + v * v / (-2 * pull) > 0)
    if comes_out:
        # Where the flights before and after it meet, as `impacts.hit_time` has it.
        hit = (y - v * t + pull * t * t / 2) / (-speed - v + pull * t)
        numbers[REBOUND] = float(v + (hit - t) * pull)
    return numbers
