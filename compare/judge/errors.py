"""Holds what an engine answered against the truth: errors at the vertices, drifts, and what went wrong silently."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from tumble.compare.judge import mechanics
from tumble.compare.judge.lookup import looked_up
from tumble.compare.run.flight import Trajectory, mean_step
from tumble.compare.run.precision import DOUBLE
from tumble.compare.run.running_engines import RunningEngine
from tumble.compare.run.status import Failure, Status, described
from tumble.scenarios.frames import Array
from tumble.scenarios.needs import needs
from tumble.scenarios.scene import Scene
from tumble.scenarios.truth import Truth

# A free body's velocity is v0 + g t in every integrator there is, but for a rounding of it a step.
HIDDEN_FORCE = 1e-4
# A lost torque leaves the angular velocity standing to round-off while the true one turns by far more than that.
STOOD_STILL = 1e-9
TURNED = 1e-3


def quietly() -> np.errstate:
    """Return a context in which a flight that blew up overflows squares unsaid; its figures say it."""
    return np.errstate(over="ignore", invalid="ignore")


@dataclass(frozen=True, eq=False)
class RunAnswer:
    """The answer of one method at one step dt [s], or under a tolerance, without its scene and reference."""

    method: str
    dt: float
    answer: Trajectory | Failure
    tolerance: float | None = None
    rounding: float = DOUBLE

    @classmethod
    def of(cls, running_engine: RunningEngine, method: str, dt: float, answer: Trajectory | Failure) -> "RunAnswer":
        """Return the answer of an engine's method."""
        return cls(method, dt, answer, running_engine.tolerance(method), running_engine.rounding)

    def run(self, scene: Scene, engine: str, truth: Truth | None) -> "Run":
        """Return the run that it is, with the scene, the engine and the reference."""
        return Run(
            scene=scene,
            engine=engine,
            method=self.method,
            dt=self.dt,
            answer=self.answer,
            truth=truth,
            tolerance=self.tolerance,
            rounding=self.rounding,
        )


@dataclass(frozen=True, eq=False)
class Run:
    """One contestant on one scene: its trajectory, or why there is none, and the reference solution.

    Beyond the reference's horizon no error is computed: scene, answer and truth end there.

    Parameters
    ----------
    scene : the scene
    engine : title of the engine
    method : name of the method
    dt : step that was asked for [s]
    answer : the trajectory, or why there is none
    truth : reference solution; None where the scene has none yet
    tolerance : tolerance by which the method chose its steps; nan: not stated; None: the method takes none
    rounding : half an ulp of 1 in the engine's precision
    """

    scene: Scene
    engine: str
    method: str
    dt: float
    answer: Trajectory | Failure
    truth: Truth | None
    tolerance: float | None = None
    rounding: float = DOUBLE

    def __post_init__(self) -> None:
        """Leave out what is beyond the horizon."""
        if self.truth is None or self.truth.known == len(self.truth.times):
            return
        known, within = self.truth.known, self.scene.times <= self.truth.horizon
        cut: dict = {"truth": self.truth.until_horizon(), "scene": replace(self.scene, times=self.scene.times[within])}
        if isinstance(self.answer, Trajectory):
            rows = {name: getattr(self.answer, name)[:known] for name in ("times", "states", "vertices")}
            cut["answer"] = replace(self.answer, **rows)
        for name, value in cut.items():
            object.__setattr__(self, name, value)

    @property
    def name(self) -> str:
        """ENGINE:METHOD."""
        return f"{self.engine}:{self.method}" if self.method else self.engine

    @property
    def flight(self) -> Trajectory:
        """The flight it made; asked only where there is one."""
        assert isinstance(self.answer, Trajectory)
        return self.answer

    @property
    def dt_taken(self) -> float | None:
        """The mean of the steps taken [s]: less than dt where samples and impulses cut the run into legs.

        None of a run that did not reach its end, and where a tolerance chose the steps.
        """
        if not isinstance(self.answer, Trajectory) or self.tolerance is not None or self.answer.diverged_at is not None:
            return None
        return mean_step(self.scene.duration, self.answer.steps, self.dt)

    @property
    def has_errors(self) -> bool:
        """Whether there is a flight and a truth to hold it against."""
        return isinstance(self.answer, Trajectory) and self.truth is not None

    @cached_property
    def status(self) -> Status:
        """What became of the run."""
        if isinstance(self.answer, Failure):
            return self.answer.status
        if self.answer.diverged_at is not None:
            return Status.DIVERGED
        return Status.FLAGGED if self.notes else Status.OK

    @cached_property
    def reason(self) -> str:
        """The reason of a status that is not ok, else empty."""
        if isinstance(self.answer, Failure):
            return self.answer.reason
        if self.answer.diverged_at is not None:
            return f"at {self.answer.diverged_at:.6g} s"
        return "; ".join(self.notes)

    @property
    def outcome(self) -> str:
        """Status and reason as text for a person."""
        return described(self.status, self.reason)

    @cached_property
    def notes(self) -> tuple[str, ...]:
        """What went wrong silently, by the engine's own audit and by ours, in words."""
        if isinstance(self.answer, Failure):
            return ()
        if self.truth is None or self.answer.diverged_at is not None:
            return self.answer.notes
        return (*self.answer.notes, *audit(self.scene, self.answer, self.truth, self.rounding))

    @cached_property
    def errors(self) -> Array:
        """Vertex positions minus true ones at the samples [m], (S, N, n, 3)."""
        assert self.truth is not None
        return (self.flight.vertices - self.truth.vertices)[-len(self.scene.times) :]

    @cached_property
    def distances(self) -> Array:
        """Lengths of errors [m], (S, N, n)."""
        with quietly():
            return np.linalg.norm(self.errors, axis=-1)

    @cached_property
    def limits(self) -> Array:
        """max(bound, floor) of the truth at the samples [m], (S, N): an error below it says nothing more."""
        assert self.truth is not None
        return self.truth.resolution[-len(self.scene.times) :]

    @cached_property
    def throws_errors(self) -> Array:
        """Each throw's largest vertex error, not below what the truth can tell [m], (N,)."""
        return np.maximum(self.distances.max(axis=(0, 2)), self.limits.max(axis=0))

    @cached_property
    def drifts(self) -> tuple[float, float, float]:
        """Drift from the truth of energy, momentum and angular momentum, each over its true scale.

        The scales are the largest true kinetic energy, momentum and angular momentum; where one is 0 the drift is SI.
        """
        assert self.truth is not None
        states, true, body = self.flight.states, self.truth.states, self.scene.body
        p_true, l_true = mechanics.momentum(true, body), mechanics.angular_momentum(true, body)
        with quietly():
            return (
                mechanics.drift(
                    mechanics.energy(states, body, self.scene.gravity),
                    mechanics.energy(true, body, self.scene.gravity),
                    float(mechanics.kinetic_energy(true, body).max()),
                ),
                mechanics.drift(mechanics.momentum(states, body), p_true, largest(p_true)),
                mechanics.drift(mechanics.angular_momentum(states, body), l_true, largest(l_true)),
            )


def largest(vectors: Array) -> float:
    """Return the largest length, vectors (..., 3)."""
    return float(np.linalg.norm(vectors, axis=-1).max())


@quietly()
def audit(scene: Scene, flight: Trajectory, truth: Truth, rounding: float) -> list[str]:
    """Return what went wrong silently, seen from outside: a frozen body, hidden damping or a clamp, a lost torque."""
    moved = np.abs(truth.vertices - truth.vertices[0]).max()
    if moved > truth.resolution.max() and (flight.vertices == flight.vertices[0]).all():
        return ["frozen: the body never moved"]
    notes = [found] if (found := looked_up(scene, flight, truth)) else []
    if scene.is_free:
        off = np.linalg.norm(flight.states[..., 7:10] - truth.states[..., 7:10], axis=-1).max(axis=1)
        worst, speed = int(np.argmax(off)), largest(truth.states[..., 7:10])
        if off[worst] > (HIDDEN_FORCE + flight.steps * rounding) * speed:
            share = f"{off[worst] / speed:.2g} of it" if speed else f"{off[worst]:.2g} m/s"
            when = f"t = {flight.times[worst]:g} s"
            notes.append(f"velocity of the centre of mass off by {share} at {when}, as by damping or a clamp")
        if "gyroscopic" in needs(scene) and lost_torque(scene, flight.states, truth.states):
            notes.append("lost gyroscopic torque: the angular velocity stands still where the true one turns")
    return notes


def lost_torque(scene: Scene, states: Array, true_states: Array) -> bool:
    """Whether the angular velocity stays what it was between impulses while the true one changes, (R, N, 13) each."""
    struck = np.searchsorted(scene.rows, [impulse.time for impulse in scene.impulses])
    between = np.setdiff1d(np.arange(1, len(scene.rows)), struck)
    turned, stood = (
        float(np.linalg.norm(each[between, :, 10:13] - each[between - 1, :, 10:13], axis=-1).max(axis=-1).sum())
        for each in (true_states, states)
    )
    return turned > TURNED * largest(true_states[..., 10:13]) and stood < STOOD_STILL * turned
