"""A rigid body program as students and engine teams write one, with a switch for every mistake that it may make.

It imports nothing of ours and is written in another way: it keeps the angular velocity in world axes and turns the
inertia tensor, R I R^T.  What it prints is what `tumble grade` must understand.  Plain numpy, and as slow as that is.
"""

import csv
import itertools
import math
import tomllib
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Throw:
    """A scene as this program reads it: SI, world axes but for inertia, vertices and impulse points."""

    duration: float
    mass: float
    inertia: np.ndarray
    vertices: np.ndarray
    x: np.ndarray
    q: np.ndarray
    v: np.ndarray
    w: np.ndarray
    gravity: np.ndarray
    impulses: list
    tethers: list
    drag: dict
    floor: dict


@dataclass(frozen=True)
class Program:
    """What a program does: as it stands every field is right, but for the size of the step.

    dt [s]; every: steps from row to row; method: of a step; axes: where it keeps w, or L; turn: how it turns q or R;
    stages: what becomes of the quaternion of a stage of rk4, which is longer than 1;
    fall: of x in a step; lasts: an impulse is a force for so many s; held: what stays while it acts; arm: its lever;
    damped: how v and w are damped, linear and angular [1/s]; clock: t = (physics - ahead) / rate, of
    physics that moves in ticks of so many steps; until: the last row [s]; drags, hangs: the law of the scene's drag and
    of its tethers; linear_drag to damper: factors on their coefficients; rests: spin [rad/s] below which it is 0;
    moments: factors on the moments of inertia; own_edges: these are of the wrong edges.
    """

    dt: float = 0.002
    every: int = 10
    method: str = "rk4"  # explicit, symplectic, leapfrog
    stages: str = "unit in R"  # normalised, raw, raw with R I^-1 R^T
    axes: str = "world"  # body, momentum
    turn: str = "quaternion"  # exponential, matrix
    fall: str = ""  # explicit, symplectic, parabola; "" as the method
    normalised: bool = True
    wrong_side: bool = False
    lasts: float = 0.0
    forever: bool = False
    held: str = "body point"  # world point, torque
    arm: str = "centre of mass"  # origin, none, reversed
    vertex: int | None = None
    strength: float = 1.0
    gravity: float = 1.0
    gravity_axes: tuple = (0, 1, 2)
    linear: float = 0.0
    angular: float = 0.0
    damped: str = "factor"  # exp, implicit, force, bullet
    damps: str = "last"  # before it moves
    gyroscopic: str = "right"  # still in world, still in body, reversed
    inertia: float = 1.0
    sphere: bool = False
    inertia_axes: tuple = (0, 1, 2)
    mass: float = 1.0
    spin: float = 1.0
    spin_in_body: bool = False
    ahead: float = 0.0
    rate: float = 1.0
    tick: int = 1
    without: str = ""  # tether, drag, floor
    drags: str = ""  # quadratic, quadratic spin, undivided
    hangs: str = ""  # no torque, no turn, still lever, centre's velocity, along the line, undivided, other vertex
    linear_drag: float = 1.0
    angular_drag: float = 1.0
    stiffness: float = 1.0
    damper: float = 1.0
    anchor: float = 1.0
    rests: float = 0.0
    moments: tuple = (1.0, 1.0, 1.0)
    own_edges: bool = False
    until: float = math.inf
    number: type = np.float64


def read(path):
    """Return the Throw of a scene file."""
    scene = tomllib.loads(path.read_text())
    body = scene["body"]
    mass = body["mass"]
    if body["shape"] == "box":
        a, b, c = body["size"]
        inertia = mass / 12 * np.diag([b * b + c * c, c * c + a * a, a * a + b * b])
        vertices = np.array(list(itertools.product((-a / 2, a / 2), (-b / 2, b / 2), (-c / 2, c / 2))))
    else:
        inertia, vertices = np.array(body["inertia"]), np.array(body["points"])
    q = np.array(body.get("orientation", [1.0, 0.0, 0.0, 0.0]))
    return Throw(
        scene["duration"],
        mass,
        inertia,
        vertices,
        np.array(body.get("position", [0.0] * 3)),
        q / np.linalg.norm(q),
        np.array(body.get("velocity", [0.0] * 3)),
        np.array(body.get("angular_velocity", [0.0] * 3)),
        np.array(scene.get("gravity", [0.0] * 3)),
        scene.get("impulse", []),
        scene.get("tether", []),
        scene.get("drag", {}),
        scene.get("floor", {}),
    )


def cross(a, b):
    """Return a x b; np.cross takes ten times as long."""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def multiply(p, q):
    """Return the product of two quaternions, w x y z."""
    return np.array(
        [
            p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
            p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
            p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1],
            p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0],
        ]
    )


def matrix(q):
    """Return the rotation matrix of a quaternion as textbooks print it: only of length 1 is it a rotation."""
    w, x, y, z = q
    return np.array(
        [
            [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
        ]
    )


def matrix_of_unit(q):
    """Return the rotation matrix of a quaternion by the formula that takes its length as 1."""
    w, x, y, z = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


class Simulation:
    """One flight."""

    def __init__(self, throw, program):
        self.throw, self.program = throw, program
        number = program.number
        self.mass = number(throw.mass * program.mass)
        inertia = throw.inertia[np.ix_(program.inertia_axes, program.inertia_axes)] * program.inertia
        if program.own_edges:
            inertia = throw.mass / 6 * np.diag(np.square(2 * throw.vertices.max(axis=0)))
        inertia = np.diag(program.moments) @ inertia
        if program.sphere:
            inertia = np.eye(3) * np.trace(inertia) / 3
        self.inertia, self.inverse = inertia.astype(number), np.linalg.inv(inertia).astype(number)
        self.gravity = (program.gravity * throw.gravity[list(program.gravity_axes)]).astype(number)
        self.x, self.v = throw.x.astype(number), throw.v.astype(number)
        self.q, self.R = throw.q.astype(number), matrix(throw.q.astype(number))
        w = program.spin * throw.w
        self.w = ((self.R @ w) if program.spin_in_body else w).astype(number)
        self.L = self.R @ self.inertia @ self.R.T @ self.w
        self.pushes = []  # force, the point where it acts in body axes and in world axes, until when
        self.torque = {}

    # --- forces -------------------------------------------------------------------------------------------------------

    def forces(self, x, R, v, w):
        """Return force and torque about the centre of mass, world axes."""
        program, throw = self.program, self.throw
        force, torque = self.mass * self.gravity, np.zeros(3, program.number)
        for tether in throw.tethers if program.without != "tether" else []:
            point = throw.vertices[tether["vertex"] - (program.hangs == "other vertex")]
            arm = point if program.hangs == "no turn" else R @ point
            away = x + arm - program.anchor * np.array(tether["anchor"])
            moves = v if program.hangs == "centre's velocity" else v + cross(w, arm)
            if program.hangs == "along the line":
                moves = (moves @ away) / (away @ away) * away
            pull = -program.stiffness * tether["stiffness"] * away
            pull = pull - program.damper * tether.get("damping", 0.0) * moves
            lever = {"no torque": 0 * arm, "still lever": point}.get(program.hangs, arm)
            force = force + pull * (self.mass if program.hangs == "undivided" else 1)
            torque = torque + cross(lever, pull)
        if throw.drag and program.without != "drag":
            linear, angular = program.linear_drag * throw.drag["linear"], program.angular_drag * throw.drag["angular"]
            force = force - linear * (np.sqrt(v @ v) if program.drags == "quadratic" else 1) * v
            spin = np.sqrt(w @ w) if program.drags == "quadratic spin" else 1
            turned = R @ self.inertia @ R.T @ w if program.drags == "undivided" else spin * w
            torque = torque - angular * turned
        if throw.floor and program.without != "floor":
            for vertex in throw.vertices:
                arm = R @ vertex
                depth = throw.floor.get("height", 0.0) - (x + arm)[1]
                if depth > 0:
                    rise = (v + cross(w, arm))[1]
                    push = max(0.0, throw.floor["stiffness"] * depth - throw.floor["damping"] * rise)
                    force = force + np.array([0.0, push, 0.0])
                    torque = torque + cross(arm, np.array([0.0, push, 0.0]))
        for push, in_body, in_world, constant, _ in self.pushes:
            force = force + push
            if program.held == "torque":
                torque = torque + constant
            elif program.held == "world point":
                torque = torque + cross(in_world - (x if program.arm == "centre of mass" else 0), push)
            else:
                torque = torque + cross(R @ in_body, push)
        if program.damped == "force":
            force = force - program.linear * self.mass * v
            torque = torque - program.angular * (R @ self.inertia @ R.T @ w)
        return force.astype(program.number), torque.astype(program.number)

    def strike(self, impulse):
        """Apply an impulse, at once or by beginning a force."""
        program = self.program
        if "value" in impulse:
            J = np.array(impulse["value"])
        else:
            J = impulse["magnitude"] * np.array(impulse["direction"]) / np.linalg.norm(impulse["direction"])
        J = (program.strength * J).astype(program.number)
        if program.vertex is not None or "vertex" in impulse:
            number = impulse.get("vertex") if program.vertex is None else program.vertex
            in_body = self.throw.vertices[number]
        elif "point_body" in impulse:
            in_body = np.array(impulse["point_body"])
        else:
            in_body = self.R.T @ (np.array(impulse["point"]) - self.x)
        point = self.x + self.R @ in_body
        arm = {
            "centre of mass": point - self.x,
            "origin": point,
            "none": 0 * point,
            "reversed": self.x - point,
        }[program.arm].astype(program.number)
        if program.lasts:
            force = J / program.number(program.lasts)
            until = math.inf if program.forever else impulse.get("time", 0.0) + program.lasts
            self.pushes.append((force, self.R.T @ arm, point, cross(arm, force), until))
            return
        self.v = self.v + J / self.mass
        self.L = self.L + cross(arm, J)
        self.w = self.w + self.R @ self.inverse @ self.R.T @ cross(arm, J)

    # --- motion -------------------------------------------------------------------------------------------------------

    def response(self, R, torque):
        """Return the change of w by a torque, or the w of an angular momentum, world axes."""
        if self.program.stages == "raw":
            return np.linalg.solve(R @ self.inertia @ R.T, torque)
        return R @ self.inverse @ R.T @ torque

    def angular(self, R, w, torque):
        """Return dw/dt, of w in world axes."""
        term = cross(w, R @ self.inertia @ R.T @ w)
        match self.program.gyroscopic:
            case "still in world":
                term = 0 * term
            case "still in body":  # Euler's equations in body axes without their cross product
                return R @ self.inverse @ R.T @ torque + self.turning(R, w)[1]
            case "reversed":  # in body axes, where I w' = +w x I w
                return R @ self.inverse @ R.T @ (torque + term) + self.turning(R, w)[1]
        return self.response(R, torque - term)

    def turning(self, R, w):
        """Return the rate at which R turns, world axes, and dw/dt of a w that stands still in the body."""
        rate = R @ w if self.program.wrong_side else w
        return rate, cross(rate, w)

    def slope(self, x, q, v, spin):
        """Return the derivatives of x, q, v and w, or L."""
        program = self.program
        if program.stages == "normalised":
            q = q / np.sqrt(q @ q)
        R = matrix_of_unit(q) if program.stages.startswith("raw") else matrix(q / np.sqrt(q @ q))
        w = self.response(R, spin) if program.axes == "momentum" else spin
        force, torque = self.forces(x, R, v, w)
        half = program.number(0.5) * np.array([program.number(0), *w])
        turned = multiply(q, half) if program.wrong_side else multiply(half, q)
        return v, turned, force / self.mass, torque if program.axes == "momentum" else self.angular(R, w, torque)

    def rk4(self, dt):
        """Take a step by the classical Runge-Kutta method."""
        is_momentum = self.program.axes == "momentum"
        state = self.x, self.q, self.v, self.L if is_momentum else self.w

        def along(by, slope):
            return [part + by * rate for part, rate in zip(state, slope, strict=True)]

        half = self.program.number(0.5)
        k1 = self.slope(*state)
        k2 = self.slope(*along(half * dt, k1))
        k3 = self.slope(*along(half * dt, k2))
        k4 = self.slope(*along(dt, k3))
        six = self.program.number(6)
        mean = [(a + 2 * b + 2 * c + d) / six for a, b, c, d in zip(k1, k2, k3, k4, strict=True)]
        self.x, self.q, self.v, spin = along(dt, mean)
        self.q = self.q / np.sqrt(self.q @ self.q)
        self.R = matrix(self.q)
        self.L, self.w = (spin, self.R @ self.inverse @ self.R.T @ spin) if is_momentum else (self.L, spin)

    def leapfrog(self, dt):
        """Take a step: half of the forces, the rotation by the w of half of it, half of the forces; L is kept."""
        self.kick(dt / 2)
        self.x = self.x + dt * self.v
        start = self.q, self.R
        self.rotate(dt / 2, self.response(self.R, self.L))
        w = self.response(self.R, self.L)
        self.q, self.R = start
        self.rotate(dt, w)
        self.kick(dt / 2)
        self.w = self.response(self.R, self.L)

    def kick(self, dt):
        """Change v and L by the forces of a time."""
        force, torque = self.forces(self.x, self.R, self.v, self.response(self.R, self.L))
        self.v, self.L = self.v + dt / self.mass * force, self.L + dt * torque

    def euler(self, dt):
        """Take a step by one of Euler's methods."""
        program = self.program
        R, w = self.R, self.w
        force, torque = self.forces(self.x, R, self.v, w)
        acceleration = force / self.mass
        new_v = self.v + dt * acceleration
        if program.damps == "before it moves":
            new_v = self.slowed(new_v, program.linear, dt)
        fall = program.fall or program.method
        if fall == "parabola":
            self.x = self.x + dt * self.v + dt * dt / 2 * acceleration
        else:
            self.x = self.x + dt * (new_v if fall == "symplectic" else self.v)
        self.v = new_v
        if program.axes == "momentum":
            self.L = self.L + dt * torque
            w = R @ self.inverse @ R.T @ self.L
            self.rotate(dt, w)
            self.w = self.R @ self.inverse @ self.R.T @ self.L
            return
        in_body = R.T @ w
        if program.axes == "body":
            new = in_body + dt * (R.T @ (self.angular(R, w, torque) - (self.turning(R, w)[1])))
            if program.damps == "before it moves":
                new = self.slowed(new, program.angular, dt)
            self.rotate(dt, R @ new if program.method == "symplectic" else w)
            self.w = self.R @ new
        else:
            new = w + dt * self.angular(R, w, torque)
            if program.damps == "before it moves":
                new = self.slowed(new, program.angular, dt)
            self.rotate(dt, new if program.method == "symplectic" else w)
            self.w = new

    def rotate(self, dt, w):
        """Turn the attitude by w dt."""
        program = self.program
        if program.turn == "matrix":
            self.R = self.R + dt * np.array([cross(w, column) for column in self.R.T]).T
            return
        if program.turn == "exponential":
            angle = dt * np.sqrt(w @ w)
            axis = w / np.sqrt(w @ w) if angle else w
            turn = np.array([np.cos(angle / 2), *(np.sin(angle / 2) * axis)])
            self.q = multiply(self.q, turn) if program.wrong_side else multiply(turn, self.q)
        else:
            half = dt / 2 * np.array([program.number(0), *w])
            self.q = self.q + (multiply(self.q, half) if program.wrong_side else multiply(half, self.q))
        if program.normalised:
            self.q = self.q / np.sqrt(self.q @ self.q)
        self.R = matrix(self.q / np.sqrt(self.q @ self.q))

    def slowed(self, velocity, rate, dt):
        """Return a velocity, v or w, after a step's damping."""
        by = rate * dt
        factors = {
            "factor": 1 - by,
            "exp": math.exp(-by),
            "implicit": 1 / (1 + by),
            "bullet": 1 - by * (1 + np.sqrt(velocity @ velocity)),
            "force": 1,
        }
        return velocity * factors[self.program.damped]

    def rows(self):
        """Yield the clock's time and x, R, q, v, w, as printed: every so many steps."""
        program = self.program
        dt = program.number(program.dt)
        waiting = sorted(self.throw.impulses, key=lambda impulse: impulse.get("time", 0.0))
        steps = round((min(program.until, self.throw.duration) * program.rate + program.ahead) / program.dt)
        shown = ()
        for n in range(steps + 1):
            now = n * program.dt
            while waiting and waiting[0].get("time", 0.0) < now + program.dt / 2:
                self.strike(waiting.pop(0))
            self.pushes = [push for push in self.pushes if push[-1] > now + program.dt / 2]
            if n % program.tick == 0:
                R = self.R if program.turn == "matrix" else matrix(self.q)
                shown = self.x, R, self.q, self.v, self.w
            clock = (now - program.ahead) / program.rate
            if n % program.every == 0 and clock > -1e-9:
                yield max(clock, 0.0), *shown
            {"rk4": self.rk4, "leapfrog": self.leapfrog}.get(program.method, self.euler)(dt)
            if program.damps == "last":
                self.v = self.slowed(self.v, program.linear, dt)
                self.w = self.slowed(self.w, program.angular, dt)
                self.L = self.slowed(self.L, program.angular, dt)
            if np.sqrt(self.w @ self.w) < program.rests:
                self.w, self.L = 0 * self.w, 0 * self.L


def fly(scene, program):
    """Return the rows of a flight of a scene file."""
    return list(Simulation(read(scene), program).rows())


def write(path, rows, vertices, kind="pose", form=repr, velocities=False, order="wxyz", conjugate=False, flip=None):
    """Write rows as CSV and return the path.

    kind: pose, matrix, or the numbers of vertices; order and conjugate: of the quaternion; flip: a signed permutation
    of the world's axes, (3, 3).
    """
    flip = np.eye(3) if flip is None else np.array(flip)
    names = ["t_s"]
    if kind == "pose":
        names += ["x_m", "y_m", "z_m", "qw", "qx", "qy", "qz"]
    elif kind == "matrix":
        names += ["x_m", "y_m", "z_m", *(f"r{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3))]
    else:
        names += [f"v{number}{axis}_m" for number in kind for axis in "xyz"]
    if velocities:
        names += ["vx_m_s", "vy_m_s", "vz_m_s", "wx_rad_s", "wy_rad_s", "wz_rad_s"]
    with path.open("w", newline="") as file:
        lines = csv.writer(file)
        lines.writerow(names)
        for t, x, R, q, v, w in rows:
            numbers = [float(t)]
            if kind == "pose":
                a, b, c, d = q * (1, -1, -1, -1) if conjugate else q
                numbers += [*x, *((b, c, d, a) if order == "xyzw" else (a, b, c, d))]
            elif kind == "matrix":
                numbers += [*(flip @ x), *(flip @ (R.T if conjugate else R) @ flip.T).ravel()]
            else:
                for number in kind:
                    numbers += [*(flip @ (x + R @ vertices[number]))]
            if velocities:
                numbers += [*v, *w]
            lines.writerow([form(float(number)) for number in numbers])
    return str(path)
