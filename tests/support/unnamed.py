"""Mistakes that `tumble grade` has no name for, planted in the program of `programs.py`."""

from dataclasses import replace

import numpy as np
from programs import Program, Simulation, cross

# Steps too fine to be seen in six figures, and rows of them.
STEP_S, EVERY = 0.001, 25


class Spoilt(Simulation):
    """A right program but for what subclasses do; now: the time of the step [s]."""

    def __init__(self, throw):
        """Begin a flight."""
        super().__init__(throw, Program(dt=STEP_S, every=EVERY))
        self.count, self.right, self.parts = 0, self.inertia, []

    @property
    def now(self):
        """The time that the flight has reached [s]."""
        return self.count * STEP_S

    def rk4(self, dt):
        """Take a step."""
        super().rk4(dt)
        self.count += 1


class WrongSideEachTenth(Spoilt):
    """In every tenth step the attitude is turned on the wrong side."""

    def rk4(self, dt):
        """Take a step."""
        self.program = replace(self.program, wrong_side=self.count % 10 == 9)
        super().rk4(dt)


class InertiaBackEachOther(Spoilt):
    """In every other step Euler's equations have the inertia tensor turned the wrong way."""

    def angular(self, R, w, torque):
        """Return dw/dt."""
        return super().angular(R.T if self.count % 2 else R, w, torque)


class RampedGravity(Spoilt):
    """Gravity grows from nothing to all of it in 0.4 s."""

    def forces(self, x, R, v, w):
        """Return force and torque."""
        force, torque = super().forces(x, R, v, w)
        return force - max(0.0, 1 - self.now / 0.4) * self.mass * self.gravity, torque


class DriftingInertia(Spoilt):
    """The first moment of inertia grows by a fifth each second."""

    def rk4(self, dt):
        """Take a step."""
        self.inertia = self.right * (1 + 0.2 * self.now * np.array([[1.0, 0, 0], [0, 0, 0], [0, 0, 0]]))
        self.inverse = np.linalg.inv(self.inertia)
        super().rk4(dt)


class HalfVelocity(Spoilt):
    """The velocity is kept in half precision."""

    def rk4(self, dt):
        """Take a step."""
        super().rk4(dt)
        self.v = self.v.astype(np.float16).astype(float)


class SpreadImpulse(Spoilt):
    """An impulse is spread over three ticks of 1/50 s: a half, a fifth, three tenths."""

    def strike(self, impulse):
        """Apply the parts that are due, and put the others off."""
        self.parts += [(self.count + 20 * tick, impulse, share) for tick, share in enumerate((0.5, 0.2, 0.3))]

    def rk4(self, dt):
        """Take a step."""
        for due, impulse, share in self.parts:
            if due == self.count:
                self.program = replace(self.program, strength=share)
                super().strike(impulse)
        super().rk4(dt)


class SpeedTorque(Spoilt):
    """A torque acts that grows with the velocity, and along it."""

    def forces(self, x, R, v, w):
        """Return force and torque."""
        force, torque = super().forces(x, R, v, w)
        return force, torque + 0.005 * v


class Magnus(Spoilt):
    """A force acts across velocity and spin, as on a ball."""

    def forces(self, x, R, v, w):
        """Return force and torque."""
        force, torque = super().forces(x, R, v, w)
        return force + 0.02 * self.mass * cross(w, v), torque


class HalfGyroscopic(Spoilt):
    """Half of the gyroscopic term is there."""

    def angular(self, R, w, torque):
        """Return dw/dt."""
        in_body = R.T @ w
        return R @ self.inverse @ (R.T @ torque - 0.5 * cross(in_body, self.inertia @ in_body))


class FilteredPosition(Spoilt):
    """What is logged of the position has gone through a first-order filter of 0.05 s."""

    def rows(self):
        """Yield rows."""
        seen, before = None, 0.0
        for t, x, *others in super().rows():
            seen = x if seen is None else x + (seen - x) * np.exp(-(t - before) / 0.05)
            before = t
            yield t, seen, *others


MISTAKES = {
    "every tenth step turned on the wrong side": WrongSideEachTenth,
    "inertia turned the wrong way in every other step": InertiaBackEachOther,
    "gravity ramped up in 0.4 s": RampedGravity,
    "a moment of inertia that drifts by 0.2 /s": DriftingInertia,
    "velocity in half precision": HalfVelocity,
    "impulse spread unevenly over three ticks": SpreadImpulse,
    "torque along the velocity": SpeedTorque,
    "Magnus force": Magnus,
    "half of the gyroscopic term": HalfGyroscopic,
    "position through a first-order filter": FilteredPosition,
}
