"""What is told of a motion above a plane, in plain doubles: phases, events, observables, and where it ends."""

from dataclasses import dataclass

import numpy as np

from tumble.scenarios.frames import Array
from tumble.scenarios.truth.contact.motion import Changed, Motion
from tumble.scenarios.truth.contact.observables import observed
from tumble.scenarios.truth.contact.outcomes import OutcomeSet, outcome_set
from tumble.scenarios.truth.contact.timeline import Event
from tumble.scenarios.truth.flight import Pose, quaternion


@dataclass(frozen=True)
class Observable:
    """A number that an engine can be held to.

    Parameters
    ----------
    name
    unit
    value
        true value
    bound
        how far that may be from the exact one
    input_error
        how far it moves when each number of the file moves by half its last bit
    begins_s, ends_s : s
        the window of time in which the motion shows it
    """

    name: str
    unit: str
    value: float
    bound: float
    input_error: float
    begins_s: float
    ends_s: float


@dataclass(frozen=True, eq=False)
class ContactEvent:
    """One event.

    Parameters
    ----------
    kind
        impact, impulse, rolls, stops, rests, ...
    time_s : s
    point
        which point of the body, -1 where none
    place : (3,), m
        world axes
    before, after : (13,)
        states just before and after
    velocity_before, velocity_after : (3,), m/s
        of the point, of an impact
    impulse : (3,), N s
        of an impact
    modes
        of an impact, in order
    energy_lost : J
        of an impact
    """

    kind: str
    time_s: float
    point: int
    place: Array
    before: Array
    after: Array
    velocity_before: Array
    velocity_after: Array
    impulse: Array
    modes: tuple[str, ...]
    energy_lost: float


@dataclass(frozen=True)
class ContactPhase:
    """A stretch of the motion.

    Parameters
    ----------
    name
    begins_s, ends_s : s
    """

    name: str
    begins_s: float
    ends_s: float


@dataclass(frozen=True, eq=False)
class ContactRecord:
    """What one throw does above its plane.

    Parameters
    ----------
    phases
        in order of time
    events
        in order of time
    observables
        in order of time
    ended_s : s
        from when on the motion is not known, infinite where it is
    why
        what ends it
    several
        where the law has several answers there, the set of them
    """

    phases: tuple[ContactPhase, ...]
    events: tuple[ContactEvent, ...]
    observables: tuple[Observable, ...]
    ended_s: float
    why: str
    several: OutcomeSet | None


def recorded(motion: Motion, changed: list[Changed]) -> ContactRecord:
    """Return the record of a motion; changed: the motions of changed inputs, the first of them unchanged."""
    setting, finer = motion.setting, motion.finer
    setting.mp.prec = motion.bits
    ends = [float(phase.since) for phase in finer.phases[1:]] + [float(min(finer.ended, setting.times[-1]))]
    phases = (
        tuple(ContactPhase(phase.name, float(phase.since), end) for phase, end in zip(finer.phases, ends, strict=True))
        if finer.phases
        else ()
    )
    several = None if finer.several is None else outcome_set(setting, *finer.several)
    events = tuple(_event(motion, event) for event in finer.events)
    return ContactRecord(phases, events, _observables(motion, changed), float(finer.ended), finer.why, several)


def state_of(motion: Motion, pose: Pose) -> Array:
    """Return a pose as a state in doubles, (13,)."""
    axes = pose.axes @ motion.setting.throw.state_axes.T
    return np.concatenate((pose.x, quaternion(motion.setting.mp, axes), pose.v, pose.w_world)).astype(float)


def _event(motion: Motion, event: Event) -> ContactEvent:
    none, done = np.full(3, np.nan), event.impact
    return ContactEvent(
        kind=event.kind,
        time_s=float(event.time),
        point=event.point,
        place=(event.before.x + event.lever).astype(float),
        before=state_of(motion, event.before),
        after=state_of(motion, event.after),
        velocity_before=none if done is None else done.before.astype(float),
        velocity_after=none if done is None else done.after.astype(float),
        impulse=none if done is None else done.impulse.astype(float),
        modes=() if done is None else done.modes,
        energy_lost=np.nan if done is None else float(done.energy_lost),
    )


def _observables(motion: Motion, changed: list[Changed]) -> tuple[Observable, ...]:
    finer, rougher = observed(motion.setting, motion.finer), observed(motion.setting, motion.rougher)
    others = [(one.share, {each.name: each.value for each in observed(one.setting, one.timeline)}) for one in changed]
    found = []
    for fine, rough in zip(finer, rougher, strict=True):
        # The last bits of the inputs decide whether it happens before the end.
        if any(fine.name not in other for _, other in others):
            continue
        value = float(fine.value)
        bound = float(abs(fine.value - rough.value)) + np.spacing(abs(value)) / 2
        moves = [abs(float(other[fine.name] - others[0][1][fine.name])) / abs(share) for share, other in others[1:]]
        found.append(
            Observable(
                fine.name, fine.unit, value, float(bound), max(moves, default=0.0), float(fine.begins), float(fine.ends)
            )
        )
    return tuple(found)
