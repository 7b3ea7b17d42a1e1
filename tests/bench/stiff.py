"""A step of the stiff methods on the tethers of the catalogue, and what long steps do to its cost and to the energy.

    python tests/bench/stiff.py [-o FILE.csv]

Lower decile of interleaved rounds, by the thread's own clock; every sample begins at the start of its scene.

"stiffer" is the cube of tether-undamped at its own step, on a tether so stiff that its fastest mode turns by w dt
radians in a step, and stretched by so much less that its energy is the same; with a rest length it pulls in one
direction, and is stretched by as much; "longer" is the first scene at longer steps.  The energy is looked at a hundred
times in ten thousand steps.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from figures import FigureRow, figure, lower_deciles, output_option, show, thread_clock

from tumble.compare.engines import tumble as engine
from tumble.compare.judge.balance import mechanical_energy
from tumble.scenarios.frames import rotation_matrix
from tumble.scenarios.read import read_scene
from tumble.scenarios.scene import Scene
from tumble.solver.scene_forces import forces_of
from tumble.solver.stiffness import fastest

SCENES = (
    "tether-undamped",
    "tether-critical",
    "tether-overdamped",
    "rod-stiff",
    "drag-stiff",
    "floor-stiff",
    "yardstick",
)
METHODS = "gauss6", "radau5"
STEPS, PASSES, ROUNDS = 500, 3, 20
# What a step on a tether may take [us], and how far the energy may be off after LONG steps.
ASKED_US, ASKED_ENERGY = 1.0, 1e-3
LONG, LOOKS = 10_000, 100
STIFFER, LONGER = (1.0, 10.0, 100.0, 1e3, 1e4), (10.0, 100.0)
REST_LENGTH = 0.3


class Flight(NamedTuple):
    """Steps of a method: a scene, as it is built, and how long one step is [s]."""

    scene: Scene
    method: str
    dt: float

    def prepared(self, steps: int = STEPS) -> Callable[[], object]:
        """Return the first steps of the scene, compiled already."""
        world = engine.build(self.scene, self.method)

        def call() -> None:
            engine.write(world, self.scene.start)
            engine.advance(world, steps, self.dt)

        call()
        return call

    def lost(self) -> float:
        """Return how far the energy is ever off in LONG steps, in parts of itself."""
        world = engine.build(self.scene, self.method)
        engine.write(world, self.scene.start)
        states = [self.scene.start]
        for _ in range(LOOKS):
            engine.advance(world, LONG // LOOKS, self.dt)
            states.append(engine.read(world).copy())
        energies = mechanical_energy(np.concatenate(states), self.scene)
        return float(np.abs(energies / energies[0] - 1.0).max())


def w_dt(scene: Scene) -> float:
    """Return by how much the fastest mode of a scene turns in its step [rad]."""
    return fastest(engine.build(scene, "gauss6").body, forces_of(scene)).frequency * scene.step


def stiffer(scene: Scene, times: float, rest_length: float = 0.0) -> Scene:
    """Return a scene on a tether so many times as stiff, which stores as much energy at the start.

    The scene's own tether has no rest length [m].
    """
    (tether,), (start,) = scene.tethers, scene.start
    end = start[0:3] + rotation_matrix(start[3:7]) @ tether.point_body
    stretch = tether.anchor - end
    anchor = end + stretch * (1.0 / np.sqrt(times) + rest_length / np.linalg.norm(stretch))
    stiff = replace(tether, anchor=anchor, stiffness=tether.stiffness * times, rest_length=rest_length)
    return replace(scene, tethers=(stiff,))


def long_flights(method: str) -> dict[str, Flight]:
    """Return flights on ever stiffer tethers, and of ever longer steps."""
    scene = read_scene("tether-undamped")
    once = w_dt(scene)
    found = {}
    for asked in STIFFER:
        found[f"stiffer, w dt = {asked:g}"] = Flight(stiffer(scene, (asked / once) ** 2), method, scene.step)
    for asked in STIFFER:
        at_length = stiffer(scene, (asked / once) ** 2, REST_LENGTH)
        found[f"stiffer, rest length {REST_LENGTH} m, w dt = {asked:g}"] = Flight(at_length, method, scene.step)
    for asked in LONGER:
        found[f"longer, w dt = {asked:g}"] = Flight(scene, method, scene.step * asked / once)
    return found


def main() -> None:
    """Measure, print and write."""
    output = output_option(__doc__.splitlines()[0])
    flights = {}
    for name in SCENES:
        scene = read_scene(name)
        for method in METHODS:
            flights[f"{method}, a step of {name}"] = Flight(scene, method, scene.step)
    for method in METHODS:
        flights |= {f"{method}, a step, {name}": flight for name, flight in long_flights(method).items()}
    tasks = {name: (flight.prepared(), thread_clock) for name, flight in flights.items()}
    passes = [lower_deciles(tasks, ROUNDS) for _ in range(PASSES)]
    rows = [step_row(name, [found[name] for found in passes]) for name in flights]
    for name, flight in long_flights("gauss6").items():
        rows.append(figure(f"gauss6, energy in {LONG} steps, {name}", "", "x", ASKED_ENERGY, [flight.lost()]))
    show(rows, output)


def step_row(name: str, seconds: list[float]) -> FigureRow:
    """Return the row of what a step takes [us]."""
    asked = ASKED_US if "tether" in name or "stiffer" in name else None
    return figure(name, "", "us", asked, np.array(seconds) / STEPS * 1e6)


if __name__ == "__main__":
    main()
