"""The model of a program: the scene as it understands it, how it simulates a throw, and what it writes.

`correct_program` is the model of a program without mistakes; a mistake replaces some of its fields.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any, NamedTuple

import numpy as np

from tumble.compare.grade.model.kernel.dynamics import (
    AS_FORCE,
    AS_THE_BODY,
    AXES_OF_WORLD,
    BEGIN,
    CAP_FORCED,
    END,
    EVENT,
    EXPLICIT,
    FLOOR_AFTER,
    IN_BODY,
    IN_ROW,
    JUMP,
    LINEARLY,
    POINT_MOVES,
    SMOOTH,
    TURNED,
    UNMIXED,
    Scheme,
    TetherLaw,
)
from tumble.compare.grade.model.kernel.parameters import NUMBERS
from tumble.compare.grade.model.kernel.reading import between_ticks, instants_of
from tumble.compare.grade.model.kernel.stepping import SEARCHING, WIDTH, integrate
from tumble.compare.grade.model.numbers import changed_numbers
from tumble.scenarios.forces import Law, stiffness
from tumble.scenarios.frames import Array, rotation_matrix
from tumble.scenarios.impulse import strike_point
from tumble.scenarios.scene import Body, Impulse, Scene
from tumble.solver.forces import Forces
from tumble.solver.scene_forces import forces_of
from tumble.solver.vectors import Vector

# Largest rotation in a continuous step at the end [rad]: order 4 leaves errors of 1e-9.  Where a motion amplifies them
# to more than a share of the body's size, steps are shorter, down to so many parts of that.
FINE, UNSEEN, FINER = 0.02, 1e-8, 8
# A force's strength that has no effect, but is not the 0 that would remove a term from the kernel.
NO_STRENGTH = 1e-200
# Lists of events, and clocks with rows; the same ones are simulated again and again with other mistakes.
EVENTS_CACHED, CLOCKS_CACHED = 1024, 1024
NOTHING, NO_EVENTS = np.empty(0), np.empty((0, EVENT))
ZERO: Vector = (0.0, 0.0, 0.0)
# Tolerance for the number of ticks at a time to be a whole number.
WHOLE = 1e-6


# Columns of a row of `kernel.stepping`.
X, AXES, Q = slice(0, 3), slice(3, 12), slice(18, 22)
# Rows between two ticks: of the last tick; others as in `kernel.reading`.
ZERO_ORDER_HOLD = 0


class Clock(NamedTuple):
    """The time that the physics has reached when the program logs t: rate t + offset [s], in whole ticks [s] unless 0.

    lag: ticks by which the physics is behind the last whole one; interpolation: of rows between two ticks, one of the
    constants above; stop: time at which the physics stops [s].
    """

    rate: float = 1.0
    offset: float = 0.0
    tick: float = 0.0
    lag: float = 0.0
    interpolation: int = ZERO_ORDER_HOLD
    stop: float = np.inf

    def physics_times(self, times: Array, rounding: float = 0.0) -> Array:
        """Return the times of the physics [s], at least 0; rounding: of the logged times [s]."""
        reached = self.rate * times + self.offset
        reached = in_ticks(reached, self.tick, self.lag, rounding) if self.tick else reached
        return np.minimum(np.maximum(reached, 0.0), self.stop)

    def fraction(self, times: Array, rounding: float) -> Array:
        """Return the fraction of a tick since the last one, from 0 to 1."""
        ticks = (self.rate * times + self.offset) / self.tick - self.lag
        fraction = ticks - np.floor(ticks + WHOLE + rounding / self.tick)
        return np.where((ticks > 0) & (fraction > WHOLE + rounding / self.tick), fraction, 0.0)


def in_ticks(times: Array, tick: float | Array, lag: float, rounding: float = 0.0) -> Array:
    """Return the last whole ticks [s] before times [s] with a rounding [s], minus a lag in ticks."""
    return tick * np.floor(times / tick - lag + WHOLE + rounding / tick)


class ImpulseApplication(NamedTuple):
    """How a program applies an impulse J.

    lasts: duration [s] of a constant force J/lasts, 0 for an instantaneous jump; ends: the force ends; turns: its
    torque lasts as well, otherwise it acts at once; lever, lever_motion, lever_axes: as in `kernel.dynamics.Dynamics`;
    strength: factor on J; axes: of J, as in `kernel.dynamics`; moves: factor on J where it changes the velocity of the
    centre; sets: an impulse sets the velocities, and adds nothing to them.
    """

    lasts: float = 0.0
    ends: bool = True
    turns: bool = True
    lever: tuple[float, float, float, float, float] = (1.0, 1.0, 0.0, 0.0, 0.0)
    lever_motion: int = POINT_MOVES
    strength: float = 1.0
    lever_axes: int = AS_THE_BODY
    axes: int = AXES_OF_WORLD
    moves: float = 1.0
    sets: bool = False


class Pose(NamedTuple):
    """The output of a program at its times [s], (T,).

    x [m], (T, 3); axes: matrix body to world, (T, 3, 3); q: (T, 4), nan if the program has none.
    """

    times: Array
    x: Array
    axes: Array
    q: Array


AT_ONCE, RIGHT_CLOCK = ImpulseApplication(), Clock()
CONTINUOUS = Scheme(0.0, SMOOTH, EXPLICIT, False, 0.0, stored=IN_BODY)
OutputTransform = Callable[[Pose], Pose]
THE_SCENES_DRAG, THE_SCENES_TETHERS = (False, False, False), TetherLaw()
# Of a scene without tethers, and without a floor.
NO_TETHERS, NO_POINTS = np.empty((0, 9)), np.empty((0, 3))


@dataclass(frozen=True, eq=False)
class ProgramModel:
    """One throw as a program understands, simulates and writes it.

    mass [kg]; moments [kg m2], (3,); start: state, (13,); gravity [m/s2], (3,), from gravity_from [s] on; forces: the
    scene's other forces; stiffness: of them [N/m]; drag_law: whether the scene's linear drag is quadratic, its angular
    drag is, and its angular drag is not divided by the inertia; the others from damping to thresholds: as in
    `kernel.dynamics.Dynamics`; application: of impulses; tick: from one instant to the next at which a program in steps
    looks for events [s], 0 for its step; output_transforms: applied to a pose in this order; rounding: of printed times
    [s].
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
    drag: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    drag_law: tuple[bool, bool, bool] = THE_SCENES_DRAG
    tether_law: TetherLaw = THE_SCENES_TETHERS
    axis_damping: tuple[Vector, Vector, Vector] = (ZERO, ZERO, ZERO)
    swirl: float = 0.0
    gravity_in_body: bool = False
    gravity_from: float = 0.0
    damping_place: int = AS_FORCE
    damping_form: int = LINEARLY
    gyroscopic: float = 1.0
    frame_mixup: int = UNMIXED
    tensor: int = TURNED
    inverse_tensor: int = TURNED
    impulse_tensor: int = TURNED
    attitude_rate_factor: float = 1.0
    caps: tuple[float, float] = (np.inf, np.inf)
    component_caps: tuple[float, float] = (np.inf, np.inf)
    cap_place: int = CAP_FORCED
    up: Vector = ZERO
    bounce: float = 0.0
    floor_place: int = FLOOR_AFTER
    thresholds: tuple[float, float] = (0.0, 0.0)
    application: ImpulseApplication = AT_ONCE
    scheme: Scheme = CONTINUOUS
    tick: float = 0.0
    clock: Clock = RIGHT_CLOCK
    output_transforms: tuple[OutputTransform, ...] = ()
    rounding: float = 0.0

    def but(self, **changes: Any) -> "ProgramModel":
        """Return the program with some fields changed: as `dataclasses.replace`, but many times as fast."""
        changed = object.__new__(ProgramModel)
        fields = changed.__dict__
        fields.update(self.__dict__)
        fields.update(changes)
        # Most numbers for the kernel are those of the program that it was changed from.
        if (row := fields.get("numbers")) is not None:
            fields["numbers"] = changed_numbers(row, changed, changes)
        return changed

    @property
    def event_tick(self) -> float:
        """The spacing of the instants at which events can happen [s]; 0 for a continuous run, in which any can."""
        return 0.0 if self.scheme.attitude == SMOOTH else self.tick or self.scheme.step

    def output(self, times: Array, fineness: float = SEARCHING) -> Pose:
        """Return the output of the program at increasing times [s], (T,); axes and q: from the body's file axes."""
        return outputs([self], times, fineness)[0]

    def instants(self, times: bytes) -> "Instants":
        """Return the instants that are simulated for rows at times of the program's clock [s], as bytes."""
        clock = self.clock
        if clock.stop < math.inf and self.event_tick:
            clock = clock._replace(stop=float(next_tick(clock.stop, self.event_tick)))
        return _instants(clock, self.rounding, times)

    def simulate(self, times: Array, fineness: float = SEARCHING) -> Array:
        """Return rows of `kernel.stepping` at times [s] that do not decrease, (T, 22), each after its impulses."""
        return simulated([self], [times], fineness)

    @cached_property
    def numbers(self) -> Array:
        """What moves the body, as a row of `kernel.parameters`."""
        return changed_numbers(np.zeros(NUMBERS), self)

    def events(self) -> Array:
        """Return what happens to the body, as in `kernel.events`, (E, 16)."""
        if not self.impulses and not self.gravity_from:
            return NO_EVENTS
        delayed_gravity = (self.gravity_from, *(self.mass * self.gravity).tolist()) if self.gravity_from else None
        return _events(self.impulses, self.application, delayed_gravity, self.event_tick)


def output_points(body: Body) -> Array:
    """Return the vertices in the axes that the output of a program has [m], (n, 3): the body's axes in the file."""
    return body.points @ rotation_matrix(body.file_axes)


def outputs(programs: Sequence[ProgramModel], times: Array, fineness: float = SEARCHING) -> list[Pose]:
    """Return what `ProgramModel.output` does of programs with one body, faster than one by one."""
    every = zip(programs, *poses(programs, times, fineness), strict=True)
    return [written(Pose(times, *own), program.output_transforms) for program, *own in every]


def written(pose: Pose, transforms: Sequence[OutputTransform]) -> Pose:
    """Return a pose after output transforms."""
    with np.errstate(all="ignore"):  # a run that diverged leaves a large residual
        for writing in transforms:
            pose = writing(pose)
    return pose


def poses(programs: Sequence[ProgramModel], times: Array, fineness: float) -> tuple[Array, Array, Array]:
    """Return x, axes and q of programs with one body before their output transforms, as in `Pose`, (N, T, ...)."""
    rows = _rows(programs, times, fineness)
    shape = rows.shape[:2]
    axes, q = rows[:, :, AXES].reshape(*shape, 3, 3), rows[:, :, Q]
    if programs[0].body.file_axes[0] != 1.0:
        turn, product = _turn_and_product(*programs[0].body.file_axes.tolist())
        with np.errstate(all="ignore"):  # a run that diverged
            axes, q = (axes.reshape(-1, 3) @ turn).reshape(axes.shape), (q.reshape(-1, 4) @ product).reshape(q.shape)
    return rows[:, :, X], axes, q


def _rows(programs: Sequence[ProgramModel], times: Array, fineness: float) -> Array:
    """Return rows of `kernel.stepping` of programs at times of their clocks [s], (N, T, 22): x, the matrix and q."""
    as_bytes = times.tobytes()
    every = [program.instants(as_bytes) for program in programs]
    simulations = simulated(programs, [instants.reached for instants in every], fineness)
    if not any(instants.are_ticks for instants in every):
        return simulations.reshape(len(programs), len(times), WIDTH)
    rows, end = np.empty((len(programs), len(times), WIDTH)), 0
    for row, program, instants in zip(rows, programs, every, strict=True):
        begin, end = end, end + len(instants.reached)
        own, clock = simulations[begin:end], program.clock
        if instants.are_ticks:
            between_ticks(own, instants.first, instants.fraction, clock.tick, clock.interpolation, row)
        else:
            row[:] = own
    return rows


class Instants(NamedTuple):
    """The instants that are simulated for some rows: reached [s], (N,).

    Rows between two ticks have the place of the first tick in them, and the fraction of a tick since, (T,).
    """

    reached: Array
    first: Array = NOTHING
    fraction: Array = NOTHING

    @property
    def are_ticks(self) -> bool:
        """Whether they are the ticks around rows."""
        return len(self.first) > 0


@lru_cache(maxsize=CLOCKS_CACHED)
def _instants(clock: Clock, rounding: float, times: bytes) -> Instants:
    """Return the instants of a clock for rows at times [s], as bytes; rounding: of these [s]."""
    logged = np.frombuffer(times)
    reached = clock.physics_times(logged, rounding)
    if clock.interpolation == ZERO_ORDER_HOLD:
        return Instants(reached)
    instants, first = np.empty(2 * len(reached)), np.empty(len(reached))
    count = instants_of(np.rint(reached / clock.tick), instants, first)
    return Instants(clock.tick * instants[:count], first, clock.fraction(logged, rounding))


def simulated(programs: Sequence[ProgramModel], times: Sequence[Array], fineness: float) -> Array:
    """Return rows of `kernel.stepping` of programs with one body, one program's after the other's.

    times: of each program [s], that do not decrease, (T,). Programs with a force that is in no row of numbers are
    simulated one by one.
    """
    if len(programs) > 1 and any(force is not None for force in programs[0].forces[IN_ROW:]):
        pairs = zip(programs, times, strict=True)
        return np.concatenate([simulated([program], [own], fineness) for program, own in pairs])
    ends, events = np.cumsum([len(each) for each in times]), [program.events() for program in programs]
    found = np.empty((int(ends[-1]), WIDTH))
    integrate(
        np.array([program.start for program in programs]),
        np.concatenate(times),
        ends,
        found,
        np.array([program.numbers for program in programs]),
        _with_every_force(programs[0].forces),
        _tethers(programs),
        np.concatenate(events),
        np.cumsum([len(each) for each in events]),
        np.array([program.scheme for program in programs], dtype=float),
        fineness,
    )
    return found


def _with_every_force(forces: Forces) -> Forces:
    """Return forces of which each that a row of numbers gives is there: so one compiled kernel serves every scene."""
    points = NO_POINTS if forces.points is None else forces.points
    return Forces(1.0, ZERO, NO_TETHERS, (0.0, 0.0), (0.0, 0.0, 0.0, 0.0, 0.0, 0.0), points, *forces[IN_ROW:])


def _tethers(programs: Sequence[ProgramModel]) -> Array:
    """Return the tethers of each program that obey the scene's law, then all, (2 N k, 9)."""
    found: list[Array] = []
    for program in programs:
        every = program.forces.tethers
        if every is None:
            return NO_TETHERS
        found += [every if program.tether_law == THE_SCENES_TETHERS else np.zeros_like(every), every]
    return np.concatenate(found)


@lru_cache
def _turn_and_product(w: float, x: float, y: float, z: float) -> tuple[Array, Array]:
    """Return the rotation matrix of a quaternion, and the matrix that multiplies quaternions in rows by it."""
    product = np.array(((w, x, y, z), (-x, w, -z, y), (-y, z, w, -x), (-z, -y, x, w)))
    return rotation_matrix(np.array((w, x, y, z))), product


def next_tick(time: float | Array, tick: float) -> float | Array:
    """Return the first tick that is not before a time [s]."""
    return tick * np.ceil(time / tick - WHOLE)


def correct_program(scene: Scene, throw: int, rounding: float = 0.0) -> ProgramModel:
    """Return the model of a program without mistakes; rounding: of its times [s].  Raises RayMissed."""
    gravity = np.zeros(3) if scene.gravity is None else np.array(scene.gravity)
    start, moments = np.array(scene.start[throw]), np.array(scene.body.moments)
    forces = forces_of(scene), stiffness(scene)
    program = ProgramModel(scene.body, scene.body.mass, moments, start, gravity, (), *forces, rounding=rounding)
    for impulse in scene.impulses:
        program = replace(program, impulses=(*program.impulses, _with_fixed_point(impulse, program)))
    return program


def fineness_until(program: ProgramModel, until: float) -> float:
    """Return the largest rotation in a continuous step [rad] for which errors do not show until a time [s]."""
    fineness, unseen_m = FINE, UNSEEN * float(np.linalg.norm(np.ptp(program.body.points, axis=0)))
    while fineness > FINE / FINER and error_m(program, fineness, until) > unseen_m:
        fineness /= 2
    return fineness


def error_m(program: ProgramModel, fineness: float, until: float) -> float:
    """Return how far continuous steps, and such of half their length, have moved a point apart until a time [m]."""
    pose, finer = (program.output(np.array([until]), each) for each in (fineness, fineness / 2))
    apart = (pose.x - finer.x)[:, None] + np.einsum("tij,kj->tki", pose.axes - finer.axes, output_points(program.body))
    return float(np.linalg.norm(apart, axis=2).max())


def scaled_force(law: Law, scene: Scene, by: float, *keys: str) -> Any:
    """Return the parameters of a force of the scene, with all strengths times a factor, or those of some keys."""
    return getattr(forces_of(law.scaled(scene, by, *keys)), law.part)


def _with_fixed_point(impulse: Impulse, before: ProgramModel) -> Impulse:
    """Return an impulse at the point where its ray hits the body, since programs are given that point."""
    if impulse.ray is None:
        return impulse
    row = before.simulate(np.array([impulse.time]), FINE)[0]
    state = np.concatenate((row[0:3], row[18:22], row[12:18]))
    return replace(impulse, ray=None, point_world=strike_point(impulse, state, before.body))


def with_output_transform(program: ProgramModel, writing: OutputTransform) -> ProgramModel:
    """Return a program with one more output transform."""
    return program.but(output_transforms=(*program.output_transforms, writing))


@lru_cache(maxsize=EVENTS_CACHED)
def _events(
    impulses: tuple[Impulse, ...],
    application: ImpulseApplication,
    delayed_gravity: tuple[float, float, float, float] | None = None,
    tick: float = 0.0,
) -> Array:
    """Return the events of `kernel.stepping`, (E, 16).

    delayed_gravity: time [s] and force [N]; tick: events happen at the first tick after their time [s], 0 for at once.
    """
    rows: list[tuple[float, ...]] = (
        [(delayed_gravity[0], BEGIN, *delayed_gravity[1:], *ZERO, *ZERO, False)] if delayed_gravity else []
    )
    for impulse in impulses:
        value = application.strength * impulse.value
        in_body_axes = impulse.point_body is not None
        place = (*(impulse.point_body if in_body_axes else impulse.point_world), in_body_axes)  # type: ignore[misc]
        if not application.lasts:
            rows.append((impulse.time, JUMP, *(application.moves * value), *value, *place))
            continue
        force = value / application.lasts
        torque = force if application.turns else np.zeros(3)
        if not application.turns:
            rows.append((impulse.time, JUMP, 0.0, 0.0, 0.0, *value, *place))
        rows.append((impulse.time, BEGIN, *(application.moves * force), *torque, *place))
        if application.ends:
            end = impulse.time + application.lasts
            rows.append((end, END, *(application.moves * force), *torque, *place))
    events = np.zeros((len(rows), EVENT))
    order = sorted(range(len(rows)), key=lambda number: rows[number][0])
    for place, number in enumerate(order):
        events[place, :12] = rows[number]
        if rows[number][1] == END:
            events[place, 15] = order.index(number - 1)  # the end of a force is listed after its start
    if tick:
        events[:, 0] = next_tick(events[:, 0], tick)
    return events
