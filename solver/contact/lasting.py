"""Lasting contact of a body with corners: it rests, slides, rocks, turns about an edge or a tip; and curved slips."""

import math
from typing import cast

import numpy as np
from numpy.typing import NDArray

from tumble.solver.compilation import inner, kernel
from tumble.solver.contact import face, pinned
from tumble.solver.contact.cone import CONTACT, by_turns, set_contact
from tumble.solver.contact.ground import Ground, lever_of, momentum_of, point_count, rim_count, spin_of, velocity_at
from tumble.solver.contact.slip import Slip, bend, ending, path, placed, slip_from, time_at, velocity, y_at
from tumble.solver.contact.throw import (
    ANCHOR,
    AT_ONCE,
    CORNER,
    DONE,
    ENDS,
    FACE_SPINS,
    FACE_TIPS,
    GOES_ON,
    KIND,
    LANDS,
    LASTING,
    LENGTH,
    LEVEL,
    OTHER,
    PINNED,
    POINT,
    RIM,
    SINCE,
    SLIPPING,
    SLIPS,
    STOPS,
    THEN,
    UNKNOWN,
    UNTIL,
    Array,
    State,
    count_impact,
    end,
    go_steadily,
    load,
    rolling,
    spread_of,
    store,
    touching_points,
)
from tumble.solver.contact.turning import turned_by
from tumble.solver.integrators.magnus6 import EARLY, LATE
from tumble.solver.quaternion import Quaternion, rotate, rotate_back
from tumble.solver.vectors import Vector, add, cross, dot, scale

# No point.  A literal would have everything that it goes through compiled once more.
NO_POINT = cast(int, np.int64(-1))
# How finely the turn of a sphere is followed whose slip turns.
FINE, MOST_TURNS = 0.05, 100_000
# Of the largest impulse of several points at once: what is left open.
AT_ONCE_WITHIN = 1e-15
# One less the cosine of the tilt at which time steps follow a disc to its face.
NEARLY_FLAT = 1e-8


@inner
def _begin(row: Array, touching: NDArray[np.int64], ground: Ground) -> None:
    """Say which motion follows a state of a body some of whose corners stay on the plane."""
    meets, stays, still = touching_points(row, touching, ground)
    if meets > 0:
        if not _rocks(row, touching, meets, stays, point_count(ground), ground):
            _strike_at_once(row, touching, meets, stays, ground)
    else:
        _begin_lasting(row, touching, stays, still, ground)


@inner
def _strike_at_once(row: Array, touching: NDArray[np.int64], meets: int, stays: int, ground: Ground) -> None:
    """Let all points on the plane strike it at once, where the law has several answers: u_n >= -e u_n before, the least

    impulses in the friction cones that make it so, which keep symmetric what is symmetric: Moreau (1988).
    """
    x, q, v, l_body = load(row, ANCHOR)
    w, count = spin_of(q, l_body, ground), point_count(ground)
    contacts = np.empty((meets + stays, CONTACT))
    for each in range(meets + stays):
        lever = lever_of(q, touching[each if each < stays else count - 1 - (each - stays)], ground)
        rate = velocity_at(v, w, lever)[2]
        set_contact(contacts[each], q, lever, -ground.restitution * min(rate, 0.0), ground)
    v_then, w_then, _ = by_turns(q, v, w, contacts, AT_ONCE_WITHIN, ground)
    count_impact(row, v, w, v_then, w_then, q, ground)
    row[AT_ONCE] += 1.0
    store(row, ANCHOR, (x, q, v_then, momentum_of(q, w_then, ground)))
    row[KIND] = UNKNOWN


@inner
def _begin_lasting(row: Array, touching: NDArray[np.int64], stays: int, still: float, ground: Ground) -> None:
    """Let a body with corners on the plane rest, slide, or turn about an edge or a tip."""
    _, q, _, _ = load(row, ANCHOR)
    near = face.ROUNDED * ground.reach
    if ground.rim > 0.0 and stays == 2:
        _begin_on_its_side(row, touching[0], still, ground)
        return
    places = face.places_of(q, touching, stays, ground)
    if stays == 1:
        _begin_pinned(row, touching[0], NO_POINT, still, ground)
    elif not face.spans_a_face(places, stays, near):
        first, second = _ends_of(places, stays)
        _begin_pinned(row, touching[first], touching[second], still, ground)
    else:
        _begin_face(row, touching, stays, places, near, still, ground)


@inner
def _begin_on_its_side(row: Array, number: int, still: float, ground: Ground) -> None:
    """Let a disc on both rims roll straight on, without a slip or a turn; end where it does anything else."""
    x, q, v, l_body = load(row, ANCHOR)
    axis, w = rotate(q, (0.0, 0.0, 1.0)), spin_of(q, l_body, ground)
    about = dot(w, axis)
    across = add(w, scale(-about, axis))
    slip = velocity_at(v, w, lever_of(q, number, ground))
    slope = (ground.gravity[0], ground.gravity[1], 0.0)
    spread = 1.0 + ground.mass * ground.rim * ground.rim * ground.inverse_moments[2]
    steep, hold = math.hypot(slope[0], slope[1]), -ground.friction * ground.gravity[2]
    turns = math.sqrt(dot(across, across)) * ground.reach > 4.0 * still
    slips = math.hypot(slip[0], slip[1]) > still or steep > spread * hold
    if turns or slips or abs(dot(slope, axis)) > LEVEL * -ground.gravity[2]:
        end(row, RIM)
        return
    pull, w = scale(1.0 - 1.0 / spread, slope), scale(about, axis)
    v = cross(w, (0.0, 0.0, ground.rim))
    store(row, ANCHOR, ((x[0], x[1], ground.rim), q, v, momentum_of(q, w, ground)))
    go_steadily(row, pull, scale(1.0 / ground.rim, cross((0.0, 0.0, 1.0), pull)), math.inf, GOES_ON)


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
def _unit(x: float, y: float) -> tuple[float, float]:
    size = math.hypot(x, y)
    return (x / size, y / size) if size > 0.0 else (0.0, 0.0)


@inner
def _begin_face(
    row: Array, touching: NDArray[np.int64], count: int, places: Array, near: float, still: float, ground: Ground
) -> None:
    """Let a body that lies on a face glide, slide, rest or tip over an edge of the face."""
    x, q, v, l_body = load(row, ANCHOR)
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
        if _margin(places, count, at, near, ground)[0] < -near:
            end(row, FACE_TIPS)
        else:
            store(row, ANCHOR, (x, q, v, l_body))
            go_steadily(row, slope, none, math.inf, GOES_ON)
        return
    if spins:
        end(row, FACE_SPINS)
        return
    reach = ground.friction * height
    down = _unit(slope[0], slope[1])
    if fast > still:
        along = _unit(v[0], v[1])
        level = steep <= LEVEL * press
        arc = face.margin_of_arc(places, count, along, along if level else down, reach, near)
        if (arc if ground.rim == 0.0 else ground.rim - reach) < -near:
            end(row, FACE_TIPS)
            return
        store(row, ANCHOR, (x, q, v, none))
        if level:
            go_steadily(row, add(slope, (-hold * along[0], -hold * along[1], 0.0)), none, fast / hold, STOPS)
        else:
            row[KIND], row[THEN] = SLIPPING, STOPS
            row[UNTIL] = ending(slip_from((v[0], v[1]), (slope[0], slope[1]), hold))
        return
    store(row, ANCHOR, (x, q, none, none))
    if steep <= hold * (1.0 + LEVEL):
        at = (height * slope[0] / press, height * slope[1] / press)
        inside, first, second = _margin(places, count, at, near, ground)
        if inside < -near and ground.rim > 0.0:
            end(row, FACE_TIPS)
        elif inside < -near:
            _begin_pinned(row, touching[first], touching[second], still, ground)
        else:
            go_steadily(row, none, none, math.inf, GOES_ON)
    elif _margin(places, count, (reach * down[0], reach * down[1]), near, ground)[0] < -near:
        end(row, FACE_TIPS)
    else:
        go_steadily(row, add(slope, scale(-hold / steep, slope)), none, math.inf, GOES_ON)


@inner
def _margin(places: Array, count: int, at: face.Pair, near: float, ground: Ground) -> tuple[float, int, int]:
    """Return how far inside the face a place is [m], of a disc inside its rim, and between which points the side is."""
    if ground.rim > 0.0:
        return ground.rim - math.hypot(at[0], at[1]), 0, 0
    return face.margin(places, count, at, near)


@inner
def _begin_pinned(row: Array, first: int, second: int, still: float, ground: Ground) -> None:
    """Let a body turn about a tip, or an edge, that friction holds; end where it does not."""
    state = load(row, ANCHOR)
    _, q, v, l_body = state
    w = spin_of(q, l_body, ground)
    lever = lever_of(q, first, ground)
    slip = velocity_at(v, w, lever)
    if math.hypot(slip[0], slip[1]) > still:
        end(row, CORNER if ground.rim == 0.0 else RIM)
        return
    if second >= 0 and not _is_in_a_plane(q, w, first, second, still, ground):
        end(row, CORNER)
        return
    state = _laid(row, first, ground)
    force, _ = pinned.reaction(state, first, second, ground)
    weight = ground.mass * math.sqrt(dot(ground.gravity, ground.gravity))
    if force[2] <= 0.0 or pinned.hold(state, first, second, ground) < -1e-12 * weight:
        end(row, SLIPS)
        return
    row[KIND], row[POINT], row[OTHER] = PINNED, first, second
    _next_step(row, state, first, second, ground)


@inner
def _laid(row: Array, first: int, ground: Ground) -> State:
    """Put the point that stays on the plane, without a velocity, and return the state: the centre moves as it spins."""
    x, q, _, l_body = load(row, ANCHOR)
    lever = lever_of(q, first, ground)
    state = (x[0], x[1], -lever[2]), q, cross(lever, spin_of(q, l_body, ground)), l_body
    store(row, ANCHOR, state)
    return state


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
    length, then = pinned.good_step(state, 2.0 * row[LENGTH], first, second, ground, slopes)
    row[LENGTH] = length
    row[UNTIL], row[THEN] = length, GOES_ON
    lowest = _lowest(then, first, second, ground)
    if ground.rim > 0.0 and abs(rotate(then[1], (0.0, 0.0, 1.0))[2]) > 1.0 - NEARLY_FLAT:
        end(row, RIM)
        return
    if _gap(then, lowest, ground) < 0.0 and lowest != -1:
        row[UNTIL], row[THEN] = _zero(state, length, first, second, lowest, ground, slopes), LANDS
        then = pinned.step(state, row[UNTIL], first, second, ground, slopes)
    if pinned.hold(then, first, second, ground) < 0.0:
        row[UNTIL], row[THEN] = _zero(state, row[UNTIL], first, second, NO_POINT, ground, slopes), ENDS


@inner
def _lowest(state: State, first: int, second: int, ground: Ground) -> int:
    """Return the lowest point of the body beside those that stay; -1 where there is none."""
    _, q, _, _ = state
    lowest, least = -1, math.inf
    if ground.rim > 0.0:
        return rim_count(ground) - 1 - first if ground.half > 0.0 else -1
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
    x, q, v, l_body = load(row, ANCHOR)
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
    count_impact(row, v, w, v_then, w_then, q, ground)
    x = (x[0], x[1], -a[2])
    store(row, ANCHOR, (x, q, v_then, momentum_of(q, w_then, ground)))
    row[KIND] = UNKNOWN
    return True


@inner
def _at(row: Array, t: float, ground: Ground) -> State:
    """Return the state t [s] after the last event."""
    if row[KIND] == SLIPPING:
        return _slipping(row, t, ground)
    slopes = np.empty((12, 13))
    return pinned.step(load(row, ANCHOR), t, int(row[POINT]), int(row[OTHER]), ground, slopes)


@inner
def _slipping(row: Array, t: float, ground: Ground) -> State:
    """Return the state of a body whose slip turns on an incline, t [s] after it began."""
    x, q, v, l_body = load(row, ANCHOR)
    is_sphere = ground.radius > 0.0
    w = spin_of(q, l_body, ground)
    slope = (ground.gravity[0], ground.gravity[1])
    spread = spread_of(ground) if is_sphere else 1.0
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
    at = 0.0
    for _ in range(MOST_TURNS):
        spin = _spin_per_y(slip, v, w, begun, slope, at, ground)
        length = -FINE / max(bend(slip, at), math.sqrt(dot(spin, spin)))
        length = max(length, y - at)
        q = turned_by(
            q,
            _spin_per_y(slip, v, w, begun, slope, at + EARLY * length, ground),
            _spin_per_y(slip, v, w, begun, slope, at + 0.5 * length, ground),
            _spin_per_y(slip, v, w, begun, slope, at + LATE * length, ground),
            length,
        )
        at += length
        if at <= y:
            break
    v_then, w_then = _spinning(slip, v, w, begun, slope, y, t, ground)
    return x, q, v_then, momentum_of(q, w_then, ground)


@inner
def _spinning(
    slip: Slip, v: Vector, w: Vector, begun: Vector, slope: tuple[float, float], y: float, t: float, ground: Ground
) -> tuple[Vector, Vector]:
    """Return velocity and spin of a sphere whose slip turns."""
    s, share = placed(slip, velocity(slip, y)), 1.0 / spread_of(ground)
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


@inner
def _happens(row: Array, ground: Ground) -> None:
    """Go to where the motion ends by itself, and through what happens there."""
    kind, t, then = row[KIND], row[UNTIL], row[THEN]
    x, q, v, l_body = _at(row, t, ground)
    row[SINCE] += t
    row[KIND] = UNKNOWN
    if then == STOPS:
        if ground.radius > 0.0:
            l_body = momentum_of(q, rolling(v, spin_of(q, l_body, ground), ground), ground)
        else:
            v = (0.0, 0.0, 0.0)
    store(row, ANCHOR, (x, q, v, l_body))
    if then == ENDS:
        end(row, SLIPS)
    elif then == GOES_ON:
        row[KIND] = kind
        _next_step(row, _laid(row, int(row[POINT]), ground), int(row[POINT]), int(row[OTHER]), ground)


@kernel
def lasting(rows: Array, time: float, ground: Ground) -> None:
    """Go on with throws in lasting contact, up to an instant after the write [s] or to where `flights` goes on.

    rows: (N, WIDTH), changed in place, plane's frame; DONE says of each whether it is there.
    """
    touching = np.empty(point_count(ground), np.int64)
    for row in rows:
        while row[KIND] >= LASTING:
            if row[KIND] == LASTING:
                _begin(row, touching, ground)
            else:
                left = time - row[SINCE]
                if not row[UNTIL] <= left:
                    store(row, 0, _at(row, left, ground))
                    row[DONE] = 1.0
                    break
                _happens(row, ground)
