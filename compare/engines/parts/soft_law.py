"""The law of an engine whose contact is soft, as the engine states it: what the plane does to a body on one point.

With y the point's height and v its rate, both negative as it goes in, the plane pushes with N [N], or not at all:

    spring and damper   N = -k y - c v
    damped approach     N = -k y - c min(v, 0)
    Hunt & Crossley     N = -k y (1 - d v)
    impedance           N / m = z (-c v - k z y - a),  a: acceleration by all else [m/s2]

z is MuJoCo's impedance: z_0 at y = 0, z_1 at -width and below, a power law with its midpoint between.  Of a point that
slips with s, friction is s / sqrt(s^2 + v_s^2) of mu N, where an engine states v_s.  Sources: Hunt & Crossley, J. Appl.
Mech. 42 (1975) 440; MuJoCo's manual, "Computation: Constraint model" and "Modeling: Impedance".
"""

import math
from dataclasses import dataclass

SPRING, HUNT_CROSSLEY, IMPEDANCE = "spring and damper", "Hunt & Crossley", "impedance"
APPROACH = "spring, and damper on the approach"


@dataclass(frozen=True)
class SoftLaw:
    """A law and its numbers.

    Parameters
    ----------
    kind : SPRING, APPROACH, HUNT_CROSSLEY or IMPEDANCE
    stiffness : k, N/m; of IMPEDANCE 1/s2
    damping : c, N s/m; d of HUNT_CROSSLEY, s/m; of IMPEDANCE 1/s
    impedance : of IMPEDANCE, MuJoCo's solimp: z_0, z_1, width [m], midpoint, power
    slow : v_s, m/s; 0 where the engine states none
    """

    kind: str
    stiffness: float
    damping: float
    impedance: tuple[float, float, float, float, float] = (1.0, 1.0, 1.0, 0.5, 1.0)
    slow: float = 0.0

    def rate(self, mass: float) -> float:
        """Return the rate of the spring without its damper [rad/s]."""
        return math.sqrt(self.stiffness if self.kind == IMPEDANCE else self.stiffness / mass)

    def push(self, y: float, v: float, mass: float, pull: float) -> float:
        """Return the acceleration by the plane [m/s2], which acts where it is positive.

        y [m], v [m/s]; pull: acceleration by all else [m/s2].
        """
        if self.kind == IMPEDANCE:
            z = self._impedance(-y)
            return z * (-self.damping * v - self.stiffness * z * y - pull)
        if self.kind == HUNT_CROSSLEY:
            return -self.stiffness * y * (1.0 - self.damping * v) / mass
        damped = min(v, 0.0) if self.kind == APPROACH else v
        return (-self.stiffness * y - self.damping * damped) / mass

    def _impedance(self, depth: float) -> float:
        """Return z at a depth [m]."""
        first, last, width, middle, power = self.impedance
        x = min(max(depth / width, 0.0), 1.0)
        if power == 1.0 or x in (0.0, 1.0):
            share = x
        elif x <= middle:
            share = x**power / middle ** (power - 1.0)
        else:
            share = 1.0 - (1.0 - x) ** power / (1.0 - middle) ** (power - 1.0)
        return first + share * (last - first)
