"""When a body in free flight meets the plane: no contact is passed, by a bound of every point's third derivative.

From an instant, a point's height stays above h + h' t + h'' t^2 / 2 - J t^3 / 6, J the greatest |h'''| there can be;
so a step that keeps all of these above zero passes no contact: conservative advancement (Mirtich & Canny,
"Impulse-based simulation of rigid bodies", I3D (1995) 181), here of order three.  The last digits are Newton's.
"""

import math
from typing import NamedTuple

from tumble.solver.body import momentum_rate
from tumble.solver.compilation import inner
from tumble.solver.contact.ground import Ground, on_rim, rim_count
from tumble.solver.integrators.exact import _swept, _turned
from tumble.solver.quaternion import Quaternion, exponential, normalise, product, rotate_back
from tumble.solver.vectors import Vector, add, cross, dot, scale, times

# Of the body's reach: the height at which Newton's steps take over; and what doubles lose, per radian turned.
NEAR, LOST_PER_RADIAN = 2.0**-34, 2.0**-49
# Of a step that the bound allows, what is taken: its root is found by few Newton's steps.
SAFE, NEARLY = 1.0 - 1e-9, 1e-6
# Of the reach: what a Newton's step may leave.
LEFT = 2.0**-56
MOST_ADVANCES, MOST_NEWTON = 20_000, 60
# Of a disc's step: its parts, how much shorter than all before the last one is, and what of a part is taken.
MOST_PARTS, SHORT, ALMOST = 20, 0.1, 1.0 - 1e-7
NONE, MET, LOST = 0, 1, 2


class Moving(NamedTuple):
    """A flight at an instant: attitude, angular momentum, body axes, and as the body sees the plane: unit normal n,

    n', n'', all body axes; height of the centre [m], its rate.
    """

    q: Quaternion
    l_body: Vector
    normal: Vector
    first: Vector
    second: Vector
    height: float
    rate: float


@inner
def turned_freely(q: Quaternion, l_body: Vector, t: float, ground: Ground) -> tuple[Quaternion, Vector]:
    """Return attitude and angular momentum after t [s] of free rotation."""
    if dot(l_body, l_body) == 0.0:
        return q, l_body
    g = ground.gyroscopic
    if g[0] == 0.0 and g[1] == 0.0 and g[2] == 0.0:
        turn = exponential(scale(t / 2.0, times(ground.inverse_moments, l_body)))
        return normalise(product(q, turn)), l_body
    if g[0] == 0.0 or g[1] == 0.0 or g[2] == 0.0:
        return _turned_top(q, l_body, t, ground)
    q, l_body = _turned(q, _swept(l_body), t, ground.inverse_moments, g)
    return normalise(q), l_body


@inner
def _turned_top(q: Quaternion, l_body: Vector, t: float, ground: Ground) -> tuple[Quaternion, Vector]:
    """Return the same of a symmetric body: its axis goes round L at |L| / I, and it turns about the axis as well."""
    g, per_moment, zero = ground.gyroscopic, ground.inverse_moments, 0.0
    if g[0] == zero:
        along, across, axis = g[1] * l_body[0], per_moment[1], (1.0, zero, zero)
    elif g[1] == zero:
        along, across, axis = g[2] * l_body[1], per_moment[0], (zero, 1.0, zero)
    else:
        along, across, axis = g[0] * l_body[2], per_moment[0], (zero, zero, 1.0)
    own = exponential(scale(0.5 * t * along, axis))
    turn = product(exponential(scale(0.5 * t * across, l_body)), own)
    return normalise(product(q, turn)), rotate_back(own, l_body)


@inner
def moving_at(z: float, q: Quaternion, v_z: float, l_body: Vector, t: float, ground: Ground) -> Moving:
    """Return the flight from z, q, v_z, L after t [s]."""
    q, l_body = turned_freely(q, l_body, t, ground)
    pull = ground.gravity[2]
    n = rotate_back(q, (0.0, 0.0, 1.0))
    w = times(ground.inverse_moments, l_body)
    w_rate = times(ground.inverse_moments, momentum_rate(l_body, ground.gyroscopic))
    first = cross(n, w)
    second = add(cross(first, w), cross(n, w_rate))
    return Moving(q, l_body, n, first, second, z + t * v_z + 0.5 * pull * t * t, v_z + pull * t)


@inner
def fastest_spin(q: Quaternion, l_body: Vector, ground: Ground) -> float:
    """Return what |w| never exceeds in free rotation [rad/s]: by energy and by angular momentum."""
    w = times(ground.inverse_moments, l_body)
    least = min(ground.moments[0], ground.moments[1], ground.moments[2])
    if ground.moments[0] == ground.moments[1] == ground.moments[2]:
        return math.sqrt(dot(w, w))
    return math.sqrt(min(dot(l_body, l_body) / (least * least), dot(w, l_body) / least))


@inner
def greatest_jerk(fastest: float, ground: Ground) -> float:
    """Return what the third derivative of a point's height never exceeds, over its distance from the centre [1/s3].

    With c the greatest coefficient of Euler's equations, w_i' = c_i w_j w_k makes |w'| <= c |w|^2 / sqrt(3) and
    |w''| <= sqrt(2) c |w'| |w|, and the third derivative of p is
    w'' x p + 2 w' x (w x p) + w x (w' x p) + w x (w x (w x p)).
    """
    a, b, c = ground.moments
    most = max(abs(b - c) / a, abs(c - a) / b, abs(a - b) / c)
    return (1.0 + most * (math.sqrt(3.0) + most * math.sqrt(2.0 / 3.0))) * fastest * fastest * fastest


@inner
def safe_step(h: float, h_1: float, h_2: float, jerk: float) -> float:
    """Return how long h + h_1 t + h_2 t^2 / 2 - jerk t^3 / 6 stays above zero, from h >= 0, not more."""
    if jerk == 0.0:
        return _safe_parabola(h, h_1, h_2)
    t = 0.0
    root = h_2 * h_2 + 2.0 * jerk * h_1
    if h_1 < 0.0 or (h_1 == 0.0 and h_2 <= 0.0):
        if h_2 > 0.0 and root > 0.0:
            # It falls to a least value; if that is above zero it rises from there to a greatest, beyond which it falls.
            t = -2.0 * h_1 / (h_2 + math.sqrt(root))
        if t == 0.0 or h + t * (h_1 + t * (h_2 / 2.0 - t * jerk / 6.0)) <= 0.0:
            return _first_zero(h, h_1, h_2, jerk, t)
    return _last_zero(h, h_1, h_2, jerk)


@inner
def _safe_parabola(h: float, h_1: float, h_2: float) -> float:
    square = h_1 * h_1 - 2.0 * h_2 * h
    if square < 0.0 or (h_1 >= 0.0 and h_2 >= 0.0):
        return math.inf
    root = math.sqrt(square)
    return 2.0 * h / (root - h_1) if h_1 < 0.0 else (h_1 + root) / -h_2


@inner
def _first_zero(h: float, h_1: float, h_2: float, jerk: float, least: float) -> float:
    """Return the zero of a cubic that falls from h: where it is convex, Newton's steps from 0 stay before it."""
    if h <= 0.0:
        return 0.0
    if least == 0.0:
        # It falls all the way.
        return _last_zero(h, h_1, h_2, jerk)
    t = 0.0
    for _ in range(6):
        value = h + t * (h_1 + t * (h_2 / 2.0 - t * jerk / 6.0))
        slope = h_1 + t * (h_2 - t * jerk / 2.0)
        if slope >= 0.0:
            break
        t -= value / slope
        if value <= NEARLY * h:
            break
    return t * SAFE


@inner
def _last_zero(h: float, h_1: float, h_2: float, jerk: float) -> float:
    """Return the last zero of the cubic, a little less: Newton's steps from beyond it.

    Up to a place where it is not negative the cubic is nowhere so: it has no dip below zero where this is asked for.
    """
    if h_2 < 0.0:
        t = _safe_parabola(h, h_1, h_2)
    else:
        t = max((18.0 * h / jerk) ** (1.0 / 3.0), math.sqrt(18.0 * max(h_1, 0.0) / jerk), 9.0 * h_2 / jerk)
    for _ in range(MOST_NEWTON):
        value = h + t * (h_1 + t * (h_2 / 2.0 - t * jerk / 6.0))
        slope = h_1 + t * (h_2 - t * jerk / 2.0)
        if slope >= 0.0:
            break
        then = max(t - value / slope, 0.0)
        is_near, t = abs(then - t) <= NEARLY * t, then
        if is_near:
            break
    t *= SAFE
    while h + t * (h_1 + t * (h_2 / 2.0 - t * jerk / 6.0)) < 0.0:
        t *= 0.5
    return t


@inner
def search(
    z: float, q: Quaternion, v_z: float, l_body: Vector, begun: float, until: float, ground: Ground
) -> tuple[int, float, int]:
    """Return whether a flight meets the plane by an instant, NONE, MET or LOST, when or up to where it does not, and by

    which point.  begun: an instant up to which it is known to meet none [s].
    """
    if ground.rim > 0.0:
        return _search_rims(z, q, v_z, l_body, begun, until, ground)
    points, pull = ground.points, ground.gravity[2]
    if len(points) == 0:
        return NONE, math.inf, 0
    fastest = fastest_spin(q, l_body, ground)
    third = greatest_jerk(fastest, ground)
    t = begun
    for _ in range(MOST_ADVANCES):
        height, rate = z + t * v_z + 0.5 * pull * t * t, v_z + pull * t
        close = ground.reach * (NEAR + LOST_PER_RADIAN * (1.0 + fastest * t))
        clear = height - ground.reach - close
        if clear > ground.reach:
            step = _safe_parabola(clear, rate, pull)
        else:
            now = moving_at(z, q, v_z, l_body, t, ground)
            lowest, least = 0, math.inf
            for number in range(len(points)):
                p = (points[number, 0], points[number, 1], points[number, 2])
                above = height + dot(now.normal, p)
                # What has just left the plane is on it still, and rises.
                if above < close and t > 0.0 and rate + dot(now.first, p) < 0.0:
                    return _refined(z, q, v_z, l_body, t, number, close, fastest, ground)
                if above < least:
                    lowest, least = number, above
            step = _safe_of(now, lowest, third, math.inf, ground)
            for number in range(len(points)):
                if number != lowest:
                    step = _safe_of(now, number, third, step, ground)
        if not step > 0.0:
            return LOST, t, 0
        t += step
        if t > until:
            return NONE, t, 0
    return LOST, t, 0


@inner
def _search_rims(
    z: float, q: Quaternion, v_z: float, l_body: Vector, begun: float, until: float, ground: Ground
) -> tuple[int, float, int]:
    """Return the same of a disc."""
    fastest, pull = fastest_spin(q, l_body, ground), ground.gravity[2]
    third = greatest_jerk(fastest, ground)
    t = begun
    for _ in range(MOST_ADVANCES):
        height, rate = z + t * v_z + 0.5 * pull * t * t, v_z + pull * t
        close = ground.reach * (NEAR + LOST_PER_RADIAN * (1.0 + fastest * t))
        clear = height - ground.reach - close
        if clear > ground.reach:
            step = _safe_parabola(clear, rate, pull)
        else:
            now = moving_at(z, q, v_z, l_body, t, ground)
            least = 0.0
            for number in range(rim_count(ground)):
                p = on_rim(now.normal, number, ground)
                above = height + dot(now.normal, p)
                least = min(least, above)
                if above < close and t > 0.0 and rate + dot(now.first, p) < 0.0:
                    return _refined_rim(z, q, v_z, l_body, t, number, fastest, ground)
            step = _safe_rims(now, height - least, third, until - t + 1.0, ground)
        if not step > 0.0:
            return LOST, t, 0
        t += step
        if t > until:
            return NONE, t, 0
    return LOST, t, 0


@inner
def _safe_rims(now: Moving, height: float, third: float, most: float, ground: Ground) -> float:
    """Return how long no point of a disc can be below the plane, at most so long: in parts, while they are long."""
    t = 0.0
    for _ in range(MOST_PARTS):
        part = _safe_part(now, height, third, t, most - t, ground)
        t += part
        if t >= most or part < SHORT * t:
            break
    return t


@inner
def _safe_part(now: Moving, height: float, third: float, t: float, most: float, ground: Ground) -> float:
    """Return how long after t no point of a disc can be below the plane, at most so long.

    With m = n + n' t + n'' t^2 / 2, P across the axis, z along it, a the radius and b half the thickness, the lowest
    point is above the plane by at least the centre's height less a |P m| + b |z m| + |p| J t^3 / 6.  From t on, by u,
    m is m + m' u + n'' u^2 / 2: what a |P m| + b |z m| is of the tangent, and u^2 / 2 times what it is of n'', are
    together no less than it is.  So bounded the height is concave in u: its zero is found by Newton's steps.
    """
    pull, jerk = ground.gravity[2], third * ground.reach
    m = add(now.normal, scale(t, add(now.first, scale(0.5 * t, now.second))))
    m_1 = add(now.first, scale(t, now.second))
    z, z_1 = height + t * (now.rate + 0.5 * t * pull), now.rate + t * pull
    bend = max(0.5 * (_beneath(now.second, now.second, ground)[0] - pull), 0.0)
    u = 0.0
    for tries in range(MOST_NEWTON):
        lowest, falls = _beneath(add(m, scale(u, m_1)), m_1, ground)
        after = t + u
        value = z + u * (z_1 - bend * u) - lowest - jerk * after * after * after / 6.0
        slope = z_1 - 2.0 * bend * u - falls - 0.5 * jerk * after * after
        if tries == 0:
            # The bound is nowhere above this parabola.
            square = slope * slope + 4.0 * bend * max(value, 0.0)
            if slope >= 0.0:
                u = (slope + math.sqrt(square)) / (2.0 * bend) if bend > 0.0 else most
            else:
                u = 2.0 * max(value, 0.0) / (math.sqrt(square) - slope)
            u = min(u, most)
        elif value >= 0.0:
            return u
        else:
            # Newton's steps come from beyond the zero: a little less is before it, once they are near.
            u = max(ALMOST * (u - value / slope), 0.0)
    return 0.0


@inner
def _beneath(m: Vector, m_1: Vector, ground: Ground) -> tuple[float, float]:
    """Return a |P m| + b |z m|, how far a disc reaches against m, and its rate."""
    size = math.sqrt(m[0] * m[0] + m[1] * m[1])
    turns = (m[0] * m_1[0] + m[1] * m_1[1]) / size if size > 0.0 else 0.0
    return (
        ground.rim * size + ground.half * abs(m[2]),
        ground.rim * turns + math.copysign(ground.half * m_1[2], m[2] * m_1[2]),
    )


@inner
def _refined_rim(
    z: float, q: Quaternion, v_z: float, l_body: Vector, t: float, number: int, fastest: float, ground: Ground
) -> tuple[int, float, int]:
    """Return when the lowest point of a rim meets the plane, by Newton's steps."""
    for _ in range(MOST_NEWTON):
        now = moving_at(z, q, v_z, l_body, t, ground)
        p = on_rim(now.normal, number, ground)
        falls = -now.rate - dot(now.first, p)
        if not falls > 0.0:
            return LOST, t, number
        step = (now.height + dot(now.normal, p)) / falls
        t += step
        # |h''| is no more than that of the point, and of its going round the rim.
        bend = fastest * fastest * (2.0 * ground.reach + ground.rim / math.hypot(now.normal[0], now.normal[1]))
        if (bend - ground.gravity[2]) * step * step <= LEFT * ground.reach or abs(step) <= 2.0**-52 * t:
            return MET, t, number
    return MET, t, number


@inner
def _safe_of(now: Moving, number: int, third: float, step: float, ground: Ground) -> float:
    """Return a step in which a point stays above the plane, at most the one given."""
    points = ground.points
    p = (points[number, 0], points[number, 1], points[number, 2])
    h, h_1 = max(now.height + dot(now.normal, p), 0.0), now.rate + dot(now.first, p)
    h_2, jerk = ground.gravity[2] + dot(now.second, p), third * math.sqrt(dot(p, p))
    # Most points are far: no root is needed.
    if h + step * (min(h_1, 0.0) + step * (min(h_2, 0.0) / 2.0 - step * jerk / 6.0)) > 0.0:
        return step
    return min(step, safe_step(h, h_1, h_2, jerk))


@inner
def _refined(
    z: float,
    q: Quaternion,
    v_z: float,
    l_body: Vector,
    t: float,
    number: int,
    close: float,
    fastest: float,
    ground: Ground,
) -> tuple[int, float, int]:
    """Return when a point that is close meets the plane, by Newton's steps; another that does so before takes over."""
    points = ground.points
    # |h''| is no more than that, by the same bounds.
    bend = 2.0 * fastest * fastest * ground.reach + abs(ground.gravity[2])
    for _ in range(MOST_NEWTON):
        now = moving_at(z, q, v_z, l_body, t, ground)
        least = math.inf
        for other in range(len(points)):
            p = (points[other, 0], points[other, 1], points[other, 2])
            height, falls = now.height + dot(now.normal, p), -now.rate - dot(now.first, p)
            if falls > 0.0 and height < 2.0 * close and height < least * falls:
                number, least = other, height / falls
        if not math.isfinite(least):
            return LOST, t, number
        t += least
        if bend * least * least <= LEFT * ground.reach or abs(least) <= 2.0**-52 * t:
            return MET, t, number
    return MET, t, number
