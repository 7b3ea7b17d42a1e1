"""Scenes and simulators: by steps, from event to event, and by a stiff spring, each with a switch for every mistake.

The plane is y = 0 turned by the incline about z.  Every vector here is in axes along the plane, x down the incline, y
the normal and z level, and is turned to the world's only when it is written.
"""

import math
from dataclasses import dataclass, field, replace

import numpy as np

G = 9.81


@dataclass(frozen=True)
class Scene:
    """A body on a plane: kind of motion, half edges or radius, start in the plane's axes, and the law."""

    kind: str
    e: float
    mu: float
    incline: float = 0.0
    radius: float = 0.0
    half: tuple = ()
    mass: float = 1.0
    x: tuple = (0.0, 0.0, 0.0)
    v: tuple = (0.0, 0.0, 0.0)
    w: tuple = (0.0, 0.0, 0.0)
    q: tuple = (1.0, 0.0, 0.0, 0.0)
    duration: float = 1.0

    @property
    def gravity(self) -> np.ndarray:
        """Gravity in the plane's axes."""
        return G * np.array((math.sin(self.incline), -math.cos(self.incline), 0.0))

    @property
    def turn(self) -> np.ndarray:
        """Plane's axes to world's."""
        c, s = math.cos(self.incline), math.sin(self.incline)
        return np.array(((c, s, 0.0), (-s, c, 0.0), (0.0, 0.0, 1.0)))

    @property
    def moments(self) -> np.ndarray:
        """Principal moments of inertia."""
        if self.radius:
            return np.full(3, 0.4 * self.mass * self.radius**2)
        a, b, c = (4 * h * h for h in self.half)
        return self.mass / 12 * np.array((b + c, c + a, a + b))


@dataclass(frozen=True)
class Program:
    """How a file is made: method, step, rows a step, digits, order of the step, and the mistake."""

    method: str
    step: float
    every: int
    digits: int
    clamp: bool = False
    bounce_first: bool = True
    mistake: str = ""
    values: dict = field(default_factory=dict)


@dataclass
class State:
    """Place, quaternion (w x y z), velocity and spin."""

    x: np.ndarray
    q: np.ndarray
    v: np.ndarray
    w: np.ndarray


def begin(scene: Scene) -> State:
    """Return the start of a scene."""
    return State(*(np.array(each, dtype=float) for each in (scene.x, scene.q, scene.v, scene.w)))


def product(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Return the Hamilton product."""
    (a, u), (b, v) = (p[0], p[1:]), (q[0], q[1:])
    return np.concatenate(((a * b - u @ v,), a * v + b * u + np.cross(u, v)))


def turned(q: np.ndarray, way: np.ndarray) -> np.ndarray:
    """Return an attitude after a rotation vector."""
    angle = float(np.linalg.norm(way))
    if angle == 0:
        return q
    return product(np.concatenate(((math.cos(angle / 2),), math.sin(angle / 2) / angle * way)), q)


def matrix(q: np.ndarray) -> np.ndarray:
    """Return the rotation matrix of a quaternion."""
    w, x, y, z = q
    return np.array(
        (
            (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
            (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
            (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
        )
    )


def corner(scene: Scene, state: State) -> np.ndarray:
    """Return the lever of the lowest point."""
    if scene.radius:
        return np.array((0.0, -scene.radius, 0.0))
    axes = matrix(state.q)
    signs = np.where(axes[1] > 0, -1.0, 1.0)
    return axes @ (signs * np.array(scene.half))


def limits(program: Program, along: np.ndarray, most: float) -> np.ndarray:
    """Return friction, (3,) with y = 0, bounded as the program does."""
    kind = program.values.get("cone", "round")
    if kind == "box":
        return np.clip(along, -most, most)
    size = float(np.linalg.norm(along))
    if kind == "diamond" and np.abs(along).sum() > most:
        big, small = max(abs(along[0]), abs(along[2])), min(abs(along[0]), abs(along[2]))
        cut = big - most if big - small >= most else (big + small - most) / 2
        return np.sign(along) * np.maximum(np.abs(along) - cut, 0.0)
    return along if kind == "diamond" or size <= most else along * (most / size)


def materials(scene: Scene, program: Program) -> tuple[float, float]:
    """Return e and mu as the program uses them."""
    e, mu = scene.e, scene.mu
    if program.mistake == "e squared":
        e = e * e
    if program.mistake == "product rule":
        e, mu = e * e, mu * mu
    return e, mu


def bounce(scene: Scene, program: Program, state: State, depth: float, routh: bool) -> None:
    """Change the velocities by one impact of the lowest point; routh: friction at each instant of the impact."""
    e, mu = materials(scene, program)
    lever, axes = corner(scene, state), matrix(state.q)
    normal = np.array((0.0, 1.0, 0.0))
    if program.mistake == "wrong normal":
        normal = np.array(program.values["normal"])
        if scene.radius:
            lever = -scene.radius * normal
    inverse = axes @ np.diag(1 / scene.moments) @ axes.T
    skew = np.array(((0, -lever[2], lever[1]), (lever[2], 0, -lever[0]), (-lever[1], lever[0], 0)))
    gain = np.eye(3) / scene.mass - skew @ inverse @ skew
    u = state.v + np.cross(state.w, lever)
    if u @ normal >= 0:
        return
    if program.mistake == "bounce threshold" and -u @ normal < program.values["speed"]:
        e = 0.0
    aim = -e * (u @ normal)
    if program.mistake == "push-out":
        aim += program.values["share"] * depth / program.step
    if routh and not scene.radius and mu:
        push = routh_impulse(gain, u, e, mu)
        state.v = state.v + push / scene.mass
        state.w = state.w + inverse @ np.cross(lever, push)
        return
    press = float((aim - u @ normal) / (normal @ gain @ normal))
    state.v = state.v + press / scene.mass * normal
    state.w = state.w + inverse @ np.cross(lever, press * normal)
    if not mu:
        return
    centre = program.mistake == "friction at centre"
    u = state.v if centre else state.v + np.cross(state.w, lever)
    slip = u - (u @ normal) * normal
    speed = float(np.linalg.norm(slip))
    if speed == 0:
        return
    if program.values.get("cone"):
        gains = np.full(3, 1 / scene.mass) if centre else np.diag(gain)
        drag = limits(program, -slip / gains, mu * press)
    else:
        along = slip / speed
        stop = speed / (1 / scene.mass if centre else along @ gain @ along)
        drag = -along * min(stop, mu * press)
    state.v = state.v + drag / scene.mass
    if not centre:
        state.w = state.w + inverse @ np.cross(lever, drag)


def routh_impulse(gain: np.ndarray, u: np.ndarray, e: float, mu: float, parts: int = 4000) -> np.ndarray:
    """Return the impulse of a corner with friction at each instant, in small parts of the normal impulse."""
    goal, total, u = -e * u[1], np.zeros(3), u.copy()
    part = -u[1] * (1 + e) / gain[1, 1] / parts
    flat = gain[np.ix_((0, 2), (0, 2))]
    for _ in range(20 * parts):
        hold = -np.linalg.solve(flat, u[[0, 2]] + gain[[0, 2], 1] * part)
        size = math.hypot(*hold)
        if size > mu * part:
            # It slips: friction is against the slip, or where there is none yet, against the one that begins.
            slip = u[[0, 2]]
            speed = math.hypot(*slip)
            along = -slip / speed if speed > 5 * part * abs(gain).max() else hold / size
            hold = along * mu * part
        push = np.array((hold[0], part, hold[1]))
        u, total = u + gain @ push, total + push
        if u[1] >= goal:
            return total
    return total


def grip(scene: Scene, program: Program, state: State, press: float, dt: float) -> None:
    """Apply friction of a lasting contact for a time; press: normal acceleration of the plane."""
    _, mu = materials(scene, program)
    lever = np.array((0.0, -scene.radius, 0.0))
    centre = program.mistake == "friction at centre"
    slip = state.v.copy() if centre or not scene.radius else state.v + np.cross(state.w, lever)
    slip[1] = 0.0
    ease = 1.0 if centre or not scene.radius else 3.5
    if program.mistake == "creep":
        size = float(np.linalg.norm(slip))
        stiff = mu * press / program.values["speed"]
        viscous = -slip * stiff / (1 + ease * stiff * dt)
        drag = viscous if np.linalg.norm(viscous) < mu * press else -slip / size * mu * press
    else:
        drag = limits(program, -slip / (ease * dt), mu * press)
    state.v = state.v + drag * dt
    if scene.radius and not centre:
        state.w = state.w + np.cross(lever, drag) * dt * scene.mass / scene.moments[0]


def free_spin(scene: Scene, state: State, dt: float, parts: int = 1) -> None:
    """Turn a free body, its angular momentum constant, by midpoint steps."""
    if scene.radius:
        state.q = turned(state.q, state.w * dt)
        return
    momentum = matrix(state.q) @ (scene.moments * (matrix(state.q).T @ state.w))

    def rate(q: np.ndarray) -> np.ndarray:
        axes = matrix(q)
        return axes @ ((axes.T @ momentum) / scene.moments)

    for _ in range(parts):
        middle = turned(state.q, rate(state.q) * dt / parts / 2)
        state.q = turned(state.q, rate(middle) * dt / parts)
    state.w = rate(state.q)


def low(scene: Scene, state: State) -> float:
    """Return the height of the lowest point."""
    return float(state.x[1] + corner(scene, state)[1])


def by_steps(scene: Scene, program: Program) -> np.ndarray:
    """Return the rows of a semi-implicit program: x, q at the times of rows."""
    state, dt, gravity = begin(scene), program.step, scene.gravity
    rows, asleep = [np.concatenate((state.x, state.q))], False
    lies = scene.kind in ("slide", "hold", "roll")
    margin = program.values.get("margin", 0.0)
    count = round(scene.duration / dt)
    for number in range(1, count + 1):
        if not asleep and lies:
            press = -gravity[1]
            pull = np.array((gravity[0], 0.0, 0.0))
            if program.mistake == "wrong normal":
                normal = np.array(program.values["normal"])
                press = float(-gravity @ normal)
                pull = gravity + press * normal
                pull[1] = 0.0
            state.v = state.v + pull * dt
            grip(scene, program, state, press, dt)
            state.x = state.x + state.v * dt
            state.q = turned(state.q, state.w * dt)
        elif not asleep:
            touches = low(scene, state) < margin
            if program.mistake == "tunnelling":
                touches = touches and low(scene, state) > -program.values["thickness"]
            if program.mistake == "gravity first":
                state.v = state.v + gravity * dt
                if touches:
                    bounce(scene, program, state, 0.0, False)
            else:
                if touches and program.bounce_first:
                    depth = max(0.0, -low(scene, state))
                    bounce(scene, program, state, depth, False)
                state.v = state.v + gravity * dt
            state.x = state.x + state.v * dt
            free_spin(scene, state, dt)
            below = low(scene, state)
            met = not program.bounce_first and below < margin and program.mistake != "gravity first"
            if met and (program.mistake != "tunnelling" or below > -program.values["thickness"]):
                bounce(scene, program, state, max(0.0, -below), False)
                if program.clamp:
                    state.x[1] -= min(0.0, below)
            settle(scene, program, state, dt)
        if program.mistake == "sleep" and number * dt > 0.05:
            speed = float(np.linalg.norm(state.v)) + scene.radius * float(np.linalg.norm(state.w))
            asleep = asleep or speed < program.values["speed"]
        if number % program.every == 0:
            rows.append(np.concatenate((state.x, state.q)))
    return np.array(rows)


def settle(scene: Scene, program: Program, state: State, dt: float) -> None:
    """Lay a sphere that hardly rebounds on the plane, with friction of its weight."""
    if program.mistake == "wrong normal" or not scene.radius or low(scene, state) > 0 or abs(state.v[1]) > 2 * G * dt:
        return
    state.x[1], state.v[1] = scene.radius, 0.0
    grip(scene, program, state, -scene.gravity[1], dt)


def by_events(scene: Scene, program: Program) -> np.ndarray:
    """Return the rows of a program that goes from impact to impact; motions along the plane by fine steps."""
    fine = 16
    if scene.kind in ("slide", "hold", "roll"):
        return by_steps(scene, replace(program, step=program.step / fine, every=program.every * fine))
    state, gravity, now = begin(scene), scene.gravity, 0.0
    apart = program.step * program.every
    rows, wanted = [np.concatenate((state.x, state.q))], apart
    while wanted <= scene.duration + 1e-9:
        hit = next_hit(scene, state, wanted - now)
        if hit is None:
            fly(scene, state, gravity, wanted - now)
            now = wanted
            rows.append(np.concatenate((state.x, state.q)))
            wanted = len(rows) * apart
            continue
        fly(scene, state, gravity, hit)
        now += hit
        bounce(scene, program, state, 0.0, True)
        lever = corner(scene, state)
        if (state.v + np.cross(state.w, lever))[1] < 1e-3:
            # It stays: the last bounces are too short to matter.
            state.v[1] = 0.0
            while wanted <= scene.duration + 1e-9 and scene.radius:
                took = (wanted - now) / 200
                for _ in range(200):
                    state.v[0] += gravity[0] * took
                    grip(scene, program, state, -gravity[1], took)
                    state.x += state.v * took
                    state.q = turned(state.q, state.w * took)
                now = wanted
                rows.append(np.concatenate((state.x, state.q)))
                wanted = len(rows) * apart
            break
    return np.array(rows)


def fly(scene: Scene, state: State, gravity: np.ndarray, took: float) -> None:
    """Let a body fly for a time."""
    state.x = state.x + took * state.v + took**2 / 2 * gravity
    state.v = state.v + took * gravity
    free_spin(scene, state, took, 1 if scene.radius else max(1, int(took * np.linalg.norm(state.w) * 200)))


def next_hit(scene: Scene, state: State, most: float) -> float | None:
    """Return when the lowest point meets the plane, None if not within a time."""

    def height(took: float) -> float:
        there = State(*(each.copy() for each in (state.x, state.q, state.v, state.w)))
        fly(scene, there, scene.gravity, took)
        return low(scene, there)

    if scene.radius:
        up, pull, gap = state.v[1], -scene.gravity[1], max(0.0, low(scene, state))
        took = (up + math.sqrt(up * up + 2 * pull * gap)) / pull
        return took if took <= most else None
    before = 0.0
    for took in np.linspace(0, most, 9)[1:]:
        if height(took) < 0 and (before > 0 or (state.v + np.cross(state.w, corner(scene, state)))[1] < 0):
            a, b = before, float(took)
            for _ in range(50):
                middle = (a + b) / 2
                a, b = (middle, b) if height(middle) >= 0 else (a, middle)
            return a
        before = float(took)
    return None


def by_spring(scene: Scene, program: Program) -> np.ndarray:
    """Return the rows of a sphere on a stiff spring with a damper that gives e in a central impact."""
    e, mu = materials(scene, program)
    state, apart = begin(scene), program.step * program.every
    speed = max(1.0, abs(scene.v[1]) + math.sqrt(2 * G * max(0.0, scene.x[1])))
    # A contact lasts pi / w; steps follow it a hundred times.
    w = 2000.0 * speed / 4
    ratio = 1.0 if e <= 0 else -math.log(e) / math.hypot(math.pi, math.log(e))
    inner = max(1, math.ceil(program.step * w * 15))
    dt = program.step / inner
    rows = [np.concatenate((state.x, state.q))]
    lever = np.array((0.0, -scene.radius, 0.0))
    centre = program.mistake == "friction at centre"
    for _ in range(round(scene.duration / apart)):
        for _ in range(inner * program.every):
            depth = scene.radius - state.x[1]
            acceleration = scene.gravity.copy()
            if depth > 0:
                press = w * w * depth - 2 * ratio * w * state.v[1]
                if program.mistake == "bounce threshold" and program.values["speed"] > abs(state.v[1]):
                    press = max(0.0, w * w * depth - 2 * w * state.v[1])
                acceleration[1] += press
                slip = state.v.copy() if centre else state.v + np.cross(state.w, lever)
                slip[1] = 0.0
                wanted = -slip / ((1.0 if centre else 3.5) * dt)
                drag = limits(program, wanted, mu * max(0.0, press))
                acceleration += drag
                if not centre:
                    state.w = state.w + np.cross(lever, drag) * dt * scene.mass / scene.moments[0]
            state.v = state.v + acceleration * dt
            state.x = state.x + state.v * dt
            state.q = turned(state.q, state.w * dt)
        rows.append(np.concatenate((state.x, state.q)))
    return np.array(rows)


METHODS = {"steps": by_steps, "events": by_events, "spring": by_spring}


def rows_of(scene: Scene, program: Program) -> np.ndarray:
    """Return the rows of a program: x and q in the plane's axes."""
    return METHODS[program.method](scene, program)


def toml(scene: Scene) -> str:
    """Return the scene as a file for Tumble."""
    turn = scene.turn
    frame = np.array((math.cos(scene.incline / 2), 0.0, 0.0, -math.sin(scene.incline / 2)))

    def line(name: str, values) -> str:
        return f"{name} = [{', '.join(repr(float(value)) for value in values)}]\n"

    shape = (
        f'shape = "sphere"\nradius = {scene.radius!r}\n'
        if scene.radius
        else 'shape = "box"\n' + line("size", 2 * np.array(scene.half))
    )
    return (
        f'title = "A program of contact: {scene.kind}"\nduration = {scene.duration!r}\nsamples = 20\nstep = 0.001\n'
        + line("gravity", turn @ scene.gravity)
        + f"[body]\n{shape}mass = {scene.mass!r}\n"
        + line("position", turn @ np.array(scene.x))
        + line("orientation", product(frame, np.array(scene.q)))
        + line("velocity", turn @ np.array(scene.v))
        + line("angular_velocity", turn @ np.array(scene.w))
        + f"[plane]\nrestitution = {scene.e!r}\nfriction = {scene.mu!r}\n"
        + line("normal", turn @ (0.0, 1.0, 0.0))
    )


def written(scene: Scene, program: Program, rows: np.ndarray) -> str:
    """Return the file of a program, in world axes, rounded to its significant digits."""
    frame = np.array((math.cos(scene.incline / 2), 0.0, 0.0, -math.sin(scene.incline / 2)))
    lines = ["t_s,x_m,y_m,z_m,qw,qx,qy,qz"]
    for number, row in enumerate(rows):
        t = number * program.step * program.every
        numbers = (*(scene.turn @ row[:3]), *product(frame, row[3:]))
        lines.append(f"{t:.9g}," + ",".join(f"{value:.{program.digits}g}" for value in numbers))
    return "\n".join(lines) + "\n"
