"""Newton's method for the slopes at the stages of one step.

Its Jacobian is that of the equations of motion at the beginning of the step, by dual numbers through the very force
terms, and renewed at the middle stage where it serves badly; that decides how soon the slopes are found, not what is
found.  In a step of many periods forces are looked at at the stages, not at the instants of their mean: `work`.
Source: Hairer & Wanner, "Solving Ordinary Differential Equations II" (1996), section IV.8.
"""

# The first correction finds what later ones may keep, which pyright cannot know.
# pyright: reportPossiblyUnboundVariable=false

import math

from tumble.solver.collocation.changes import Changes, changes_at
from tumble.solver.collocation.corrections import Missed, corrections, resolved
from tumble.solver.collocation.equations import (
    AT_INSTANTS,
    AT_STAGES,
    NOTHING,
    Eights,
    Slopes,
    Stages,
    Whole,
    moved,
    pushes_at,
    rows,
    stages_of,
    turned,
    wanted,
)
from tumble.solver.collocation.scheme import Scheme
from tumble.solver.collocation.work import (
    ROUNDING,
    UNCLEAR,
    UNCOUNTED,
    Work,
    counted,
    is_clear,
    least_energy,
    power_along,
    power_of,
    rounding_worth,
)
from tumble.solver.compilation import inlined
from tumble.solver.eight import eight, lane, transposed
from tumble.solver.forces import Forces
from tumble.solver.quaternion import Quaternion, conjugate, norm_squared, plus, product, stretch
from tumble.solver.vectors import Vector, add, dot, scale, times

# A Jacobian serves badly where a correction is more than POOR of the one before.  Measured on the stiff scenes of the
# catalogue, at their own steps and at 30 times those: with 0.1 to 0.9 a step costs the same within a third.  50
# corrections for 20 change nothing; 8 cost 1.6 times as much on a spring, for steps are then taken in halves.
MOST_CORRECTIONS, POOR = 20, 0.3
# A correction that is so many times the one before leads nowhere.  Below that the next Jacobian may serve: with 1 for
# new ones a step on a tether with a rest length takes a sixth longer at w dt = 1000, for more are taken in halves.
MOST_GROWTH = 3.0
# Newton's method has ended where the next correction would be less than a rounding of what it corrects ...
LEAST_CHANGE = 2.0**-55
# ... or, where the sum of all modes' (w dt)^2 is above STIFF, less than a few roundings of the body's place and size:
# what those do to a stiff force, and so to the velocity, no correction takes away.  With 2^-53 a step takes a twentieth
# longer at 10 rad and a seventh at 1000, and the energy of ten thousand steps is off by 5e-10 instead of 4e-9 ...
STIFF, LEAST_SHIFT, NEVER = 10.0, 2.0**-50, -1.0
# ... or where rounding keeps the corrections from halving, at ROUNDING of the body's place and size.
HALVING = 0.5
# Where that sum is above LONG the step is one of several periods.  There, with a method that keeps energy, Newton's
# method has ended where the next correction would move the body by less than so much of its size, for `work` makes good
# what energy that costs: with 2^-50 a step takes a fifth longer.
LONG, LEAST_LONG_SHIFT = 500.0, 2.0**-40
# The furthest turn in a step that is not taken in halves [rad]: a parabola for dq/dt is off by some turn^4/4!, a few
# percent.  With half of it or twice as much no step of the stiff scenes costs a tenth more or less.
FURTHEST_TURN = 1.0


@inlined
def found(
    state: Whole,
    dt: float,
    method: Scheme,
    reach: float,
    inverse_moments: Vector | None,
    gyroscopic: Vector | None,
    forces: Forces,
) -> tuple[Slopes, Work, bool]:
    """Return the slopes at the stages of one step, the work to be done in it, and whether the slopes could be found.

    reach [m]: the body's size, as its radius of gyration has it.
    Begins from a state that stands still.  The slopes of the step before would serve better, but then a step would
    depend on more than the state it begins from, and two advances would not be one long one to the last bit.
    """
    no, to_stages = (eight(0.0), eight(0.0), eight(0.0)), rows(dt, method.to_stages)
    slopes = Slopes((*no, no[0]), no, no)
    previous, is_first, stale, middle, least_shift, look = math.inf, True, True, state, NEVER, AT_INSTANTS
    ends, work = False, UNCOUNTED
    for _ in range(MOST_CORRECTIONS):
        stages = stages_of(state, slopes, to_stages)
        if stale:
            if not is_first:
                middle = _middle(state, stages, to_stages)
            accelerations, twists, changes = changes_at(middle, inverse_moments, gyroscopic, forces)
            linear = resolved(changes, dt, method)
            stiffness = dt * dt * _stiffness(changes)
            if is_first and method.keeps_energy and stiffness > LONG:
                look = AT_STAGES
            enough = _least_shift(stiffness, look)
        if is_first:
            # As x is here still that of the beginning, all of its slope is missed.
            asked, twisted, power, missed = _all_stages(accelerations), _all_stages(twists), no[0], stages.v
        else:
            pushes = pushes_at(state, slopes, stages, dt, method, look, inverse_moments, forces)
            if ends:
                power = power_along(pushes, slopes, method, forces.mass, inverse_moments)
                rounding = rounding_worth(stiffness, dt, reach, forces.mass)
                least = least_energy(dt, reach, forces.mass) + rounding / UNCLEAR
                clear = is_clear(power, stages, dt, method, least, forces.mass, inverse_moments)
                return slopes, counted(power, pushes, dt, method, rounding), clear
            asked, twisted = wanted(stages, pushes, method, look, inverse_moments, gyroscopic)
            power, missed = power_of(pushes, forces.mass, inverse_moments), no
        after = _corrected(
            state[1],
            slopes,
            stages,
            to_stages,
            corrections(linear, _missed(slopes, stages, missed, asked, twisted, inverse_moments), dt, method),
            inverse_moments,
        )
        change, shift, turn = _sizes(slopes, after, stages, state, dt, to_stages, reach, inverse_moments)
        slopes = after
        if not turn <= FURTHEST_TURN:
            return slopes, work, False
        shrinking = change / previous if previous < math.inf else POOR
        is_least = (change * shrinking <= LEAST_CHANGE) | (shift * shrinking <= least_shift)
        if is_least or (shrinking > HALVING and shift < ROUNDING):
            if look == AT_INSTANTS:
                least = least_energy(dt, reach, forces.mass)
                clear = is_first or is_clear(power, stages, dt, method, least, forces.mass, inverse_moments)
                return slopes, work, clear
            # Once more, to see what work is done on the way.
            look, ends = AT_INSTANTS, True
        if not (shrinking < MOST_GROWTH or ends):
            return slopes, work, False
        least_shift = enough
        # In a long step the Jacobian of the beginning has a tension that is gone at the middle, and so the second is
        # new; it is not judged by its first correction.
        judged = not (stale and look == AT_STAGES)
        stale = (is_first and look == AT_STAGES) or (shrinking > POOR and judged and not ends)
        previous, is_first = change, False
    return slopes, work, False


@inlined
def _middle(state: Whole, stages: Stages, to_stages: Eights) -> Whole:
    """Return the state at the middle stage."""
    x, (q, v, l_body) = moved(state[0], to_stages, stages.v), stages
    return (
        (lane(x[0], 1), lane(x[1], 1), lane(x[2], 1)),
        (lane(q[0], 1), lane(q[1], 1), lane(q[2], 1), lane(q[3], 1)),
        (lane(v[0], 1), lane(v[1], 1), lane(v[2], 1)),
        (lane(l_body[0], 1), lane(l_body[1], 1), lane(l_body[2], 1)),
    )


@inlined
def _least_shift(stiffness: float, look: int) -> float:
    """Return what shift of the body need not be corrected; stiffness: the sum of all modes' (w dt)^2."""
    if look == AT_STAGES:
        return LEAST_LONG_SHIFT
    return LEAST_SHIFT if stiffness > STIFF else NEVER


@inlined
def _stiffness(changes: Changes) -> float:
    """Return the sum of all modes' w^2 [1/s2]."""
    x, y, z, _, a, b, c, _ = changes.by_place
    return -(lane(x, 0) + lane(y, 1) + lane(z, 2) + lane(a, 4) + lane(b, 5) + lane(c, 6))


@inlined
def _all_stages(a: Vector) -> Vector:
    return eight(a[0]), eight(a[1]), eight(a[2])


@inlined
def _missed(
    slopes: Slopes, stages: Stages, velocities: Vector, asked: Vector, twisted: Vector, inverse_moments: Vector | None
) -> Missed:
    """Return what slopes miss of dx/dt, as given, and of those that the equations of motion ask for."""
    return Missed(
        velocities,
        _turn_missed(slopes, stages, inverse_moments),
        add(asked, scale(-1.0, slopes.accelerations)),
        add(twisted, scale(-1.0, slopes.twists)),
    )


@inlined
def _corrected(
    q: Quaternion,
    slopes: Slopes,
    stages: Stages,
    to_stages: Eights,
    correction: tuple[Vector, Vector],
    inverse_moments: Vector | None,
) -> Slopes:
    """Return slopes after a correction of those of v and L; q: at the beginning of the step."""
    force, torque = correction
    l_body = add(stages.l_body, moved(NOTHING, to_stages, torque))
    return Slopes(
        turned(q, slopes.turns, l_body, to_stages, inverse_moments),
        add(slopes.accelerations, force),
        add(slopes.twists, torque),
    )


@inlined
def _turn_missed(slopes: Slopes, stages: Stages, inverse_moments: Vector | None) -> Vector:
    """Return I times the angular velocity that dq/dt misses, 2 q* (q w~/2 - dq/dt) / |q|^2."""
    if inverse_moments is None:
        return eight(0.0), eight(0.0), eight(0.0)
    q, l_body = stages.q, stages.l_body
    _, x, y, z = product(conjugate(q), slopes.turns)
    factor = -2.0 / norm_squared(q)
    a, b, c = 1.0 / inverse_moments[0], 1.0 / inverse_moments[1], 1.0 / inverse_moments[2]
    return add(l_body, scale(factor, times((a, b, c), (x, y, z))))


@inlined
def _sizes(
    before: Slopes,
    after: Slopes,
    stages: Stages,
    state: Whole,
    dt: float,
    to_stages: Eights,
    reach: float,
    inverse_moments: Vector | None,
) -> tuple[float, float, float]:
    """Return how large corrections of the stages are, of what they correct, and of the body's place and size.

    And how far the body turns in the step [rad].
    """
    dq = plus(after.turns, stretch(-1.0, before.turns))
    dv = add(after.accelerations, scale(-1.0, before.accelerations))
    dl = add(after.twists, scale(-1.0, before.twists))
    dx = moved(NOTHING, to_stages, dv)
    w = _spin(stages.l_body, inverse_moments)
    squares = transposed(
        (
            dot(dx, dx),
            norm_squared(dq),
            dot(dv, dv),
            dot(dl, dl),
            dot(w, w),
            eight(0.0),
            dot(stages.v, stages.v),
            dot(stages.l_body, stages.l_body),
        )
    )
    a, b, c = squares[0], squares[1], squares[2]
    sums, square = (a + b + c) * (1.0 / 3.0), dt * dt
    place = dot(state[0], state[0]) + reach * reach
    shift = square * max(lane(sums, 0) / place, lane(sums, 1))
    moving = square * max(_part(lane(sums, 2), lane(sums, 6)), _part(lane(sums, 3), lane(sums, 7)))
    turn = abs(dt) * math.sqrt(max(lane(a, 4), max(lane(b, 4), lane(c, 4))))
    return math.sqrt(max(shift, moving)), math.sqrt(shift), turn


@inlined
def _spin(l_body: Vector, inverse_moments: Vector | None) -> Vector:
    if inverse_moments is None:
        return eight(0.0), eight(0.0), eight(0.0)
    return times(inverse_moments, l_body)


@inlined
def _part(part: float, whole: float) -> float:
    """Return part / whole, and nothing for no part of nothing."""
    return part / whole if part != 0.0 else 0.0
