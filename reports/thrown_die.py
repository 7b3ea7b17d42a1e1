"""The figures of the IGR202 report: a die thrown straight, and the rotation matrix that stops being a rotation."""

from dataclasses import dataclass

import numpy as np
from markupsafe import Markup

from compare.engines import OWN
from reports import die
from reports.numerals import figure, fixed, given
from reports.rows import Tables, poses
from scenarios.frames import Array

STRAIGHT, AT_VERTEX = "die-straight", "die-vertex"
FIGURES = {
    "Figure 2: the matrix, R += dt ω* R (tumble:matrix-euler)": (OWN, "matrix-euler"),
    "Figure 3: the quaternion, normalised (tumble:quaternion-euler)": (OWN, "quaternion-euler"),
}
SHOWN = 6
# Edges that keep their length to this part of it: a rigid body.
RIGID = 1e-6


@dataclass(frozen=True)
class Row:
    """One contestant's die at the times shown, and what became of it."""

    title: str
    finding: str
    pictures: list[die.Picture]


@dataclass(frozen=True)
class ThrownDie:
    """The section; what has nothing to show is None or empty."""

    title: str
    parabola: die.Picture | None
    rows: list[Row]


def section(tables: Tables) -> ThrownDie | None:
    """Return the section, or None where neither scene was flown."""
    parabola = thrown_straight(tables.true_boxes(STRAIGHT))
    true = tables.true_boxes(AT_VERTEX)
    flown = {title: poses(tables.flown(AT_VERTEX, *contestant), true=False) for title, contestant in FIGURES.items()}
    rows = side_by_side(true, {title: own for title, own in flown.items() if true and own})
    if parabola is None and not rows:
        return None
    title = "A die thrown, and the matrix that stops being a rotation" if rows else "A die thrown"
    return ThrownDie(title, parabola, rows)


def thinned(times: list[float]) -> list[float]:
    """Return at most SHOWN times at even distances that end with the last."""
    count = min(SHOWN, len(times))
    return [times[round((number + 1) * len(times) / count) - 1] for number in range(count)]


def thrown_straight(true: dict[float, Array]) -> die.Picture | None:
    """Return the die along its parabola (Figure 1), or None where it was not flown."""
    if not true:
        return None
    times = thinned(list(true))
    centres = np.array([vertices.mean(axis=0) for vertices in true.values()])
    dice = [Markup('<g class="ghost">{}</g>').format(die.box(true[time])) for time in times]
    size = float(die.edge_lengths(true[times[0]]).max())
    frame = die.view_box(np.array([true[time] for time in times]), 0.1 * size)
    path = [die.line(centres, "path"), *(die.dot(centre, "true", 0.03 * size) for centre in centres)]
    return die.Picture(f"t = {given(times[0])} s to {given(times[-1])} s", frame, Markup("").join([*dice, *path]))


def side_by_side(true: dict[float, Array], flown: dict[str, dict[float, Array]]) -> list[Row]:
    """Return each contestant's die at the same times, where all still are somewhere, about its own centre."""
    times = thinned([time for time in true if all(np.isfinite(own[time]).all() for own in flown.values())])
    centred = {title: {time: own[time] - own[time].mean(axis=0) for time in times} for title, own in flown.items()}
    if not times or not flown:
        return []
    everything = np.array([vertices for own in centred.values() for vertices in own.values()])
    frame = die.view_box(everything, 0.05 * float(np.ptp(everything, axis=(0, 1)).max()))
    return [
        Row(
            title,
            deformation(own[times[-1]], true[times[-1]], times[-1]),
            [
                die.Picture(f"{given(time)} s · {edges(vertices, true[time])}", frame, die.box(vertices, pips=True))
                for time, vertices in own.items()
            ],
        )
        for title, own in centred.items()
    ]


def stretch(vertices: Array, true: Array) -> Array:
    """Return the edges over the true ones, (12,)."""
    return die.edge_lengths(vertices) / die.edge_lengths(true)


def edges(vertices: Array, true: Array) -> str:
    """Return the shortest and the longest edge over the true one."""
    ratios = stretch(vertices, true)
    return f"edges {fixed(ratios.min(), 2)} to {fixed(ratios.max(), 2)}"


def deformation(vertices: Array, true: Array, time: float) -> str:
    """Return what became of the die."""
    ratios = stretch(vertices, true)
    off = float(np.abs(ratios - 1.0).max())
    if off < RIGID:
        return f"After {given(time)} s every edge has its true length to {figure(off, 2)} of it."
    return (
        f"After {given(time)} s the edges are {fixed(ratios.min(), 2)} to {fixed(ratios.max(), 2)} times, "
        f"and the volume is {fixed(die.volume(vertices) / die.volume(true), 2)} times, what they were."
    )
