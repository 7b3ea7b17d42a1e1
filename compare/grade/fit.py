"""Which convention of Euler angles makes a file's first rows right: offered to the user, never assumed."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import permutations, product
from pathlib import Path
from typing import NamedTuple

import numpy as np

from compare.grade.block import vertices_of
from compare.grade.columns import AnglesUnread, BadTrajectory
from compare.grade.conventions import AXES, EULER, Reading
from compare.grade.foreign import Trajectory
from compare.grade.offers import map_option
from compare.grade.reference import Reference
from scenarios.scene import Scene

# A convention fits where the vertices of half of the first rows are within this share of the body of the truth; others
# fit as well where they are not twice as far off, but for rounding.
FITS = 0.05
ALIKE, ROUNDING = 2.0, 1e-6
ROWS = 64
MOST_SHOWN = 4


class Fit(NamedTuple):
    """One way to read angles: its error over the body's size, the option to give, and whose way it is."""

    error: float
    option: str
    whose: str


def euler_offer(
    path: Path, scene: Scene, mapping: Mapping[str, str], decimal: str, reading: Reading, unread: AnglesUnread
) -> str:
    """Return the options that read a file's Euler angles right, or that none was found."""
    columns = ", ".join(unread.named)
    fits = sorted(_fits(path, scene, mapping, decimal, reading, unread))
    if not fits or fits[0].error > FITS:
        return f"no convention of {columns} fits {scene.name}: --euler and --axes say which it is"
    alike = [fit for fit in fits if fit.error <= ALIKE * fits[0].error + ROUNDING]
    if len(alike) == 1:
        return f"{columns} fit as {alike[0].whose}: {alike[0].option}"
    return f"{columns} fit in {len(alike)} ways: {'; or '.join(fit.option for fit in alike[:MOST_SHOWN])}"


def _fits(
    path: Path, scene: Scene, mapping: Mapping[str, str], decimal: str, reading: Reading, unread: AnglesUnread
) -> Iterator[Fit]:
    """Yield every way to read the angles that can be read, each once."""
    size_m = float(np.ptp(scene.body.points, axis=0).max())
    reference = Reference(scene)
    for (euler, names), axes, unit in product(_orders().items(), _axes(reading), ("deg", "rad")):
        units = {column: said or unit for column, (_, said) in unread.named.items()}
        if set(units.values()) != {unit}:
            continue
        named = {column: f"{angle}_{unit}" for column, (angle, _) in unread.named.items()}
        try:
            trajectory = Trajectory(
                path, scene, {**mapping, **named}, None, decimal, replace(reading, euler=euler, axes=axes, notes=[])
            )
            block = next(trajectory.blocks())
        except BadTrajectory:
            continue
        rows = block.throw(int(block.throws[0]))
        true = reference.vertices(int(rows.throws[0]), rows.times[:ROWS])
        seen = vertices_of(rows, trajectory.shown[0], scene)[:ROWS]
        error = float(np.median(np.linalg.norm(seen - true, axis=-1).max(axis=1))) / size_m
        own = [name for name in names if axes is None or AXES.get(name) == AXES[axes]] or names
        options = [f"--euler {own[0] if own else euler}"]
        if axes and axes != reading.axes:
            options.append(f"--axes {axes}")
        options += [map_option(*pair) for pair in named.items() if pair[0] != pair[1]]
        whose = f"{' or '.join(name.capitalize() for name in own)}'s" if own else f"turns in the order {euler}"
        yield Fit(error, " ".join(options), whose)


def _orders() -> dict[str, list[str]]:
    """Return every order of turns, as --euler takes it, and the programs that have it."""
    named: dict[tuple[str, tuple[int, int, int]], list[str]] = {}
    for name, (order, signs) in EULER.items():
        # Turns about the body's axes are those about fixed axes in reverse.
        named.setdefault((order[::-1].lower() if order.isupper() else order, signs), []).append(name)
    found = {(order if signs == (1, 1, 1) else names[0]): names for (order, signs), names in named.items()}
    return {"".join(order): [] for order in permutations("xyz")} | found


def _axes(reading: Reading) -> list[str | None]:
    """Return the axes to try: those that the user says, or those that differ."""
    return (
        [reading.axes]
        if reading.axes
        else [None, *{cells: name for name, cells in reversed(AXES.items()) if cells != "x,y,z"}.values()]
    )
