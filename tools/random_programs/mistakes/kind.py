"""What a kind of mistake is: its label, where it can be made, what is drawn of it, and how a program makes it."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from tools.random_programs.scene import Scene
from tools.random_programs.scheme import Scheme

Value = float | int | str
Params = dict[str, Value]
Draw = Callable[[np.random.Generator, Scene, Scheme], Value]


def anywhere(scene: Scene, scheme: Scheme) -> bool:
    """Whether a mistake can be made: always."""
    return True


@dataclass(frozen=True)
class Kind:
    """A kind of mistake.

    part: of the program; two mistakes of one program are of two parts.  where: in which scenes and upon which schemes
    it can be made; draws: a draw for each parameter; plant: makes a simulation of it, given the parameters.
    """

    label: str
    part: str
    where: Callable[[Scene, Scheme], bool]
    plant: Callable[..., None]
    draws: dict[str, Draw] = field(default_factory=dict)

    def drawn(self, random: np.random.Generator, scene: Scene, scheme: Scheme) -> Params:
        """Return parameters."""
        return {name: draw(random, scene, scheme) for name, draw in self.draws.items()}


KINDS: dict[str, Kind] = {}


def mistake(
    part: str, label: str, where: Callable[[Scene, Scheme], bool] = anywhere, /, **draws: Draw
) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Enter a function of a Simulation and parameters into the table as a kind of mistake."""

    def enter(plant: Callable[..., None]) -> Callable[..., None]:
        assert label not in KINDS, label
        KINDS[label] = Kind(label, part, where, plant, draws)
        return plant

    return enter


def one_of(*values: Value) -> Draw:
    """Return a draw of one of some values."""
    return lambda random, scene, scheme: values[int(random.integers(len(values)))]


def even(low: float, high: float, figures: int = 3) -> Draw:
    """Return a draw between two numbers, evenly of their logarithm, to some figures."""
    return lambda random, scene, scheme: float(f"{np.exp(random.uniform(np.log(low), np.log(high))):.{figures}g}")


def instant(low: float, high: float) -> Draw:
    """Return a draw of an instant between two shares of the duration [s], on a tick."""

    def draw(random: np.random.Generator, scene: Scene, scheme: Scheme) -> float:
        return round(random.uniform(low, high) * scene.duration / scheme.dt) * scheme.dt

    return draw


def is_split(scene: Scene, scheme: Scheme) -> bool:
    """Whether the scheme is of split steps."""
    return scheme.method == "split"


def has_euler(scene: Scene, scheme: Scheme) -> bool:
    """Whether the body is triaxial and the scheme has Euler's equations with their term as it is."""
    explicit = scheme.method != "split" or scheme.gyroscopic == "explicit"
    return scene.is_triaxial and scheme.keeps != "momentum" and explicit


def spins(scene: Scene, scheme: Scheme) -> bool:
    """Whether the body spins at the start."""
    return bool(np.linalg.norm(scene.w) > 0.05)


def moves(scene: Scene, scheme: Scheme) -> bool:
    """Whether the body moves at the start."""
    return bool(np.linalg.norm(scene.v) > 0.05)


def is_turned(scene: Scene, scheme: Scheme) -> bool:
    """Whether the start has an attitude."""
    return abs(scene.q[0]) < 0.99


def falls(scene: Scene, scheme: Scheme) -> bool:
    """Whether gravity acts."""
    return bool(scene.gravity.any())


def is_struck(scene: Scene, scheme: Scheme) -> bool:
    """Whether an impulse acts."""
    return bool(scene.impulses)
