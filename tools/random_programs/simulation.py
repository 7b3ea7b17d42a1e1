"""One program: it simulates a scene by a scheme, in double or single precision; mistakes change what it does.

It is right but for its steps.  A mistake replaces an attribute of the Simulation, wraps one of its functions, or adds
to `before`, `after`, `limits`, `laws` or `rewrites`.  The angular velocity is kept in world axes.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from tools.random_programs.algebra import (
    ZERO,
    Matrix,
    Quaternion,
    Vector,
    add,
    along,
    conjugate,
    cross,
    dot,
    length,
    matrices,
    matrix,
    matrix_of_unit,
    minus,
    norm,
    normalised,
    product,
    scale,
    times,
    times_transposed,
    transposed,
)
from tools.random_programs.gyroscopic import SCHEMES
from tools.random_programs.scene import Impulse, Scene
from tools.random_programs.scheme import NORMALISED, RAW, RAW_INVERSE, SPLIT, TABLEAUS, VERLET, Scheme
from tools.random_programs.turning import TURNINGS

# Of a on_progress: how late an impulse may be and still be of that tick.
NEARLY = 1e-6
Load = tuple[Vector, Vector]
State = tuple[Vector, Quaternion, Vector, Vector]


class BlownUp(Exception):
    """The program left all numbers that anybody would write down."""


@dataclass
class Rows:
    """What is written: t [s] (n,), x [m], q (n, 4) of any length, v [m/s], w [rad/s], world axes; points [m], body.

    scatter: what a measurement adds to each vertex [m], (n, k, 3).
    """

    t: np.ndarray
    x: np.ndarray
    q: np.ndarray
    v: np.ndarray
    w: np.ndarray
    points: np.ndarray
    own_axes: np.ndarray | None = None
    scatter: np.ndarray | None = None

    @property
    def axes(self) -> np.ndarray:
        """The matrices body to world, (n, 3, 3): of the quaternions, or as a mistake has made them."""
        return matrices(self.q) if self.own_axes is None else self.own_axes

    @property
    def vertices(self) -> np.ndarray:
        """Vertices in world axes [m], (n, k, 3)."""
        right = self.x[:, None] + np.einsum("nij,kj->nki", self.axes, self.points)
        return right if self.scatter is None else right + self.scatter

    def part(self, chosen: np.ndarray) -> "Rows":
        """Return some of the rows."""
        own = None if self.own_axes is None else self.own_axes[chosen]
        return Rows(self.t[chosen], self.x[chosen], self.q[chosen], self.v[chosen], self.w[chosen], self.points, own)


class Simulation:
    """One run.  number: float or np.float32, the precision in which the state is kept and stepped."""

    def __init__(self, scene: Scene, scheme: Scheme, number: type = float) -> None:
        self.scene, self.scheme, self.number = scene, scheme, number
        self.mass = number(scene.mass)
        self.set_inertia(scene.inertia)
        self.gravity = self.vector(scene.gravity)
        self.impulses = list(scene.impulses)
        self.x, self.v, self.w = self.vector(scene.x), self.vector(scene.v), self.vector(scene.w)
        self.q: Quaternion = tuple(number(part) for part in scene.q)  # type: ignore[assignment]
        self.first: Matrix = matrix(self.q)
        self.points = scene.points
        self.dt, self.count, self.now = scheme.step, 0, 0.0
        self.gyroscopic = 1.0
        self.spin_scheme = SCHEMES[scheme.gyroscopic]
        self.turn_by = TURNINGS[scheme.turning]
        # The axes in which the tensor of the gyroscopic term, and the inverse that torques are multiplied by, are.
        self.tensor_axes: Callable[[Quaternion], Matrix] = matrix
        self.inverse_axes: Callable[[Quaternion], Matrix] = matrix
        if scheme.stages in (RAW, RAW_INVERSE):
            self.tensor_axes = self.inverse_axes = matrix_of_unit
        if scheme.stages == RAW:
            self.inverse_axes = self._of_inverse
        self.laws: list[Callable[[Vector, Quaternion, Vector, Vector], Load]] = [self.weight]
        self.laws += [self._tether(tether) for tether in scene.tethers]
        self.laws += [self.drag] if any(scene.drag) else []
        self.before: list[Callable[[], None]] = []
        self.after: list[Callable[[float], None]] = []
        self.limits: list[Callable[[Vector, Vector], tuple[Vector, Vector]]] = []
        self.rewrites: list[Callable[[Rows], Rows]] = []
        self.turn_rate: Callable[[Quaternion, Vector], Vector] = lambda q, w: w
        self.step_of: Callable[[int], float] = lambda n: self.dt
        # How many times as much as the file's time the physics runs, and more [s].
        self.rate, self.ahead = 1.0, 0.0

    # --- what mistakes use ----------------------------------------------------------------------------------------

    def vector(self, values: object) -> Vector:
        """Return three numbers in the program's precision."""
        x, y, z = (self.number(value) for value in values)  # type: ignore[attr-defined]
        return (x, y, z)

    def tensor(self, values: np.ndarray) -> Matrix:
        """Return a 3x3 matrix in the program's precision."""
        return (self.vector(values[0]), self.vector(values[1]), self.vector(values[2]))

    def set_inertia(self, tensor: np.ndarray) -> None:
        """Set the tensor [kg m2] and its inverse."""
        self.inertia, self.inverse = self.tensor(tensor), self.tensor(np.linalg.inv(tensor))

    def _of_inverse(self, q: Quaternion) -> Matrix:
        """Return the axes A of the inverse (R I R^T)^-1 = A I^-1 A^T, for an R that is no rotation: R^-T."""
        return transposed(self.tensor(np.linalg.inv(np.array(matrix_of_unit(q)))))

    def momentum(self, q: Quaternion, w: Vector) -> Vector:
        """Return I w in world axes, with the tensor of the gyroscopic term."""
        axes = self.tensor_axes(q)
        return times(axes, times(self.inertia, times_transposed(axes, w)))

    def from_torque(self, q: Quaternion, torque: Vector) -> Vector:
        """Return what a torque does to the angular velocity, I^-1 torque, world axes."""
        axes = self.inverse_axes(q)
        return times(axes, times(self.inverse, times_transposed(axes, torque)))

    # --- forces ---------------------------------------------------------------------------------------------------

    def weight(self, x: Vector, q: Quaternion, v: Vector, w: Vector) -> Load:
        """Return the weight; none in the ticks in which gravity is idle."""
        idle = self.count < self.scheme.idle * self.scheme.substeps
        return (self.vector(ZERO) if idle else scale(self.mass, self.gravity)), self.vector(ZERO)

    def drag(self, x: Vector, q: Quaternion, v: Vector, w: Vector) -> Load:
        """Return the scene's drag."""
        linear, angular = map(self.number, self.scene.drag)
        return scale(-linear, v), scale(-angular, w)

    def _tether(self, tether: object) -> Callable[[Vector, Quaternion, Vector, Vector], Load]:
        number = self.number
        k, c, rest = number(tether.stiffness), number(tether.damping), tether.rest_length  # type: ignore[attr-defined]
        place = self.vector(self.scene.points[tether.vertex])  # type: ignore[attr-defined]
        anchor = self.vector(tether.anchor)  # type: ignore[attr-defined]

        def pull(x: Vector, q: Quaternion, v: Vector, w: Vector) -> Load:
            arm = times(matrix(q), place)
            away, moves = minus(add(x, arm), anchor), add(v, cross(w, arm))
            if rest == 0:
                force = along(scale(-k, away), -c, moves)
            else:
                size = norm(away)
                unit = scale(1 / size, away)
                force = scale(-(k * (size - number(rest)) + c * dot(moves, unit)), unit)
            return force, cross(arm, force)

        pull.tether = tether  # type: ignore[attr-defined]
        return pull

    def load(self, x: Vector, q: Quaternion, v: Vector, w: Vector) -> Load:
        """Return force and torque about the centre of mass."""
        force = torque = self.vector(ZERO)
        for law in self.laws:
            f, t = law(x, q, v, w)
            force, torque = add(force, f), add(torque, t)
        return force, torque

    # --- impulses -------------------------------------------------------------------------------------------------

    def lever(self, impulse: Impulse) -> Vector:
        """Return where an impulse acts, from the centre of mass, world axes."""
        at = self.scene.body_point(impulse)
        if at is None:
            return minus(self.vector(impulse.point), self.x)
        return times(matrix(self.q), self.vector(at))

    def value(self, impulse: Impulse) -> Vector:
        """Return an impulse [N s], world axes."""
        return self.vector(impulse.value)

    def strike(self, impulse: Impulse) -> None:
        """Apply an impulse."""
        self.push(self.value(impulse), self.lever(impulse))

    def push(self, J: Vector, arm: Vector) -> None:
        """Change the velocities by an impulse with a lever arm."""
        self.v = along(self.v, 1 / self.mass, J)
        self.w = add(self.w, self.from_torque(self.q, cross(arm, J)))

    # --- steps ----------------------------------------------------------------------------------------------------

    def spin(self, q: Quaternion, w: Vector, dt: float) -> Vector:
        """Return w after a step's gyroscopic term, the attitude standing still."""
        if self.gyroscopic != 1.0 or self.tensor_axes is not self.inverse_axes:
            return along(w, dt, self.euler(q, w, self.vector(ZERO)))
        axes = self.tensor_axes(q)
        inside = self.spin_scheme(times_transposed(axes, w), dt, self.inertia, self.inverse)
        return times(axes, inside)

    def euler(self, q: Quaternion, w: Vector, torque: Vector) -> Vector:
        """Return dw/dt in world axes, I^-1 (torque - w x I w)."""
        return self.from_torque(q, along(torque, -self.gyroscopic, cross(w, self.momentum(q, w))))

    def turned(self, q: Quaternion, w: Vector, dt: float) -> Quaternion:
        """Return the attitude after a step."""
        q = self.turn_by(q, scale(dt, self.turn_rate(q, w)))
        normalises = self.scheme.normalises
        return normalised(q) if normalises and (self.count + 1) % normalises == 0 else q

    def advance(self, dt: float) -> None:
        """Take a step."""
        if self.scheme.method == SPLIT:
            self._split(dt)
        elif self.scheme.method == VERLET:
            self._verlet(dt)
        else:
            self._runge_kutta(dt)

    def _limited(self, v: Vector, w: Vector) -> tuple[Vector, Vector]:
        for limit in self.limits:
            v, w = limit(v, w)
        return v, w

    def _damped(self, v: Vector, w: Vector, dt: float, where: str) -> tuple[Vector, Vector]:
        damping = self.scheme.damping
        if damping.where != where:
            return v, w
        factors = (self.number(damping.factor(rate, dt)) for rate in (damping.linear, damping.angular))
        return scale(next(factors), v), scale(next(factors), w)

    def _split(self, dt: float) -> None:
        scheme, q = self.scheme, self.q
        unit = normalised(q) if scheme.normalises != 1 else q
        v, w = self._damped(self.v, self.w, dt, "before")
        force, torque = self.load(self.x, unit, self.v, self.w)
        old_v, old_w = v, w
        acceleration = scale(1 / self.mass, force)
        if scheme.velocity != "world":
            acceleration = minus(acceleration, cross(w, v))
        v = along(v, dt, acceleration)
        if scheme.keeps == "momentum" and scheme.gyroscopic != "none":
            w = along(w, dt, self.from_torque(unit, torque))
        else:
            w = along(self.spin(unit, w, dt), dt, self.from_torque(unit, torque))
        v, w = self._damped(v, w, dt, "between")
        v, w = self._limited(v, w)
        moving = v
        if scheme.moves in ("old", "old, all"):
            moving = old_v
        elif scheme.moves == "parabola":
            moving = scale(0.5, add(old_v, v))
        elif scheme.centre > 1:
            moving = along(old_v, (scheme.centre + 1) / (2 * scheme.centre), minus(v, old_v))
        if scheme.velocity == "screw":
            moving = _screw(w, moving, dt)
        self.x = along(self.x, dt, moving)
        turning = old_w if scheme.moves in ("old, all", "old turn") else w
        if scheme.gyroscopic == "midpoint" and scheme.keeps != "momentum":
            turning = scale(0.5, add(old_w, w))
        self.q = self.turned(q, turning, dt)
        w = self._carried(unit, w)
        if scheme.velocity != "world":
            v = _carried_with(q, self.q, v)
        if scheme.recovers:
            w = _recovered(q, self.q, dt)
        self.v, self.w = self._damped(v, w, dt, "after")

    def _carried(self, old: Quaternion, w: Vector) -> Vector:
        """Return the angular velocity at the new attitude, when what the program keeps stands still while it turns."""
        keeps = self.scheme.keeps
        if keeps == "world" or (keeps == "momentum" and self.scheme.gyroscopic == "none"):
            return w
        if keeps == "body":
            return _carried_with(old, self.q, w)
        return self.from_torque(normalised(self.q), self.momentum(old, w))

    def _verlet(self, dt: float) -> None:
        """Velocity Verlet: half a kick, a drift, half a kick; with L stored, it rotates by the w of mid-step."""
        is_momentum = self.scheme.keeps == "momentum"
        for kick in (True, False):
            force, torque = self.load(self.x, self.q, self.v, self.w)
            half = 0.5 * dt
            self.v = along(self.v, half / self.mass, force)
            change = self.from_torque(self.q, torque) if is_momentum else self.euler(self.q, self.w, torque)
            self.w = along(self.w, half, change)
            if kick:
                self.x = along(self.x, dt, self.v)
                old, turning = self.q, self._w_midway(dt) if is_momentum else self.w
                self.q = self.turned(old, turning, dt)
                if is_momentum:
                    self.w = self.from_torque(normalised(self.q), self.momentum(old, self.w))
        self.v, self.w = self._limited(self.v, self.w)

    def _w_midway(self, dt: float) -> Vector:
        """Return the angular velocity after half of a step's rotation, with constant L."""
        midway = normalised(self.turn_by(self.q, scale(0.5 * dt, self.turn_rate(self.q, self.w))))
        return self.from_torque(midway, self.momentum(self.q, self.w))

    def _slope(self, state: State) -> State:
        x, q, v, spin = state
        unit = normalised(q)
        if self.scheme.stages == NORMALISED:
            q = unit
        at = q if self.tensor_axes is matrix_of_unit else unit
        axes = self.inverse_axes(at)
        keeps = self.scheme.keeps
        w = times(axes, spin) if keeps == "body" else spin
        if keeps == "momentum":
            w = self.from_torque(at, spin)
        force, torque = self.load(x, unit, v, w)
        rate = (self.number(0.0), *scale(0.5, self.turn_rate(unit, w)))
        changed = torque
        if keeps != "momentum":
            changed = self.euler(at, w, torque)
            changed = times_transposed(axes, changed) if keeps == "body" else changed
        return v, product(rate, q), scale(1 / self.mass, force), changed  # type: ignore[arg-type]

    def _runge_kutta(self, dt: float) -> None:
        stages, weights = TABLEAUS[self.scheme.method]
        keeps = self.scheme.keeps
        unit = normalised(self.q)
        axes = self.inverse_axes(unit)
        spin = self.w
        if keeps == "body":
            spin = times_transposed(axes, self.w)
        elif keeps == "momentum":
            spin = times(axes, times(self.inertia, times_transposed(axes, self.w)))
        state: State = (self.x, self.q, self.v, spin)
        slopes: list[State] = []
        for stage in stages:
            slopes.append(self._slope(_moved(state, dt, stage, slopes)))
        self.x, q, v, spin = _moved(state, dt, weights, slopes)
        normalises = self.scheme.normalises
        self.q = normalised(q) if normalises and (self.count + 1) % normalises == 0 else q
        unit = normalised(self.q)
        if keeps == "body":
            spin = times(self.inverse_axes(unit), spin)
        elif keeps == "momentum":
            spin = self.from_torque(unit, spin)
        self.v, self.w = self._limited(v, spin)

    # --- the run --------------------------------------------------------------------------------------------------

    def rows(self) -> Rows:
        """Return what the program writes.  Raises BlownUp."""
        try:
            with np.errstate(all="ignore"):
                ticks = self._ticks()
                rows = self._read(ticks)
                for rewrite in self.rewrites:
                    rows = rewrite(rows)
        except (ValueError, OverflowError, ZeroDivisionError):
            raise BlownUp from None
        sizes = np.abs(np.concatenate([rows.x.ravel(), rows.q.ravel(), rows.w.ravel()]))
        if not len(rows.t) or not np.isfinite(sizes).all() or sizes.max() > 1e5:
            raise BlownUp
        return rows

    def _ticks(self) -> Rows:
        scheme = self.scheme
        late = max(0, scheme.reading.late)
        until = self.scene.duration * self.rate + max(0.0, self.ahead)
        last = math.ceil(until / scheme.dt - 1e-6) + (2 if scheme.reading.between or scheme.reading.late < 0 else late)
        waiting = sorted(self.impulses, key=lambda impulse: impulse.time)
        table = np.empty((last + 1, 13))
        for on_progress in range(last + 1):
            self.now = on_progress * scheme.dt
            while waiting and waiting[0].time < self.now + NEARLY * scheme.dt:
                self.strike(waiting.pop(0))
            table[on_progress] = (*self.x, *self.q, *self.v, *self.w)
            if on_progress < scheme.asleep:
                continue
            for _ in range(scheme.substeps):
                for hook in self.before:
                    hook()
                dt = self.number(self.step_of(self.count))
                self.advance(dt)
                for late_hook in self.after:
                    late_hook(dt)
                self.count += 1
                self.now += self.dt
        t = scheme.dt * np.arange(last + 1)
        return Rows(t, table[:, :3], table[:, 3:7], table[:, 7:10], table[:, 10:13], self.points)

    def _read(self, ticks: Rows) -> Rows:
        """Return rows at instants of the file's clock."""
        reading, dt = self.scheme.reading, self.scheme.dt
        wanted = np.arange(math.floor(self.scene.duration / self.scheme.spacing + 1e-6) + 1) * self.scheme.spacing
        reached = wanted * self.rate + self.ahead
        place = (reached / dt - reading.late).clip(min=0.0)
        if not reading.between:
            rows = ticks.part(np.rint(place).astype(int))
        else:
            rows = between(ticks, np.floor(place + 1e-6).astype(int), place, dt, reading.between)
        return replace(rows, t=wanted)


def between(ticks: Rows, at: np.ndarray, place: np.ndarray, dt: float, how: str) -> Rows:
    """Return rows between ticks; at: whole ticks, place: ticks and parts of them."""
    before, after = ticks.part(at), ticks.part(np.minimum(at + 1, len(ticks.t) - 1))
    if how == "held":
        return before
    share = (place - at).clip(0.0, 1.0)[:, None]
    sign = np.where((before.q * after.q).sum(axis=1) < 0, -1.0, 1.0)[:, None]
    if how == "ahead":
        x, q = before.x + share * dt * before.v, _rotated(before.q, share * dt * before.w)
    elif how == "smooth":
        x = _hermite(before.x, after.x, dt * before.v, dt * after.v, share)
        slopes = (0.5 * dt * _multiplied(rows.w, rows.q) for rows in (before, after))
        first, second = slopes
        q = _hermite(before.q, sign * after.q, first, sign * second, share)
        q = q / np.linalg.norm(q, axis=1)[:, None]
    else:
        x = (1 - share) * before.x + share * after.x
        one, other = 1 - share, share
        if how == "arcs":
            one, other = _arcs((before.q * sign * after.q).sum(axis=1)[:, None], share)
        q = one * before.q + other * sign * after.q
        q = q / np.linalg.norm(q, axis=1)[:, None]
    v, w = ((1 - share) * a + share * b for a, b in ((before.v, after.v), (before.w, after.w)))
    return Rows(before.t, x, q, v, w, ticks.points)


def _arcs(cosine: np.ndarray, share: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the weights of slerp."""
    angle = np.arccos(cosine.clip(-1, 1))
    small = angle < 1e-7
    sine = np.where(small, 1.0, np.sin(angle))
    return (
        np.where(small, 1 - share, np.sin((1 - share) * angle) / sine),
        np.where(small, share, np.sin(share * angle) / sine),
    )


def _hermite(a: np.ndarray, b: np.ndarray, slope_a: np.ndarray, slope_b: np.ndarray, s: np.ndarray) -> np.ndarray:
    """Return the cubic through two values with two slopes per unit of s."""
    two, three = s * s, s * s * s
    return (
        (2 * three - 3 * two + 1) * a
        + (three - 2 * two + s) * slope_a
        + (3 * two - 2 * three) * b
        + (three - two) * slope_b
    )


def _multiplied(w: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Return w q of vectors as quaternions, (n, 3), (n, 4)."""
    p = (0 * w[:, 0], *w.T)
    return np.stack(product(p, tuple(q.T)), axis=1)  # type: ignore[arg-type]


def _rotated(q: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """Return attitudes turned by vectors [rad], world axes."""
    angle = np.linalg.norm(turn, axis=1)
    part = 0.5 * np.sinc(angle / (2 * np.pi))
    p = (np.cos(angle / 2), *(part[:, None] * turn).T)
    return np.stack(product(p, tuple(q.T)), axis=1)  # type: ignore[arg-type]


def _carried_with(old: Quaternion, new: Quaternion, a: Vector) -> Vector:
    """Return a vector that stands still in the body while it turns."""
    return times(matrix(normalised(new)), times_transposed(matrix(normalised(old)), a))


def _screw(w: Vector, v: Vector, dt: float) -> Vector:
    """Return the mean over a step of a velocity that turns with the body (the left Jacobian of SO(3))."""
    turn = scale(dt, w)
    angle = norm(turn)
    number = type(angle)
    if angle < 1e-4:
        first, second = number(0.5), number(1 / 6)
    else:
        first = number((1 - math.cos(angle)) / (angle * angle))
        second = number((angle - math.sin(angle)) / (angle * angle * angle))
    once = cross(turn, v)
    return add(v, add(scale(first, once), scale(second, cross(turn, once))))


def _recovered(old: Quaternion, new: Quaternion, dt: float) -> Vector:
    """Return the angular velocity as position-based dynamics takes it from two attitudes, 2 Im(q' q*) / dt."""
    turn = product(new, conjugate(old))
    sign = 2 / dt if turn[0] >= 0 else -2 / dt
    return scale(sign / (length(new) * length(old)), (turn[1], turn[2], turn[3]))


def _moved(state: State, dt: float, shares: tuple[float, ...], slopes: list[State]) -> State:
    """Return a state moved along slopes."""
    x, q, v, w = state
    for share, (dx, dq, dv, dw) in zip(shares, slopes, strict=True):
        if share:
            by = dt * share
            x, v, w = along(x, by, dx), along(v, by, dv), along(w, by, dw)
            q = (q[0] + by * dq[0], q[1] + by * dq[1], q[2] + by * dq[2], q[3] + by * dq[3])
    return x, q, v, w
