"""The reference motion at any times, quickly: compiled, and compared with the truth at a dozen of them.

A truth costs milliseconds a time, the compiled kernel a microsecond.  So rows are compared with the kernel's motion,
and its distance from the truth is added to the resolution.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from tumble.compare.grade.model.kernel.coasting import coast
from tumble.compare.grade.model.program_model import FINE, correct_program, fineness_until
from tumble.scenarios.frames import Array, rotation_matrix, vertices
from tumble.scenarios.impulse import jump
from tumble.scenarios.scene import Scene, frozen_array
from tumble.scenarios.truth import NoTruth, truth
from tumble.solver.body import Body

if TYPE_CHECKING:
    from tumble.scenarios.truth.contact.record import ContactRecord

CERTIFIED = 12
# Times at which the truth above a plane is looked at, to learn where it ends.
LOOKED = 64


class ReferenceEnds(NoTruth):
    """The reference of a throw is known until a time only; until: [s]."""

    def __init__(self, throw: int, until: float, why: str) -> None:
        super().__init__(f"the reference solution is known until {until:.6g} s: {why}")
        self.throw, self.until, self.why = throw, until, why


class Reference:
    """The reference motion of every throw of a scene."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._free = scene.is_free
        a, b, c = scene.body.moments.tolist()
        self._body = Body(scene.body.mass, (a, b, c))
        self._segments: tuple[int, list[tuple[float, Array]]] = (-1, [])
        self._records: dict[int, ContactRecord] = {}
        self._ends: dict[int, float] = {}
        self._fineness: dict[int, float] = {}

    def horizon(self, throw: int) -> float:
        """Return until when the reference is known [s], as far as that has been asked for.  Raises NoTruth."""
        ends = self._ends.get(throw, np.inf)
        return ends if self._scene.plane is None else min(ends, self._record(throw).ended_s)

    def end(self, throw: int, until: float) -> None:
        """Let the reference of a throw end at a time [s], as its `resolution` has shown it to."""
        self._ends[throw] = until

    def first_contact(self, throw: int) -> float:
        """Return when a throw first touches the plane [s].  Raises NoTruth."""
        phases = self._record(throw).phases
        if not phases:
            return 0.0
        return phases[0].ends_s if phases[0].name == "flight" else 0.0

    def _record(self, throw: int) -> "ContactRecord":
        if throw not in self._records:
            start = frozen_array(self._scene.start[throw : throw + 1])
            times = frozen_array(np.linspace(0, self._scene.duration, LOOKED + 1)[1:])
            found = truth(replace(self._scene, times=times, start=start), with_input_error=False)
            self._records[throw] = found.contacts[0]
        return self._records[throw]

    def fineness(self, throw: int) -> float:
        """Return the largest rotation in a continuous step of the kernel [rad] with which a throw is simulated."""
        if self._scene.plane is not None or self._free:
            return FINE
        if throw not in self._fineness:
            program = correct_program(self._scene, throw)
            self._fineness[throw] = fineness_until(program, self._scene.duration)
        return self._fineness[throw]

    def states(self, throw: int, times: Array) -> Array:
        """Return the states at increasing times [s], after the impulses at each, (T, 13)."""
        if self._scene.plane is not None:
            return self._above_plane(throw, times)
        if not self._free:
            rows = correct_program(self._scene, throw).simulate(times, self.fineness(throw))
            return np.hstack((rows[:, 0:3], rows[:, 18:22], rows[:, 12:18]))
        segments = self._segments_of(throw)
        found = np.empty((len(times), 13))
        ends = [begin for begin, _ in segments[1:]] + [np.inf]
        done = 0
        for (begin, state), end in zip(segments, ends, strict=True):
            upto = int(np.searchsorted(times, end))
            found[done:upto] = self._free_motion(state, times[done:upto] - begin)
            done = upto
        return found

    def _above_plane(self, throw: int, times: Array) -> Array:
        """Return the states of Tumble's `events`, (T, 13), each from the scene's start on."""
        from tumble.solver.contact.flight import ContactFlight, Plane

        scene, found = self._scene, np.empty((len(times), 13))
        plane = scene.plane
        assert plane is not None
        above = Plane(
            plane.point,
            plane.normal,
            plane.restitution,
            plane.friction,
            scene.body.points,
            scene.body.radius or 0.0,
            scene.body.disc and (scene.body.disc.radius, scene.body.disc.thickness),
        )
        flight = ContactFlight(self._body, "events", scene.gravity, above)
        flight.write(scene.start[throw : throw + 1])
        now, impulses = 0.0, list(scene.impulses)
        for row, time in enumerate(times.tolist()):
            while impulses and impulses[0].time <= time:
                impulse = impulses.pop(0)
                flight.advance(1, impulse.time - now)
                flight.write(jump(impulse, flight.read(), scene.body))
                now = impulse.time
            if time > now:
                flight.advance(1, time - now)
                now = time
            found[row] = flight.read()[0]
        return found

    def vertices(self, throw: int, times: Array) -> Array:
        """Return the vertices [m], (T, n, 3)."""
        return vertices(self.states(throw, times), self._scene.body.points)

    def resolution(
        self, throw: int, times: Array, on_progress: Callable[[float], object] = lambda share: None
    ) -> Array:
        """Return the resolution of the reference up to times [m], (T,): the truth's, and the kernel's distance from it.

        times: increasing [s]; the truth is computed at a dozen of them, and the resolution up to another one is that up
        to the next of these; on_progress: called with the share that is done.  Raises ReferenceEnds, NoTruth.
        """
        some = np.unique(np.linspace(0, len(times) - 1, CERTIFIED).round().astype(int))
        asked = frozen_array(times[some])
        duration = max(self._scene.duration, float(asked[-1]))
        start = frozen_array(self._scene.start[throw : throw + 1])
        true = truth(replace(self._scene, times=asked, duration=duration, start=start), on_share=on_progress)
        if not np.isfinite(true.vertices).all():
            raise ReferenceEnds(throw, true.horizon, true.why)
        apart = self.vertices(throw, asked) - true.vertices[-len(asked) :, 0]
        own = true.resolution[-len(asked) :, 0] + np.linalg.norm(apart, axis=-1).max(axis=-1)
        return np.maximum.accumulate(own)[np.searchsorted(asked, times)]

    def _segments_of(self, throw: int) -> list[tuple[float, Array]]:
        """Return the time [s] and the state, (13,), at the start of each segment without impulses."""
        if self._segments[0] != throw:
            segments = [(0.0, np.array(self._scene.start[throw]))]
            for impulse in self._scene.impulses:
                begin, state = segments[-1]
                before = self._free_motion(state, np.array([impulse.time - begin]))
                after = impulse.time, jump(impulse, before, self._scene.body)[0]
                segments = [*segments[:-1], after] if impulse.time == begin else [*segments, after]
            self._segments = throw, segments
        return self._segments[1]

    def _free_motion(self, state: Array, t: Array) -> Array:
        """Return the states after free motion for times [s], (T,), from one state, (13,)."""
        axes = rotation_matrix(state[3:7])
        spins = np.empty((len(t), 14))
        spins[:, 7:14] = *state[3:7], *(self._scene.body.moments * (axes.T @ state[10:13]))
        coast(spins, t, self._body.inverse_moments, self._body.gyroscopic)
        q, momentum_body = spins[:, 0:4], spins[:, 4:7]
        w = np.einsum("tij,tj->ti", rotation_matrix(q), momentum_body / self._scene.body.moments)
        gravity = np.zeros(3) if self._scene.gravity is None else self._scene.gravity
        x = state[0:3] + t[:, None] * state[7:10] + (t * t / 2)[:, None] * gravity
        return np.hstack((x, q, state[7:10] + t[:, None] * gravity, w))
