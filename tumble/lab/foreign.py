"""A trajectory of somebody's own program as one more ghost, and what `tumble grade` says of it."""

import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from scenarios.format import visible
from scenarios.frames import Array
from scenarios.scene import Scene
from tumble.lab.aside import Errand, Hands


@dataclass(frozen=True, eq=False)
class Foreign:
    """A graded trajectory: instants [s], (S,), vertices [m], (S, K, 3), of which there may be fewer than the body has.

    sentences: what grade says of it, the verdict first.
    """

    name: str
    times: Array
    vertices: Array
    sentences: tuple[str, ...]

    def at(self, time: float) -> Array | None:
        """Return the vertices of its last row until a time [s], None before the first."""
        row = int(np.searchsorted(self.times, time * (1 + 1e-12), side="right")) - 1
        return self.vertices[row] if row >= 0 else None


def loading(hands: Hands, folder: Path, name: str, content: bytes, scene: Scene) -> Errand:
    """Return what will be the graded trajectory of a file's content; it lies in the folder only while it is read.

    Its future raises BadTrajectory, NoTruth, RayMissed.
    """
    aside = tempfile.TemporaryDirectory(prefix=".lab-", dir=folder)
    path = Path(aside.name) / "trajectory.csv"
    path.write_bytes(content)
    errand = hands.send([(graded, path, visible(name), scene)])
    errand.futures[0].add_done_callback(lambda _: aside.cleanup())
    return errand


def graded(path: Path, name: str, scene: Scene) -> Foreign:
    """Grade a file and return it under another name."""
    from compare.grade.columns import BadTrajectory
    from compare.grade.verdict import grade
    from reports.grade import verdict_lines

    try:
        found = grade(path, scene, {})
    except BadTrajectory as error:
        raise BadTrajectory(str(error).replace(str(path), name)) from None
    kept = found.measured.kept
    order = np.argsort(kept.times)
    return Foreign(name, kept.times[order], kept.vertices[order], tuple(verdict_lines(found)))
