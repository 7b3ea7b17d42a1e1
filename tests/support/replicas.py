"""Steps of engines as replicas: plain numpy, in single or double precision, sharing nothing with ours.

Each is held by hand against files of the engine itself; what it writes is what `tumble grade` must name.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from programs import cross, matrix, multiply

# The fixed point of the midpoint rule is better by |w| dt in each round.
ROUNDS = 60


def explicit(w, inertia, dt):
    """Return w in body axes after the gyroscopic term, explicit."""
    return w - dt * cross(w, inertia * w) / inertia


def midpoint(w, inertia, dt):
    """Return the same by the implicit midpoint rule."""
    new = w
    for _ in range(ROUNDS):
        mean = (w + new) / 2
        new = w - dt * cross(mean, inertia * mean) / inertia
    return new


def rescaled(w, inertia, dt):
    """Return the same with the angular momentum as long as it was."""
    momentum = inertia * w
    new = momentum - dt * cross(w, momentum)
    return new * np.sqrt((momentum @ momentum) / (new @ new)) / inertia


def none(w, inertia, dt):
    """Return w in body axes with nothing done; the replica keeps it in world axes."""
    return w


def along_screw(w, v, dt):
    """Return how far the centre moves in a step whose v turns with the body."""
    speed = np.sqrt(w @ w)
    axis = w / speed
    along = (axis @ v) * axis
    across, angle = v - along, speed * dt
    return dt * along + (np.sin(angle) * across + (1 - np.cos(angle)) * cross(axis, v)) / speed


@dataclass(frozen=True)
class Replica:
    """What an engine does in a step of dt [s]; substeps: of equal length; damps: what it makes of v and w; drags: the
    accelerations by which it damps them, from what they were before the step; mean: turned by the mean of the old w and
    the new; cap [rad/s]; screw: v is stored in body axes and x moves along the screw of v and w, as Pinocchio's
    integrate does."""

    dt: float
    spin: Callable = explicit
    turn: str = "exponential"
    mean: bool = False
    substeps: int = 1
    damps: Callable = lambda v, w, dt: (v, w)
    drags: Callable = lambda v, w: (0, 0)
    cap: float = np.inf
    number: type = np.float64
    screw: bool = False

    def rows(self, throw, every=1):
        """Yield the clock's time and x, R, q, v, w, a row every so many steps."""
        number = self.number
        x, q, v = (part.astype(number) for part in (throw.x, throw.q, throw.v))
        inertia, dt = np.diag(throw.inertia).astype(number), number(self.dt / self.substeps)
        w = self.capped(throw.w.astype(number))
        steps = round(throw.duration / self.dt)
        for n in range(steps + 1):
            if n % every == 0:
                yield n * self.dt, x, matrix(q), q, v, w
            for _ in range(self.substeps):
                R = matrix(q)
                a, alpha = self.drags(v, w)
                v = v + dt * (throw.gravity.astype(number) + a) - (dt * cross(w, v) if self.screw else 0)
                new = dt * alpha + (w if self.spin is none else R @ self.spin(R.T @ w, inertia, dt))
                v, new = self.damps(v, new, dt)
                new = self.capped(new)
                x = x + (along_screw(new, v, dt) if self.screw else dt * v)
                q = self.turned(q, (w + new) / 2 if self.mean else new, dt)
                v = matrix(q) @ (R.T @ v) if self.screw else v
                w = matrix(q) @ (R.T @ new) if self.mean else new  # about another axis w stays in body axes

    def capped(self, w):
        """Return w no faster than the cap."""
        speed = np.sqrt(w @ w)
        return (w * (self.number(self.cap) / speed)).astype(self.number) if speed > self.cap else w

    def turned(self, q, w, dt):
        """Return q turned by w dt, normalised."""
        number, speed = self.number, np.sqrt(w @ w)
        half = dt * w / 2
        if self.turn == "exponential" and speed:
            q = multiply(np.array([np.cos(speed * dt / 2), *(np.sin(speed * dt / 2) / speed * w)], number), q)
        else:
            q = q + multiply(np.array([0, *half], number), q)
        return (q / np.sqrt(q @ q)).astype(number)
