"""Friction within a cone: of an impact, and of a body that slides or rolls along a plane, step by step."""

import math
from pathlib import Path

from tumble.compare.grade.model.kernel.dynamics import Array
from tumble.solver.compilation import kernel_with, scalar

# Cones of friction: Coulomb's, a bound on each axis alone, and a bound on the sum over both axes.
ROUND, SQUARE, DIAMOND = 0, 1, 2


@scalar
def bounded(f: float, g: float, most: float, cone: int) -> tuple[float, float]:
    """Return the friction in a cone's section that is nearest to the wanted one; most: bound along an axis."""
    a, b = abs(f), abs(g)
    if cone == SQUARE:
        return math.copysign(min(a, most), f), math.copysign(min(b, most), g)
    if cone == ROUND:
        size = math.hypot(f, g)
        share = most / size if size > most else 1.0
        return f * share, g * share
    if a + b <= most:
        return f, g
    excess = max(a, b) - most if abs(a - b) >= most else (a + b - most) / 2
    return math.copysign(max(a - excess, 0.0), f), math.copysign(max(b - excess, 0.0), g)


@kernel_with(Path(__file__).parent)
def slide_along(
    path: Array,
    dt: float,
    down: tuple[float, float],
    most: float,
    cone: int,
    spin: tuple[float, float, float],
    stops: tuple[float, float],
) -> None:
    """Fill rows of x, v (2 each) and w (3) from the first one, dt [s] apart.

    down, most: acceleration by gravity and greatest one by friction [m/s2]; spin: lever of the slip [m], 1 + m r^2 / I,
    and spin by friction, m r / I [1/m]; stops: speeds below which the body is put to sleep, and friction is viscous.
    """
    sees, spread, gain = spin
    asleep, viscous = stops
    stopped = False
    for step in range(1, len(path)):
        x0, x1, v0, v1, w0, w1, w2 = path[step - 1]
        u0, u1 = v0 - sees * w1 + down[0] * dt, v1 + sees * w0 + down[1] * dt
        # What ends the slip in the step; if viscous, f = -most u / viscous with the slip at the end of it.
        ease = -1.0 / (spread * dt) if viscous == 0.0 else -most / (viscous + spread * most * dt)
        f0, f1 = bounded(u0 * ease, u1 * ease, most, cone)
        n0, n1 = v0 + (down[0] + f0) * dt, v1 + (down[1] + f1) * dt
        speed = math.hypot(n0, n1)
        stopped = stopped or (speed < asleep and speed <= math.hypot(v0, v1))
        if stopped:
            v0 = v1 = n0 = n1 = w0 = w1 = w2 = f0 = f1 = 0.0
        path[step, 0], path[step, 1] = x0 + dt * (v0 + n0) / 2, x1 + dt * (v1 + n1) / 2
        path[step, 2], path[step, 3] = n0, n1
        path[step, 4], path[step, 5], path[step, 6] = w0 + gain * f1 * dt, w1 - gain * f0 * dt, w2


@kernel_with(Path(__file__).parent)
def impulse_of(
    response: Array, drag_response: Array, u: Array, slip: Array, target: float, friction: float, cone: int, ways: Array
) -> tuple[float, float, float]:
    """Return the friction's impulse along both axes, and the normal one [N s].

    response: of the contact point to an impulse, (3, 3), and of what friction opposes to friction, (2, 2) [1/kg]; u:
    velocity of the point, (3,); slip: what friction opposes, (2,); target: normal velocity wanted [m/s]; ways: largest
    number of sweeps (1: friction after the normal impulse), whether friction changes the normal velocity, and the
    normal impulse the slip.
    """
    sweeps, turns, moves = ways
    a, b, d = drag_response[0, 0], drag_response[0, 1], drag_response[1, 1]
    size = (a + d) / 2 + math.hypot((a - d) / 2, b)
    f = g = press = 0.0
    for _ in range(int(sweeps)):
        press = max(0.0, (target - u[2] - turns * (response[2, 0] * f + response[2, 1] * g)) / response[2, 2])
        s = slip[0] + moves * response[0, 2] * press
        t = slip[1] + moves * response[1, 2] * press
        before, beside = f, g
        if sweeps > 1.0:  # descends to where friction is against the slip that is left
            f, g = bounded(f - (s + a * f + b * g) / size, g - (t + b * f + d * g) / size, friction * press, cone)
        elif cone == SQUARE:
            f, g = bounded(-s / a, -t / d, friction * press, cone)
        elif s != 0.0 or t != 0.0:
            gain = (a * s * s + 2 * b * s * t + d * t * t) / (s * s + t * t)
            f, g = bounded(-s / gain, -t / gain, friction * press, cone)
        if max(abs(f - before), abs(g - beside)) <= 1e-13 * press:
            break
    return f, g, press
