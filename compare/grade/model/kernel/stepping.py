"""The run of a program with mistakes: continuous, or in steps, with parts missing or wrong.

A row of the result, (22,): x [m], the program's matrix body to world by rows, v [m/s], w [rad/s], world axes, and q,
nan if the program has none.
"""

import math
from pathlib import Path

import numpy as np

from tumble.compare.grade.model.kernel.dynamics import (
    CAP_BEFORE,
    DOUBLE,
    FLOOR_AFTER,
    FLOOR_BEFORE,
    MATRIX,
    RUNGE_KUTTA,
    SMOOTH,
    Array,
    Dynamics,
    Motion,
    Push,
    Scheme,
)
from tumble.compare.grade.model.kernel.euler import euler_step, limited, matrix_step, to_single
from tumble.compare.grade.model.kernel.events import happen
from tumble.compare.grade.model.kernel.parameters import AT, dynamics_of, scheme_of
from tumble.compare.grade.model.kernel.rates import twist
from tumble.compare.grade.model.kernel.runge_kutta import continuous_step, runge_kutta_step, smooth_count
from tumble.solver.compilation import borrowing, kernel_with
from tumble.solver.forces import Forces
from tumble.solver.quaternion import Quaternion, normalise, rotate, rotate_back, stretch
from tumble.solver.vectors import Vector, add, dot, scale, times

WIDTH = 22
# Largest number of steps of a run, and largest rotation of a continuous one [rad].
MOST_STEPS, MOST_RADIANS = 100_000, 1_000.0
# Rounding error of an interval of whole steps, over a step.
NEARLY = 1e-9
# Least share of a step, where a step is divided: so every part of it gets on.
LEAST_SHARE = 1e-3
# Largest rotation in a continuous step while searching [rad]: order 4 leaves errors of 1e-5.
SEARCHING = 0.2
# Of the shortest time in which a spring oscillates by a radian, while searching; finer with a power of the fineness.
SPRING_STEP, SPRING_POWER = 0.16, 0.7
# A speed that is as good as 0 [m/s].
TINY = 1e-300


@borrowing
def write_matrix(row: Array, q: Quaternion) -> None:
    """Write the matrix of a quaternion into a row, of the square of its length."""
    w, x, y, z = q
    row[3], row[4], row[5] = w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)
    row[6], row[7], row[8] = 2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)
    row[9], row[10], row[11] = 2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z


@borrowing
def _write(row: Array, motion: Motion, q: Quaternion, columns: Array, w_matrix: Vector, attitude: int) -> None:
    """Write a row; q: of the program's length."""
    row[0], row[1], row[2] = motion.x
    row[12], row[13], row[14] = motion.v
    row[15], row[16], row[17] = rotate(motion.q, motion.w_body)
    row[18], row[19], row[20], row[21] = q
    write_matrix(row, q)
    if attitude == MATRIX:
        row[15], row[16], row[17] = w_matrix
        row[18:22] = math.nan
        for i in range(3):
            for j in range(3):
                row[3 + 3 * j + i] = columns[i, j]


@borrowing
def _limited(motion: Motion, dynamics: Dynamics) -> Motion:
    """Return a motion whose velocities are below the caps."""
    if not dynamics.is_capped:
        return motion
    v, w = limited(motion.v, motion.w_body, motion.q, dynamics)
    return Motion(motion.x, motion.q, v, w)


@borrowing
def _at_rest(motion: Motion, dynamics: Dynamics) -> Motion:
    """Return a motion whose velocities are 0 below the thresholds."""
    slow, slow_spin = dynamics.thresholds
    v, w = motion.v, motion.w_body
    if dot(v, v) < slow * slow:
        v = (0.0, 0.0, 0.0)
    if dot(w, w) < slow_spin * slow_spin:
        w = (0.0, 0.0, 0.0)
    return Motion(motion.x, motion.q, v, w)


@borrowing
def _share_above(before: float, after: float, threshold: float) -> float:
    """Return the share of a step after which a speed that changes linearly is below a threshold, or 1; of squares."""
    if before >= threshold * threshold > after:  # neither is true of a run that diverged
        first, last = math.sqrt(before), math.sqrt(after)
        return (first - threshold) / (first - last)
    return 1.0


@borrowing
def _share_awake(before: Motion, after: Motion, dynamics: Dynamics) -> float:
    """Return the share of a step after which a velocity is below its threshold, or 1."""
    slow, slow_spin = dynamics.thresholds
    return min(
        _share_above(dot(before.v, before.v), dot(after.v, after.v), slow),
        _share_above(dot(before.w_body, before.w_body), dot(after.w_body, after.w_body), slow_spin),
    )


@borrowing
def _above_floor(motion: Motion, before: Motion, dt: float, dynamics: Dynamics, smooth: bool) -> Motion:
    """Return a motion whose centre is at no negative height: it stops there, or bounces.

    before: dt [s] earlier.  A continuous run bounces at the instant of the contact, under the mean acceleration.
    """
    up = dynamics.up
    height, rate = dot(up, motion.x), dot(up, motion.v)
    if height >= 0.0:
        return motion
    other_height, other_rate = 0.0, -dynamics.bounce * rate
    first, speed = dot(up, before.x), dot(up, before.v)
    if smooth and dynamics.bounce > 0.0 and first >= 0.0:
        a = (rate - speed) / dt
        # The larger root of first + speed t + a t^2 / 2 = 0, in a form that also holds for a = 0 or first = 0.
        root = math.sqrt(max(0.0, speed * speed - 2.0 * a * first))
        contact = (speed + root) / -a if speed > 0.0 else 2.0 * first / max(root - speed, TINY)
        left = max(0.0, dt - contact)
        other_rate = -dynamics.bounce * (speed + a * contact)
        other_height = max(0.0, other_rate * left + 0.5 * a * left * left)
        other_rate += a * left
    x = add(motion.x, scale(other_height - height, up))
    return Motion(x, motion.q, add(motion.v, scale(other_rate - rate, up)), motion.w_body)


@borrowing
def _spring_rate(row: Array, fineness: float) -> float:
    """Return an upper bound of the springs' angular frequency [rad/s], less if a search may be coarse."""
    stiffness = row[AT.stiffness]
    if stiffness == 0.0:
        return 0.0
    least = min(row[AT.moments], row[AT.moments + 1], row[AT.moments + 2])
    rate = math.sqrt(stiffness * (1.0 / row[AT.mass] + row[AT.reach] * row[AT.reach] / least))
    return rate * fineness * (SEARCHING / fineness) ** SPRING_POWER / SPRING_STEP


@borrowing
def _integrate(
    start: Array,
    times_s: Array,
    found: Array,
    dynamics: Dynamics,
    events: Array,
    spring_rate: float,
    scheme: Scheme,
    rounding: float,
    columns: Array,
) -> None:
    """Simulate from a state, (13,), at t = 0 to times [s] that do not decrease, (T,); found: rows, (T, 22).

    events: in the order of their times, (E, 16); spring_rate: upper bound of the springs' angular frequency [rad/s];
    rounding: of the times [s]; columns: room for a matrix.  Between two times there are whole steps and a shorter last
    one, or only whole ones if they fit within rounding; a continuous run takes equal steps.
    """
    q = normalise((start[3], start[4], start[5], start[6]))
    w_matrix = (start[10], start[11], start[12])
    motion = Motion((start[0], start[1], start[2]), q, (start[7], start[8], start[9]), rotate_back(q, w_matrix))
    momentum = rotate(q, times(dynamics.moments, motion.w_body))
    columns[0, 0], columns[0, 1], columns[0, 2] = rotate(q, (1.0, 0.0, 0.0))
    columns[1, 0], columns[1, 1], columns[1, 2] = rotate(q, (0.0, 1.0, 0.0))
    columns[2, 0], columns[2, 1], columns[2, 2] = rotate(q, (0.0, 0.0, 1.0))
    nothing = (0.0, 0.0, 0.0)
    floor = not dynamics.is_usual and dot(dynamics.up, dynamics.up) > 0.0
    sleeps = not dynamics.is_usual and max(*dynamics.thresholds) > 0.0
    push = Push(0, nothing, nothing, nothing, (nothing, nothing, nothing))
    length, now, number, row, steps = 1.0, 0.0, 0, 0, 0
    while row < len(times_s):
        happens = number < len(events) and events[number, 0] <= times_s[row]
        stop = events[number, 0] if happens else times_s[row]
        interval = stop - now
        smooth = scheme.attitude == SMOOTH
        if interval > (0.0 if smooth else NEARLY * scheme.step):  # what is only rounding is no step
            ratio = interval / scheme.step
            if smooth:
                ratio = smooth_count(motion, interval, dynamics, push, spring_rate, scheme.step)
            most = (MOST_RADIANS / scheme.step if smooth else MOST_STEPS) * interval / times_s[-1]
            count = max(1, math.ceil(min(ratio - (0.0 if smooth else NEARLY), most)))
            nearest = max(1, round(ratio))
            is_whole = not smooth and ratio <= most and abs(interval - nearest * scheme.step) <= 2.0 * rounding
            if is_whole:
                count = nearest
            for done in range(count):
                dt = scheme.step if is_whole or done < count - 1 else interval - done * scheme.step
                if smooth or ratio > most:
                    dt = interval / count
                if smooth:
                    part, least = dt, LEAST_SHARE * dt  # divided where a velocity falls below its threshold
                    while dt > 0.0:
                        after = continuous_step(_limited(motion, dynamics), part, dynamics, push, scheme.stored)
                        after = _limited(after, dynamics)
                        if floor:
                            after = _above_floor(after, motion, part, dynamics, True)
                        share = _share_awake(motion, after, dynamics) if sleeps and part == dt else 1.0
                        shorter = max(share * dt, least)
                        if shorter < dt:  # also after rounding, so that each pass is shorter or gets on
                            part = shorter
                        else:
                            motion = _at_rest(after, dynamics) if sleeps else after
                            dt -= part
                            part = dt
                    continue
                if floor and dynamics.floor_place == FLOOR_BEFORE:
                    motion = _above_floor(motion, motion, dt, dynamics, False)
                growth, before = 1.0, motion
                if scheme.attitude != RUNGE_KUTTA:
                    motion, growth = euler_step(motion, dt, dynamics, push, scheme, steps >= scheme.idle_steps)
                    steps += 1
                elif dynamics.cap_place == CAP_BEFORE:
                    motion = runge_kutta_step(_limited(motion, dynamics), dt, dynamics, push, scheme)
                else:
                    motion = _limited(runge_kutta_step(motion, dt, dynamics, push, scheme), dynamics)
                if floor and dynamics.floor_place == FLOOR_AFTER:
                    motion = _above_floor(motion, motion, dt, dynamics, False)
                if sleeps:
                    motion = _at_rest(motion, dynamics)
                if scheme.precision != DOUBLE:
                    motion = to_single(before, motion, scheme.precision, dt if scheme.recovers else 0.0)
                length *= growth
                if scheme.normalise_every > 0 and steps % scheme.normalise_every == 0:
                    length = 1.0
                if scheme.attitude == MATRIX:
                    momentum = add(momentum, scale(dt, twist(motion.x, motion.q, push)))
                    w_matrix = matrix_step(columns, dt, momentum, dynamics.moments)
            now = stop
        if happens:
            motion, push, jump = happen(motion, push, events, number, dynamics, 1.0 if scheme.is_unit_used else length)
            momentum = add(momentum, jump)
            number += 1
        else:
            _write(found[row], motion, stretch(length, motion.q), columns, w_matrix, scheme.attitude)
            row += 1


@kernel_with(Path(__file__).parent)
def integrate(
    starts: Array,
    times_s: Array,
    ends: Array,
    found: Array,
    numbers: Array,
    scene: Forces,
    tethers: Array,
    events: Array,
    event_ends: Array,
    schemes: Array,
    fineness: float,
) -> None:
    """Simulate programs, each from a state, (N, 13), at t = 0 to times of its own [s] that do not decrease.

    times_s, found: one program's after the other's, (T,) and (T, 22); ends: where those of each end, (N,); numbers,
    scene, tethers: as in `kernel.parameters`; events: in the order of their times, (E, 16), and where those of each
    program end, (N,); schemes: rows of `Scheme`; fineness: rotation in a step of a continuous run [rad].
    """
    columns = np.empty((3, 3))
    begin, first = 0, 0
    for program in range(len(ends)):
        end, last, row = ends[program], event_ends[program], numbers[program]
        _integrate(
            starts[program],
            times_s[begin:end],
            found[begin:end],
            dynamics_of(numbers, program, scene, tethers),
            events[first:last],
            _spring_rate(row, fineness),
            scheme_of(schemes[program], fineness),
            row[AT.rounding],
            columns,
        )
        begin, first = end, last
