"""The right motion at any instants, quickly: compiled, and held against the truth at a dozen of them.

A truth costs milliseconds an instant, a compiled flight a microsecond.  So rows are measured from the flight, and how
far that is from the truth where both are known is added to what can be told from nothing.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from tumble.compare.grade.model.kernel.coasting import coast
from tumble.compare.grade.model.program_model import FINE, truthful
from tumble.scenarios.frames import Array, rotation_matrix, vertices
from tumble.scenarios.impulse import jump
from tumble.scenarios.scene import Scene, frozen_array
from tumble.scenarios.truth import NoTruth, truth
from tumble.solver.body import Body
from tumble.solver.compilation import without_blas

CERTIFIED = 12


class Reference:
    """The right motion of every throw of a scene."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._free = scene.is_free
        a, b, c = scene.body.moments.tolist()
        self._body = Body(scene.body.mass, (a, b, c))
        self._legs: tuple[int, list[tuple[float, Array]]] = (-1, [])

    def states(self, throw: int, times: Array) -> Array:
        """Return the states at instants [s], increasing, after the impulses of each, (T, 13)."""
        with without_blas():
            return self._flown(throw, times)

    def _flown(self, throw: int, times: Array) -> Array:
        if not self._free:
            rows = truthful(self._scene, throw).flown(times, FINE)
            return np.hstack((rows[:, 0:3], rows[:, 18:22], rows[:, 12:18]))
        legs = self._legs_of(throw)
        found = np.empty((len(times), 13))
        ends = [begin for begin, _ in legs[1:]] + [np.inf]
        done = 0
        for (begin, state), end in zip(legs, ends, strict=True):
            upto = int(np.searchsorted(times, end))
            found[done:upto] = self._coasted(state, times[done:upto] - begin)
            done = upto
        return found

    def vertices(self, throw: int, times: Array) -> Array:
        """Return where the vertices are [m], (T, n, 3)."""
        return vertices(self.states(throw, times), self._scene.body.points)

    def limit(self, throw: int, times: Array, tell: Callable[[float], object] = lambda share: None) -> float:
        """Return what cannot be told from nothing [m]: the truth's own limit, and what the flight is off from it.

        times: instants [s], increasing, of which a dozen are asked of the truth; tell: is called with the share of it
        that is done.  Raises NoTruth.
        """
        some = np.unique(np.linspace(0, len(times) - 1, CERTIFIED).round().astype(int))
        asked = frozen_array(times[some])
        duration = max(self._scene.duration, float(asked[-1]))
        start = frozen_array(self._scene.start[throw : throw + 1])
        true = truth(replace(self._scene, times=asked, duration=duration, start=start), tell=tell)
        if not np.isfinite(true.vertices).all():
            raise NoTruth(f"the true flight is known until {true.horizon:.6g} s: {true.why}")
        apart = self.vertices(throw, asked) - true.vertices[-len(asked) :, 0]
        return float(true.limit.max()) + float(np.linalg.norm(apart, axis=-1).max())

    def _legs_of(self, throw: int) -> list[tuple[float, Array]]:
        """Return from when [s] and from which state, (13,), each stretch without impulses goes."""
        if self._legs[0] != throw:
            legs = [(0.0, np.array(self._scene.start[throw]))]
            for impulse in self._scene.impulses:
                begin, state = legs[-1]
                before = self._coasted(state, np.array([impulse.time - begin]))
                after = impulse.time, jump(impulse, before, self._scene.body)[0]
                legs = [*legs[:-1], after] if impulse.time == begin else [*legs, after]
            self._legs = throw, legs
        return self._legs[1]

    def _coasted(self, state: Array, t: Array) -> Array:
        """Return the states after free flight for times [s], (T,), from one, (13,)."""
        axes = rotation_matrix(state[3:7])
        spins = np.empty((len(t), 14))
        spins[:, 7:14] = *state[3:7], *(self._scene.body.moments * (axes.T @ state[10:13]))
        coast(spins, t, self._body.inverse_moments, self._body.gyroscopic)
        q, momentum_body = spins[:, 0:4], spins[:, 4:7]
        w = np.einsum("tij,tj->ti", rotation_matrix(q), momentum_body / self._scene.body.moments)
        gravity = np.zeros(3) if self._scene.gravity is None else self._scene.gravity
        x = state[0:3] + t[:, None] * state[7:10] + (t * t / 2)[:, None] * gravity
        return np.hstack((x, q, state[7:10] + t[:, None] * gravity, w))
