"""The findings of films."""

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np

from tumble.compare.motion.film import Film
from tumble.compare.motion.results import deformed, faces
from tumble.compare.tables.shared import FindingRow
from tumble.scenarios.frames import Array
from tumble.scenarios.scene import Body


def film_findings(films: Sequence[Film]) -> Iterator[FindingRow]:
    """Yield the edge stretch at the end of every body that is no longer rigid.

    Parameters
    ----------
    films : of the scenes

    Returns
    -------
    rows of findings.csv
    """
    for film in films:
        for (engine, method), trajectory in deformed(film).items():
            ratio = edge_stretch(trajectory.vertices[-1, 0], film.scene.body)
            if np.isfinite(ratio):
                yield FindingRow(
                    finding="edge stretch",
                    scene=film.scene.name,
                    engine=engine,
                    method=method,
                    value=ratio,
                    unit="1",
                )


def edge_stretch(points: Array, body: Body) -> float:
    """Return length over true length of the most distorted edge; points [m], (n, 3)."""
    edges = np.array([pair for face in faces(body) for pair in pairwise([*face, face[0]])])
    lengths = np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1)
    ratios = lengths / np.linalg.norm(body.points[edges[:, 0]] - body.points[edges[:, 1]], axis=1)
    return float(ratios[np.argmax(np.abs(np.log(ratios)))])
