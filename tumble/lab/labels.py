"""Names beside the bodies: one label for those that overlap."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from tumble.lab.eye import Box, Eye
from tumble.scenarios.frames import Array

LISTED = 4  # names in a label; of more it says how many
AWAY = 0.22  # from the body to its label, in what the bodies are drawn in
LETTER, LINE, MARGIN = 6.6, 15.0, 8.0  # pixels: of a label's text, and between it and the picture's edge
LEAN = 0.38  # the sine of 22 degrees: nearer to an axis a label is centred beside it
STILL = 0.02  # bodies whose middles are nearer than this have no side to be on


class Label(NamedTuple):
    """Words beside a body: the names of those there, the vertex it points at, (3,), its place, (3,), and its anchor."""

    names: tuple[str, ...]
    words: str
    tip: Array
    place: Array
    anchor: str


def labels(bodies: Mapping[str, Array], apart: float, eye: Eye, solid: str, note: str = "") -> list[Label]:
    """Return a label for each group of bodies that are seen apart, none where all are one.

    bodies: name -> vertices, (n, 3), of all the same number; apart: vertices further from each other than this are seen
    apart; note: below the names of all groups but that of the solid body.  A label lies on the side of its body that is
    away from the others, in the picture.
    """
    groups = grouped(bodies, apart)
    if len(groups) < 2:
        return []
    middles = np.array([bodies[group[0]].mean(axis=0) for group in groups])
    found: list[Label] = []
    taken: list[Array] = []
    for number, group in enumerate(groups):
        aside = middles[number] - np.delete(middles, number, axis=0).mean(axis=0)
        way = np.array([aside @ eye.axes.right, aside @ eye.axes.up])
        if (length := float(np.linalg.norm(way))) > STILL:
            way /= length
        else:
            turn = np.pi / 2 + 2 * np.pi * number / len(groups)
            way = np.array([np.cos(turn), np.sin(turn)])
        outwards = way[0] * eye.axes.right + way[1] * eye.axes.up
        vertices = bodies[group[0]]
        tip = vertices[int(np.argmax(vertices @ outwards))]
        words, anchor = text(group, "" if solid in group else note), anchored(way)
        box = box_of(words, anchor)
        place = placed(eye.moved_inside(tip + AWAY * outwards, box), box, taken, eye, up=bool(way[1] > 0))
        taken.append(eye.covered(place, box))
        found.append(Label(group, words, tip, place, anchor))
    return found


def placed(place: Array, box: Box, taken: Sequence[Array], eye: Eye, *, up: bool) -> Array:
    """Return the place above one, (3,), or else below, at which what is written beside it lies clear of what is taken
    of the picture and in it; above or below first, by `up`."""
    own = eye.covered(place, box)
    found = [place + eye.upwards(place, clear_of(own, taken, up=way)) for way in (up, not up)]
    return next((one for one in found if np.allclose(eye.moved_inside(one, box), one)), found[0])


def clear_of(own: Array, taken: Sequence[Array], *, up: bool) -> float:
    """Return how far up, or down, a rectangle lies clear of others [pixels]; each is left, right, low and high."""
    moved = 0.0
    for left, right, low, high in sorted(taken, key=lambda one: one[2] if up else -one[3]):
        beside = own[1] <= left or own[0] >= right
        if not beside and own[2] + moved < high and own[3] + moved > low:
            moved = high - own[2] if up else low - own[3]
    return moved


def grouped(bodies: Mapping[str, Array], apart: float) -> list[tuple[str, ...]]:
    """Return the names of bodies, those together that are not apart from the first of them."""
    groups: list[list[str]] = []
    for name, vertices in bodies.items():
        near = (group for group in groups if np.abs(bodies[group[0]] - vertices).max() <= apart)
        group = next(near, None)
        if group is None:
            groups.append([name])
        else:
            group.append(name)
    return [tuple(group) for group in groups]


def anchored(way: Array) -> str:
    """Return which point of a label lies at its place, so that it goes on in a direction, (right, up)."""
    right, up = way
    across = "left" if right > LEAN else "right" if right < -LEAN else "center"
    over = "bottom" if up > LEAN else "top" if up < -LEAN else "center"
    return f"{over}-{across}"


def box_of(words: str, anchor: str) -> Box:
    """Return what a label takes of a picture about its place."""
    lines = words.split("\n")
    wide, high = LETTER * max(map(len, lines)), LINE * len(lines)
    over, _, across = anchor.partition("-")
    left = {"left": 0.0, "center": wide / 2, "right": wide}[across]
    below = {"bottom": 0.0, "center": high / 2, "top": high}[over]
    return Box(left + MARGIN, wide - left + MARGIN, below + MARGIN, high - below + MARGIN)


def text(names: Sequence[str], note: str = "") -> str:
    """Return what a label says: a name a line, and a note below."""
    more = len(names) - LISTED
    shown = [*names[: LISTED - 1], f"and {more + 1} more"] if more > 0 else list(names)
    return "\n".join([*shown, *filter(None, [note])])
