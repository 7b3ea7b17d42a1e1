"""Mistakes with the clock, and with which steps are taken and which rows written."""

from dataclasses import replace

import numpy as np

from tools.random_programs.algebra import ZERO
from tools.random_programs.mistakes.kind import even, instant, mistake, one_of
from tools.random_programs.scene import Scene
from tools.random_programs.scheme import Scheme
from tools.random_programs.simulation import Rows, Simulation


def _unstruck_later(scene: Scene, scheme: Scheme) -> bool:
    """Whether the physics and the clock may run apart without an impulse that both are asked for."""
    return all(impulse.time == 0 for impulse in scene.impulses)


def _between_rows(scene: Scene, scheme: Scheme) -> bool:
    return _unstruck_later(scene, scheme) and (scheme.reading.between != "" or scheme.every >= 1)


def _offset(random: np.random.Generator, scene: Scene, scheme: Scheme) -> float:
    """Return whole ticks, as a program that logs another instant has them [s]."""
    return int(random.choice((1, 2, 3, 5, 10))) * scheme.spacing * (1 if random.random() < 0.5 else -1)


@mistake("clock", "clock offset", _between_rows, time=_offset)
def _(sim: Simulation, time: float) -> None:
    sim.ahead = time


@mistake("clock", "clock rate", _unstruck_later, rate=one_of(0.5, 2.0, 1.2, 5 / 6, 1.01, 0.97, 1.1, 0.6))
def _(sim: Simulation, rate: float) -> None:
    """Steps are longer than the file's times by this factor."""
    sim.scheme = replace(sim.scheme, dt=sim.scheme.dt * rate, spacing=sim.scheme.spacing * rate)
    sim.dt *= rate
    sim.scene = replace(sim.scene, duration=sim.scene.duration * rate)
    sim.rewrites.append(lambda rows: replace(rows, t=rows.t / rate))


@mistake("clock", "stops", time=instant(0.3, 0.8))
def _(sim: Simulation, time: float) -> None:
    """The body falls asleep."""
    _stands_still(sim, time, np.inf)


# --- without a name when this was written ---------------------------------------------------------------------------


@mistake("clock", "a hitch", time=instant(0.2, 0.6), lasts=instant(0.05, 0.15))
def _(sim: Simulation, time: float, lasts: float) -> None:
    """For a while nothing moves, and the clock goes on."""
    if lasts > 0:
        _stands_still(sim, time, time + lasts)


@mistake("clock", "slow motion from an instant on", time=instant(0.2, 0.6), rate=one_of(0.5, 0.8, 0.25))
def _(sim: Simulation, time: float, rate: float) -> None:
    sim.step_of = lambda n: sim.dt if n * sim.dt < time - 1e-9 else rate * sim.dt


@mistake(
    "clock", "uneven steps", jitter=even(0.05, 0.5), seed=lambda random, scene, scheme: int(random.integers(1 << 30))
)
def _(sim: Simulation, jitter: float, seed: int) -> None:
    """Steps are as long as frames take, and rows are written as if all were equal."""
    longer = 1 + jitter * np.random.default_rng(seed).uniform(-1, 1, size=200_000)
    sim.step_of = lambda n: sim.dt * float(longer[n])


@mistake("clock", "every n-th row lost", n=one_of(5, 10, 20))
def _(sim: Simulation, n: int) -> None:
    """The rows that are left are numbered, and their times made of their numbers."""

    def rewrite(rows: Rows) -> Rows:
        left = np.arange(len(rows.t)) % n != n - 1
        return replace(rows.part(left), t=rows.t[: left.sum()])

    sim.rewrites.append(rewrite)


@mistake("clock", "restarts", time=instant(0.4, 0.8))
def _(sim: Simulation, time: float) -> None:
    """The body is put back to where it began."""
    first = (sim.x, sim.q, sim.v, sim.w)
    done: list[bool] = []

    def again() -> None:
        if not done and sim.now >= time - 1e-9:
            done.append(True)
            sim.x, sim.q, sim.v, sim.w = first

    sim.before.append(again)


@mistake("clock", "velocities forgotten once", time=instant(0.3, 0.7))
def _(sim: Simulation, time: float) -> None:
    """As where a body is made again: it stays where it is, and starts from rest."""
    done: list[bool] = []

    def again() -> None:
        if not done and sim.now >= time - 1e-9:
            done.append(True)
            sim.v = sim.w = sim.vector(ZERO)

    sim.before.append(again)


def _stands_still(sim: Simulation, begin: float, end: float) -> None:
    """Take no steps from one instant to another [s]."""
    right = sim.advance

    def advance(dt: float) -> None:
        if not begin - 1e-9 <= sim.now < end - 1e-9:
            right(dt)

    sim.advance = advance
