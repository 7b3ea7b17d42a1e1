"""Mistakes with a name, planted in the program of `programs.py`, and the names that are right for each.

They follow the words of what `tumble grade` says it knows (impulses, starts, inertia, caps, clocks, steps, what is
written down, the scene as suspect), not its models: each is a method of a plain numpy program that is spoilt.
"""

import itertools
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from programs import Program, Simulation, cross, matrix, multiply

NEVER, WRONG_WAY, FROZEN = "never turned", "turned the wrong way", "frozen at the start"
INERTIA = {
    NEVER: "inertia-never-rotated",
    WRONG_WAY: "inertia-rotated-inversely",
    FROZEN: "inertia-frozen-at-start",
}
SWAPPED, FLIPPED = np.array([[1.0, 0, 0], [0, 0, 1], [0, 1, 0]]), np.diag([1.0, 1.0, -1.0])


class Spoilt(Simulation):
    """A program whose parts can be replaced one by one; it counts its steps and the impulses that it applies."""

    def __init__(self, throw, **fields):
        super().__init__(throw, Program(**fields))
        self.count, self.struck, self.R0 = 0, 0, self.R.copy()
        self.begin()

    def begin(self):
        """Change what the flight begins with."""

    def after(self):
        """Change what a step has left."""

    def rk4(self, dt):
        """Take a step."""
        super().rk4(dt)
        self.count += 1
        self.after()

    def euler(self, dt):
        """Take a step."""
        super().euler(dt)
        self.count += 1
        self.after()

    def strike(self, impulse):
        """Apply an impulse at a vertex."""
        self.struck += 1
        self.hit(self.program.strength * np.array(impulse["value"]), self.throw.vertices[impulse["vertex"]])

    def hit(self, J, p):
        """Apply an impulse [N s], world axes, at a point [m], body axes."""
        self.push(J, cross(self.R @ p, J))

    def push(self, J, T, axes=None):
        """Change v and w by an impulse and its torque, by the inertia as it is turned."""
        axes = self.R if axes is None else axes
        self.v = self.v + J / self.mass
        self.w = self.w + axes @ self.inverse @ axes.T @ T


def tensor_axes(sim, R, how):
    """Return in which axes a program has the inertia tensor."""
    return {NEVER: np.eye(3), WRONG_WAY: R.T, FROZEN: sim.R0}[how]


def inertia(how):
    """Return the methods of a program with an inertia tensor in other axes."""

    def angular(self, R, w, torque):
        axes = tensor_axes(self, R, how)
        return axes @ self.inverse @ axes.T @ (torque - cross(w, axes @ self.inertia @ axes.T @ w))

    return {"angular": angular} | struck_inertia(how)


def struck_inertia(how):
    """Return the methods of one with such a tensor where an impulse acts."""
    return {"hit": lambda self, J, p: self.push(J, cross(self.R @ p, J), tensor_axes(self, self.R, how))}


def implicit(how):
    """Return the methods of a program with such a tensor and Catto's implicit gyroscopic step."""

    def skew(a):
        return np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])

    def euler(self, dt):
        axes, tensor = tensor_axes(self, self.R, how), self.inertia
        force, _ = self.forces(self.x, self.R, self.v, self.w)
        self.v = self.v + dt * force / self.mass
        self.x = self.x + dt * self.v
        w = axes.T @ self.w
        slope = tensor + dt * (skew(w) @ tensor - skew(tensor @ w))
        self.w = axes @ (w - np.linalg.solve(slope, dt * cross(w, tensor @ w)))
        self.rotate(dt, self.w)

    return {"euler": euler} | struck_inertia(how)


def one(number, hit):
    """Return a hit that is wrong for one impulse only."""
    return {"hit": lambda self, J, p: hit(self, J, p) if self.struck == number else Spoilt.hit(self, J, p)}


def begin(**changes):
    """Return a start with other parts, each made of the simulation."""

    def changed(self):
        for name, change in changes.items():
            setattr(self, name, change(self))
        self.q = self.q / np.sqrt(self.q @ self.q)
        self.R = matrix(self.q)

    return {"begin": changed}


def capped(name, cap):
    """Return a cap of a velocity."""

    def after(self):
        rate = getattr(self, name)
        setattr(self, name, rate * min(1.0, cap / np.sqrt(rate @ rate)))

    return {"after": after}


def pulled(force=None, torque=None):
    """Return more force, of the program and v [per kg], and more torque, of R and w [N m]."""

    def forces(self, x, R, v, w):
        f, t = Simulation.forces(self, x, R, v, w)
        more = 0 if force is None else self.mass * force(self, v)
        return f + more, t if torque is None else t + torque(R, w)

    return {"forces": forces}


def resized(*edges):
    """Return a box of other edges [m] and the same mass."""

    def changed(self):
        a, b, c = edges
        tensor = self.throw.mass / 12 * np.diag([b * b + c * c, c * c + a * a, a * a + b * b])
        corners = np.array(list(itertools.product((-a / 2, a / 2), (-b / 2, b / 2), (-c / 2, c / 2))))
        self.inertia, self.inverse, self.throw = tensor, np.linalg.inv(tensor), replace(self.throw, vertices=corners)

    return {"begin": changed}


def stepped(method):
    """Return a step of order 2 or 3, w in world axes."""

    def euler(self, dt):
        state = self.x, self.q, self.v, self.w

        def along(dt, slope):
            return [part + dt * rate for part, rate in zip(state, slope, strict=True)]

        k1 = self.slope(*state)
        if method == "midpoint":
            new = along(dt, self.slope(*along(dt / 2, k1)))
        elif method == "heun":
            new = along(dt / 2, [a + b for a, b in zip(k1, self.slope(*along(dt, k1)), strict=True)])
        else:
            k2 = self.slope(*along(dt / 2, k1))
            k3 = self.slope(*along(dt, [2 * b - a for a, b in zip(k1, k2, strict=True)]))
            new = along(dt / 6, [a + 4 * b + c for a, b, c in zip(k1, k2, k3, strict=True)])
        self.x, self.q, self.v, self.w = new
        self.q = self.q / np.sqrt(self.q @ self.q)
        self.R = matrix(self.q)

    return {"euler": euler}


def rarely(steps):
    """Return an attitude that is normalised every so many steps only."""

    def rotate(self, dt, w):
        self.q = self.q + multiply(dt / 2 * np.array([0, *w]), self.q)
        if (self.count + 1) % steps == 0:
            self.q = self.q / np.sqrt(self.q @ self.q)
        self.R = matrix(self.q / np.sqrt(self.q @ self.q))

    return {"rotate": rotate}


def turned(axes, q):
    """Return the quaternion of an attitude in other axes."""
    w, x, y, z = q
    return np.array([w, *(np.linalg.det(axes) * axes @ (x, y, z))])


@dataclass(frozen=True)
class Case:
    """A planted mistake: names that are right; what the program is; what it writes of x and q; the scene."""

    names: set[str]
    methods: dict[str, Callable] = field(default_factory=dict)
    program: dict[str, object] = field(default_factory=dict)
    x: Callable = lambda x, q: x
    q: Callable = lambda q: q
    scene: str = "struck"

    def rows(self, throw):
        """Return the rows of a flight."""
        fields = {"dt": 0.001, "every": 25} | self.program
        flight = type("Planted", (Spoilt,), self.methods)(throw, **fields).rows()
        return [(t, self.x(x, q), R, self.q(q), v, w) for t, x, R, q, v, w in flight]


STEP = {"dt": 0.025 / 3, "every": 3, "method": "symplectic", "turn": "exponential"}
OWN = {"dt": 0.005, "every": 5}
CASES = {
    "impulses 0.37 times as large": Case({"impulse-wrong-magnitude"}, program={"strength": 0.37}),
    "impulses times 1/60": Case({"impulse-wrong-magnitude"}, program={"strength": 1 / 60}),
    "mass of 1000 times": Case({"wrong-mass"}, begin(mass=lambda s: 1000 * s.mass)),
    "mass of 0.45 times": Case({"wrong-mass"}, begin(mass=lambda s: 0.45 * s.mass)),
    "impulse 2 missing": Case({"one-impulse-missing"}, one(2, lambda s, J, p: None)),
    "impulse 1 reversed": Case({"one-impulse-reversed"}, one(1, lambda s, J, p: Spoilt.hit(s, -J, p))),
    "impulse 2 0.3 times": Case({"one-impulse-wrong-magnitude"}, one(2, lambda s, J, p: Spoilt.hit(s, 0.3 * J, p))),
    "impulse 2 at the centre": Case({"one-impulse-at-centre-of-mass"}, one(2, lambda s, J, p: s.push(J, 0 * J))),
    "impulse 2 at vertex 7": Case(
        {"one-impulse-at-wrong-vertex"}, one(2, lambda s, J, p: Spoilt.hit(s, J, s.throw.vertices[7]))
    ),
    "impulse 2 in body axes": Case({"one-impulse-in-body-axes"}, one(2, lambda s, J, p: Spoilt.hit(s, s.R @ J, p))),
    "lever of impulse 2 not turned": Case(
        {"one-impulse-lever-not-rotated"}, one(2, lambda s, J, p: s.push(J, cross(p, J)))
    ),
    "impulses in body axes": Case({"impulse-in-body-axes"}, {"hit": lambda s, J, p: Spoilt.hit(s, s.R @ J, p)}),
    "levers as at the start": Case(
        {"impulse-lever-from-start-attitude"}, {"hit": lambda s, J, p: s.push(J, cross(s.R0 @ p, J))}
    ),
    "torque of impulses in body axes": Case(
        {"impulse-torque-in-body-axes"}, {"hit": lambda s, J, p: s.push(J, s.R @ cross(s.R @ p, J))}
    ),
    "impulses only turn": Case(
        {"impulse-linear-part-missing"}, {"hit": lambda s, J, p: s.push(0 * J, cross(s.R @ p, J))}
    ),
    "start velocity in body axes": Case({"start-velocity-in-body-axes"}, begin(v=lambda s: s.R @ s.v)),
    "start velocity, y and z swapped": Case({"start-velocity-in-wrong-axes"}, begin(v=lambda s: s.v[[0, 2, 1]])),
    "start spin missing": Case({"start-spin-missing"}, begin(w=lambda s: 0 * s.w)),
    "start spin, y and z swapped": Case({"start-spin-in-wrong-axes"}, begin(w=lambda s: s.w[[0, 2, 1]])),
    "start attitude missing": Case(
        {"start-attitude-missing", "wrong-start-attitude"}, begin(q=lambda s: np.array([1.0, 0, 0, 0]))
    ),
    "start attitude inverted": Case({"start-attitude-inverted"}, begin(q=lambda s: s.q * (1, -1, -1, -1))),
    "another start": Case({"wrong-start-position"}, begin(x=lambda s: s.x + np.array([0.1, 0, -0.2]))),
    **{f"inertia {how}": Case({INERTIA[how]}, inertia(how)) for how in (NEVER, WRONG_WAY, FROZEN)},
    **{
        f"inertia {how}, implicit step": Case({INERTIA[how], "symplectic-euler"}, implicit(how), STEP)
        for how in (NEVER, WRONG_WAY, FROZEN)
    },
    "inertia frozen in the impulse": Case({"impulse-inertia-frozen-at-start"}, struck_inertia(FROZEN)),
    "inverse for inertia": Case(
        {"inertia-inverted"}, {"begin": lambda s: s.__dict__.update(inertia=s.inverse, inverse=s.inertia)}
    ),
    "inertia of a tenth": Case({"wrong-inertia"}, program={"inertia": 0.1, "dt": 0.0005, "every": 50}),
    "spin cap 7": Case({"spin-cap", "runge-kutta-4"}, capped("w", 7.0)),
    "spin cap 5.3": Case({"spin-cap", "runge-kutta-4"}, capped("w", 5.3)),
    "speed cap 6": Case({"speed-cap", "runge-kutta-4"}, capped("v", 6.0)),
    "half of q' missing": Case(
        {"quaternion-rate-doubled"},
        {"slope": lambda s, *state: (lambda v, q, a, b: (v, 2 * q, a, b))(*Simulation.slope(s, *state))},
    ),
    "normalised every 10th step": Case(
        {"quaternion-rarely-normalised", "explicit-euler"}, rarely(10), OWN | {"method": "explicit"}
    ),
    "only positions mirrored": Case({"position-only-in-wrong-axes"}, x=lambda x, q: FLIPPED @ x),
    "only positions swapped": Case({"position-only-in-wrong-axes"}, x=lambda x, q: SWAPPED @ x),
    "only the quaternion mirrored": Case({"attitude-only-in-wrong-axes"}, q=lambda q: turned(FLIPPED, q)),
    "quaternion's z reversed": Case({"quaternion-vector-mirrored"}, q=lambda q: q * (1, 1, 1, -1)),
    "another point logged": Case({"constant-offset-in-body-axes"}, x=lambda x, q: x + matrix(q) @ (0.1, 0, 0.02)),
    "the base logged": Case({"wrong-point-logged"}, x=lambda x, q: x + matrix(q) @ (0, -0.15, 0)),
    "positions in feet": Case({"wrong-length-unit"}, x=lambda x, q: x / 0.3048),
    "gravity a row late": Case(
        {"gravity-delayed"}, pulled(lambda s, v: s.gravity * (-1 if s.count * s.program.dt < 0.025 - 1e-9 else 0))
    ),
    "gravity of 9.8": Case({"gravity-wrong-magnitude"}, program={"gravity": 9.8 / 9.81}),
    "wind along x": Case({"constant-acceleration"}, pulled(lambda s, v: np.array([0.7, 0, 0]))),
    "another start velocity": Case({"wrong-start-velocity"}, begin(v=lambda s: s.v + np.array([0.3, 0, -0.1]))),
    "quadratic drag": Case({"quadratic-drag"}, pulled(lambda s, v: -0.03 * np.sqrt(v @ v) * v)),
    "torque damping": Case({"drag-torque"}, pulled(torque=lambda R, w: -0.004 * w)),
    "damping along x": Case({"linear-damping-along-x"}, pulled(lambda s, v: -0.3 * v * (1, 0, 0))),
    "damping of the body's z": Case(
        {"angular-damping-about-body-z"},
        {"angular": lambda s, R, w, torque: Simulation.angular(s, R, w, torque) - R @ ((R.T @ w) * (0, 0, 0.4))},
    ),
    "a clock 2.5 times as fast": Case({"clock-rate"}, program={"rate": 2.5}),
    **{
        f"{title}, 1/120 s": Case({name}, stepped(method), STEP)
        for title, name, method in (
            ("midpoint rule", "midpoint", "midpoint"),
            ("Heun's method", "heun", "heun"),
            ("Runge-Kutta of order 3", "runge-kutta-3", "rk3"),
        )
    },
    "edge along x of 0.6 m": Case({"wrong-body-size-along-x"}, resized(0.6, 0.3, 0.2)),
    "edges in another order": Case({"edges-permuted"}, resized(0.3, 0.5, 0.2)),
    "impulses at vertex 3": Case(
        {"impulse-at-wrong-vertex"}, {"hit": lambda s, J, p: Spoilt.hit(s, J, s.throw.vertices[3])}
    ),
}
