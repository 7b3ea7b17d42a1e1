"""The energies that a flight is judged by, each held against what physics leaves of it."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from tumble.compare.judge import mechanics
from tumble.compare.judge.errors import Run
from tumble.scenarios.forces import GRAVITY, stored, takes_energy
from tumble.scenarios.frames import Array
from tumble.scenarios.scene import Scene

# 5 % of the energy is 2.5 % of the speed: what a person begins to see.  Where forces act a symplectic step keeps an
# energy that is up to w dt/2 off, and modes that pass theirs on to each other let it wander over many turns: that is
# no growth yet.  What swings and comes back within a quarter of the flight is none either: the band is widened
# by what the first quarter takes back of a rise, or gives back of a fall.
BAND, PULLED_BAND = 0.05, 0.25

Law = Callable[[Array, Scene], Array]  # an energy of states, (..., 13) -> (...) [J]


@dataclass(frozen=True, eq=False)
class Balance:
    """One energy over the rows of a flight, minus what physics leaves, over its scale [J], (R, N).

    band: how much of it may be gained; decays: whether physics takes energy and nobody knows how much, so that only a
    growth is wrong.
    """

    name: str
    excess: Array
    scale: float
    band: float
    decays: bool

    @property
    def ratio(self) -> float:
        """The energy at the end over what physics leaves, of the throw that is furthest off."""
        last = self.excess[-1]
        return float(1.0 + last[np.argmax(abs(last))])

    @property
    def top(self) -> float:
        """The largest there ever was, over the scale."""
        return float(self.excess.max()) + 1.0

    @property
    def grows(self) -> bool:
        """Whether the last quarter of the flight tops the first by more than the band, or stays above it."""
        first, last = self.quarters
        band = self.band + (np.maximum.accumulate(first, axis=0) - first).max(axis=0)
        return bool((np.maximum(last.max(axis=0) - first.max(axis=0), last.min(axis=0)) > band).any())

    @property
    def falls(self) -> bool:
        """Whether the last quarter of the flight stays below the band, and physics would not."""
        first, last = self.quarters
        band = BAND + (first - np.minimum.accumulate(first, axis=0)).max(axis=0)
        return not self.decays and bool((last.max(axis=0) < -band).any())

    @property
    def growth(self) -> float:
        """How many times the largest of the first quarter the largest of the last is."""
        first, last = self.quarters
        return float(((1.0 + last.max(axis=0)) / (1.0 + first.max(axis=0))).max())

    @property
    def quarters(self) -> tuple[Array, Array]:
        """The first and the last quarter, of at least two rows and one."""
        count = max(1, len(self.excess) // 4)
        return self.excess[: count + 1], self.excess[-count:]


def energies(run: Run) -> Iterator[Balance]:
    """Yield the energies that are judged, the one that is quoted first.

    Where forces act it is all of it.  A free body keeps that of its spin and that of its fall apart: a fast fall would
    hide what becomes of the spin.
    """
    scene, states = run.scene, run.flight.states
    true = None if run.truth is None else run.truth.states
    if not scene.is_free:
        yield balance("energy", mechanical_energy, moving_and_stored, scene, states, true)
        return
    of_spin = balance("energy of the spin", spin, spin, scene, states, true)
    of_fall = balance("energy of the fall", fall, carried, scene, states, true)
    turns = spin(states[:1] if true is None else true, scene).max() > 0
    yield from (of_spin, of_fall) if turns else (of_fall, of_spin)


def spin(states: Array, scene: Scene) -> Array:
    """Return w.I w / 2 [J]."""
    return mechanics.spin_energy(states, scene.body)


def carried(states: Array, scene: Scene) -> Array:
    """Return m v.v / 2 [J]."""
    return mechanics.kinetic_energy(states, scene.body) - spin(states, scene)


def fall(states: Array, scene: Scene) -> Array:
    """Return m v.v / 2 - m g.x [J]."""
    return mechanics.energy(states, scene.body, scene.gravity) - spin(states, scene)


def moving_and_stored(states: Array, scene: Scene) -> Array:
    """Return kinetic energy and what tethers and floor hold [J]."""
    return mechanics.kinetic_energy(states, scene.body) + stored(scene, states, but=GRAVITY)


def mechanical_energy(states: Array, scene: Scene) -> Array:
    """Return kinetic energy, that of height, and what tethers and floor hold [J], (...); states (..., 13)."""
    return mechanics.kinetic_energy(states, scene.body) + stored(scene, states)


def balance(name: str, law: Law, unit: Law, scene: Scene, states: Array, true: Array | None) -> Balance:
    """Return one energy's balance; its scale is the largest of another in the truth, or without one at the start."""
    known = states[:1] if true is None else true
    scale = float(unit(known, scene).max()) or own_scale(scene)
    decays = true is None and takes_energy(scene)
    band = BAND if scene.is_free else PULLED_BAND
    return Balance(name, (law(states, scene) - law(known, scene)) / scale, scale, band, decays)


def own_scale(scene: Scene) -> float:
    """Return an energy to measure by where nothing moves at first and nothing is stored: that of a fall by its size."""
    size = scene.body.reach
    return scene.body.mass * size * float(np.linalg.norm(scene.gravity if scene.gravity is not None else 0.0)) or 1.0
