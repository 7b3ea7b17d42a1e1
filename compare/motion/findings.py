"""What films show: the numbers of their sentences."""

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np

from tumble.compare.motion.film import Film
from tumble.compare.motion.results import bent, faces
from tumble.compare.tables.shared import FindingRow
from tumble.scenarios.frames import Array
from tumble.scenarios.scene import Body


def film_findings(films: Sequence[Film]) -> Iterator[FindingRow]:
    """Yield how far an edge has come from its true length at the end, of every body that is no longer rigid."""
    for film in films:
        for (engine, method), flight in bent(film).items():
            ratio = bent_edge(flight.vertices[-1, 0], film.scene.body)
            if np.isfinite(ratio):
                yield FindingRow(
                    finding="bent edge",
                    scene=film.scene.name,
                    engine=engine,
                    method=method,
                    value=ratio,
                    unit="1",
                )


def bent_edge(points: Array, body: Body) -> float:
    """Return the length over the true length of the edge for which that is furthest from 1; points [m], (n, 3)."""
    edges = np.array([pair for face in faces(body) for pair in pairwise([*face, face[0]])])
    lengths = np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1)
    ratios = lengths / np.linalg.norm(body.points[edges[:, 0]] - body.points[edges[:, 1]], axis=1)
    return float(ratios[np.argmax(np.abs(np.log(ratios)))])
