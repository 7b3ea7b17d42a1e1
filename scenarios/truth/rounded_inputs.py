"""What it costs engines that they are handed doubles: moments, principal axes, points and blows, rounded once more.

It is no error of theirs, nor is it the floor: a program that reads the file itself need not pay it.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from tumble.scenarios.impulse import RayMissed
from tumble.scenarios.scene import Scene
from tumble.scenarios.truth import Truth, rounded_vertices
from tumble.scenarios.truth.resolution import PRECISIONS, Flight, closed_form
from tumble.scenarios.truth.throw import Throw, read_throw

# The first throws and so many instants, the last that is known among them, tell it well enough.
THROWS, INSTANTS = 8, 32


def input_rounding_error(scene: Scene, answer: Truth) -> float:
    """Return how far rounding the inputs to double precision moves the vertices, at most, within the horizon.

    Parameters
    ----------
    scene
    answer
        its truth

    Returns
    -------
    distance : m
        infinite where a ray hits the body as written, but not as rounded; 0 above a plane, where it is not computed
    """
    if scene.written is None or scene.plane is not None:
        return 0.0
    from mpmath import MPContext

    mp = MPContext()
    rows = np.unique(np.linspace(0, answer.known - 1, INSTANTS).round().astype(int))
    rounded = replace(scene, written=None, times=answer.times[rows], start=scene.start[:THROWS])
    furthest = 0.0
    for row in range(len(rounded.start)):
        throw = read_throw(rounded, row)
        try:
            flight = _simulate(mp, scene, throw)
        except RayMissed:
            return np.inf
        vertices = rounded_vertices(flight.poses, throw.points, flight.bits)
        off = vertices - answer.vertices[rows[: len(vertices)], row]
        furthest = max(furthest, float(np.linalg.norm(off, axis=-1).max()))
    return furthest


def _simulate(mp: Any, scene: Scene, throw: Throw) -> Flight:
    if scene.is_free:
        return closed_form(mp, throw, PRECISIONS[2])
    from tumble.scenarios.truth.forced import simulate

    return simulate(mp, throw)
