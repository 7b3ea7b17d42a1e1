"""Which convention of Euler angles makes a file's first rows right: offered to the user, never assumed."""

from collections.abc import Iterator
from itertools import permutations, product
from pathlib import Path
from typing import NamedTuple

import numpy as np

from tumble.compare.grade.model.reference import Reference
from tumble.compare.grade.read.block import vertices_of
from tumble.compare.grade.read.columns import AnglesUnread, BadTrajectory
from tumble.compare.grade.read.conventions import AXES, EULER
from tumble.compare.grade.read.reading_options import Said
from tumble.scenarios.scene import Scene

# A convention fits where the vertices of half of the first rows are within this share of the body of the truth; others
# fit as well where they are not twice as far off, but for rounding.
FITS = 0.05
ALIKE, ROUNDING = 2.0, 1e-6
ROWS = 64
MOST_SHOWN = 4
# The axes of the scene itself.
OURS = "x,y,z"


class Fit(NamedTuple):
    """One way to read angles: its error over the body's size, what is said then, and whose way it is."""

    error: float
    said: Said
    whose: str


def best_fits(path: Path, scene: Scene, said: Said, unread: AnglesUnread) -> list[Fit]:
    """Return the way to read a file's Euler angles that comes nearest, and those that come as near; none of none."""
    fits = sorted(_fits(path, scene, said, unread), key=lambda fit: fit.error)
    return [fit for fit in fits if fit.error <= ALIKE * fits[0].error + ROUNDING]


def euler_offer(scene: Scene, said: Said, unread: AnglesUnread, fits: list[Fit]) -> str:
    """Return the options that read a file's Euler angles right, or nearest to that; said: without them."""
    columns = ", ".join(unread.named)
    if not fits:
        return f"no convention of {columns} can be read: --euler and --axes say which it is"
    best, options = fits[0], [fit.said.options(said) for fit in fits]
    if best.error > FITS:
        return (
            f"no convention of {columns} fits {scene.name}; nearest, {off(best.error)}, is {best.whose}: {options[0]}"
        )
    if len(fits) == 1:
        return f"{columns} fit as {best.whose}: {options[0]}"
    return f"{columns} fit in {len(fits)} ways: {'; or '.join(options[:MOST_SHOWN])}"


def off(error: float) -> str:
    """Return in words how far rows are off, over the body's size."""
    return f"{error:.0%} of the body off" if error < 1 else f"{error:.1f} times the size of the body off"


def misfit(path: Path, scene: Scene, said: Said, reference: Reference) -> float | None:
    """Return how far a file's first rows are off, read like that, over the body's size; None if it cannot be read."""
    try:
        trajectory, rows = said.first_rows(path, scene)
    except BadTrajectory:
        return None
    rows = rows.some(slice(ROWS))
    shown = trajectory.shown[0]
    true = reference.vertices(int(rows.throws[0]), rows.times)[:, list(shown.vertices)]
    seen = vertices_of(rows, shown, scene)
    if not shown.centred:
        true = true - reference.states(int(rows.throws[0]), rows.times)[:, None, 0:3]
    size_m = float(np.ptp(scene.body.points, axis=0).max())
    return float(np.median(np.linalg.norm(seen - true, axis=-1).max(axis=1))) / size_m


def _fits(path: Path, scene: Scene, said: Said, unread: AnglesUnread) -> Iterator[Fit]:
    """Yield every way to read the angles that can be read, each once."""
    reference = Reference(scene)
    for (euler, names), axes, unit in product(_orders().items(), _axes(said), ("deg", "rad")):
        if {said_unit or unit for _, said_unit in unread.named.values()} != {unit}:
            continue
        cells = AXES.get(axes, axes) if axes else OURS
        own = [name for name in names if AXES[name] == cells] or names
        way = said.with_angles(unread.named, unit).read_as(euler=own[0] if own else euler, axes=axes)
        whose = f"{' or '.join(name.capitalize() for name in own)}'s" if own else f"turns in the order {euler}"
        if (error := misfit(path, scene, way, reference)) is not None:
            yield Fit(error, way, whose)


def _orders() -> dict[str, list[str]]:
    """Return every order of turns, as --euler takes it, and the programs that have it."""
    named: dict[tuple[str, tuple[int, int, int]], list[str]] = {}
    for name, (order, signs) in EULER.items():
        # Turns about the body's axes are those about fixed axes in reverse.
        named.setdefault((order[::-1].lower() if order.isupper() else order, signs), []).append(name)
    found = {(order if signs == (1, 1, 1) else names[0]): names for (order, signs), names in named.items()}
    return {"".join(order): [] for order in permutations("xyz")} | found


def _axes(said: Said) -> list[str | None]:
    """Return the axes to try: those that are said, or those that differ."""
    if said.reading.axes:
        return [said.reading.axes]
    return [None, *{cells: name for name, cells in reversed(AXES.items()) if cells != "x,y,z"}.values()]
