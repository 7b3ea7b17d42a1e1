"""The one-impact map: every engine starts from the true state shortly before an impact, and is read just after it.

Errors grow from impact to impact; so started, an engine answers for one impact alone.  The instant at which it hits
is taken from its own flights before and after, so that being early or late by a part of a step changes no velocity.
"""

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tumble.compare.contact.asked import BY_OWN_LAW, Asked
from tumble.compare.contact.watched import Watched, angular_momentum, gravity, lowest, spin_of
from tumble.compare.judge import mechanics
from tumble.scenarios.frames import Array, quaternion_product
from tumble.scenarios.scene import Scene
from tumble.scenarios.truth.contact.one_impact import ImpactMap
from tumble.scenarios.truth.contact.record import ContactEvent, ContactRecord, Observable

# Impacts of one scene; a later one is the same question at another speed.
MOST_IMPACTS = 4
# Where in a step the plane is met, as a share of the step: the answer of some engines depends on it.
PHASES = (0.3, 0.8)
# The flight before: as long as the body takes for a share of its size, of at least and at most so many steps.
LEAD_SHARE, LEAD_STEPS = 0.1, (2, 200)
# The motion after: a share of the time to the next event, so that being late does not reach that; at most so many of
# the finest steps.  A soft contact takes tens of steps, so the longest step leaves FEWEST of them.
FOLLOW_SHARE, MOST_STEPS, FEWEST = 0.6, 2000, 40
# The same after a body has rocked onto another edge.
FOLLOW_ROCKING = 0.3
# Samples of the flight before; steps after the impact that are all seen; and samples of the rest.
LEAD_SAMPLES, EACH_STEP, SAMPLES = 20, 64, 100
# The plane has let go when so many steps pass without a push.
LET_GO = 3
# A contact that still pushes with this share of its mean force is not over.
STILL = 0.5
# Both ends of what is measured may be off by a step.
SHIFTS = 2
GAP, DEEPEST, INSTANT = "gap at contact", "deepest penetration", "instant of impact"
REBOUND = "rebound speed after impact"
IN_THE_AIR, TIPS = ("flight", "bounces"), "tips"


@dataclass(frozen=True, eq=False)
class ImpactRun:
    """A run from the true state before an impact, which is lead_s after its start; after: the true state at its end."""

    scene: Scene
    lead_s: float
    after: Array


@dataclass(frozen=True, eq=False)
class Impact:
    """One impact of a scene: what is asked about it, and its runs by step [s], the longest first.

    event: as the truth has it; rocks: whether the body comes from another edge; flies: whether it truly leaves the
    plane.
    """

    number: int
    event: ContactEvent
    rocks: bool
    flies: bool
    asked: tuple[Asked, ...]
    runs: dict[float, tuple[ImpactRun, ...]]


@dataclass(frozen=True)
class Reading:
    """The numbers of one run by observable.

    unfinished: whether the impact was not over at its end; stays: whether the body had not left the plane then;
    through: whether it passed the plane.
    """

    values: dict[str, float]
    unfinished: bool = False
    stays: bool = False
    through: bool = False


def impacts(
    scene: Scene, record: ContactRecord, steps: Sequence[float], step: float, most: int = MOST_IMPACTS
) -> Iterator[Impact]:
    """Yield the first impacts that a body meets in flight, or as it rocks.

    steps: of the ladder [s], the longest first; step: at which values are reported.
    """
    events = [event for event in record.events if event.kind == "impact"][:most]
    if not events:
        return
    known = ImpactMap(scene, 0)
    for number, event in enumerate(events, 1):
        before_s, after_s = known.gaps(number)
        if min(before_s, after_s) <= 0:
            continue
        # Two impacts within a few steps are no question of one impact: the ladder then begins at a shorter step.
        rocks = phase_at(record, before(event.time_s)) == TIPS
        share = (FOLLOW_ROCKING if rocks else FOLLOW_SHARE) * after_s
        shorter = max(0, math.ceil(math.log2(steps[0] * FEWEST / share)))
        own = [one / 2**shorter for one in steps]
        follow_s = min(share, MOST_STEPS * own[-1])
        first = step if step in own else own[0]
        speed = max(-float(event.velocity_before @ normal(scene)), np.finfo(float).tiny)
        lead_s = LEAD_SHARE * scene.body.reach / speed
        yield Impact(
            number=number,
            event=event,
            rocks=rocks,
            flies=phase_at(record, event.time_s) in IN_THE_AIR,
            asked=tuple(asked(scene, record, event, number, first, own[-1], rocks)),
            runs={dt: tuple(runs(scene, known, number, dt, lead_s, follow_s)) for dt in own},
        )


def row_step(impact: Impact, step: float) -> float:
    """Return the step [s] at which an impact's values are reported: the one asked for, or the longest it can take."""
    return step if step in impact.runs else max(impact.runs)


def normal(scene: Scene) -> Array:
    """Return the plane's normal, (3,)."""
    assert scene.plane is not None
    return scene.plane.normal


def before(time: float) -> float:
    """Return the double before an instant."""
    return float(np.nextafter(time, -math.inf))


def phase_at(record: ContactRecord, time: float) -> str:
    """Return the name of the phase at an instant, of two that of the later."""
    return next((phase.name for phase in record.phases if phase.begins_s <= time < phase.ends_s), "flight")


def runs(scene: Scene, known: ImpactMap, number: int, dt: float, lead_s: float, follow_s: float) -> Iterator[ImpactRun]:
    """Yield the runs of one impact at one step, the plane being met at each of PHASES."""
    for phase in PHASES:
        count = int(np.clip(math.ceil(lead_s / dt), *LEAD_STEPS))
        near = known.near(number, (count + phase) * dt, 0.0)
        lead = near.time_s - near.begins_s
        times = sample_times(lead, follow_s, dt)
        after = known.near(number, 0.0, float(times[-1]) - lead).after
        yield ImpactRun(run_scene(scene, near.before, times, dt), lead, after)


def sample_times(lead_s: float, follow_s: float, dt: float) -> Array:
    """Return the instants [s], (S,), at which a run about an impact is looked at, all whole numbers of steps."""
    steps, hits = math.ceil((lead_s + follow_s) / dt), max(1, math.floor(lead_s / dt))
    each = min(steps, hits + EACH_STEP)
    before, rest = np.linspace(1, hits, LEAD_SAMPLES), np.linspace(each, steps, SAMPLES)
    seen = np.unique(np.concatenate((before.astype(int), np.arange(hits, each + 1), rest.astype(int))))
    return seen[seen > 0].astype(float) * dt


def run_scene(scene: Scene, start: Array, times: Array, dt: float) -> Scene:
    """Return a scene that starts at a state, (13,), and is looked at at those times [s]."""
    return replace(
        scene, start=start[None].copy(), times=times, duration=float(times[-1]), step=dt, impulses=(), written=None
    )


def asked(
    scene: Scene, record: ContactRecord, event: ContactEvent, number: int, dt: float, finest: float, rocks: bool
) -> Iterator[Asked]:
    """Yield what is asked about one impact; dt, finest: the step at which values are reported, and the shortest [s]."""
    pull = float(np.linalg.norm(gravity(scene)))
    speed = float(np.linalg.norm(event.before[7:10]))
    approach = abs(float(event.velocity_before @ normal(scene)))
    reach = scene.body.reach
    spin = max(float(np.linalg.norm(state[10:13])) for state in (event.before, event.after)) + approach / reach
    energy = float(mechanics.kinetic_energy(event.before, scene.body))
    scales = {"m/s": max(speed, approach), "rad/s": spin, "J": energy, "s": reach / approach, "m": reach}
    steps = {
        "m/s": pull,
        "rad/s": pull / reach,
        "J": scene.body.mass * speed * pull,
        "s": 1.0,
        "m": max(speed, approach),
    }
    for one in record.observables:
        name = re.sub(rf" impact {number}(?=,|$)", " impact", one.name)
        if name != one.name and not (rocks and name in (INSTANT, REBOUND)):
            scale = abs(one.value) if name.startswith("apex") else scales[one.unit]
            yield Asked(name, number, one.unit, one.value, scale, SHIFTS * dt * steps[one.unit], known_to(one))
    # The gap is that of one step already: free fall within it is all that it may be off.
    if not rocks:
        yield Asked(GAP, number, "m", 0.0, reach, dt * dt * pull, 0.0)
    yield Asked(DEEPEST, number, "m", 0.0, reach, SHIFTS * dt * steps["m"], 0.0)
    if scene.body.radius is not None:  # whose motion along the normal is its centre's
        yield Asked(DEEPEST + BY_OWN_LAW, number, "m", 0.0, reach, SHIFTS * finest * steps["m"], 0.0)
        yield Asked(REBOUND + BY_OWN_LAW, number, "m/s", 0.0, scales["m/s"], SHIFTS * dt * steps["m/s"], 0.0)


def known_to(one: Observable) -> float:
    """Return how far the true value of an observable may be off."""
    return one.bound + one.input_error


def read_impact(impact: Impact, run: ImpactRun, seen: Watched) -> Reading:
    """Return the numbers of one run."""
    if impact.rocks and not seen.through:
        return Reading({DEEPEST: seen.deepest} | numbers(impact, run, seen, 0, None), stays=True)
    touched = int(np.argmax(seen.pushed)) if seen.pushed.any() else None
    if touched is None:
        return Reading({}, through=seen.through)
    gap = gap_at_contact(seen, touched)
    values = {GAP: gap, DEEPEST: seen.deepest}
    left = leaves(seen, touched)
    if left is None and impact.flies and still_pushing(seen, touched):
        return Reading(values, unfinished=True, through=seen.through)
    return Reading(values | numbers(impact, run, seen, touched, left), stays=left is None, through=seen.through)


def leaves(seen: Watched, touched: int) -> int | None:
    """Return the first instant after a contact from which on the body flies, None if it stays.

    A body that is let go below the plane, and falls back before it is out, has not left.
    """
    pushed, height = seen.pushed, seen.lowest
    for left in range(touched + 1, len(pushed)):
        if pushed[left - 1] and not pushed[left : left + LET_GO].any():
            again = left + int(np.argmax(pushed[left:])) if pushed[left:].any() else len(pushed)
            comes_out = again == len(pushed) and height[-1] > height[-2]
            if height[left : again + 1].max() > 0 or comes_out:
                return left
    return None


def still_pushing(seen: Watched, touched: int) -> bool:
    """Whether the plane's force in the last quarter of the contact is that of an impact under way, not of a rest."""
    instants, along = seen.times[touched:], seen.states[touched:, 7:10] @ seen.plane.normal
    weight = seen.pull @ seen.plane.normal
    middle = int(np.searchsorted(instants, instants[0] + 0.75 * (instants[-1] - instants[0])))
    whole, late = (
        (along[-1] - along[first]) / (instants[-1] - instants[first]) - weight
        for first in (0, min(middle, len(along) - 2))
    )
    return bool(late > STILL * whole and late > 2 * abs(weight))


def gap_at_contact(seen: Watched, touched: int) -> float:
    """Return how far above the plane the body, left alone, would have been where the first push had acted [m].

    A step of free fall may be off by g dt^2, according to how it is integrated: that is no gap.
    """
    state, took = seen.states[touched], float(seen.times[touched + 1] - seen.times[touched])
    alone = state.copy()
    alone[0:3] += took * state[7:10] + took * took / 2 * seen.pull
    turn, angle = state[10:13] * took / 2, float(np.linalg.norm(state[10:13])) * took / 2
    alone[3:7] = quaternion_product(np.concatenate(([np.cos(angle)], np.sinc(angle / np.pi) * turn)), state[3:7])
    return max(0.0, float(lowest(seen.scene, alone[None])[0]) - float(np.linalg.norm(seen.pull)) * took**2)


def numbers(impact: Impact, run: ImpactRun, seen: Watched, touched: int, left: int | None) -> dict[str, float]:
    """Return the numbers of an impact that is over: the body has left, or stays."""
    body, event = seen.scene.body, impact.event
    if left is not None:
        hit = hit_time(seen, left)
        v = seen.states[left, 7:10] + (hit - seen.times[left]) * seen.pull
        w = spin_of(angular_momentum(seen.states[left], body), event.after[3:7], body)
    else:
        hit, v, w = float(seen.times[touched + 1]), seen.states[-1, 7:10], seen.states[-1, 10:13]
        if not impact.flies:  # both are in contact: what they differ by at the end, from the true velocities here
            grown = growth(seen, event, float(seen.times[-1]) - run.lead_s) if impact.rocks else 1.0
            v = event.after[7:10] + (v - run.after[7:10]) / grown
            w = event.after[10:13] + (w - run.after[10:13]) / grown
    after = event.after.copy()
    after[7:10], after[10:13] = v, w
    lever = event.place - event.before[0:3]
    values = {
        INSTANT: event.time_s + hit - run.lead_s,
        REBOUND: float((v + np.cross(w, lever)) @ seen.plane.normal),
        "energy lost in impact": float(
            mechanics.kinetic_energy(event.before, body) - mechanics.kinetic_energy(after, body)
        ),
        "apex after impact": float(seen.height[int(np.argmin(seen.height)) :].max())
        if left is None
        else apex(seen, left),
    }
    for name, vector in (("velocity", v), ("spin", w)):
        values |= {f"{name} after impact, {axis}": float(value) for axis, value in zip("xyz", vector, strict=True)}
    return values


def growth(seen: Watched, event: ContactEvent, took: float) -> float:
    """Return by how much an error of the spin about a new edge grows within a time [s]: a pendulum's, from upright."""
    w, arm = event.after[10:13], event.before[0:3] - event.place
    if not w.any():
        return 1.0
    along, body = w / np.linalg.norm(w), seen.scene.body
    arm = arm - (arm @ along) * along
    moment = along @ angular_momentum(np.concatenate((event.after[:10], along)), body) + body.mass * (arm @ arm)
    return math.cosh(took * math.sqrt(max(0.0, -body.mass * float(seen.pull @ arm)) / moment))


def hit_time(seen: Watched, left: int) -> float:
    """Return when the flights before and after the contact are at one height [s], which is when a hard plane is hit."""
    pull, up = float(seen.pull @ seen.plane.normal), seen.states[:, 7:10] @ seen.plane.normal
    time, height = float(seen.times[left]), seen.height
    return float((height[left] - height[0] - up[left] * time + pull * time**2 / 2) / (up[0] - up[left] + pull * time))


def apex(seen: Watched, left: int) -> float:
    """Return the greatest height of the centre of mass after a contact [m], a parabola between the samples."""
    pull, up = -float(seen.pull @ seen.plane.normal), seen.states[:, 7:10] @ seen.plane.normal
    top = left + int(np.argmax(seen.height[left:]))
    return float(seen.height[top] + (up[top] ** 2 / (2 * pull) if pull > 0 else 0.0))
