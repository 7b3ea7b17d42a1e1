"""Which conventions of Euler angles fit a file's first rows: suggested to the user, never assumed."""

from collections.abc import Iterator
from itertools import permutations, product
from pathlib import Path
from typing import NamedTuple

import numpy as np

from tumble.compare.grade.model.reference import Reference
from tumble.compare.grade.read.block import vertices_of
from tumble.compare.grade.read.columns import AmbiguousAngles, BadTrajectory
from tumble.compare.grade.read.conventions import AXES, EULER
from tumble.compare.grade.read.reading_options import ReadingOptions
from tumble.scenarios.scene import Scene

# A convention fits if the median vertex error of the first rows is at most this share of the body's size.  Others fit
# equally well if their error is less than twice as large, plus rounding.
FITS = 0.05
ALIKE, ROUNDING = 2.0, 1e-6
ROWS = 64
MOST_SHOWN = 4
# The scene's own axes.
OURS = "x,y,z"


class Fit(NamedTuple):
    """One reading of the angles: its error over the body's size, its options, and whose convention it is."""

    error: float
    options: ReadingOptions
    whose: str


def best_fits(path: Path, scene: Scene, options: ReadingOptions, angles: AmbiguousAngles) -> list[Fit]:
    """Return the readings of a file's Euler angles that fit best, best first; empty if none can be read."""
    fits = sorted(_fits(path, scene, options, angles), key=lambda fit: fit.error)
    return [fit for fit in fits if fit.error <= ALIKE * fits[0].error + ROUNDING]


def euler_suggestion(scene: Scene, options: ReadingOptions, angles: AmbiguousAngles, fits: list[Fit]) -> str:
    """Return the options that read a file's Euler angles, in words; options: the given ones."""
    columns = ", ".join(angles.named)
    if not fits:
        return f"{columns} can be read in no convention: give --euler and --axes"
    best, suggested = fits[0], [fit.options.command_line(options) for fit in fits]
    if best.error > FITS:
        return (
            f"no convention of {columns} fits {scene.name}; the nearest, {misfit_text(best.error)}, is {best.whose}: "
            f"{suggested[0]}"
        )
    if len(fits) == 1:
        return f"{columns} fit as {best.whose}: {suggested[0]}"
    return f"{columns} fit in {len(fits)} ways: {'; or '.join(suggested[:MOST_SHOWN])}"


def misfit_text(error: float) -> str:
    """Return in words how far rows are off, given over the body's size."""
    return f"{error:.0%} of the body's size off" if error < 1 else f"{error:.1f} times the body's size off"


def misfit(path: Path, scene: Scene, options: ReadingOptions, reference: Reference) -> float | None:
    """Return the median vertex error of a file's first rows over the body's size; None if they cannot be read."""
    try:
        trajectory, rows = options.first_rows(path, scene)
    except BadTrajectory:
        return None
    rows = rows.some(slice(ROWS))
    description = trajectory.descriptions[0]
    true = reference.vertices(int(rows.throws[0]), rows.times)[:, list(description.vertices)]
    seen = vertices_of(rows, description, scene)
    if not description.has_centre:
        true = true - reference.states(int(rows.throws[0]), rows.times)[:, None, 0:3]
    size_m = float(np.ptp(scene.body.points, axis=0).max())
    return float(np.median(np.linalg.norm(seen - true, axis=-1).max(axis=1))) / size_m


def _fits(path: Path, scene: Scene, options: ReadingOptions, angles: AmbiguousAngles) -> Iterator[Fit]:
    """Yield every possible reading of the angles once."""
    reference = Reference(scene)
    for (euler, names), axes, unit in product(_orders().items(), _axes(options), ("deg", "rad")):
        if {own_unit or unit for _, own_unit in angles.named.values()} != {unit}:
            continue
        cells = AXES.get(axes, axes) if axes else OURS
        own = [name for name in names if AXES[name] == cells] or names
        way = options.with_angles(angles.named, unit).with_conventions(euler=own[0] if own else euler, axes=axes)
        whose = f"{' or '.join(name.capitalize() for name in own)}'s" if own else f"rotations in the order {euler}"
        if (error := misfit(path, scene, way, reference)) is not None:
            yield Fit(error, way, whose)


def _orders() -> dict[str, list[str]]:
    """Return every rotation order, as --euler takes it, and the programs that use it."""
    named: dict[tuple[str, tuple[int, int, int]], list[str]] = {}
    for name, (order, signs) in EULER.items():
        # Rotations about body axes are those about fixed axes in reverse order.
        named.setdefault((order[::-1].lower() if order.isupper() else order, signs), []).append(name)
    found = {(order if signs == (1, 1, 1) else names[0]): names for (order, signs), names in named.items()}
    return {"".join(order): [] for order in permutations("xyz")} | found


def _axes(options: ReadingOptions) -> list[str | None]:
    """Return the axes to try: the given ones, or all that differ."""
    if options.conventions.axes:
        return [options.conventions.axes]
    return [None, *{cells: name for name, cells in reversed(AXES.items()) if cells != "x,y,z"}.values()]
