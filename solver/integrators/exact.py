"""The closed form of free rotation, in theta series: one step of any length.

The angular momentum runs round axis 3, that of the least or the greatest moment, on Euler's curve

    L_body = (a1 cn u, a2 sn u, a3 dn u),   u = u0 + rate t,

and the body, seen from L, is the shortest turn of L_body onto axis 3 followed by one about L by the angle A t + p(t),
with p periodic.  Its parameter depends on the moments alone: p is the phase of theta1 at a complex argument whose
imaginary part is a constant, less the phase of L1 + i L2; A makes the two turn as fast as the body does at L1 = 0.

Every motion is one of two.  Below m = 1/2 the series run in the nome q of m, trigonometric in the phase and hyperbolic
in the imaginary part.  Above it Jacobi's imaginary transformation exchanges the two, and m with 1 - m.  So no nome
passes exp(-pi) = 0.0432, four terms are all that doubles can tell, and the separatrix is the nome 0 of the second form.
Only differences of moments and sums of positive terms are used: near symmetry and near the separatrix no digit is lost
but those that the motion itself makes uncertain.

Source: Jacobi, "Sur la rotation d'un corps" (1850); Whittaker, "Analytical Dynamics" (1937), sections 69-70; theta
functions: Whittaker & Watson, "Modern Analysis" (1927), chapter 21; DLMF 20.2, 20.7.30-33, 22.2, 22.20(ii).
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tumble.solver.body import by_moment, momentum_rate
from tumble.solver.compilation import inner, kernel
from tumble.solver.fused import fused_half_turn
from tumble.solver.quaternion import Quaternion, exponential, normalise, product
from tumble.solver.spins import load_anchor, store
from tumble.solver.theta import (
    Harmonics,
    Pair,
    alternating,
    even_sums,
    half,
    hyperbolic,
    landen,
    less,
    nome_of,
    power,
    shifted,
    times_complex,
    total,
)
from tumble.solver.vectors import Vector, dot, scale, times

Axes = tuple[int, int, int]

# Of a component of L over the largest.
SPECK = 1e-150


class Polhode(NamedTuple):
    """The curve of L_body = (a1 cn u, a2 sn u, a3 dn u): amplitudes, parameter m and m1 = 1 - m.

    aspect: in the ratio of a1 and a2, also where both are 0; phase: cn and sn at the start; shift: 1 and
    sn/i, or cn and sn to the modulus of m1, both over sc, of the imaginary part: where L would lie along axis 3.
    """

    m: float
    m1: float
    amplitudes: Vector
    aspect: Pair
    phase: Pair
    shift: Pair


class Seen(NamedTuple):
    """L_body, and a complex number whose phase is half of p [rad], but for what is linear in time."""

    momentum: Vector
    half_phase: Pair


class Path(NamedTuple):
    """From the start to now.  lag: what A t lacks of |L| t/I2, by unit of u; turned: a number whose phase is half of
    the rest of the angle about L; momentum: L_body."""

    lag: float
    turned: Pair
    momentum: Vector


@inner
def _circular_path(polhode: Polhode, gained: float) -> Path:
    """Follow the polhode while u grows by gained, m <= 1/2: series in the nome of m."""
    m, m1, phase, shift = polhode.m, polhode.m1, polhode.phase, polhode.shift
    mean, start, (one, sinh) = landen(m, m1, phase, shift)
    nome = nome_of(m, m1)
    exp = sinh + math.sqrt(one * one + sinh * sinh)
    waves = hyperbolic(nome, (one / exp) ** 2, 2.0 * sinh / exp)
    (c1, c3, c5, c7), (s1, s3, s5, s7) = waves
    lag = mean * (s1 + 3.0 * s3 + 5.0 * s5 + 7.0 * s7) / (c1 + c3 + c5 + c7)
    root = math.sqrt(math.sqrt(m1))
    null = 1.0 / (math.sqrt(mean) * (1.0 + nome**2 + nome**6))
    began = _circular(polhode, waves, nome, root, null, start)
    now = _circular(polhode, waves, nome, root, null, times_complex(start, fused_half_turn(2.0 * mean * gained)))
    return Path(lag, less(now.half_phase, began.half_phase), now.momentum)


@inner
def _circular(polhode: Polhode, waves: Harmonics, nome: float, root: float, null: float, angle: Pair) -> Seen:
    """Return what is seen at an angle pi u/(2 K); root: sqrt(k'); null: theta3(0)/theta2(0) nome^(1/4) 2.

    DLMF 22.2.4-6: cn = theta4(0)/theta2(0) theta2/theta4, sn = theta3(0)/theta2(0) theta1/theta4 and
    dn = theta4(0)/theta3(0) theta3/theta4, where theta4(0)/theta3(0) = sqrt(k') and theta3(0)^2 = 2 K/pi.
    """
    (a1, a2, a3), aspect = polhode.amplitudes, polhode.aspect
    cosine, sine = angle
    double = 2.0 * (cosine - sine) * (cosine + sine)
    theta3, theta4 = even_sums(nome, double)
    squared, sixth = nome**2, nome**6
    cosine3, sine3 = cosine * (double - 1.0), sine * (double + 1.0)
    theta1 = sine - squared * sine3 + sixth * (double * sine3 - sine)
    theta2 = cosine + squared * cosine3 + sixth * (double * cosine3 - cosine)
    momentum = (a1 * root * null * theta2 / theta4, a2 * null * theta1 / theta4, a3 * root * theta3 / theta4)
    meridian = (aspect[0] * root * theta2, aspect[1] * theta1)
    return Seen(momentum, half(less(shifted(waves, angle), meridian)))


@inner
def _hyperbolic_path(polhode: Polhode, gained: float) -> Path:
    """Follow the polhode while u grows by gained, m > 1/2: series in the nome of 1 - m.

    In half a period p loses twice the angle of `landen`, which is not in the series: they know but the last of them.
    """
    m, m1, phase, shift = polhode.m, polhode.m1, polhode.phase, polhode.shift
    mean, angle, (one, sinh) = landen(m1, m, shift, phase)
    nome = nome_of(m1, m)
    double = 2.0 * (angle[0] - angle[1]) * (angle[0] + angle[1])
    slope = 8.0 * nome * angle[0] * angle[1]
    slope *= 1.0 - 2.0 * nome**3 * double + 3.0 * nome**8 * (double * double - 1.0)
    lag = mean * slope / even_sums(nome, double)[1]
    root = math.sqrt(math.sqrt(m))
    null = math.sqrt(mean) * (1.0 + nome**2 + nome**6)

    # exp(-x) at the start, where |x| is half of half a period at most, and now.
    high = abs(sinh) + math.sqrt(one * one + sinh * sinh)
    fall = high / one if sinh < 0.0 else one / high
    began = _hyperbolic(polhode, angle, nome, root, null, fall)
    period = -math.log(nome) if nome > 0.0 else math.inf
    x = mean * gained
    halves = np.rint(x / period)
    if halves != 0.0:
        x -= period * halves
    fall *= math.exp(-x)
    if fall * fall < nome:
        fall, halves = fall / nome, halves + 1.0
    elif fall * fall * nome > 1.0:
        fall, halves = fall * nome, halves - 1.0
    now = _hyperbolic(polhode, angle, nome, root, null, fall)
    sign = 1.0 - 2.0 * abs(halves % 2.0)
    e1, e2, e3 = now.momentum
    turned = less(less(now.half_phase, began.half_phase), power(angle, halves))
    return Path(lag, turned, (sign * e1, sign * e2, e3))


@inner
def _hyperbolic(polhode: Polhode, angle: Pair, nome: float, root: float, null: float, fall: float) -> Seen:
    """Return what is seen at i x, x = pi u/(2 K'), from exp(-x); root: sqrt(k); null: theta3(0)/theta2(0) nome^(1/4) 2.

    DLMF 22.6(iv): cn = theta2(0)/theta4(0) theta4/theta2, sn = theta3(0)/theta4(0) theta1/(i theta2) and
    dn = theta2(0)/theta3(0) theta3/theta2, where theta4(0)/theta3(0) = sqrt(k).  Half a period on, L1 and L2 have
    changed their signs and all else is the same.
    """
    (a1, a2, a3), aspect = polhode.amplitudes, polhode.aspect
    side = 1.0
    if fall > 1.0:
        fall, side = 1.0 / fall, -1.0
    decay = fall * fall
    waves = hyperbolic(nome, decay, 1.0 - decay)
    growth = nome / decay
    near, far = growth + nome * decay, nome**6 * growth**3 + nome**9 * decay**3
    even = 1.0 + (nome * growth) ** 2 + nome**4 * decay * decay
    theta1, theta2 = side * alternating(waves.sinh), total(waves.cosh)
    theta3, theta4 = 2.0 * fall * (even + near + far), 2.0 * fall * (even - near - far)
    per = root * theta2
    momentum = (a1 * null * theta4 / per, a2 * theta1 / per, a3 * null * theta3 / theta2)
    sinh_cosine, cosh_sine = shifted(waves, angle)
    meridian = (aspect[0] * null * theta4, aspect[1] * theta1)
    return Seen(momentum, half(less((cosh_sine, side * sinh_cosine), meridian)))


@inner
def _turn_between(start: Vector, speed: float, path: Path, turned: float) -> Quaternion:
    """Return the turn of the body since the start, in its own axes, when L's shortest turn onto axis 3 has gone round.

    It is of any length.  speed: |L|; turned: A t [rad].
    """
    d1, d2, d3 = start
    e1, e2, e3 = path.momentum
    c, s = times_complex(fused_half_turn(turned), path.turned)
    return product((speed + d3, -d2, d1, 0.0), product((c, 0.0, 0.0, s), (speed + e3, e2, -e1, 0.0)))


@inner
def _along_polhode(
    start: Vector, t: float, inverse_middle: float, gyroscopic: Vector, sense: float
) -> tuple[Quaternion, Vector]:
    """Return the turn of the body, in its own axes and of any length, and L_body after t [s].

    All in the axes of the frame: start: L_body, first and third not negative; inverse_middle: 1/I2; gyroscopic: the
    differences of inverse moments, none negative; sense: the sign of I3 - I2.
    """
    L1, L2, L3 = start
    g1, g2, g3 = gyroscopic
    root1, root2 = math.sqrt(g1), math.sqrt(g2)
    # L^2 - 2E I1, 2E I3 - L^2 and L^2 - 2E I2, each over the moment that makes it a sum of these differences.
    above, below = L2 * L2 * g3 + L3 * L3 * g2, L1 * L1 * g2 + L2 * L2 * g1
    beyond = L3 * L3 * g1 - L1 * L1 * g3
    a1, a2, a3 = math.sqrt(below / g2), math.sqrt(below / g1), math.sqrt(above / g2)
    per_above = 1.0 / (above * g1)
    polhode = Polhode(
        m=below * g3 * per_above,
        m1=beyond * g2 * per_above,
        amplitudes=(a1, a2, a3),
        aspect=(root1, root2),
        phase=(L1 / a1, L2 / a2),
        shift=(math.sqrt(g3) / root2, root1 / root2),
    )
    rate, speed = sense * math.sqrt(above * g1), math.sqrt(dot(start, start))
    path = _circular_path(polhode, rate * t) if polhode.m <= polhode.m1 else _hyperbolic_path(polhode, rate * t)
    turn = _turn_between(start, speed, path, (speed * inverse_middle - rate * path.lag) * t)
    return turn, path.momentum


@inner
def _picked(axes: Axes, a: Vector) -> Vector:
    """Return the components of a vector, or of a tensor in its principal axes, in the order of the frame."""
    return (a[axes[0]], a[axes[1]], a[axes[2]])


@inner
def _placed(axes: Axes, a: Vector) -> Vector:
    """Return the components of a frame's vector in the order of the body."""
    x = a[0] if axes[0] == 0 else a[1] if axes[1] == 0 else a[2]
    y = a[0] if axes[0] == 1 else a[1] if axes[1] == 1 else a[2]
    z = a[0] if axes[0] == 2 else a[1] if axes[1] == 2 else a[2]
    return (x, y, z)


@inner
def _turned(
    q: Quaternion, momentum: Vector, t: float, inverse_moments: Vector, gyroscopic: Vector
) -> tuple[Quaternion, Vector]:
    """Return q and L_body after t [s].

    The frame: L circles axis 3, of the least or the greatest moment, axis 2 has the middle one; its axes are the
    body's or against them, so that the first and the third component of L are not negative.
    """
    differences = (abs(gyroscopic[0]), abs(gyroscopic[1]), abs(gyroscopic[2]))
    least, middle, greatest = by_moment(inverse_moments)
    if momentum[greatest] ** 2 * differences[least] >= momentum[least] ** 2 * differences[greatest]:
        axes, sense = (least, middle, greatest), 1.0
    else:
        axes, sense = (greatest, middle, least), -1.0
    start = _picked(axes, momentum)
    handedness = 1.0 if (middle - axes[0]) % 3 == 1 else -1.0
    first, third = math.copysign(1.0, start[0]), math.copysign(1.0, start[2])
    signs = (first, handedness * first * third, third)
    start, differences = times(signs, start), _picked(axes, differences)
    if momentum_rate(start, differences) == (0.0, 0.0, 0.0):
        return product(q, exponential(scale(t / 2.0, times(inverse_moments, momentum)))), momentum
    turn, end = _along_polhode(start, t, inverse_moments[middle], differences, sense)
    x, y, z = _placed(axes, times(signs, (turn[1], turn[2], turn[3])))
    return product(q, normalise((turn[0], x, y, z))), _placed(axes, times(signs, end))


@inner
def _swept(momentum: Vector) -> Vector:
    """Return the vector without components whose square would be nothing: they turn nobody in the life of a double."""
    x, y, z = momentum
    speck = SPECK * max(abs(x), abs(y), abs(z))
    return x if abs(x) > speck else 0.0, y if abs(y) > speck else 0.0, z if abs(z) > speck else 0.0


@kernel
def exact(spins: NDArray[np.float64], n: int, dt: float, inverse_moments: Vector, gyroscopic: Vector | None) -> None:
    """Advance torque-free rotations in closed form to n dt after the instant that their rows remember.

    Parameters
    ----------
    spins : (N, 14)
        changed in place: attitude q, angular momentum L in body axes [kg m2/s], and both when the count of n began
    n
        number of steps
    dt : s
    inverse_moments : (3,), 1/(kg m2)
    gyroscopic : (3,), 1/(kg m2)
        `Body.gyroscopic`; None for equal moments
    """
    t = n * dt
    for spin in spins:
        q, momentum = load_anchor(spin)
        if gyroscopic is None:
            q = product(q, exponential(scale(t / 2.0, times(inverse_moments, momentum))))
        elif dot(momentum, momentum) > 0.0:
            q, momentum = _turned(q, _swept(momentum), t, inverse_moments, gyroscopic)
        store(spin, q, momentum)
