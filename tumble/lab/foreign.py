"""A user's own trajectory as one more ghost, and its verdict from `tumble grade`."""

import tempfile
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from tumble.lab.background import Job, Workers
from tumble.scenarios.format import visible
from tumble.scenarios.frames import Array
from tumble.scenarios.scene import Scene


@dataclass(frozen=True, eq=False)
class Foreign:
    """A graded trajectory: instants [s], (S,), and by how much each vertex is off there [m], (S, K, 3), of which there
    may be fewer than the body has.

    verdict: whether it is right and how far off, in a sentence; is_right: the same in short; details: the evidence.
    """

    name: str
    times: Array
    off: Array
    verdict: str
    is_right: bool
    details: tuple[str, ...]

    def at(self, time: float) -> Array | None:
        """Return by how much its vertices are off in its last row until a time [s], (K, 3), None before the first."""
        row = int(np.searchsorted(self.times, time * (1 + 1e-12), side="right")) - 1
        return self.off[row] if row >= 0 else None

    @cached_property
    def errors(self) -> Array:
        """The largest vertex error at each of its instants [m], (S,)."""
        return np.linalg.norm(self.off, axis=-1).max(axis=1)


def loading(workers: Workers, folder: Path, name: str, content: bytes, scene: Scene) -> Job:
    """Return what will be the graded trajectory of a file's content; it lies in the folder only while it is read.

    Its future raises BadTrajectory, NoTruth, RayMissed.
    """
    drafts = tempfile.TemporaryDirectory(prefix=".lab-", dir=folder)
    path = Path(drafts.name) / "trajectory.csv"
    path.write_bytes(content)
    job = workers.send([(graded, path, visible(name), scene)])
    job.futures[0].add_done_callback(lambda _: drafts.cleanup())
    return job


def graded(path: Path, name: str, scene: Scene) -> Foreign:
    """Grade a file and return it under another name."""
    from tumble.compare.grade.grade import (
        CORRECT_TO_DIGITS,
        CORRECT_TO_NOISE,
        CORRECT_TO_RESOLUTION,
        CORRECT_TO_SINGLE,
        grade,
    )
    from tumble.compare.grade.read.columns import BadTrajectory
    from tumble.reports.grade import headline, verdict_lines

    try:
        found = grade(path, scene, {})
    except BadTrajectory as error:
        raise BadTrajectory(str(error).replace(str(path), name)) from None
    sample = found.measured.sample
    order = np.argsort(sample.times)
    is_right = found.verdict in (CORRECT_TO_RESOLUTION, CORRECT_TO_DIGITS, CORRECT_TO_SINGLE, CORRECT_TO_NOISE)
    verdict = headline(found).replace(str(path), name).replace(path.name, name)
    off = (sample.vertices - sample.true)[order]
    return Foreign(name, sample.times[order], off, verdict, is_right, tuple(verdict_lines(found)))
