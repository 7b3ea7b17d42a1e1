"""When the floor begins and ceases to push a vertex: the laws have a corner there, and a step has to end on it.

A vertex is ABOVE the floor, PRESSING on it, or IDLE: below, but leaving so fast that the damper would pull.  What would
end that state is watched as a number that is not negative while it lasts: the height, the depth, the thrust N or -N.
"""

from typing import NamedTuple

import numpy as np

from scenarios.frames import Array
from scenarios.truth.forced.compilation import inner
from scenarios.truth.forced.laws import Forces, Solid, X, floor_gauge, motion_of, three
from scenarios.truth.forced.radau import Step, Tableau, go_to, length

ABOVE, PRESSING, IDLE = 0, 1, 2
NEVER = 2.0
# Below this share of a step a polynomial is not asked any more whether it dips under 0 and comes back.
FINEST = 2.0**-30
# The share of size and distance that a height is not known to.
ROUNDING = 1e-15


@inner
def set_contacts(y: Array, solid: Solid, forces: Forces, contacts: np.ndarray) -> None:
    """Write how each vertex stands to the floor at the start of a passage, (n,)."""
    motion = motion_of(y, solid)
    for row in range(len(forces.floor)):
        for vertex in range(len(solid.points)):
            _, height, thrust = floor_gauge(forces.floor[row], three(solid.points[vertex], 0), motion)
            contacts[vertex] = ABOVE if height >= 0.0 else PRESSING if thrust > 0.0 else IDLE


class Switch(NamedTuple):
    """When a vertex leaves its state, in steps; which vertex; whether its thrust tells or its height; and for what."""

    at: float
    vertex: int
    by_thrust: bool
    then: int


@inner
def next_switch(step: Step, h: float, rule: Tableau, solid: Solid, forces: Forces, contacts: np.ndarray) -> Switch:
    """Return the first switch in the step, h [s] long; its instant is NEVER where there is none."""
    first = Switch(NEVER, 0, False, ABOVE)
    polynomial = np.empty(len(rule.powers))
    for row in range(len(forces.floor)):
        floor = forces.floor[row]
        nothing = ROUNDING * (solid.radius + length(step.y, X) + abs(floor[3]))
        no_thrust = (floor[4] + floor[5] / h) * nothing
        for vertex in range(len(solid.points)):
            below = contacts[vertex] != ABOVE
            # What has to stay positive: the height above the floor, or the depth below it, ...
            gauge(step, rule, floor, solid, vertex, False, -1.0 if below else 1.0, polynomial)
            at = first_fall(polynomial, nothing)
            first = sooner(first, Switch(at, vertex, False, ABOVE if below else PRESSING))
            if below:
                # ... and there the thrust while it presses, its opposite while it does not.
                pressing = contacts[vertex] == PRESSING
                gauge(step, rule, floor, solid, vertex, True, 1.0 if pressing else -1.0, polynomial)
                at = first_fall(polynomial, no_thrust)
                first = sooner(first, Switch(at, vertex, True, IDLE if pressing else PRESSING))
    return first


@inner
def sooner(a: Switch, b: Switch) -> Switch:
    """Return the earlier of two switches."""
    return b if b.at < a.at else a


@inner
def gauge(
    step: Step,
    rule: Tableau,
    floor: Array,
    solid: Solid,
    vertex: int,
    by_thrust: bool,
    sign: float,
    polynomial: Array,
) -> None:
    """Write the polynomial of a vertex's height [m] or thrust [N] over the step, in 2 t/h - 1, times a sign."""
    for power in range(len(polynomial)):
        polynomial[power] = 0.0
    for node in range(len(polynomial)):
        value = sign * reading(step, node - 1, floor, solid, vertex, by_thrust)
        for power in range(len(polynomial)):
            polynomial[power] += rule.powers[power, node] * value


@inner
def reading(step: Step, stage: int, floor: Array, solid: Solid, vertex: int, by_thrust: bool) -> float:
    """Return a vertex's height [m] or thrust [N] at a stage, or at the start if that is -1."""
    go_to(step, stage)
    _, height, thrust = floor_gauge(floor, three(solid.points[vertex], 0), motion_of(step.here, solid))
    return thrust if by_thrust else height


@inner
def off_switch(step: Step, rule: Tableau, solid: Solid, forces: Forces, switch: Switch) -> float:
    """Return by what share of itself the step ends too late for its switch (Newton's correction)."""
    polynomial = np.empty(len(rule.powers))
    gauge(step, rule, forces.floor[0], solid, switch.vertex, switch.by_thrust, 1.0, polynomial)
    rate = 0.0
    for power in range(1, len(polynomial)):
        rate += 2.0 * power * polynomial[power]
    # The value is read off the end itself: the polynomial's has the rounding of sums that all but cancel.
    return reading(step, len(step.stages) - 1, forces.floor[0], solid, switch.vertex, switch.by_thrust) / rate


@inner
def first_fall(polynomial: Array, nothing: float) -> float:
    """Return the first t in [0, 1] after which a polynomial in 2 t - 1 is negative, or NEVER.

    It is asked piece by piece, each half as long where neither the bounds of value nor those of slope decide: no dip
    wider than FINEST is overlooked.  Where it is `nothing` all along it is rounding, and so is a start below 0 that
    rises: a switch was made there.
    """
    piece = np.empty_like(polynomial)
    begin, width = 0.0, 1.0
    while begin < 1.0:
        set_piece(piece, polynomial, begin, width)
        end, swing, bend = piece[0] + piece[1], abs(piece[1]), 0.0
        for power in range(2, len(piece)):
            end += piece[power]
            swing += abs(piece[power])
            bend += power * abs(piece[power])
        rises, falls, stays = piece[1] > bend, -piece[1] > bend, abs(piece[0]) > swing
        blank = abs(piece[0]) + swing <= nothing
        if not (rises or falls or stays or blank) and width > FINEST:
            width /= 2.0
            continue
        if end < 0.0 and not (rises or blank):
            return begin + (width * root_of(piece) if falls else 0.0)
        begin += width
        # The longest piece that may start here: a half of a half ... of the whole.
        while begin % (2.0 * width) == 0.0 and width < 1.0:
            width *= 2.0
    return NEVER


@inner
def set_piece(piece: Array, polynomial: Array, begin: float, width: float) -> None:
    """Write the same polynomial in u: over the piece 2 t - 1 = centre + width u, u in [-1, 1] (Horner's scheme)."""
    centre = 2.0 * begin - 1.0 + width
    degree = len(piece) - 1
    for power in range(degree + 1):
        piece[power] = polynomial[power]
    for lowest in range(degree):
        for power in range(degree - 1, lowest - 1, -1):
            piece[power] += centre * piece[power + 1]
    stretch = 1.0
    for power in range(degree + 1):
        piece[power] *= stretch
        stretch *= width


@inner
def root_of(piece: Array) -> float:
    """Return where in [0, 1] a falling polynomial in u = 2 t - 1 passes 0, by bisection; 0 where it starts below."""
    low, high = 0.0, 1.0
    while True:
        middle = (low + high) / 2.0
        if not low < middle < high:
            return low
        value = 0.0
        for power in range(len(piece) - 1, -1, -1):
            value = value * (2.0 * middle - 1.0) + piece[power]
        if value < 0.0:
            high = middle
        else:
            low = middle
