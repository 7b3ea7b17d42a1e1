"""An account of how a trajectory came about: the scene as the program understood it, how it flew, what it wrote down.

The account of a program without mistakes is `truthful`; a mistake replaces some of its fields.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from tumble.compare.engines.tumble import forces_of
from tumble.compare.grade.model.kernel.dynamics import (
    AS_FORCE,
    AS_THE_BODY,
    BEGIN,
    END,
    EVENT,
    EXPLICIT,
    JUMP,
    LINEARLY,
    POINT_MOVES,
    SMOOTH,
    TURNED,
    UNMIXED,
    Laws,
    Scheme,
)
from tumble.compare.grade.model.kernel.stepping import WIDTH, integrate
from tumble.scenarios.forces import Law, stiffness
from tumble.scenarios.frames import Array, rotation_matrix
from tumble.scenarios.impulse import strike_point
from tumble.scenarios.scene import Body, Impulse, Scene
from tumble.solver.forces import Forces
from tumble.solver.vectors import Vector

# Radians a smooth step turns at most: order 4 leaves 1e-5 of a radian turned while searching, 1e-9 in the end.
SEARCHING, FINE = 0.2, 0.02
# Of the shortest time in which a spring swings by a radian.
SPRING_STEP = 0.1
# Of a force's strength: no sum has a digit of it, and it is not the 0 that would leave a term out of the kernel.
NO_STRENGTH = 1e-200
# Of impulses applied in some way; the same are flown again and again with other mistakes.
EVENTS_KEPT = 1024
NOTHING: Vector = (0.0, 0.0, 0.0)
# Where a clock's instant divided by its tick is a whole number but for rounding, it is that number.
WHOLE = 1e-6


# Rows between two ticks: the last tick's; the centre straight and the attitude along an arc, or its q straight as well.
HELD, ALONG_ARCS, STRAIGHT = 0, 1, 2


class Clock(NamedTuple):
    """What the program's physics had reached when it wrote t: rate t + offset [s], in whole ticks [s] unless 0.

    lag: by so many ticks more than the whole ones that fit; between: how rows between two
    ticks are interpolated, of the constants above; stop: no further than this [s].
    """

    rate: float = 1.0
    offset: float = 0.0
    tick: float = 0.0
    lag: float = 0.0
    between: int = HELD
    stop: float = np.inf

    def reached(self, times: Array, rounding: float = 0.0) -> Array:
        """Return the instants of the physics [s]; before it starts they are 0.  rounding: of the times [s]."""
        reached = self.rate * times + self.offset
        reached = in_ticks(reached, self.tick, self.lag, rounding) if self.tick else reached
        return np.clip(reached, 0.0, self.stop)

    def share(self, times: Array, rounding: float) -> Array:
        """Return how far the physics is from the tick that it has reached to the next, from 0 to 1."""
        ticks = (self.rate * times + self.offset) / self.tick - self.lag
        share = ticks - np.floor(ticks + WHOLE + rounding / self.tick)
        return np.where((ticks > 0) & (share > WHOLE + rounding / self.tick), share, 0.0)


def in_ticks(times: Array, tick: float | Array, lag: float, rounding: float = 0.0) -> Array:
    """Return the last whole ticks [s] before instants [s], rounded by so much, of a clock that lags by so many more."""
    return tick * np.floor(times / tick - lag + WHOLE + rounding / tick)


class Stroke(NamedTuple):
    """How an impulse J is applied.

    lasts: [s], as a constant force J/lasts, 0 for a jump; ends: the force stops then; turns: so does its torque, which
    otherwise acts at once; arm, held, levers: of the lever, as `kernel.laws.Laws` has them; strength: of J; in_body: J
    is meant in body axes; moves: the centre as well.
    """

    lasts: float = 0.0
    ends: bool = True
    turns: bool = True
    arm: tuple[float, float, float, float, float] = (1.0, 1.0, 0.0, 0.0, 0.0)
    held: int = POINT_MOVES
    strength: float = 1.0
    levers: int = AS_THE_BODY
    in_body: bool = False
    moves: bool = True


class Pose(NamedTuple):
    """What a program writes down at its instants [s], (T,).

    x [m], (T, 3); axes: its matrix body to world, (T, 3, 3); q as flown, (T, 4), nan where it keeps none.
    """

    times: Array
    x: Array
    axes: Array
    q: Array


AT_ONCE, RIGHT, IN_NO_STEPS = Stroke(), Clock(), Scheme(0.0, SMOOTH, EXPLICIT, False, 0.0)
Writing = Callable[[Pose], Pose]


@dataclass(frozen=True, eq=False)
class Account:
    """One throw as a program understood it, flew it and wrote it down.

    mass [kg]; moments [kg m2], (3,); start: (13,); gravity [m/s2], (3,), from an instant [s] on; forces: the scene's
    others, and how stiff they are [N/m]; damping to caps: as `kernel.laws.Laws` has them; writings: what is done to a
    pose, in this order; rounding: of printed instants [s].
    """

    body: Body
    mass: float
    moments: Array
    start: Array
    gravity: Array
    impulses: tuple[Impulse, ...]
    forces: Forces
    stiffness: float
    damping: tuple[float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0)
    brakes: tuple[Vector, Vector, Vector] = (NOTHING, NOTHING, NOTHING)
    falls_from: float = 0.0
    damps: int = AS_FORCE
    decays: int = LINEARLY
    gyroscopic: float = 1.0
    mixed: int = UNMIXED
    tensor: int = TURNED
    struck: int = TURNED
    turning: float = 1.0
    caps: tuple[float, float] = (np.inf, np.inf)
    stroke: Stroke = AT_ONCE
    scheme: Scheme = IN_NO_STEPS
    clock: Clock = RIGHT
    writings: tuple[Writing, ...] = ()
    rounding: float = 0.0

    def written(self, times: Array, fineness: float = SEARCHING) -> Pose:
        """Return what the program wrote at its instants [s], increasing, (T,)."""
        reached = self.clock.reached(times, self.rounding)
        if self.clock.between != HELD:
            pose = self._between(times, reached, fineness)
        else:
            pose = pose_of(times, self.flown(reached, fineness))
        with np.errstate(all="ignore"):  # a flight that blew up is judged by what it leaves
            for writing in self.writings:
                pose = writing(pose)
        return pose

    def _between(self, times: Array, reached: Array, fineness: float) -> Pose:
        """Return what is interpolated between the tick that the physics has reached and the next."""
        instants, places = np.unique(np.concatenate((reached, reached + self.clock.tick)).round(9), return_inverse=True)
        rows = self.flown(instants, fineness)
        before, after = (pose_of(times, rows[part]) for part in np.split(places, 2))
        share = self.clock.share(times, self.rounding)[:, None]
        same = np.sign((before.q * after.q).sum(axis=1))[:, None]
        one, other = 1 - share, share
        if self.clock.between == ALONG_ARCS:
            angle = np.arccos(np.clip((same * before.q * after.q).sum(axis=1), -1.0, 1.0))[:, None]
            with np.errstate(invalid="ignore", divide="ignore"):
                one, other = (np.where(angle > 0, np.sin(part * angle) / np.sin(angle), part) for part in (one, other))
        q = one * before.q + other * same * after.q
        axes = rotation_matrix(q / np.linalg.norm(q, axis=1)[:, None])
        return Pose(times, (1 - share) * before.x + share * after.x, axes, q)

    def flown(self, times: Array, fineness: float = SEARCHING) -> Array:
        """Return rows of `kernel.stepping` at instants [s] that do not decrease, (T, 22), each after its impulses."""
        rows = np.empty((len(times), WIDTH))
        gravity = tuple(self.gravity.tolist())
        late = (self.falls_from, *(self.mass * self.gravity).tolist()) if self.falls_from else None
        forces = self.forces._replace(mass=self.mass, gravity=NOTHING if late else gravity)
        laws = Laws(
            moments=tuple(self.moments.tolist()),
            forces=forces,
            damping=self.damping,
            brakes=self.brakes,
            damps=self.damps,
            decays=self.decays,
            gyroscopic=self.gyroscopic,
            mixed=self.mixed,
            tensor=self.tensor,
            struck=self.struck,
            first=tuple((self.start[3:7] / np.linalg.norm(self.start[3:7])).tolist()),
            turning=self.turning,
            caps=self.caps,
            arm=self.stroke.arm,
            held=self.stroke.held,
            levers=self.stroke.levers,
            strikes_in_body=self.stroke.in_body,
        )
        scheme = self.scheme if self.scheme.attitude != SMOOTH else self.scheme._replace(step=fineness)
        integrate(
            self.start,
            times,
            rows,
            laws,
            _events(self.impulses, self.stroke, late),
            self._spring_rate() * fineness / SPRING_STEP,
            scheme,
            self.rounding,
        )
        return rows

    def _spring_rate(self) -> float:
        """Return at most how fast a spring of the scene can make the body swing [rad/s]."""
        reach = (self.body.points**2).sum(axis=1).max()
        return float(np.sqrt(self.stiffness * (1 / self.mass + reach / self.moments.min())))


def pose_of(times: Array, rows: Array) -> Pose:
    """Return the pose in rows of `flown`."""
    return Pose(times, rows[:, 0:3], rows[:, 3:12].reshape(-1, 3, 3), rows[:, 18:22])


def truthful(scene: Scene, throw: int, rounding: float = 0.0) -> Account:
    """Return the account of a program that makes no mistake; rounding: of its instants [s].  Raises RayMissed."""
    gravity = np.zeros(3) if scene.gravity is None else np.array(scene.gravity)
    start, moments = np.array(scene.start[throw]), np.array(scene.body.moments)
    forces = forces_of(scene), stiffness(scene)
    account = Account(scene.body, scene.body.mass, moments, start, gravity, (), *forces, rounding=rounding)
    for impulse in scene.impulses:
        account = replace(account, impulses=(*account.impulses, _landed(impulse, account)))
    return account


def without_strength(law: Law, scene: Scene) -> Any:
    """Return an acting law's numbers as the account's forces have them, but for its strength."""
    return getattr(forces_of(law.scaled(scene, NO_STRENGTH)), law.part)


def _landed(impulse: Impulse, before: Account) -> Impulse:
    """Return an impulse with the point where its ray meets the body of an account: others are told it."""
    if impulse.ray is None:
        return impulse
    row = before.flown(np.array([impulse.time]), FINE)[0]
    state = np.concatenate((row[0:3], row[18:22], row[12:18]))
    return replace(impulse, ray=None, point_world=strike_point(impulse, state, before.body))


def with_writing(account: Account, writing: Writing) -> Account:
    """Return the account of a program that does this to a pose last of all."""
    return replace(account, writings=(*account.writings, writing))


@lru_cache(maxsize=EVENTS_KEPT)
def _events(
    impulses: tuple[Impulse, ...], stroke: Stroke, late: tuple[float, float, float, float] | None = None
) -> Array:
    """Return the events of `kernel.stepping`, (E, 16); late: from when on a force acts on the centre, and which."""
    rows: list[tuple[float, ...]] = [(late[0], BEGIN, *late[1:], *NOTHING, *NOTHING, False)] if late else []
    for impulse in impulses:
        value = stroke.strength * impulse.value
        in_body = impulse.point_body is not None
        place = (*(impulse.point_body if in_body else impulse.point_world), in_body)  # type: ignore[misc]
        if not stroke.lasts:
            rows.append((impulse.time, JUMP, *(value if stroke.moves else NOTHING), *value, *place))
            continue
        force, turning = value / stroke.lasts, value / stroke.lasts if stroke.turns else np.zeros(3)
        if not stroke.turns:
            rows.append((impulse.time, JUMP, 0.0, 0.0, 0.0, *value, *place))
        rows.append((impulse.time, BEGIN, *force, *turning, *place))
        if stroke.ends:
            rows.append((impulse.time + stroke.lasts, END, *force, *turning, *place))
    events = np.zeros((len(rows), EVENT))
    order = sorted(range(len(rows)), key=lambda number: rows[number][0])
    for place, number in enumerate(order):
        events[place, :12] = rows[number]
        if rows[number][1] == END:
            events[place, 15] = order.index(number - 1)  # a force is listed as it begins, then as it ends
    return events
