"""The whole motion of one throw above a plane: phases, and the events between them.

`choose` says what a pose does next, `follow` makes it happen; so a motion whose numbers are changed a little can be
made to take the same course.  Where the law has no one answer, or none of the phases here is what happens, the
timeline ends, and says why.
"""

from collections.abc import Callable
from typing import Any, NamedTuple, Protocol

import numpy as np

from tumble.scenarios.truth.contact import disc, edge, face, sphere, top
from tumble.scenarios.truth.contact.approach import Flight, NoContactFound, in_doubles, meeting, meets_near
from tumble.scenarios.truth.contact.impact import Impact, impact, velocity_at
from tumble.scenarios.truth.contact.pinned import LANDS, SLIPS, Failure, failure, hold, zero_of
from tumble.scenarios.truth.contact.setting import FLAT, TOUCHING, Setting, length
from tumble.scenarios.truth.deadline import current
from tumble.scenarios.truth.flight import Pose, lever
from tumble.scenarios.truth.inertia import Numbers
from tumble.scenarios.truth.rational import cross

MOST_PHASES, MOST_IMPACTS = 4000, 60
# How many of the impacts of a sphere that bounces steadily are events.
MOST_BOUNCES = 24
# Of body and speed: the velocity along the normal that an impact without restitution, rounded, leaves.
SETTLED_BITS = 30

IMPACT, IMPULSE, ROLLS, STOPS, RESTS = "impact", "impulse", "rolls", "stops", "rests"


class Phase(Protocol):
    """A stretch of the motion: its name, when it begins and ends by itself, inf where it does not, and its poses."""

    name: str
    since: Any
    until: Any

    def at(self, time: Any) -> Pose:
        """Return the pose at an instant within it."""
        ...


class Event(NamedTuple):
    """What happens at an instant: kind; point: which of the body's touches, -1 where none does; before and after it,

    poses; impact: what an impact did, else None; lever: of the point, world axes, (3,).
    """

    kind: str
    time: Any
    point: int
    before: Pose
    after: Pose
    lever: Numbers
    impact: Impact | None = None


class Choice(NamedTuple):
    """What happens next: kind, a key of FOLLOW, or ENDS; to which points of the body; when, about; why it ends;

    others: of a body that rocks, the points that it leaves; of one that turns about points, that which ends it.
    """

    kind: str
    points: tuple[int, ...] = ()
    guess: float = np.inf
    why: str = ""
    others: tuple[int, ...] = ()


ENDS = "ends"


class Timeline(NamedTuple):
    """Phases in order, of which the last may end before the motion does; events; choices made; and why it ends, when.

    ended: the instant from which on the motion is not known, inf where it is; several: at that instant, the points
    that touch at once, and the pose before, where the law has several answers.
    """

    phases: list[Phase]
    events: list[Event]
    choices: list[Choice]
    ended: Any
    why: str
    several: tuple[tuple[int, ...], Pose] | None = None

    def at(self, time: Any) -> Pose:
        """Return the pose at an instant, after its events."""
        phase = next(phase for phase in reversed(self.phases) if phase.since <= time)
        return phase.at(time)


class Builder:
    """Makes the timeline of a setting; near: the same in doubles; choices: those of a like motion, to be followed."""

    def __init__(self, setting: Setting, near: Setting, choices: list[Choice] | None = None) -> None:
        self.setting, self.near, self.guide = setting, near, choices
        self.last = setting.times[-1]
        self.phases: list[Phase] = []
        self.events: list[Event] = []
        self.choices: list[Choice] = []
        # Speeds along the normal that count as none: as rounded inputs leave them, or our own rounding.
        self.by_inputs = True
        self._fastest = setting.mp.sqrt(length(setting.mp, setting.gravity) * setting.reach)
        # The flight that `choose` has found, with the instant of its contact, until it is followed.
        self.found: tuple[Flight, Any] | None = None
        # The same of a motion about points that stay; and why the motion ends after the phase that has just ended.
        self.pinned: tuple[Any, Failure | None] | None = None
        self.rolling: disc.RollingDisc | None = None
        self.ending = ""

    def made(self) -> Timeline:
        """Return the timeline.  Raises RayMissed."""
        setting = self.setting
        pose, time = setting.start, setting.mp.zero
        impulses = [(setting.mp.mpf(impulse.time), impulse) for impulse in setting.throw.impulses]
        while len(self.choices) < MOST_PHASES:
            current().check()
            while impulses and impulses[0][0] <= time:
                pose = self._applied(pose, *impulses.pop(0))
            until = min(impulses[0][0], self.last) if impulses else self.last
            choice = self._next(pose, time, until)
            self.choices.append(choice)
            if choice.kind == ENDS:
                several = (choice.points, pose) if choice.points else None
                return Timeline(self.phases, self.events, self.choices, time, choice.why, several)
            try:
                pose, time = FOLLOW[choice.kind](self, pose, time, until, choice)
            except NoContactFound as why:
                return Timeline(self.phases, self.events, self.choices, time, str(why))
            if time > self.last or (time == self.last and not impulses):
                return Timeline(self.phases, self.events, self.choices, setting.mp.inf, "")
        return Timeline(self.phases, self.events, self.choices, time, "its phases are too many")

    def _next(self, pose: Pose, time: Any, until: Any) -> Choice:
        if self.guide is not None:
            if len(self.choices) >= len(self.guide):
                return Choice(ENDS, why="the followed motion ends")
            return self.guide[len(self.choices)]
        if self.ending:
            return Choice(ENDS, why=self.ending)
        try:
            return choose(self, pose, time, until)
        except NoContactFound as why:
            return Choice(ENDS, why=str(why))

    def _applied(self, pose: Pose, time: Any, impulse: Any) -> Pose:
        """Return the pose after an applied impulse.  Raises RayMissed."""
        setting = self.setting
        J = setting.numbers(impulse.value)
        arm = lever(impulse, pose.x, pose.axes, setting.throw)
        w = pose.w_world + setting.inverse_world(pose) @ cross(arm, J)
        after = pose._replace(v=pose.v + J / setting.mass, w_world=w)
        self.events.append(Event(IMPULSE, time, -1, pose, after, arm))
        self.by_inputs = True
        return after

    def still(self, pose: Pose) -> Any:
        """Return the speed along the normal that counts as none [m/s]."""
        setting = self.setting
        speed = setting.speed_m_s(pose)
        self._fastest = max(self._fastest, speed)
        if self.by_inputs:
            return TOUCHING * speed
        return setting.mp.ldexp(self._fastest, SETTLED_BITS - setting.mp.prec)

    def stay(self, phase: Phase, until: Any, event: str, points: tuple[int, ...]) -> tuple[Pose, Any]:
        """Go through a phase to its own end, which is an event, or to an instant."""
        self.phases.append(phase)
        if phase.until > until:
            return phase.at(until), until
        pose = phase.at(phase.until)
        self.by_inputs = False
        arm = self.setting.lever(pose, points[0])
        self.events.append(Event(event, phase.until, points[0], pose, pose, arm))
        return pose, phase.until


def choose(builder: Builder, pose: Pose, time: Any, until: Any) -> Choice:
    """Return what a pose does next.  Raises NoContactFound."""
    setting = builder.setting
    gaps, arms = setting.gaps(pose), setting.levers(pose)
    touching = tuple(point for point, gap in enumerate(gaps) if gap <= setting.touching_m(pose))
    if setting.rim is not None and touching:
        return _disc(builder, pose, touching, time, until)
    speeds = {point: velocity_at(pose, arms[point]) @ setting.normal for point in touching}
    still = builder.still(pose)
    meets = tuple(point for point in touching if speeds[point] < -still)
    stays = tuple(point for point in touching if abs(speeds[point]) <= still)
    if len(meets) > 1 or (meets and stays):
        if len(meets) > 1 and len(stays) > 1 and edge.rock(setting, pose, stays, meets) is not None:
            return _counted(builder, time, Choice("rocks", meets, others=stays))
        return several(meets + stays, time)
    if meets:
        return _counted(builder, time, Choice("impact", (meets[0],)))
    if stays:
        return (
            _sphere(builder, pose, time) if setting.radius is not None else _lasting(builder, pose, stays, time, until)
        )
    if setting.radius is not None and touching and _bounces_steadily(builder, pose):
        return Choice("bouncing", (0,))
    return _flight_choice(builder, pose, time, until)


def several(points: tuple[int, ...], time: Any) -> Choice:
    """Return the end of a motion at which several points meet the plane at once."""
    what = "a face" if len(points) > 2 else "an edge"
    why = (
        f"{what} meets the plane flat at {float(time):.6g} s, {len(points)} points at once: the law has several answers"
    )
    return Choice(ENDS, points, why=why)


def _counted(builder: Builder, time: Any, choice: Choice) -> Choice:
    """Return the choice of one more impact, or the end where they are too many."""
    most = MOST_PHASES if builder.setting.radius is not None else MOST_IMPACTS
    if sum(event.kind == IMPACT for event in builder.events) < most:
        return choice
    return Choice(ENDS, why=f"impacts follow one another without end (chatter) at {float(time):.6g} s")


def _flight_choice(builder: Builder, pose: Pose, time: Any, until: Any) -> Choice:
    flight = Flight(builder.setting, pose, time)
    met = meeting(builder.setting, builder.near, flight, pose, until)
    builder.found = flight, None if met is None else met.time
    if met is None:
        return Choice("flight")
    return Choice("flight", met.points, float(met.time - time))


def _sphere(builder: Builder, pose: Pose, time: Any) -> Choice:
    """Return what a sphere on the plane does."""
    setting = builder.setting
    if setting.pressing <= 0:
        return _leaving(builder, pose, time)
    slip = setting.along(velocity_at(pose, setting.levers(pose)[0]))
    if not setting.friction:
        return Choice("sphere slides", (0,))
    speed = length(setting.mp, slip)
    if speed > _rounded_slip(builder, pose):
        return Choice("sphere slips", (0,))
    return Choice("sphere rolls" if sphere.rolls(setting) else "sphere slips from rest", (0,))


def _disc(builder: Builder, pose: Pose, touching: tuple[int, ...], time: Any, until: Any) -> Choice:
    """Return what a disc does of which some rims touch the plane."""
    setting, still, at = builder.setting, builder.still(pose), f"at {float(time):.6g} s"
    if setting.sine_of_tilt(pose) <= FLAT:
        rises, tilts = pose.v @ setting.normal, length(setting.mp, setting.along(pose.w_world)) * setting.reach
        if rises - tilts < -still:
            return Choice(ENDS, why=f"a disc meets the plane flat {at}: the law has several answers")
        if rises > still or setting.pressing <= 0:
            return _flight_choice(builder, pose, time, until)
        return _on_face(builder, face.Face(setting, pose, touching), touching, time, until)
    rates = {rim: velocity_at(pose, setting.lever(pose, rim)) @ setting.normal for rim in touching}
    pressed = tuple(rim for rim, rate in rates.items() if rate <= still)
    if not pressed:
        return _flight_choice(builder, pose, time, until)
    if min(rates.values()) < -still:
        return several(pressed, time) if len(pressed) > 1 else _counted(builder, time, Choice("impact", pressed))
    if len(pressed) > 1 and not disc.goes_straight(setting, pose, still):
        return Choice(ENDS, why=f"a disc turns on both its rims {at}: the law leaves open how its pressure is spread")
    slip = setting.along(velocity_at(pose, setting.lever(pose, min(pressed))))
    if setting.pressing <= 0 or length(setting.mp, slip) > still:
        return Choice(
            ENDS, why=f"a rim slips on the plane, or is not pressed on it, {at}: the truth is of discs that roll"
        )
    phase = disc.RollingDisc(setting, pose, pressed, time)
    builder.rolling = phase
    fails = phase.failure(until)
    if fails is None:
        return Choice("rim rolls", pressed)
    at = f"at {float(fails.time):.6g} s"
    if fails.time <= time:
        return Choice(ENDS, why=f"a rim begins to slip {at}")
    return Choice(
        "rim rolls",
        pressed,
        float(fails.time - time),
        f"{disc.ENDS[fails.how]} {at}",
        (list(disc.ENDS).index(fails.how),),
    )


def _leaving(builder: Builder, pose: Pose, time: Any) -> Choice:
    """Return the flight of a body that nothing presses against the plane it touches."""
    builder.found = Flight(builder.setting, pose, time), None
    return Choice("flight")


def _rounded_slip(builder: Builder, pose: Pose) -> Any:
    """Return the slip that is none but for rounding [m/s]."""
    return builder.still(pose)


def _bounces_steadily(builder: Builder, pose: Pose) -> bool:
    """Return whether friction does nothing to the bounces to come: no slip, or no friction, and no incline."""
    setting = builder.setting
    still = builder.still(pose)
    if setting.pressing <= 0 or length(setting.mp, setting.gravity_along) > TOUCHING * setting.pressing:
        return False
    slip = setting.along(velocity_at(pose, setting.levers(pose)[0]))
    return bool(not setting.friction or length(setting.mp, slip) <= still)


def _lasting(builder: Builder, pose: Pose, stays: tuple[int, ...], time: Any, until: Any) -> Choice:
    """Return what a body does of which some points stay on the plane."""
    setting = builder.setting
    if setting.pressing < 0 or (setting.pressing == 0 and not any(pose.w_world)):
        return _leaving(builder, pose, time)
    if setting.pressing and face.spans_a_face(setting, stays):
        return _on_face(builder, face.Face(setting, pose, stays), stays, time, until)
    if setting.pressing and (pinned := _pinned(builder, pose, stays, time, until)) is not None:
        return pinned
    return Choice(
        ENDS,
        why=f"{_points(stays)} on the plane at {float(time):.6g} s: the truth does not cover this lasting contact",
    )


def _pinned(builder: Builder, pose: Pose, points: tuple[int, ...], time: Any, until: Any) -> Choice | None:
    """Return what a body does that an edge or a tip of stays on the plane, None where no truth knows it."""
    setting = builder.setting
    kind = "tips" if len(points) > 1 else "spins on its tip"
    if len(points) == 1 and (not top.is_top(setting, points[0]) or top.is_upright(setting, pose, points[0])):
        return None
    phase = PIN[kind](setting, pose, points, time)
    near = PIN[kind](builder.near, in_doubles(builder.near, pose), points, 0.0)
    if phase is None or near is None:
        return None
    fails = failure(phase, near, until)
    builder.pinned = phase, fails
    what = "an edge" if len(points) > 1 else "the tip"
    if fails is None:
        return Choice(kind, points)
    at = f"at {float(fails.time):.6g} s"
    if fails.how == SLIPS and fails.time <= time:
        return Choice(ENDS, why=f"{what} begins to slip {at}")
    why = f"{what} begins to slip {at}" if fails.how == SLIPS else ""
    return Choice(kind, points, float(fails.time - time), why, (fails.point,))


def _edge_phase(setting: Setting, pose: Pose, points: tuple[int, ...], since: Any) -> edge.Tipping | None:
    found = edge.edge_of(setting, pose, points)
    return None if found is None else edge.Tipping(setting, found, points, since)


def _top_phase(setting: Setting, pose: Pose, points: tuple[int, ...], since: Any) -> top.Top:
    return top.Top(setting, pose, points[0], since)


PIN: dict[str, Callable[[Setting, Pose, tuple[int, ...], Any], Any]] = {
    "tips": _edge_phase,
    "spins on its tip": _top_phase,
}


def _points(points: tuple[int, ...]) -> str:
    return f"vertex {points[0]} stays" if len(points) == 1 else f"vertices {', '.join(map(str, points))} stay"


def _on_face(builder: Builder, lying: face.Face, stays: tuple[int, ...], time: Any, until: Any) -> Choice:
    """Return what a body does that lies on a face."""
    setting, pose, mp = builder.setting, lying.pose, builder.setting.mp
    spins = length(mp, pose.w_world) * setting.reach > builder.still(pose)
    along, none = setting.gravity_along, 0 * pose.v
    at = f"at {float(time):.6g} s"
    if not setting.friction:
        torque = face.gyration(setting, pose) if spins else none
        tips = "its spin tips the body over its face"
        return Choice("face glides", stays) if lying.carries(none, torque) else Choice(ENDS, why=f"{tips} {at}")
    if spins:
        return Choice(ENDS, why=f"a face spins on the plane {at}: the law leaves open how its pressure is spread")
    size = length(mp, along)
    if length(mp, pose.v) > builder.still(pose):
        is_straight = face.Sliding(setting, pose, time, time).is_straight
        if lying.carries_all or (is_straight and lying.carries(face.friction_of(setting, pose.v), none)):
            return Choice("face slides", stays)
        return Choice(ENDS, why=f"the body tips as it slides {at}")
    if size <= setting.friction * setting.pressing * (1 + mp.mpf(TOUCHING)):
        if lying.carries(-along / setting.pressing, none):
            return Choice("face rests", stays)
        still = pose._replace(v=none, w_world=none)
        edge_points = () if setting.rim is not None else lying.tipping_edge(-along / setting.pressing)
        tips = _pinned(builder, still, edge_points, time, until) if edge_points else None
        return tips or Choice(ENDS, why=f"the body tips over {at} before it would slide")
    if lying.carries(face.friction_of(setting, along), none):
        return Choice("face slides from rest", stays)
    return Choice(ENDS, why=f"the body tips as it begins to slide {at}")


def _fall(builder: Builder, pose: Pose, time: Any, until: Any, choice: Choice) -> tuple[Pose, Any]:
    setting = builder.setting
    if builder.found is not None:
        flight, met = builder.found
        builder.found = None
    else:
        flight, met = Flight(setting, pose, time), None
        if choice.points:
            met = meets_near(setting, flight, choice.points[0], float(time) + choice.guess, pose)
    builder.phases.append(flight)
    if met is None:
        return flight.at(until), until
    builder.by_inputs = False
    return flight.at(met), met


def _strike(builder: Builder, pose: Pose, time: Any, until: Any, choice: Choice) -> tuple[Pose, Any]:
    setting = builder.setting
    arm = setting.levers(pose)[choice.points[0]]
    done = impact(setting, pose, arm)
    builder.events.append(Event(IMPACT, time, choice.points[0], pose, done.pose, arm, done))
    builder.by_inputs = False
    return done.pose, time


def _bounce(builder: Builder, pose: Pose, time: Any, until: Any, choice: Choice) -> tuple[Pose, Any]:
    setting = builder.setting
    phase = sphere.Bouncing(setting, pose, time)
    builder.phases.append(phase)
    arm = setting.levers(pose)[0]
    for number in range(1, phase.impacts(until, MOST_BOUNCES) + 1):
        instant = time + phase.after(number)
        after = phase.at(instant)
        up, down = phase.speed(number), -phase.speed(number - 1)
        before = after._replace(v=setting.along(after.v) + setting.normal * down)
        after = after._replace(v=setting.along(after.v) + setting.normal * up)
        along = setting.along(velocity_at(after, arm))
        J = setting.normal * (setting.mass * (up - down))
        lost = setting.mass * (down * down - up * up) / 2
        done = Impact(
            J,
            along + setting.normal * down,
            along + setting.normal * up,
            after,
            ("frictionless" if not setting.friction else "sticks",),
            lost,
        )
        builder.events.append(Event(IMPACT, instant, 0, before, after, arm, done))
    if phase.until > until:
        return phase.at(until), until
    after = phase.at(phase.until)
    builder.events.append(Event(RESTS, phase.until, 0, after, after, arm))
    builder.by_inputs = False
    return after, phase.until


def _roll(name: str) -> Callable:
    def follow(builder: Builder, pose: Pose, time: Any, until: Any, choice: Choice) -> tuple[Pose, Any]:
        return builder.stay(sphere.Rolling(builder.setting, pose, time, name), until, ROLLS, (0,))

    return follow


def _slip(builder: Builder, pose: Pose, time: Any, until: Any, choice: Choice) -> tuple[Pose, Any]:
    return builder.stay(sphere.Slipping(builder.setting, pose, time, builder.last), until, ROLLS, (0,))


def _pin(builder: Builder, pose: Pose, time: Any, until: Any, choice: Choice) -> tuple[Pose, Any]:
    """Go through a motion about points that stay, to its own end or to an instant."""
    setting = builder.setting
    if builder.pinned is not None:
        phase, fails = builder.pinned
        builder.pinned = None
        end = setting.mp.inf if fails is None else fails.time
    else:
        phase = PIN[choice.kind](setting, pose, choice.points, time)
        if phase is None:
            raise NoContactFound("a changed motion leaves its plane")
        end = setting.mp.inf
        if choice.others:
            slips, point = bool(choice.why), choice.others[0]
            gauge = (lambda t: hold(setting, phase.force(t))) if slips else (lambda t: setting.gaps(phase.at(t))[point])
            end = zero_of(gauge, phase, choice.guess)
    phase.until = end
    builder.ending = choice.why if end <= until else ""
    return builder.stay(phase, until, SLIPS if choice.why else LANDS, choice.points)


def _roll_on(builder: Builder, pose: Pose, time: Any, until: Any, choice: Choice) -> tuple[Pose, Any]:
    """Go through the rolling of a disc, to its own end or to an instant."""
    setting, phase = builder.setting, builder.rolling
    builder.rolling = None
    if phase is None:
        phase = disc.RollingDisc(setting, pose, choice.points, time)
    how = list(disc.ENDS)[choice.others[0]] if choice.others else ""
    if how:
        phase.until = zero_of(lambda instant: phase.gauge(how, instant), phase, choice.guess)
    builder.ending = choice.why if phase.until <= until else ""
    return builder.stay(phase, until, how, choice.points)


def _rock(builder: Builder, pose: Pose, time: Any, until: Any, choice: Choice) -> tuple[Pose, Any]:
    setting = builder.setting
    done = edge.rock(setting, pose, choice.others, choice.points)
    if done is None:
        raise NoContactFound("a changed block does not rock")
    point = choice.points[0]
    builder.events.append(Event(IMPACT, time, point, pose, done.pose, setting.levers(pose)[point], done))
    builder.by_inputs = False
    return done.pose, time


def _rest(builder: Builder, pose: Pose, time: Any, until: Any, choice: Choice) -> tuple[Pose, Any]:
    lying = face.Face(builder.setting, pose, choice.points).pose
    return builder.stay(face.Resting(builder.setting, lying, time), until, STOPS, choice.points)


def _slide(builder: Builder, pose: Pose, time: Any, until: Any, choice: Choice) -> tuple[Pose, Any]:
    lying = face.Face(builder.setting, pose, choice.points).pose
    lying = lying._replace(w_world=0 * lying.w_world)
    return builder.stay(face.Sliding(builder.setting, lying, time, builder.last), until, STOPS, choice.points)


def _glide(builder: Builder, pose: Pose, time: Any, until: Any, choice: Choice) -> tuple[Pose, Any]:
    lying = face.Face(builder.setting, pose, choice.points).pose
    if choice.kind == "face slides from rest":
        lying = lying._replace(v=0 * lying.v, w_world=0 * lying.w_world)
    return builder.stay(face.Gliding(builder.setting, lying, time), until, STOPS, choice.points)


FOLLOW: dict[str, Callable[[Builder, Pose, Any, Any, Choice], tuple[Pose, Any]]] = {
    "flight": _fall,
    "impact": _strike,
    "bouncing": _bounce,
    "sphere rolls": _roll("rolls"),
    "sphere slides": _roll("slides"),
    "sphere slips from rest": _roll("slips"),
    "sphere slips": _slip,
    "tips": _pin,
    "spins on its tip": _pin,
    "rocks": _rock,
    "rim rolls": _roll_on,
    "face rests": _rest,
    "face slides": _slide,
    "face glides": _glide,
    "face slides from rest": _glide,
}


def timeline(setting: Setting, near: Setting, choices: list[Choice] | None = None) -> Timeline:
    """Return the motion of a setting; near: the same in doubles; choices: those of a like motion.  Raises RayMissed."""
    return Builder(setting, near, choices).made()
