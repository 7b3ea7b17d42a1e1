"""From event to event: closed forms between impacts, a certified next contact, and the law of each impact.

Where none of the motions here goes on, a corner that slides say, Moreau's time steps do, in steps of the method's own.
"""

import math

import numpy as np
from numpy.typing import NDArray

from tumble.solver.compilation import inner, kernel
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
from tumble.solver.contact.lasting import lasting
from tumble.solver.contact.moreau import moreau
from tumble.solver.contact.slip import ending, slip_from
from tumble.solver.contact.throw import (
    ANCHOR,
    ARRIVES,
    DONE,
    ENDED,
    FREE,
    GOES_ON,
    GRAZES,
    IMPACTS,
    KIND,
    LASTING,
    LEVEL,
    MOST_IMPACTS,
    POINT,
    PULL,
    SEARCHED,
    SINCE,
    SLIPPING,
    SPIN_RATE,
    STEADY,
    STOPS,
    STRIKES,
    TAKEN,
    THEN,
    TOO_MANY,
    UNKNOWN,
    UNTIL,
    WIDTH,
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
from tumble.solver.contact.turning import turned_steadily
from tumble.solver.vectors import Vector, add, cross, dot, scale

# Of the time in which the body falls half its reach: a time step; and gravity where there is none [m/s2].
STEP, USUAL_GRAVITY = 1e-3, 9.81


@inner
def _begin(row: Array, touching: NDArray[np.int64], ground: Ground) -> None:
    """Say which motion follows the state of the last event, and when it ends by itself."""
    meets, stays, still = touching_points(row, touching, ground)
    if meets > 1 or (meets == 1 and stays > 0):
        row[KIND] = LASTING
    elif meets == 1:
        row[KIND], row[UNTIL], row[THEN], row[POINT] = FREE, 0.0, STRIKES, touching[point_count(ground) - 1]
    elif stays > 0 and ground.gravity[2] < 0.0:
        if ground.radius > 0.0:
            _begin_sphere(row, still, ground)
        else:
            row[KIND] = LASTING
    elif ground.radius > 0.0:
        _begin_fall(row, ground)
    else:
        row[KIND], row[UNTIL], row[THEN], row[SEARCHED] = FREE, math.inf, GOES_ON, 0.0


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
    go_steadily(row, ground.gravity, (0.0, 0.0, 0.0), until, STRIKES)


@inner
def _begin_sphere(row: Array, still: float, ground: Ground) -> None:
    """Let a sphere on the plane slide, slip or roll."""
    x, q, v, l_body = load(row, ANCHOR)
    x, v = (x[0], x[1], ground.radius), (v[0], v[1], 0.0)
    w = spin_of(q, l_body, ground)
    press, slope = -ground.gravity[2], (ground.gravity[0], ground.gravity[1], 0.0)
    steep, spread = math.hypot(slope[0], slope[1]), spread_of(ground)
    slip = velocity_at(v, w, (0.0, 0.0, -ground.radius))
    fast = math.hypot(slip[0], slip[1])
    hold = ground.friction * press
    none = (0.0, 0.0, 0.0)
    if hold == 0.0:
        store(row, ANCHOR, (x, q, v, l_body))
        go_steadily(row, slope, none, math.inf, GOES_ON)
    elif fast > still:
        store(row, ANCHOR, (x, q, v, l_body))
        if steep <= LEVEL * press:
            c = scale(-hold / fast, (slip[0], slip[1], 0.0))
            go_steadily(row, add(slope, c), _spun_up(c, ground), fast / (hold * spread), STOPS)
        else:
            found = slip_from((slip[0], slip[1]), (slope[0], slope[1]), hold * spread)
            row[KIND], row[UNTIL], row[THEN] = SLIPPING, ending(found), STOPS
    elif steep <= spread * hold:
        store(row, ANCHOR, (x, q, v, momentum_of(q, rolling(v, w, ground), ground)))
        pull = scale(1.0 - 1.0 / spread, slope)
        go_steadily(row, pull, scale(1.0 / ground.radius, cross((0.0, 0.0, 1.0), pull)), math.inf, GOES_ON)
    else:
        store(row, ANCHOR, (x, q, v, momentum_of(q, rolling(v, w, ground), ground)))
        c = scale(-hold / steep, slope)
        go_steadily(row, add(slope, c), _spun_up(c, ground), math.inf, GOES_ON)


@inner
def _spun_up(force: Vector, ground: Ground) -> Vector:
    """Return how the spin of a sphere changes by a force at its lowest point, per mass."""
    torque = cross((0.0, 0.0, -ground.radius), scale(ground.mass, force))
    return scale(ground.inverse_moments[0], torque)


@inner
def _at(row: Array, t: float, ground: Ground) -> State:
    """Return the state t [s] after the last event."""
    x, q, v, l_body = load(row, ANCHOR)
    if row[KIND] == FREE:
        g = ground.gravity
        x = add(x, scale(t, add(v, scale(0.5 * t, g))))
        q, l_body = turned_freely(q, l_body, t, ground)
        return x, q, add(v, scale(t, g)), l_body
    if row[KIND] == STEADY:
        pull = (row[PULL], row[PULL + 1], row[PULL + 2])
        rate = (row[SPIN_RATE], row[SPIN_RATE + 1], row[SPIN_RATE + 2])
        x = add(x, scale(t, add(v, scale(0.5 * t, pull))))
        if dot(l_body, l_body) > 0.0 or dot(rate, rate) > 0.0:
            w = spin_of(q, l_body, ground)
            q = turned_steadily(q, w, rate, t)
            if dot(rate, rate) > 0.0:
                l_body = momentum_of(q, add(w, scale(t, rate)), ground)
        return x, q, add(v, scale(t, pull)), l_body
    lost = math.nan
    return (lost, lost, lost), (lost, lost, lost, lost), (lost, lost, lost), (lost, lost, lost)


@inner
def _happens(row: Array, ground: Ground) -> None:
    """Go to where the motion ends by itself, and through what happens there."""
    t, then = row[UNTIL], row[THEN]
    x, q, v, l_body = load(row, ANCHOR) if t == 0.0 else _at(row, t, ground)
    row[SINCE] += t
    if then == ARRIVES:
        # Whether others do so too is for `_begin` to say.
        x = (x[0], x[1], -lever_of(q, int(row[POINT]), ground)[2])
    elif then == STRIKES:
        lever = lever_of(q, int(row[POINT]), ground)
        x = (x[0], x[1], -lever[2])
        w = spin_of(q, l_body, ground)
        K, u = response(q, lever, ground), velocity_at(v, w, lever)
        if u[2] < 0.0:
            after = velocity_after(K, u, ground.restitution, ground.friction)
            impulse = solved(K, add(after, scale(-1.0, u)))
            v_then, w_then = struck(q, v, w, lever, impulse, ground)
            count_impact(row, v, w, v_then, w_then, q, ground)
            v, l_body = v_then, momentum_of(q, w_then, ground)
    elif then == STOPS:
        if ground.radius > 0.0:
            l_body = momentum_of(q, rolling(v, spin_of(q, l_body, ground), ground), ground)
        else:
            v = (0.0, 0.0, 0.0)
    store(row, ANCHOR, (x, q, v, l_body))
    row[KIND] = UNKNOWN
    if row[IMPACTS] >= MOST_IMPACTS:
        end(row, TOO_MANY)


@kernel
def flights(rows: Array, time: float, ground: Ground) -> None:
    """Go on with throws in flight, with impacts, and with constant accelerations, up to an instant after the write [s].

    rows: (N, WIDTH), changed in place, plane's frame; DONE says of each whether it is there.
    """
    touching = np.empty(point_count(ground), np.int64)
    for row in rows:
        while True:
            if row[KIND] == UNKNOWN:
                _begin(row, touching, ground)
            if row[KIND] >= LASTING:
                break
            left = time - row[SINCE]
            if row[KIND] == FREE and row[UNTIL] == math.inf and row[SEARCHED] <= left:
                x, q, v, l_body = load(row, ANCHOR)
                how, t, number = search(x[2], q, v[2], l_body, row[SEARCHED], left, ground)
                row[SEARCHED] = t
                if how == MET:
                    row[UNTIL], row[THEN], row[POINT] = t, ARRIVES, number
                elif how == LOST:
                    row[SINCE] += t
                    end(row, GRAZES)
            if not row[UNTIL] <= left:
                store(row, 0, _at(row, left, ground))
                row[DONE] = 1.0
                break
            _happens(row, ground)


def events(rows: Array, time: float, ground: Ground) -> None:
    """Go to an instant after the write.

    Lasting contacts have a kernel of their own, compiled where a throw first comes to one; so have time steps.

    Parameters
    ----------
    rows : (N, WIDTH + moreau_width(ground))
        changed in place; plane's frame
    time : s
    ground
    """
    rows[:, DONE] = 0.0
    flights(rows, time, ground)
    while len(waiting := np.flatnonzero(rows[:, DONE] == 0.0)):
        some = rows[waiting]
        lasting(some, time, ground)
        flights(some, time, ground)
        rows[waiting] = some
    for number in np.flatnonzero(rows[:, KIND] == ENDED):
        _take_steps(rows[number], time, ground)


def step_of(ground: Ground) -> float:
    """Return the time step with which a motion goes on whose events end [s]: a share of that in which it would fall."""
    pull = math.hypot(*ground.gravity)
    return STEP * math.sqrt(ground.reach / (pull or USUAL_GRAVITY))


def _take_steps(row: Array, time: float, ground: Ground) -> None:
    """Go on with one throw from its last event to an instant, on the line between two whole steps."""
    stepped, step = row[WIDTH:], step_of(ground)
    if row[TAKEN] == 0.0:
        stepped[:ANCHOR] = row[ANCHOR : 2 * ANCHOR]
    left = time - row[SINCE]
    whole = max(float(math.floor(left / step)), row[TAKEN])
    moreau(stepped[np.newaxis], int(whole - row[TAKEN]), step, ground)
    row[TAKEN] = whole
    last: Array = stepped.copy()
    moreau(last[np.newaxis], 1, step, ground)
    share = left / step - whole
    row[:ANCHOR] = (1.0 - share) * stepped[:ANCHOR] + share * last[:ANCHOR]
