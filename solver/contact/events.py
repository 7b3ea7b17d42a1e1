"""From event to event: closed forms between impacts, a certified next contact, and the law of each impact.

A row is one throw: the state asked for, the state at the last event and when that was, which motion follows, and when
that ends by itself.  The events do not depend on the instants asked for.
"""

import math

import numpy as np
from numpy.typing import NDArray

from tumble.solver.compilation import inner, kernel
from tumble.solver.contact import face, pinned
from tumble.solver.contact.approach import LOST, MET, search, turned_freely
from tumble.solver.contact.ground import (
    Ground,
    lever_of,
    momentum_of,
    point_count,
    response,
    solved,
    spin_of,
    struck,
    velocity_at,
)
from tumble.solver.contact.impact import velocity_after
from tumble.solver.contact.slip import Slip, ending, path, placed, slip_from, time_at, velocity, y_at
from tumble.solver.contact.turning import turned_by, turned_steadily
from tumble.solver.integrators.magnus6 import EARLY, LATE
from tumble.solver.quaternion import Quaternion, rotate, rotate_back
from tumble.solver.vectors import Vector, add, cross, dot, scale

Array = NDArray[np.float64]
State = tuple[Vector, Quaternion, Vector, Vector]

# What a row holds: the state (13), that of the last event (13), and these.
ANCHOR, SINCE, KIND, UNTIL, THEN, SEARCHED, FASTEST, POINT, OTHER = 13, 26, 27, 28, 29, 30, 31, 32, 33
PULL, SPIN_RATE, WHY, IMPACTS, GAINED, LOST_J, LENGTH, WIDTH = 34, 37, 40, 41, 42, 43, 44, 45

# Motions.
UNKNOWN, FREE, STEADY, SLIPPING, PINNED, ENDED = 0.0, 1.0, 2.0, 3.0, 4.0, 5.0
# What happens where one ends.
GOES_ON, STRIKES, STOPS, ENDS = 0.0, 1.0, 2.0, 3.0

# Why the motion is not known any more.
REASONS = (
    "",
    "several points meet the plane at once, and the law has several answers",
    "a corner stays on the plane, or an edge in a motion that is not in a plane",
    "a face spins on the plane, and the law leaves open how its pressure is spread",
    "the body tips over its face while it slides or spins",
    "an edge or a tip that turned about where it was begins to slip",
    "a point grazes the plane, or impacts follow one another without end",
    "there were too many impacts",
)
SEVERAL, CORNER, FACE_SPINS, FACE_TIPS, SLIPS, GRAZES, TOO_MANY = 1, 2, 3, 4, 5, 6, 7
MOST_IMPACTS = 1_000_000

# Of body and distance, and of the greatest speed so far: what a gap and a speed are none below.
TOUCHING, STILL = 2.0**-45, 2.0**-45
# Of the acceleration that presses the body on: what is no slope but for rounding.
LEVEL = 2.0**-46
# How finely the turn of a sphere is followed whose slip turns.
FINE, MOST_TURNS = 0.05, 4000


@inner
def _load(row: Array, at: int) -> State:
    return (
        (row[at], row[at + 1], row[at + 2]),
        (row[at + 3], row[at + 4], row[at + 5], row[at + 6]),
        (row[at + 7], row[at + 8], row[at + 9]),
        (row[at + 10], row[at + 11], row[at + 12]),
    )


@inner
def _store(row: Array, at: int, state: State) -> None:
    x, q, v, l_body = state
    row[at], row[at + 1], row[at + 2] = x
    row[at + 3], row[at + 4], row[at + 5], row[at + 6] = q
    row[at + 7], row[at + 8], row[at + 9] = v
    row[at + 10], row[at + 11], row[at + 12] = l_body


@inner
def _spread(ground: Ground) -> float:
    """Return how much more a touching point gains per force along the plane than the centre: 1 + m r^2 / I."""
    return 1.0 + ground.mass * ground.radius * ground.radius * ground.inverse_moments[0]


@inner
def _unit(x: float, y: float) -> tuple[float, float]:
    size = math.hypot(x, y)
    return (x / size, y / size) if size > 0.0 else (0.0, 0.0)


# What follows an event.


@inner
def _begin(row: Array, touching: NDArray[np.int64], ground: Ground) -> None:
    """Say which motion follows the state of the last event, and when it ends by itself."""
    x, q, v, l_body = _load(row, ANCHOR)
    w = spin_of(q, l_body, ground)
    speed = math.sqrt(dot(v, v)) + math.sqrt(dot(w, w)) * ground.reach
    pull = math.sqrt(dot(ground.gravity, ground.gravity))
    row[FASTEST] = max(row[FASTEST], speed, math.sqrt(pull * ground.reach))
    still = STILL * row[FASTEST]
    near = TOUCHING * (ground.reach + math.sqrt(dot(x, x)) + ground.far)
    meets, stays, met = 0, 0, 0
    count = point_count(ground)
    for number in range(count):
        lever = lever_of(q, number, ground)
        if x[2] + lever[2] <= near:
            rate = velocity_at(v, w, lever)[2]
            if rate < -still:
                # From the far end: those that stay are counted from the near one.
                meets, met = meets + 1, number
                touching[count - meets] = number
            elif rate <= still:
                touching[stays] = number
                stays += 1
    if meets > 1 or (meets == 1 and stays > 0):
        if not _rocks(row, touching, meets, stays, count, ground):
            _end(row, SEVERAL)
    elif meets == 1:
        row[KIND], row[UNTIL], row[THEN], row[POINT] = FREE, 0.0, STRIKES, met
    elif stays > 0 and ground.gravity[2] < 0.0:
        if ground.radius > 0.0:
            _begin_sphere(row, still, ground)
        else:
            _begin_lasting(row, touching, stays, still, ground)
    elif ground.radius > 0.0:
        _begin_fall(row, ground)
    else:
        row[KIND], row[UNTIL], row[THEN], row[SEARCHED] = FREE, math.inf, GOES_ON, 0.0


@inner
def _end(row: Array, why: int) -> None:
    row[KIND], row[UNTIL], row[WHY] = ENDED, math.inf, why


@inner
def _steady(row: Array, pull: Vector, spin_rate: Vector, until: float, then: float) -> None:
    """Let the centre accelerate, and the spin change, at constant rates."""
    row[KIND], row[UNTIL], row[THEN] = STEADY, until, then
    row[PULL], row[PULL + 1], row[PULL + 2] = pull
    row[SPIN_RATE], row[SPIN_RATE + 1], row[SPIN_RATE + 2] = spin_rate


@inner
def _begin_fall(row: Array, ground: Ground) -> None:
    """Let a sphere fly: its lowest point falls as its centre does."""
    height, rate, pull = max(row[ANCHOR + 2] - ground.radius, 0.0), row[ANCHOR + 9], ground.gravity[2]
    square = rate * rate - 2.0 * pull * height
    until = math.inf
    if square >= 0.0 and (rate < 0.0 or pull < 0.0):
        root = math.sqrt(square)
        until = (rate + root) / -pull if rate >= 0.0 else 2.0 * height / (root - rate)
    row[POINT] = 0.0
    _steady(row, ground.gravity, (0.0, 0.0, 0.0), until, STRIKES)


@inner
def _begin_sphere(row: Array, still: float, ground: Ground) -> None:
    """Let a sphere on the plane slide, slip or roll."""
    x, q, v, l_body = _load(row, ANCHOR)
    x, v = (x[0], x[1], ground.radius), (v[0], v[1], 0.0)
    w = spin_of(q, l_body, ground)
    press, slope = -ground.gravity[2], (ground.gravity[0], ground.gravity[1], 0.0)
    steep, spread = math.hypot(slope[0], slope[1]), _spread(ground)
    slip = velocity_at(v, w, (0.0, 0.0, -ground.radius))
    fast = math.hypot(slip[0], slip[1])
    hold = ground.friction * press
    none = (0.0, 0.0, 0.0)
    if hold == 0.0:
        _store(row, ANCHOR, (x, q, v, l_body))
        _steady(row, slope, none, math.inf, GOES_ON)
    elif fast > still:
        _store(row, ANCHOR, (x, q, v, l_body))
        if steep <= LEVEL * press:
            c = scale(-hold / fast, (slip[0], slip[1], 0.0))
            _steady(row, add(slope, c), _spun_up(c, ground), fast / (hold * spread), STOPS)
        else:
            found = slip_from((slip[0], slip[1]), (slope[0], slope[1]), hold * spread)
            row[KIND], row[UNTIL], row[THEN] = SLIPPING, ending(found), STOPS
    elif steep <= spread * hold:
        _store(row, ANCHOR, (x, q, v, momentum_of(q, _rolling(v, w, ground), ground)))
        pull = scale(1.0 - 1.0 / spread, slope)
        _steady(row, pull, scale(1.0 / ground.radius, cross((0.0, 0.0, 1.0), pull)), math.inf, GOES_ON)
    else:
        _store(row, ANCHOR, (x, q, v, momentum_of(q, _rolling(v, w, ground), ground)))
        c = scale(-hold / steep, slope)
        _steady(row, add(slope, c), _spun_up(c, ground), math.inf, GOES_ON)


@inner
def _rolling(v: Vector, w: Vector, ground: Ground) -> Vector:
    """Return the spin of a sphere whose lowest point has no slip."""
    return (-v[1] / ground.radius, v[0] / ground.radius, w[2])


@inner
def _spun_up(force: Vector, ground: Ground) -> Vector:
    """Return how the spin of a sphere changes by a force at its lowest point, per mass."""
    torque = cross((0.0, 0.0, -ground.radius), scale(ground.mass, force))
    return scale(ground.inverse_moments[0], torque)


@inner
def _begin_lasting(row: Array, touching: NDArray[np.int64], stays: int, still: float, ground: Ground) -> None:
    """Let a body with corners on the plane rest, slide, or turn about an edge or a tip."""
    _, q, _, _ = _load(row, ANCHOR)
    near = face.ROUNDED * ground.reach
    places = face.places_of(q, touching, stays, ground)
    if stays == 1:
        _begin_pinned(row, touching[0], -1, still, ground)
    elif not face.spans_a_face(places, stays, near):
        first, second = _ends_of(places, stays)
        _begin_pinned(row, touching[first], touching[second], still, ground)
    else:
        _begin_face(row, touching, stays, places, near, still, ground)


@inner
def _ends_of(places: Array, count: int) -> tuple[int, int]:
    """Return the two places of a line that are furthest apart."""
    first, second, size = 0, 0, -1.0
    for a in range(count):
        for b in range(a + 1, count):
            apart = math.hypot(places[a, 0] - places[b, 0], places[a, 1] - places[b, 1])
            if apart > size:
                first, second, size = a, b, apart
    return first, second


@inner
def _begin_face(
    row: Array, touching: NDArray[np.int64], count: int, places: Array, near: float, still: float, ground: Ground
) -> None:
    """Let a body that lies on a face glide, slide, rest or tip over an edge of the face."""
    x, q, v, l_body = _load(row, ANCHOR)
    w = spin_of(q, l_body, ground)
    height = 0.0
    for number in range(count):
        height -= lever_of(q, touching[number], ground)[2] / count
    x, v, w = (x[0], x[1], height), (v[0], v[1], 0.0), (0.0, 0.0, w[2])
    press, slope = -ground.gravity[2], (ground.gravity[0], ground.gravity[1], 0.0)
    steep, fast = math.hypot(slope[0], slope[1]), math.hypot(v[0], v[1])
    hold, none = ground.friction * press, (0.0, 0.0, 0.0)
    spins = abs(w[2]) * ground.reach > still
    if hold == 0.0:
        l_body = momentum_of(q, w, ground)
        needed = cross(w, rotate(q, l_body))
        weight = ground.mass * press
        at = (-needed[1] / weight, needed[0] / weight)
        if face.margin(places, count, at, near)[0] < -near:
            _end(row, FACE_TIPS)
        else:
            _store(row, ANCHOR, (x, q, v, l_body))
            _steady(row, slope, none, math.inf, GOES_ON)
        return
    if spins:
        _end(row, FACE_SPINS)
        return
    reach = ground.friction * height
    down = _unit(slope[0], slope[1])
    if fast > still:
        along = _unit(v[0], v[1])
        level = steep <= LEVEL * press
        if face.margin_of_arc(places, count, along, along if level else down, reach, near) < -near:
            _end(row, FACE_TIPS)
            return
        _store(row, ANCHOR, (x, q, v, none))
        if level:
            _steady(row, add(slope, (-hold * along[0], -hold * along[1], 0.0)), none, fast / hold, STOPS)
        else:
            row[KIND], row[THEN] = SLIPPING, STOPS
            row[UNTIL] = ending(slip_from((v[0], v[1]), (slope[0], slope[1]), hold))
        return
    _store(row, ANCHOR, (x, q, none, none))
    if steep <= hold * (1.0 + LEVEL):
        at = (height * slope[0] / press, height * slope[1] / press)
        inside, first, second = face.margin(places, count, at, near)
        if inside < -near:
            _begin_pinned(row, touching[first], touching[second], still, ground)
        else:
            _steady(row, none, none, math.inf, GOES_ON)
    elif face.margin(places, count, (reach * down[0], reach * down[1]), near)[0] < -near:
        _end(row, FACE_TIPS)
    else:
        _steady(row, add(slope, scale(-hold / steep, slope)), none, math.inf, GOES_ON)


@inner
def _begin_pinned(row: Array, first: int, second: int, still: float, ground: Ground) -> None:
    """Let a body turn about a tip, or an edge, that friction holds; end where it does not."""
    state = _load(row, ANCHOR)
    x, q, v, l_body = state
    w = spin_of(q, l_body, ground)
    lever = lever_of(q, first, ground)
    slip = velocity_at(v, w, lever)
    if math.hypot(slip[0], slip[1]) > still:
        _end(row, CORNER)
        return
    if second >= 0 and not _is_in_a_plane(q, w, first, second, still, ground):
        _end(row, CORNER)
        return
    # The point has no velocity: the centre moves as the spin has it.
    v = scale(-1.0, cross(w, lever))
    x = (x[0], x[1], -lever[2])
    state = (x, q, v, l_body)
    _store(row, ANCHOR, state)
    force, _ = pinned.reaction(state, first, second, ground)
    weight = ground.mass * math.sqrt(dot(ground.gravity, ground.gravity))
    if force[2] <= 0.0 or pinned.hold(state, first, second, ground) < -1e-12 * weight:
        _end(row, SLIPS)
        return
    row[KIND], row[POINT], row[OTHER] = PINNED, first, second
    _next_step(row, state, first, second, ground)


@inner
def _is_in_a_plane(q: Quaternion, w: Vector, first: int, second: int, still: float, ground: Ground) -> bool:
    """Return whether a body turns about an edge alone, and is such that it goes on doing so with both ends pressed."""
    a, b = lever_of(q, first, ground), lever_of(q, second, ground)
    along = add(b, scale(-1.0, a))
    along = scale(1.0 / math.sqrt(dot(along, along)), along)
    near = face.ROUNDED
    off = add(w, scale(-dot(w, along), along))
    own = rotate_back(q, along)
    L = (ground.moments[0] * own[0], ground.moments[1] * own[1], ground.moments[2] * own[2])
    twisted = cross(L, own)
    most = max(ground.moments[0], ground.moments[1], ground.moments[2])
    level = abs(dot(ground.gravity, along)) <= near * math.sqrt(dot(ground.gravity, ground.gravity))
    inside = dot(a, along) < 0.0 < dot(b, along)
    principal = math.sqrt(dot(twisted, twisted)) <= near * most
    return level and inside and principal and math.sqrt(dot(off, off)) * ground.reach <= 4.0 * still


@inner
def _next_step(row: Array, state: State, first: int, second: int, ground: Ground) -> None:
    """Set the length of a step of a pinned motion, up to where it ends."""
    slopes = np.empty((12, 13))
    length = pinned.good_step(state, 2.0 * row[LENGTH], first, second, ground, slopes)
    row[LENGTH] = length
    row[UNTIL], row[THEN] = length, GOES_ON
    then = pinned.step(state, length, first, second, ground, slopes)
    lowest = _lowest(then, first, second, ground)
    if _gap(then, lowest, ground) < 0.0 and lowest != -1:
        row[UNTIL] = _zero(state, length, first, second, lowest, ground, slopes)
    if pinned.hold(pinned.step(state, row[UNTIL], first, second, ground, slopes), first, second, ground) < 0.0:
        row[UNTIL], row[THEN] = _zero(state, row[UNTIL], first, second, -1, ground, slopes), ENDS


@inner
def _lowest(state: State, first: int, second: int, ground: Ground) -> int:
    """Return the lowest point of the body beside those that stay; -1 where there is none."""
    _, q, _, _ = state
    lowest, least = -1, math.inf
    near = face.ROUNDED * ground.reach
    stay = lever_of(q, first, ground)
    edge = add(lever_of(q, max(second, 0), ground), scale(-1.0, stay))
    size = math.sqrt(dot(edge, edge))
    for number in range(len(ground.points)):
        lever = lever_of(q, number, ground)
        off = add(lever, scale(-1.0, stay))
        if second >= 0:
            off = scale(1.0 / size, cross(off, edge))
        if dot(off, off) > near * near and lever[2] < least:
            lowest, least = number, lever[2]
    return lowest


@inner
def _gap(state: State, number: int, ground: Ground) -> float:
    return state[0][2] + lever_of(state[1], max(number, 0), ground)[2]


@inner
def _zero(state: State, high: float, first: int, second: int, number: int, ground: Ground, slopes: Array) -> float:
    """Return when within a step a point lands, or, for the number -1, friction gives way: the Illinois method."""
    low = 0.0
    at_low, at_high = _gauge(state, first, second, number, ground), 0.0
    at_high = _gauge(pinned.step(state, high, first, second, ground, slopes), first, second, number, ground)
    if at_low <= 0.0:
        at_low = -1e-3 * at_high
    for _ in range(100):
        t = high - at_high * (high - low) / (at_high - at_low)
        if not low < t < high:
            t = 0.5 * (low + high)
        value = _gauge(pinned.step(state, t, first, second, ground, slopes), first, second, number, ground)
        if value < 0.0:
            high, at_high = t, value
            at_low *= 0.5
        else:
            low, at_low = t, value
            at_high *= 0.5
        if value == 0.0 or high - low <= 2.0**-52 * high:
            break
    return high


@inner
def _gauge(state: State, first: int, second: int, number: int, ground: Ground) -> float:
    return pinned.hold(state, first, second, ground) if number < 0 else _gap(state, number, ground)


@inner
def _rocks(row: Array, touching: NDArray[np.int64], meets: int, stays: int, count: int, ground: Ground) -> bool:
    """Land a body that turned about an edge on another that is parallel, e = 0; whether that is what happens.

    The angular momentum about the new edge stays, and the old one leaves the plane, or both hold: Housner, Bull. Seism.
    Soc. Am. 53 (1963) 403.
    """
    if meets < 2 or stays < 2 or ground.restitution != 0.0:
        return False
    x, q, v, l_body = _load(row, ANCHOR)
    w = spin_of(q, l_body, ground)
    a, b = lever_of(q, touching[count - 1], ground), lever_of(q, touching[count - 2], ground)
    c, d = lever_of(q, touching[0], ground), lever_of(q, touching[1], ground)
    along = add(b, scale(-1.0, a))
    along = scale(1.0 / math.sqrt(dot(along, along)), along)
    beside = add(d, scale(-1.0, c))
    beside = scale(1.0 / math.sqrt(dot(beside, beside)), beside)
    apart, off = cross(along, beside), cross(along, w)
    near = face.ROUNDED
    if dot(apart, apart) > near * near or dot(off, off) > near * near * dot(w, w):
        return False
    axis = rotate_back(q, along)
    own = dot(axis, (ground.moments[0] * axis[0], ground.moments[1] * axis[1], ground.moments[2] * axis[2]))
    arm = add(scale(dot(a, along), along), scale(-1.0, a))
    moment = own + ground.mass * dot(arm, arm)
    about = own * dot(w, along) + ground.mass * dot(cross(arm, v), along)
    rate = about / moment
    if rate * dot(w, along) <= 0.0:
        rate = 0.0
    w_then = scale(rate, along)
    v_then = cross(w_then, arm)
    J = scale(ground.mass, add(v_then, scale(-1.0, v)))
    if math.hypot(J[0], J[1]) > ground.friction * J[2]:
        return False
    _count_energy(row, v, w, v_then, w_then, q, ground)
    x = (x[0], x[1], -a[2])
    _store(row, ANCHOR, (x, q, v_then, momentum_of(q, w_then, ground)))
    row[KIND], row[UNTIL], row[THEN] = FREE, 0.0, GOES_ON
    return True


@inner
def _count_energy(
    row: Array, v: Vector, w: Vector, v_then: Vector, w_then: Vector, q: Quaternion, ground: Ground
) -> None:
    """Count an impact, and the energy that it lost or gained [J]."""
    before = ground.mass * dot(v, v) + dot(w, rotate(q, momentum_of(q, w, ground)))
    after = ground.mass * dot(v_then, v_then) + dot(w_then, rotate(q, momentum_of(q, w_then, ground)))
    row[IMPACTS] += 1.0
    row[LOST_J] += 0.5 * (before - after)
    if after > before * (1.0 + 1e-12):
        row[GAINED] += 0.5 * (after - before)


# The motions.


@inner
def _at(row: Array, t: float, ground: Ground) -> State:
    """Return the state t [s] after the last event."""
    x, q, v, l_body = _load(row, ANCHOR)
    kind = row[KIND]
    if kind == FREE:
        g = ground.gravity
        x = add(x, scale(t, add(v, scale(0.5 * t, g))))
        q, l_body = turned_freely(q, l_body, t, ground)
        return x, q, add(v, scale(t, g)), l_body
    if kind == STEADY:
        pull = (row[PULL], row[PULL + 1], row[PULL + 2])
        rate = (row[SPIN_RATE], row[SPIN_RATE + 1], row[SPIN_RATE + 2])
        x = add(x, scale(t, add(v, scale(0.5 * t, pull))))
        if dot(l_body, l_body) > 0.0 or dot(rate, rate) > 0.0:
            w = spin_of(q, l_body, ground)
            q = turned_steadily(q, w, rate, t)
            if dot(rate, rate) > 0.0:
                l_body = momentum_of(q, add(w, scale(t, rate)), ground)
        return x, q, add(v, scale(t, pull)), l_body
    if kind == SLIPPING:
        return _slipping(row, t, ground)
    if kind == PINNED:
        slopes = np.empty((12, 13))
        return pinned.step((x, q, v, l_body), t, int(row[POINT]), int(row[OTHER]), ground, slopes)
    lost = math.nan
    return (lost, lost, lost), (lost, lost, lost, lost), (lost, lost, lost), (lost, lost, lost)


@inner
def _slipping(row: Array, t: float, ground: Ground) -> State:
    """Return the state of a body whose slip turns on an incline, t [s] after it began."""
    x, q, v, l_body = _load(row, ANCHOR)
    is_sphere = ground.radius > 0.0
    w = spin_of(q, l_body, ground)
    slope = (ground.gravity[0], ground.gravity[1])
    spread = _spread(ground) if is_sphere else 1.0
    begun = velocity_at(v, w, (0.0, 0.0, -ground.radius))
    slip = slip_from((begun[0], begun[1]), slope, -ground.gravity[2] * ground.friction * spread)
    y = y_at(slip, t)
    way = placed(slip, path(slip, y))
    share, rest = 1.0 / spread, 1.0 - 1.0 / spread
    x = (
        x[0] + (v[0] - share * begun[0]) * t + share * way[0] + rest * slope[0] * (0.5 * t * t),
        x[1] + (v[1] - share * begun[1]) * t + share * way[1] + rest * slope[1] * (0.5 * t * t),
        x[2],
    )
    if not is_sphere:
        s = placed(slip, velocity(slip, y))
        return x, q, (s[0], s[1], 0.0), l_body
    steps = max(math.ceil(max(-y * (slip.hold / slip.pull + 1.0), math.sqrt(dot(w, w)) * t) / FINE), 4)
    steps = min(steps, MOST_TURNS)
    length = y / steps
    for step in range(steps):
        begins = step * length
        q = turned_by(
            q,
            _spin_per_y(slip, v, w, begun, slope, begins + EARLY * length, ground),
            _spin_per_y(slip, v, w, begun, slope, begins + 0.5 * length, ground),
            _spin_per_y(slip, v, w, begun, slope, begins + LATE * length, ground),
            length,
        )
    v_then, w_then = _spinning(slip, v, w, begun, slope, y, t, ground)
    return x, q, v_then, momentum_of(q, w_then, ground)


@inner
def _spinning(
    slip: Slip, v: Vector, w: Vector, begun: Vector, slope: tuple[float, float], y: float, t: float, ground: Ground
) -> tuple[Vector, Vector]:
    """Return velocity and spin of a sphere whose slip turns."""
    s, share = placed(slip, velocity(slip, y)), 1.0 / _spread(ground)
    v_x = v[0] + share * (s[0] - begun[0]) + (1.0 - share) * slope[0] * t
    v_y = v[1] + share * (s[1] - begun[1]) + (1.0 - share) * slope[1] * t
    return (v_x, v_y, 0.0), ((s[1] - v_y) / ground.radius, (v_x - s[0]) / ground.radius, w[2])


@inner
def _spin_per_y(
    slip: Slip, v: Vector, w: Vector, begun: Vector, slope: tuple[float, float], y: float, ground: Ground
) -> Vector:
    """Return the spin times dt/dy."""
    _, spin = _spinning(slip, v, w, begun, slope, y, time_at(slip, y), ground)
    s = velocity(slip, y)
    return scale(-math.hypot(s[0], s[1]) / slip.pull, spin)


# Events.


@inner
def _happens(row: Array, ground: Ground) -> None:
    """Go to where the motion ends by itself, and through what happens there."""
    t, then = row[UNTIL], row[THEN]
    state = _load(row, ANCHOR) if t == 0.0 else _at(row, t, ground)
    row[SINCE] += t
    x, q, v, l_body = state
    if then == STRIKES:
        lever = lever_of(q, int(row[POINT]), ground)
        x = (x[0], x[1], -lever[2])
        w = spin_of(q, l_body, ground)
        K, u = response(q, lever, ground), velocity_at(v, w, lever)
        if u[2] < 0.0:
            after = velocity_after(K, u, ground.restitution, ground.friction)
            impulse = solved(K, add(after, scale(-1.0, u)))
            v_then, w_then = struck(q, v, w, lever, impulse, ground)
            _count_energy(row, v, w, v_then, w_then, q, ground)
            v, l_body = v_then, momentum_of(q, w_then, ground)
    elif then == STOPS:
        if ground.radius > 0.0:
            l_body = momentum_of(q, _rolling(v, spin_of(q, l_body, ground), ground), ground)
        else:
            v = (0.0, 0.0, 0.0)
    _store(row, ANCHOR, (x, q, v, l_body))
    row[KIND] = UNKNOWN
    if then == ENDS:
        _end(row, SLIPS)
    elif row[IMPACTS] >= MOST_IMPACTS:
        _end(row, TOO_MANY)


@kernel
def events(rows: Array, time: float, ground: Ground) -> None:
    """Go to an instant after the write [s].

    Parameters
    ----------
    rows : (N, WIDTH)
        changed in place; plane's frame
    time : s
    ground
    """
    touching = np.empty(point_count(ground), np.int64)
    for row in rows:
        while True:
            if row[KIND] == UNKNOWN:
                _begin(row, touching, ground)
            left = time - row[SINCE]
            if row[KIND] == FREE and row[UNTIL] == math.inf and row[SEARCHED] <= left:
                x, q, v, l_body = _load(row, ANCHOR)
                how, t, number = search(x[2], q, v[2], l_body, row[SEARCHED], left, ground)
                row[SEARCHED] = t
                if how == MET:
                    row[UNTIL], row[THEN], row[POINT] = t, STRIKES, number
                elif how == LOST:
                    row[SINCE] += t
                    _end(row, GRAZES)
            if not row[UNTIL] <= left:
                break
            _happens(row, ground)
        _store(row, 0, _at(row, left, ground))
