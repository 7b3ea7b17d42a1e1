"""The whole run: where and when a body stops, where it begins to roll, how it goes on, whether it holds.

Each number belongs to the window of time that the truth gives it, and is read off the engine's own motion there.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tumble.compare.contact.asked import BY_OWN_LAW, CREEP, Asked
from tumble.compare.contact.impacts import DEEPEST, SHIFTS, known_to
from tumble.compare.contact.watched import Watched, gravity
from tumble.compare.judge import mechanics
from tumble.scenarios.frames import Array, rotation_matrix, vertices
from tumble.scenarios.scene import Scene
from tumble.scenarios.truth import Truth
from tumble.scenarios.truth.contact.record import ContactRecord, Observable

# Samples of a run; and how long it is in times of the last stop, so that a body that goes too far is seen to stop.
SAMPLES, LONGER = 250, 2.0
# The same where a ball comes to rest: its last bounces are short.
SAMPLES_TO_REST = 1000
# Below this share of its first speed a slip is followed to zero by its last deceleration.
SLOW = 0.02
# What is left out at the start of a window that begins with a contact, where an engine may be late.
LATE = 0.1
# A ball at rest bounces no faster than gravity makes it in so many times the time between samples.
REST_STEPS = 2.0
# Samples through which a curve is laid; and, of its reach, how near to its lowest point others lie on the plane.
AROUND, ON_THE_PLANE = 4, 1e-9
REST, SLIP, LOST = "instant of rest", "creep speed of the rim", "energy lost as it rolls"
TIPPED, PRECESSION, TILT = "angle it has tipped by", "mean precession", "greatest tilt of the axis"


@dataclass(frozen=True, eq=False)
class WholeRun:
    """What is asked about a whole run: observables as the truth has them, and the scene that is run, by step [s]."""

    asked: dict[str, tuple[Asked, Observable]]
    scenes: dict[float, Scene]
    truth: Truth


def whole_run(scene: Scene, truth: Truth, steps: Sequence[float], step: float) -> WholeRun | None:
    """Return the question of a whole run, None where there is none.

    steps: of the ladder [s], the longest first; step: at which values are reported.
    """
    record = truth.contacts[0]
    found = {
        one.name: (asked(scene, record, one, step, steps[-1]), one)
        for one in record.observables
        if " impact " not in one.name
    }
    if CREEP in found:
        by_own_law = CREEP + BY_OWN_LAW
        found[by_own_law] = replace(found[CREEP][0], observable=by_own_law), found[CREEP][1]
    if not any(event.kind == "impact" for event in record.events) and math.isinf(record.ended_s):
        deepest = Observable(DEEPEST, "m", 0.0, 0.0, 0.0, 0.0, scene.duration)
        found[DEEPEST] = asked(scene, record, deepest, step, steps[-1]), deepest
    if not found:
        return None
    last = max((event.time_s for event in record.events if event.kind == "stops"), default=0.0)
    duration = max(scene.duration, LONGER * last)
    apart = steps[0] * max(1, math.ceil(duration / SAMPLES / steps[0]))
    if REST in found:
        apart = max(steps[0], duration / SAMPLES_TO_REST)
        found[REST] = replace(found[REST][0], one_step=rest_shift(scene, record, step, apart)), found[REST][1]
    times = apart * np.arange(1, math.floor(duration / apart) + 1)
    times = times if math.isclose(times[-1], duration) else np.append(times, duration)
    scenes = {dt: replace(scene, times=times, duration=float(times[-1]), step=dt) for dt in steps}
    return WholeRun(found, scenes, truth)


def rest_shift(scene: Scene, record: ContactRecord, dt: float, apart: float) -> float:
    """Return by how much the instant of rest may be off [s] of a ball that follows the law; apart: of the samples [s].

    The bounces below the least speed that is seen take some time; and a first rebound that is off by SHIFTS steps, of
    e by de, moves the end t1 (1 + e) / (1 - e).
    """
    assert scene.plane is not None
    e, pull = scene.plane.restitution, float(np.linalg.norm(gravity(scene)))
    first = next(event for event in record.events if event.kind == "impact")
    de = SHIFTS * dt * pull / abs(float(first.velocity_before @ scene.plane.normal))
    return 4 * REST_STEPS * apart / (1 - e) + 2 * first.time_s * de / (1 - e) ** 2


def asked(scene: Scene, record: ContactRecord, one: Observable, dt: float, finest: float) -> Asked:
    """Return what is asked about one observable, with the scales of its window.

    dt, finest: the step of the values, and the shortest of the ladder [s].
    """
    pull, took = float(np.linalg.norm(gravity(scene))), one.ends_s - one.begins_s
    speed = max((float(np.linalg.norm(event.before[7:10])) for event in record.events), default=0.0)
    speed = max(speed, float(np.linalg.norm(scene.start[0, 7:10])), pull * dt)
    reach, gained = scene.body.reach, max(speed, pull * took)
    energy = float(mechanics.kinetic_energy(scene.start[0], scene.body))
    scales = {"m/s": gained, "rad/s": gained / reach, "s": took or one.value, "rad": 1.0, "m/s2": pull, "J": energy}
    steps = {"m/s": pull, "rad/s": pull / reach, "s": 1.0, "m": speed, "rad": pull / speed, "m/s2": pull / (took or 1)}
    steps["J"] = scene.body.mass * speed * pull
    one_step, scale = SHIFTS * dt * steps[one.unit], scales.get(one.unit, abs(one.value) or reach)
    if one.name in ("height at rest", DEEPEST):  # what a body falls within a step
        one_step, scale = dt * dt * pull, reach
    if one.name.startswith(CREEP):  # the same, over the time in which it is seen
        one_step = 2 * dt * dt * pull / took
    if one.name == TIPPED:
        one_step = SHIFTS * dt * size(record, "spin at that angle")
    if one.name in (PRECESSION, TILT, SLIP, LOST):  # of a top or a disc, that falls with the turn of a step
        turn = float(np.linalg.norm(scene.start[0, 10:13]))
        one_step = SHIFTS * finest * turn * {SLIP: turn * reach, LOST: energy}.get(one.name, abs(one.value))
    return Asked(one.name, None, one.unit, one.value, scale, one_step, known_to(one))


def size(record: ContactRecord, name: str) -> float:
    """Return the size of the true vector, or number, whose observables' names begin so."""
    return math.hypot(*(one.value for one in record.observables if one.name.startswith(name)))


def read_whole(whole: WholeRun, seen: Watched) -> dict[str, float]:
    """Return the numbers of one run by observable; nan where the run does not show it."""
    return {name: reader(name)(whole, one, seen) for name, (_, one) in whole.asked.items()}


Reader = Callable[[WholeRun, Observable, Watched], float]


def reader(name: str) -> Reader:
    """Return what reads an observable."""
    return next(read for start, read in READERS.items() if name.startswith(start))


@dataclass(frozen=True)
class Stop:
    """The end of a slip: when [s], how far the centre had gone by then, (3,) [m], and the last sample before."""

    time: float
    way: np.ndarray
    last: int


def slip_end(one: Observable, seen: Watched) -> Stop | None:
    """Return where the slip of an observable's window ends, None where the body slips to the end of the run."""
    first = int(np.searchsorted(seen.times, one.begins_s))
    speed = np.linalg.norm(seen.slip, axis=1)
    slow = speed[first:] <= SLOW * speed[first]
    if not slow.any() or not slow[-1]:
        return None
    last = first + int(np.argmax(slow)) - 1
    t, x, v = seen.times, seen.states[:, 0:3], seen.states[:, 7:10]
    if last < first:
        return Stop(float(t[first]), np.zeros(3), first)
    before = max(first, last - 1)
    if before < last and speed[before] > speed[last]:
        left = float(speed[last] * (t[last] - t[before]) / (speed[before] - speed[last]))
        acceleration = (v[last] - v[before]) / (t[last] - t[before])
    else:  # from full slip to none between two samples
        left = float(t[last + 1] - t[last]) / 2
        acceleration = (v[last + 1] - v[last]) / (2 * left)
    begins = seen.at(one.begins_s)[0:3]
    return Stop(float(t[last]) + left, x[last] + left * v[last] + left**2 / 2 * acceleration - begins, last)


def instant(whole: WholeRun, one: Observable, seen: Watched) -> float:
    """Return when a slip ends [s]."""
    stop = slip_end(one, seen)
    return math.nan if stop is None else stop.time


def distance(whole: WholeRun, one: Observable, seen: Watched) -> float:
    """Return how far the centre goes until a slip ends [m]."""
    stop = slip_end(one, seen)
    return math.nan if stop is None else float(np.linalg.norm(seen.along(stop.way)))


def turn(whole: WholeRun, one: Observable, seen: Watched) -> float:
    """Return by how much the way until a slip ends is turned from the first velocity, about the normal [rad]."""
    stop = slip_end(one, seen)
    return math.nan if stop is None else turned(seen, one.begins_s, stop)


def turned(seen: Watched, begins_s: float, stop: Stop) -> float:
    """Return the turn of a way from the velocity at an instant, about the normal [rad]."""
    along = seen.along(seen.at(begins_s)[7:10])
    return math.atan2(float(np.cross(along, stop.way) @ seen.plane.normal), float(along @ stop.way))


def as_it_ends(whole: WholeRun, one: Observable, seen: Watched) -> float:
    """Return a component of the velocity or the spin where a slip ends, on the line through the samples after it."""
    window = replace(one, begins_s=slip_begins(whole, one))
    stop = slip_end(window, seen)
    if stop is None or stop.last + 3 >= len(seen.times):
        return math.nan
    t, row = seen.times, seen.states[:, component(one)]
    near, far = stop.last + 2, stop.last + 3
    return float(row[near] + (stop.time - t[near]) * (row[far] - row[near]) / (t[far] - t[near]))


def slip_begins(whole: WholeRun, one: Observable) -> float:
    """Return when the slip begins whose end an observable is about [s]."""
    ends = one.begins_s
    return max(other.begins_s for _, other in whole.asked.values() if other.begins_s < other.ends_s == ends)


def component(one: Observable) -> int:
    """Return the column of a state that an observable names."""
    return (7 if one.name.startswith("velocity") else 10) + "xyz".index(one.name[-1])


def mean_acceleration(whole: WholeRun, one: Observable, seen: Watched) -> float:
    """Return a component of the mean acceleration [m/s2] over the window: the true one, and what the engine's is off.

    Held against the true motion between the same two samples, so that a late contact does not count.
    """
    axis, truth = 7 + "xyz".index(one.name[-1]), whole.truth
    begins = one.begins_s + (LATE * (one.ends_s - one.begins_s) if one.begins_s > 0 else 0.0)
    inside = np.flatnonzero((truth.times >= begins) & (truth.times <= min(one.ends_s, truth.horizon)))
    if len(inside) < 2:
        return math.nan
    first, last = truth.times[inside[[0, -1]]]
    true = truth.states[inside[-1], 0, axis] - truth.states[inside[0], 0, axis]
    own = seen.at(last)[axis] - seen.at(first)[axis]
    return float(one.value + (own - true) / (last - first))


def creep(whole: WholeRun, one: Observable, seen: Watched) -> float:
    """Return the speed along the plane [m/s] over the second half of a window of rest."""
    ends = max(one.ends_s, float(seen.times[-1])) if one.ends_s >= whole.truth.times[-1] else one.ends_s
    middle = (one.begins_s + ends) / 2
    moved = seen.along(seen.at(ends)[0:3] - seen.at(middle)[0:3])
    return float(np.linalg.norm(moved)) / (ends - middle)


def height_at_rest(whole: WholeRun, one: Observable, seen: Watched) -> float:
    """Return the height of the centre of mass at the end of the window [m], nan where it still moves there."""
    return math.nan if bounces(seen)[-1] else float(np.interp(one.ends_s, seen.times, seen.height))


def bounces(seen: Watched) -> NDArray[np.bool_]:
    """Return whether the body moves faster along the normal than gravity makes it between samples, (R,)."""
    up = abs(seen.states[:, 7:10] @ seen.plane.normal)
    return up > REST_STEPS * float(seen.times[1] - seen.times[0]) * float(np.linalg.norm(seen.pull))


def instant_of_rest(whole: WholeRun, one: Observable, seen: Watched) -> float:
    """Return from when on the body bounces no more [s]."""
    moving = np.flatnonzero(bounces(seen))
    last = int(moving[-1]) if len(moving) else 0
    return math.nan if last + 1 >= len(seen.times) else float(seen.times[last + 1])


def angle_tipped(whole: WholeRun, one: Observable, seen: Watched) -> float:
    """Return the angle [rad] by which the body has turned from its first attitude at an instant."""
    return smooth(one.begins_s, seen.times, seen.turned)


def spin_at_angle(whole: WholeRun, one: Observable, seen: Watched) -> float:
    """Return a component of the spin [rad/s] where the body has turned by the true angle at the true instant."""
    _, angle = whole.asked[TIPPED]
    past = np.flatnonzero(seen.turned >= angle.value)
    if not len(past):
        return math.nan
    near = slice(max(0, int(past[0]) - AROUND), int(past[0]) + AROUND)
    return smooth(angle.value, seen.turned[near], seen.states[near, component(one)])


def smooth(at: float, places: Array, values: Array) -> float:
    """Return the value at a place, on the cubic through the nearest samples; places rise."""
    first = int(np.clip(np.searchsorted(places, at) - AROUND // 2, 0, max(0, len(places) - AROUND)))
    near = slice(first, first + AROUND)
    share = places[near] - at
    weights = [np.prod([b / (b - a) for b in np.delete(share, number)]) for number, a in enumerate(share)]
    return float(np.array(weights) @ values[near])


def creep_of_pivot(whole: WholeRun, one: Observable, seen: Watched) -> float:
    """Return the mean speed along the plane [m/s] of the edge or the tip that truly stays on it."""
    places = seen.place(pivot(whole, one))
    moved = seen.along(places - places[0])
    return float(np.linalg.norm(np.array([np.interp(one.ends_s, seen.times, each) for each in moved.T]))) / one.ends_s


def pivot(whole: WholeRun, one: Observable) -> Array:
    """Return the middle of the points that truly lie on the plane late in a window [m], (3,), body axes."""
    truth, scene = whole.truth, next(iter(whole.scenes.values()))
    assert scene.plane is not None
    inside = truth.times <= min(one.ends_s, truth.horizon)
    state = truth.states[inside][-1, 0]
    heights = vertices(state, scene.body.points) @ scene.plane.normal
    return scene.body.points[heights <= heights.min() + ON_THE_PLANE * scene.body.reach].mean(axis=0)


def axes(whole: WholeRun, one: Observable, seen: Watched) -> Array:
    """Return the unit vectors from the tip to the centre of mass, or along a disc's axis, on the plane's side at first,

    (R, 3).
    """
    if seen.scene.body.disc is not None:
        along: Array = rotation_matrix(seen.states[:, 3:7])[:, :, 2]
        return along if along[0] @ seen.plane.normal >= 0 else -along
    apart = seen.states[:, 0:3] - seen.place(pivot(whole, one))
    return apart / np.linalg.norm(apart, axis=1, keepdims=True)


def mean_precession(whole: WholeRun, one: Observable, seen: Watched) -> float:
    """Return the mean rate [rad/s] at which the body's axis turns about the vertical."""
    up, axis = -seen.pull / np.linalg.norm(seen.pull), axes(whole, one, seen)
    first = axis[0] - (axis[0] @ up) * up
    turned = np.unwrap(np.arctan2(axis @ np.cross(up, first), axis @ first))
    return float(np.interp(one.ends_s, seen.times, turned) - turned[0]) / (one.ends_s - float(seen.times[0]))


def mean_axial_spin(whole: WholeRun, one: Observable, seen: Watched) -> float:
    """Return the mean spin [rad/s] about the line from the point on the plane to the centre of mass."""
    return float(np.einsum("ri,ri->r", axes(whole, one, seen), seen.states[:, 10:13])[seen.times <= one.ends_s].mean())


def mean_slip(whole: WholeRun, one: Observable, seen: Watched) -> float:
    """Return the mean speed along the plane [m/s] of the material at a disc's lowest point."""
    inside = seen.times <= one.ends_s
    return float(np.linalg.norm(seen.slip[inside], axis=1).mean())


def energy_lost(whole: WholeRun, one: Observable, seen: Watched) -> float:
    """Return the energy [J] that a disc loses from its start to the end of the window."""
    first, last = seen.states[0], seen.at(one.ends_s)
    body = seen.scene.body
    kinetic = mechanics.kinetic_energy(first, body) - mechanics.kinetic_energy(last, body)
    return float(kinetic - body.mass * seen.pull @ (first[0:3] - last[0:3]))


def greatest_tilt(whole: WholeRun, one: Observable, seen: Watched) -> float:
    """Return the greatest angle of the axis from the vertical [rad], a parabola between the samples."""
    up = -seen.pull / np.linalg.norm(seen.pull)
    tilts = np.arccos(np.clip(axes(whole, one, seen) @ up, -1, 1))[seen.times <= one.ends_s]
    top = int(np.argmax(tilts))
    if not 0 < top < len(tilts) - 1:
        return float(tilts[top])
    before, here, after = tilts[top - 1 : top + 2]
    bend = 2 * here - before - after
    return float(here + (after - before) ** 2 / (8 * bend) if bend > 0 else here)


def deepest(whole: WholeRun, one: Observable, seen: Watched) -> float:
    """Return the deepest penetration [m]."""
    return seen.deepest


READERS: dict[str, Reader] = {
    REST: instant_of_rest,
    "instant it": instant,
    "distance until": distance,
    "turn of the path": turn,
    "velocity as it": as_it_ends,
    "spin as it": as_it_ends,
    "mean acceleration": mean_acceleration,
    SLIP: mean_slip,
    "creep speed of": creep_of_pivot,
    CREEP: creep,
    TIPPED: angle_tipped,
    "spin at that angle": spin_at_angle,
    PRECESSION: mean_precession,
    "mean spin": mean_axial_spin,
    TILT: greatest_tilt,
    LOST: energy_lost,
    "height at rest": height_at_rest,
    DEEPEST: deepest,
}
