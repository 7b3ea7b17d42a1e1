"""A run without a step of its own: what an answer describes that names no method."""

import math
from dataclasses import replace

import numpy as np

from tools.random_programs.algebra import norm
from tools.random_programs.scene import Scene
from tools.random_programs.scheme import Reading, Scheme
from tools.random_programs.simulation import Rows, Simulation

# Turn in a step [rad], and the shortest and the longest step [s].
TURN, SHORTEST, LONGEST = 0.01, 0.0001, 0.004
TINY = 1e-9


class Exact(Simulation):
    """Short steps of order 4, which end at rows, at impulses, and at instants at which a force begins or ends.

    instants: these [s]; stop: when the body stops [s].
    """

    def __init__(self, scene: Scene, spacing: float, keeps: str, reading: Reading, tick: float) -> None:
        super().__init__(scene, Scheme(tick, spacing, "order 4", keeps=keeps, reading=reading))
        self.instants: list[float] = []
        self.stop = np.inf

    def _ticks(self) -> Rows:
        """Return states at ticks if rows lie between them, at the times of rows if not."""
        if self.scheme.reading.between:
            until = self.scene.duration * self.rate + max(0.0, self.ahead)
            return self._at(self.scheme.dt * np.arange(math.ceil(until / self.scheme.dt) + 3))
        return self._at((self._wanted() * self.rate + self.ahead).clip(0.0, self.stop))

    def _read(self, ticks: Rows) -> Rows:
        return super()._read(ticks) if self.scheme.reading.between else replace(ticks, t=self._wanted())

    def _wanted(self) -> np.ndarray:
        spacing = self.scheme.spacing
        return np.arange(math.floor(self.scene.duration / spacing + 1e-6) + 1) * spacing

    def _at(self, instants: np.ndarray) -> Rows:
        waiting = sorted(self.impulses, key=lambda impulse: impulse.time)
        breaks = sorted({*self.instants, *(impulse.time for impulse in waiting)})
        longest = self._longest()
        table = np.empty((len(instants), 13))
        for row, instant in enumerate(instants):
            for end in (*(one for one in breaks if self.now <= one < instant - TINY), float(instant)):
                self._march(end, longest)
                while waiting and waiting[0].time <= self.now + TINY:
                    self.strike(waiting.pop(0))
            table[row] = (*self.x, *self.q, *self.v, *self.w)
        return Rows(instants, table[:, :3], table[:, 3:7], table[:, 7:10], table[:, 10:13], self.points)

    def _march(self, end: float, longest: float) -> None:
        left = end - self.now
        count = math.ceil(left / longest - TINY) if left > TINY else 0
        for _ in range(count):
            self.v, self.w = self._limited(self.v, self.w)
            self.advance(left / count)
            self.now += left / count
            self.count += 1
        self.now = end

    def _longest(self) -> float:
        """Return the longest step that the body's spin and its springs allow [s]."""
        scene, inverse = self.scene, float(np.linalg.norm(np.array(self.inverse), 2))
        pushes = sum(norm(self.value(impulse)) for impulse in self.impulses)
        fastest = norm(self.w) + 2 * scene.reach * inverse * pushes
        for tether in scene.tethers:
            fastest += math.sqrt(tether.stiffness * (1 / scene.mass + scene.reach**2 * inverse))
        return min(LONGEST, max(SHORTEST, TURN / (fastest + TINY)))
