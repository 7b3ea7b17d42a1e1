"""What a file shows of contact: its free flights, the impacts between them, and its motions along the plane.

Positions at rows are late by the step of the program; the velocities before and after an impact are not.  They are
those of the flights that fit the rows before and after it, at the instant where both flights meet.
"""

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from tumble.compare.grade.measure.conserved import poses_of
from tumble.compare.grade.measure.errors import Measured, half_digits
from tumble.compare.grade.model.contact_law import UP, Approach, after_impacts, free_rotation, lowest_of, right_law
from tumble.compare.grade.read.trajectory import Trajectory
from tumble.scenarios.frames import Array, quaternion_product, rotation_matrix, turned_by
from tumble.scenarios.lowest import lowest
from tumble.scenarios.scene import Scene, frozen_array
from tumble.solver.contact.flight import axes_of
from tumble.solver.quaternion import from_matrix

# Most rows of a throw that are measured; of a longer file every second, third, ... row is.
MOST_ROWS = 4000
# A row is in flight if its acceleration is gravity's within this share, apart from the printed digits.
FREE = 0.02
# Rows are taken so far apart that digits change their accelerations by this share of gravity at most.
DIGITS_SHARE = 0.05
# A flight is fitted to at least three rows, and its ends reach as far as rows fit, within this many digits.
FEWEST, FITS = 3, 4.0
# Rows without a flight between two that belong to one impact, at most.
GAP = 3
# Rows that show the rotation before or after an impact, at most, and the angle between the first and the last [rad].
TURN_ROWS, TURN = 12, 1.0
# Rows that a motion along the plane has at least, and of these the first ones, which show its start.
LASTING, FIRST_ROWS = 6, 6
# A body this near to the plane, as a share of its reach, for so many times as a hop of that height lasts, lies on it.
HOP, HOPS = 5e-3, 8.0
# Corners that are within this share of the body above the lowest one meet the plane with it.
LEVEL = 2e-3
# Relative effect of the last bit of a single-precision number.
SINGLE = 3e-7


@dataclass(frozen=True, eq=False)
class Rows:
    """Rows of one throw in the plane's frame, with the plane through the origin.

    times [s], (n,); x [m], (n, 3); q: body to the plane's frame, (n, 4); half: uncertainty of x from the printed digits
    [m], (n,); half_turn: the same of the attitude [rad]; low: height of the lowest point [m], (n,).
    """

    times: Array
    x: Array
    q: Array
    half: Array
    half_turn: float
    low: Array

    @cached_property
    def spacing_s(self) -> float:
        """The interval of most rows [s]."""
        return float(np.median(np.diff(self.times)))


@dataclass(frozen=True, eq=False)
class Flight:
    """A free flight: rows first to last, x and v at `time`, and the uncertainty of the fitted velocity [m/s]."""

    first: int
    last: int
    time: float
    x: Array
    v: Array
    sigma: float

    def at(self, time: float, pull: Array) -> tuple[Array, Array]:
        """Return x and v at a time [s]."""
        t = time - self.time
        return self.x + t * self.v + t * t / 2 * pull, self.v + t * pull


@dataclass(frozen=True, eq=False)
class Impact:
    """One impact in the file.

    Parameters
    ----------
    time : instant where the flights before and after it meet [s]
    before : the body just before it
    v, w : velocity [m/s] and angular velocity [rad/s] after it, (3,)
    gap : how far above the plane the flights meet, negative below it [m]
    late : time that the body spends below or above the plane's surface, as by a step [s]
    stays : whether it stays on the plane
    sigma_v, sigma_w : uncertainties from the printed digits [m/s], [rad/s]
    single : whether one corner meets the plane alone
    chain : how long after it other corners may have met the plane before the first row that follows [s]; 0 if by the
        right law none does. Of a chain, `time` and `before` are of the first touch, v and w of the flight after it
    lasts, rises : time [s], and greatest height [m], from the flight before it to what follows
    """

    time: float
    before: Approach
    v: Array
    w: Array
    gap: float
    late: float
    stays: bool
    sigma_v: float
    sigma_w: float
    single: bool
    chain: float = 0.0
    lasts: float = 0.0
    rises: float = 0.0

    @cached_property
    def approach(self) -> float:
        """Speed of the contact point towards the plane [m/s]."""
        return -float((self.before.v + np.cross(self.before.w, self.before.lever))[2])

    @cached_property
    def rebound(self) -> float:
        """Speed of the contact point away from the plane [m/s]."""
        return float((self.v + np.cross(self.w, self.before.lever))[2])


@dataclass(frozen=True, eq=False)
class Lasting:
    """A motion along the plane: rows first to last; v, w at the first one; whether that is the scene's start."""

    first: int
    last: int
    v: Array
    w: Array
    from_start: bool
    height: float


@dataclass(frozen=True, eq=False)
class ContactMotion:
    """What one throw of a file shows of contact.

    rows: of the throw; pull: gravity, plane's frame [m/s2]; flights, impacts, lasting: in order of time; through: time
    at which it is inside or below the plane without having been turned back, None: never; frozen: time from which on
    it hangs still in the air, None: never.
    """

    scene: Scene
    rows: Rows
    pull: Array
    flights: tuple[Flight, ...]
    impacts: tuple[Impact, ...]
    lasting: tuple[Lasting, ...]
    through: float | None
    frozen: float | None


def contact_motion(trajectory: Trajectory, scene: Scene, measured: Measured) -> ContactMotion:
    """Return what the rows of the diagnosed throw show of contact."""
    rows = rows_of(trajectory, scene, measured)
    scene = replace(scene, start=frozen_array(scene.start[measured.throw : measured.throw + 1]))
    assert scene.plane is not None
    assert scene.gravity is not None
    pull = axes_of(scene.plane.normal) @ scene.gravity
    flights = tuple(flights_of(rows, pull))
    lies = lying(rows, scene, pull)
    flights = tuple(flight for flight in flights if not lies[flight.first : flight.last + 1].all())
    lasting = tuple(lasting_of(rows, scene, pull, flights, lies))
    impacts = tuple(impacts_of(rows, scene, pull, flights, lasting))
    return ContactMotion(
        scene, rows, pull, flights, impacts, lasting, passed(rows, scene, flights), frozen(rows, scene)
    )


def rows_of(trajectory: Trajectory, scene: Scene, measured: Measured) -> Rows:
    """Return the rows of the diagnosed throw in the plane's frame."""
    assert scene.plane is not None
    description, every = measured.description, -(-measured.rows // measured.throws // MOST_ROWS)
    poses, times, halves = [], [], []
    for block in trajectory.blocks():
        own = block.throw(measured.throw)
        if not len(own.times):
            continue
        poses.append(poses_of(own, description, scene))
        times.append(own.times)
        still = np.zeros((len(own.times), 13))
        halves.append(np.linalg.norm(half_digits(trajectory, own, description, scene, still), axis=1))
    pose, time, half = np.concatenate(poses)[::every], np.concatenate(times)[::every], np.concatenate(halves)[::every]
    axes = axes_of(scene.plane.normal)
    x = (pose[:, 0:3] - scene.plane.point) @ axes.T
    q = from_world(axes, pose[:, 3:7])
    half = half + measured.single * SINGLE * float(np.abs(pose[:, 0:3]).max() + scene.body.reach)
    half_turn = float(np.median(half)) / scene.body.reach
    return Rows(time, x, q, half, half_turn, x[:, 2] + lowest(scene.body, q, UP))


def from_world(axes: Array, q: Array) -> Array:
    """Return attitudes in the plane's frame, normalised, (n, 4)."""
    unit = q / np.linalg.norm(q, axis=1)[:, None]
    return quaternion_product(np.broadcast_to(from_matrix(axes[None])[0], unit.shape), unit)


def flights_of(rows: Rows, pull: Array) -> Iterator[Flight]:
    """Yield the free flights."""
    t, x, strength = rows.times, rows.x, float(np.linalg.norm(pull))
    half = float(np.median(rows.half))
    lag = int(np.clip(np.ceil(np.sqrt(8 * half / (DIGITS_SHARE * strength)) / rows.spacing_s), 1, len(t) // 4 or 1))
    if len(t) < 2 * lag + 1:
        return
    before, here, after = slice(0, -2 * lag), slice(lag, -lag), slice(2 * lag, None)
    first, second = (t[here] - t[before])[:, None], (t[after] - t[here])[:, None]
    bends = 2 * ((x[after] - x[here]) / second - (x[here] - x[before]) / first) / (first + second)
    room = FREE * strength + 8 * half / np.minimum(first, second)[:, 0] ** 2
    free = np.flatnonzero(np.abs(bends - pull).max(axis=1) <= room) + lag
    end = -1
    for run in np.split(free, np.flatnonzero(np.diff(free) > 1) + 1):
        if not len(run):
            continue
        low, high = int(run[0]), int(run[-1])
        if high - low < 1:
            low, high = low - lag, high + lag
        flight = fitted(rows, pull, low, high)
        low, high = reached(rows, pull, flight, low, high, end)
        if high - low + 1 < FEWEST:
            continue
        end = high
        yield fitted(rows, pull, low, high)


def fitted(rows: Rows, pull: Array, low: int, high: int) -> Flight:
    """Return the flight through rows low to high."""
    t, x = rows.times[low : high + 1], rows.x[low : high + 1]
    middle = float(t.mean())
    s = (t - middle)[:, None]
    rest = x - s * s / 2 * pull
    square = float((s * s).sum())
    v = (s * rest).sum(axis=0) / square
    sigma = float(np.median(rows.half)) / np.sqrt(square)
    return Flight(low, high, middle, rest.mean(axis=0), v, sigma)


def reached(rows: Rows, pull: Array, flight: Flight, low: int, high: int, end: int) -> tuple[int, int]:
    """Return how far the rows on both sides are of the same flight; end: last row of the flight before."""
    span = rows.times[high] - rows.times[low]

    def fits(row: int) -> bool:
        off = np.abs(rows.x[row] - flight.at(float(rows.times[row]), pull)[0]).max()
        beyond = max(rows.times[low] - rows.times[row], rows.times[row] - rows.times[high], 0.0)
        return bool(off <= FITS * (rows.half[row] * (1 + 2 * beyond / span) + 1e-9 * (1 + np.abs(rows.x[row]).max())))

    while low - 1 > end and fits(low - 1):
        low -= 1
    while high + 1 < len(rows.times) and fits(high + 1):
        high += 1
    return low, high


def spin_near(rows: Rows, scene: Scene, row: int, way: int, until: int, time: float) -> tuple[Array, float]:
    """Return the angular velocity at a time [rad/s], (3,), from the attitudes of rows beside it, and its uncertainty.

    row: nearest to the impact; way: +1 for rows after it, -1 before; until: the last row that may be used.
    """
    count = min(TURN_ROWS, abs(until - row) + 1)
    chosen = row + way * np.arange(count)
    if count < 2:
        return np.zeros(3), np.inf
    t, q = rows.times[chosen], rows.q[chosen]
    steps = turned_by(q[:-1], q[1:])
    angles = np.cumsum(np.linalg.norm(steps, axis=1))
    if not scene.body.radius:
        count = max(3, int(np.searchsorted(angles, TURN)) + 1)
    t, q, steps = t[:count], q[:count], steps[: count - 1]
    w = steps.sum(axis=0) / (t[-1] - t[0])
    if not scene.body.radius and len(t) > 2:
        w = refined(scene, t, q, time)
    return w, 2 * rows.half_turn / abs(float(t[-1] - t[0])) * (1.0 if scene.body.radius else 3.0)


def refined(scene: Scene, t: Array, q: Array, time: float) -> Array:
    """Return the angular velocity at a time of the free rotation that fits attitudes best, (3,)."""
    body = scene.body
    middle = len(t) // 2
    rates = turned_by(q[:-1], q[1:]) / np.diff(t)[:, None]
    w, attitude = rates[min(middle, len(rates) - 1)].copy(), np.zeros(3)

    def coasted(turn: Array, w: Array, times: Array) -> tuple[Array, Array]:
        return free_rotation(body.moments, turned(turn, q[middle]), w, times - t[middle])

    def misfit(parameters: Array) -> Array:
        return turned_by(coasted(parameters[:3], parameters[3:], t)[0], q).ravel()

    at = np.concatenate((attitude, w))
    scale = np.concatenate((np.full(3, 1e-5), np.full(3, 1e-4 * (1 + np.linalg.norm(w)))))
    for _ in range(6):
        off = misfit(at)
        slopes = np.stack([(misfit(at + step) - off) / scale[n] for n, step in enumerate(np.diag(scale))], axis=1)
        change = np.linalg.lstsq(slopes, -off, rcond=None)[0]
        at = at + change
        if np.abs(change / scale).max() < 1e-4:
            break
    return coasted(at[:3], at[3:], np.array([time]))[1][0]


def turned(rotation: Array, q: Array) -> Array:
    """Return an attitude that is rotated by a rotation vector."""
    angle = float(np.linalg.norm(rotation))
    half = np.concatenate(([np.cos(angle / 2)], np.sinc(angle / 2 / np.pi) * rotation / 2))
    return quaternion_product(half, q)


def impacts_of(
    rows: Rows, scene: Scene, pull: Array, flights: tuple[Flight, ...], lasting: tuple[Lasting, ...]
) -> Iterator[Impact]:
    """Yield the impacts between flights, and between a flight and a motion along the plane."""
    every = sorted((*flights, *lasting), key=lambda one: one.first)
    for one, other in itertools.pairwise(every):
        apart = rows.times[other.first] - rows.times[one.last]
        between = rows.low[one.last + 1 : other.first]
        # A contact that yields may last many rows, in which a ball does not rise above the plane.
        yields = bool(scene.body.radius) and len(between) and between.max() <= HOP * scene.body.reach
        if isinstance(one, Flight) and (apart <= GAP * rows.spacing_s * 1.01 or yields):
            found = chain_of(rows, scene, pull, one, other) or impact_of(rows, scene, pull, one, other)
            # Of a body with corners, two may have met the plane between rows that are further apart.
            if found is not None and (scene.body.radius or found.chain or apart <= rows.spacing_s * 1.01):
                yield found


def chain_of(rows: Rows, scene: Scene, pull: Array, one: Flight, other: "Flight | Lasting") -> Impact | None:
    """Return the impacts of several corners between two rows as one; None if only one meets the plane by the law."""
    assert scene.plane is not None
    if scene.body.radius or isinstance(other, Lasting):
        return None
    begin, end = float(rows.times[one.last]), float(rows.times[other.first])
    time = met_surface(rows, scene, pull, one, begin, end)
    if time is None:
        return None
    w, sigma = spin_near(rows, scene, one.last, -1, one.first, time)
    axes = axes_at(rows, scene, one.last, w, time)
    lever, second = lowest_point(axes, scene)
    single = second > LEVEL * scene.body.reach
    before = Approach(one.at(time, pull)[1], w, axes, lever, 0.0)
    answer = after_impacts(scene.body, before, right_law(scene.plane), pull, end - time)
    if answer is None or answer[2] < 2:
        return None
    v, (w, sigma_after) = other.at(time, pull)[1], spin_near(rows, scene, other.first, +1, other.last, time)
    sigma_v = one.sigma + other.sigma
    return Impact(time, before, v, w, 0.0, np.nan, False, sigma_v, float(sigma + sigma_after), single, end - time)


def impact_of(rows: Rows, scene: Scene, pull: Array, one: Flight, other: "Flight | Lasting") -> Impact | None:
    """Return the impact between a flight and what follows it; None if they do not meet."""
    begin, end = rows.times[one.last] - rows.spacing_s, rows.times[other.first] + rows.spacing_s
    surface = met_surface(rows, scene, pull, one, begin, end + rows.spacing_s)
    if isinstance(other, Lasting):
        if surface is None:
            return None
        time = float(np.clip(surface, rows.times[one.last], rows.times[other.first]))
        v, w, late, gap = other.v, other.w, 0.0, 0.0
        sigma_v, sigma_w = 4 * float(np.median(rows.half)) / rows.spacing_s, 4 * rows.half_turn / rows.spacing_s
        v = v - np.array((0.0, 0.0, v[2]))
    else:
        (x1, v1), (x2, v2) = (flight.at(0.0, pull) for flight in (one, other))
        if v2[2] - v1[2] <= 0:
            return None
        time = float((x1[2] - x2[2]) / (v2[2] - v1[2]))
        if not begin <= time <= end:
            return None
        v = other.at(time, pull)[1]
        w, sigma_w = spin_near(rows, scene, other.first, +1, other.last, time)
        sigma_v, gap = one.sigma + other.sigma, np.nan
        late = abs(time - surface) if surface is not None else np.nan
    x, v_before = one.at(time, pull)
    w_before, sigma = spin_near(rows, scene, one.last, -1, one.first, time)
    axes = axes_at(rows, scene, one.last, w_before, time)
    lever, second = lowest_point(axes, scene)
    height = float(x[2] + lever[2])
    # A program that finds the contact as deep as another corner is above it may solve both at once.
    single = second > LEVEL * scene.body.reach + max(0.0, -height)
    if isinstance(other, Flight):
        gap = height
        if surface is None:
            late = max(0.0, height) / max(-float((v_before + np.cross(w_before, lever))[2]), 1e-12)
    lasts = float(rows.times[other.first] - rows.times[one.last])
    rises = float(rows.low[one.last + 1 : other.first + FIRST_ROWS].max(initial=0.0))
    fall, rise = (-float((v_before + np.cross(w_before, lever))[2]), float((v + np.cross(w, lever))[2]))
    if fall <= 0:
        return None
    depth = max(0.0, -height)
    before = Approach(v_before, w_before, axes, lever, depth, depth * (1 + fall / rise) if rise > 0 else 0.0)
    return Impact(
        time,
        before,
        v,
        w,
        gap,
        late,
        isinstance(other, Lasting),
        sigma_v,
        float(sigma + sigma_w),
        single,
        lasts=lasts,
        rises=rises,
    )


def axes_at(rows: Rows, scene: Scene, row: int, w: Array, time: float) -> Array:
    """Return the body's axes at a time near a row, (3, 3)."""
    took = time - float(rows.times[row])
    return rotation_matrix(turned(w * took, rows.q[row]))


def met_surface(rows: Rows, scene: Scene, pull: Array, flight: Flight, begin: float, end: float) -> float | None:
    """Return when the lowest point of a flight meets the plane [s], between two times; None if it does not."""
    w, _ = spin_near(rows, scene, flight.last, -1, flight.first, float(rows.times[flight.last]))

    def height(time: float) -> float:
        lever, _ = lowest_point(axes_at(rows, scene, flight.last, w, time), scene)
        return float(flight.at(time, pull)[0][2] + lever[2])

    times = np.linspace(begin, end, 33)
    heights = np.array([height(time) for time in times])
    below = np.flatnonzero((heights[1:] <= 0) & (heights[:-1] > 0))
    if not len(below):
        return None
    low, high = float(times[below[0]]), float(times[below[0] + 1])
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (middle, high) if height(middle) > 0 else (low, middle)
    return high


def lowest_point(axes: Array, scene: Scene) -> tuple[Array, float]:
    """Return the lever of the lowest point [m], (3,), and how much the next one is above it [m]."""
    body = scene.body
    if body.radius:
        return np.array((0.0, 0.0, -body.radius)), np.inf
    if body.disc is not None:
        # Of a disc that is nearly flat half the rim is near the plane; of one on its side, the other rim.
        near = body.disc.radius * float(np.hypot(*axes[2, :2]))
        other = body.disc.thickness * abs(float(axes[2, 2])) if body.disc.thickness else np.inf
        return lowest_of(body, axes), min(near, other)
    levers = body.points @ axes.T
    order = np.argsort(levers[:, 2])
    return levers[order[0]], float(levers[order[1], 2] - levers[order[0], 2]) if len(order) > 1 else np.inf


def lying(rows: Rows, scene: Scene, pull: Array) -> np.ndarray:
    """Return whether the body lies on the plane, which a yielding contact may shake it on, (n,) of bool."""
    height = HOP * scene.body.reach
    lies = np.abs(rows.low) <= height
    least = HOPS * 2 * float(np.sqrt(2 * height / np.linalg.norm(pull)))
    for run in np.split(np.arange(len(lies)), np.flatnonzero(np.diff(lies)) + 1):
        if len(run) < LASTING or rows.times[run[-1]] - rows.times[run[0]] < least:
            lies[run] = False
    return lies


def lasting_of(
    rows: Rows, scene: Scene, pull: Array, flights: tuple[Flight, ...], lies: np.ndarray
) -> Iterator[Lasting]:
    """Yield the motions along the plane: rows between flights at a steady height and, of a box, on a face."""
    assert scene.plane is not None
    taken = np.zeros(len(rows.times), dtype=bool)
    for flight in flights:
        taken[flight.first : flight.last + 1] = True
    steady = np.zeros(len(rows.times), dtype=bool)
    room = 4 * float(np.median(rows.half)) + 0.05 * float(np.linalg.norm(pull)) * rows.spacing_s**2
    steady[:-1] = np.abs(np.diff(rows.low)) <= room
    steady[1:] |= steady[:-1]
    near = np.abs(rows.low) <= 0.1 * scene.body.reach
    up = rotation_matrix(rows.q)[:, 2, :]
    faces = up[:, 2:] if scene.body.disc is not None else up
    tilt = np.ones(len(up), dtype=bool) if scene.body.radius else (np.abs(faces).max(axis=1) > 1 - 1e-4)
    start = axes_of(scene.plane.normal)
    usable = np.flatnonzero(~taken & (steady & near | lies) & tilt)
    for run in np.split(usable, np.flatnonzero(np.diff(usable) > 1) + 1):
        if len(run) < LASTING:
            continue
        # A flight as long as this would show in the heights of its rows.
        rises = float(np.linalg.norm(pull)) * float(rows.times[run[-1]] - rows.times[run[0]]) ** 2 / 8
        if np.ptp(rows.low[run]) > rises / 4:
            continue
        first, last = int(run[0]), int(run[-1])
        from_start = first == 0 and rows.times[0] == 0
        if not from_start:
            # Bounces that are too short to be flights come first; the motion begins where the height stays.
            off = np.abs(rows.low[run] - np.median(rows.low[run]))
            above = np.flatnonzero(off > max(room, 6 * float(np.median(off))))
            first += int(above[-1]) + 1 if len(above) else 0
            if last - first + 1 < LASTING:
                continue
        if from_start:
            own = scene.start[0]
            v, w = start @ own[7:10], start @ own[10:13]
        else:
            v, w = started(rows, first, last)
        yield Lasting(first, last, v, w, from_start, float(np.median(rows.low[first : last + 1])))


def started(rows: Rows, first: int, last: int) -> tuple[Array, Array]:
    """Return v and w at the first row of a motion along the plane, from the parabola through the first rows."""
    some = slice(first, min(last, first + FIRST_ROWS) + 1)
    t, x, q = rows.times[some] - rows.times[first], rows.x[some], rows.q[some]
    v = np.polynomial.polynomial.polyfit(t, x, 2)[1]
    rates = turned_by(q[:-1], q[1:]) / np.diff(t)[:, None]
    w = np.polynomial.polynomial.polyfit((t[1:] + t[:-1]) / 2, rates, 1)[0]
    return v, w


def passed(rows: Rows, scene: Scene, flights: tuple[Flight, ...]) -> float | None:
    """Return when a flight that begins above the plane goes on below it by the body's reach [s], None: never."""
    for flight in flights:
        low = rows.low[flight.first : flight.last + 1]
        if low[0] > 0 and low[-1] < -scene.body.reach:
            return float(rows.times[flight.first + int(np.argmax(low < 0))])
    return None


def frozen(rows: Rows, scene: Scene) -> float | None:
    """Return from when on the body hangs still above the plane to the end [s], None: never."""
    moved = np.abs(np.diff(rows.x, axis=0)).max(axis=1) > 2 * rows.half[1:]
    last = int(np.flatnonzero(moved)[-1]) + 1 if moved.any() else 0
    hangs = rows.low[-1] > 0.01 * scene.body.reach + FITS * rows.half[-1]
    return float(rows.times[last]) if hangs and len(rows.times) - last > LASTING else None
