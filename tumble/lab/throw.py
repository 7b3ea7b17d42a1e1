"""One throw: the truth and all contestants, computed at once, each shown as soon as it is there."""

import threading
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from dataclasses import replace
from functools import partial

import numpy as np

from tumble.compare.comparison.against_truth import Comparison, lost_m
from tumble.compare.judge.errors import Run
from tumble.compare.run.engines.registry import BadEngine
from tumble.compare.run.flight import Trajectory
from tumble.compare.run.running_engines import Halted
from tumble.compare.run.status import Failure, Status
from tumble.lab.pool import Contestant, Lease, Pool
from tumble.scenarios.frames import Array
from tumble.scenarios.scene import Scene
from tumble.scenarios.truth import NoTruth, Truth, truth

# Instants of a free flight's truth that are computed in one call: few at first, so that the body can begin to move.
FIRST, MOST = 5, 40


class Throw:
    """The results of one scene as they come in, the first row of each at t = 0.

    answers: contestant -> its trajectory, or why there is none; no entry while it runs.  true_states (R, 13) and
    true_vertices (R, n, 3) [m] are NaN where the truth is not there yet; why_no_truth says that it will not be, and
    why_truth_ends that it will not be later than truth_ends [s].
    changed: called, from any thread, when something came in.
    """

    def __init__(
        self, scene: Scene, contestants: Sequence[Contestant], pool: Pool, changed: Callable[[], object]
    ) -> None:
        self.scene, self.contestants = scene, tuple(contestants)
        self.answers: dict[Contestant, Trajectory | Failure] = {}
        self.true_states = np.full((len(scene.rows), 13), np.nan)
        self.true_vertices = np.full((len(scene.rows), *scene.body.points.shape), np.nan)
        self.true_limit = np.full(len(scene.rows), np.nan)
        self.why_no_truth = self.why_truth_ends = ""
        self.truth_ends = np.inf
        self._pool, self._changed = pool, changed
        self._lock = threading.Lock()
        self._leases: set[Lease] = set()
        self._stopped = False
        self._parts = parts(len(scene.times)) if scene.is_free else [slice(0, len(scene.times))]
        self._pieces: dict[int, Truth] = {}
        for engine in dict.fromkeys(contestant.engine for contestant in contestants):
            threading.Thread(target=self._run, args=(engine,), daemon=True).start()
        calls = [(truth, replace(scene, times=scene.times[part])) for part in self._parts]
        self._truth = pool.background.send(calls)
        for number, future in enumerate(self._truth.futures):
            future.add_done_callback(partial(self._take_truth, number))

    def stop(self) -> None:
        """Stop all that still runs; later results are dropped."""
        with self._lock:
            self._stopped = True
            for lease in self._leases:
                lease.halt()
        self._truth.stop()

    @property
    def known(self) -> int:
        """How many rows have a truth: those before the first that has none."""
        missing = np.isnan(self.true_states[:, 0])
        return int(np.argmax(missing)) if missing.any() else len(missing)

    @property
    def is_complete(self) -> bool:
        """Whether nothing more will come in."""
        return self.truth_is_complete and len(self.answers) == len(self.contestants)

    @property
    def truth_is_complete(self) -> bool:
        """Whether the whole truth is there, or why there is none."""
        return bool(self.why_no_truth) or len(self._pieces) == len(self._parts)

    def trajectories(self) -> dict[Contestant, Trajectory]:
        """Return the trajectories that are there."""
        answers = dict(self.answers)
        return {one: answers[one] for one in self.contestants if isinstance(answers.get(one), Trajectory)}  # type: ignore[misc]

    def comparison(self, scene: Scene | None = None) -> Comparison:
        """Return the comparison of what is there, as of `tumble compare`; scene: the same under its saved name."""
        scene = scene or self.scene
        whole = None if self.why_no_truth or not self.truth_is_complete else self._whole_truth()
        waiting = Failure(Status.TIMEOUT, "still running when the file was saved")
        runs = (
            Run(
                scene=scene,
                engine=one.title,
                method=one.method,
                dt=scene.step,
                answer=self.answers.get(one, waiting),
                truth=whole,
                tolerance=self._pool.tolerance(one),
            )
            for one in self.contestants
        )
        why = self.why_no_truth or "still being computed"
        roles = {one.name: self._pool.role(one) for one in self.contestants}
        return Comparison(
            scene=scene, truth=whole, why_no_truth=why, runs=tuple(runs), lost_m=lost_m(scene, whole), roles=roles
        )

    def _whole_truth(self) -> Truth:
        pieces = [self._pieces[number] for number in range(len(self._parts))]

        def rows(name: str) -> Array:
            first, *others = (getattr(piece, name) for piece in pieces)
            # Every piece begins with a row for t = 0.
            return np.concatenate([first, *(other[1:] for other in others)])

        parts = {name: rows(name) for name in ("times", "states", "vertices", "bound", "input_error")}
        # The first horizon is that of the whole.
        ends = min(pieces, key=lambda piece: piece.horizon)
        return replace(ends, how=" / ".join(dict.fromkeys(piece.how for piece in pieces)), **parts)

    def _take_truth(self, number: int, future: "Future[Truth]") -> None:
        """Take in a part of the truth; a callback of its future."""
        if future.cancelled():
            return
        error = future.exception()
        with self._lock:
            if self._stopped:
                return
            if error is not None:
                self.why_no_truth = str(error) if isinstance(error, NoTruth) else f"{type(error).__name__}: {error}"
            else:
                piece, part = future.result(), self._parts[number]
                rows = slice(0 if number == 0 else part.start + 1, part.stop + 1)
                count = rows.stop - rows.start
                self.true_states[rows] = piece.states[-count:, 0]
                self.true_vertices[rows] = piece.vertices[-count:, 0]
                self.true_limit[rows] = piece.resolution[-count:, 0]
                if not np.isfinite(piece.states[-1]).all() and piece.horizon < self.truth_ends:
                    self.truth_ends, self.why_truth_ends = piece.horizon, piece.why
                self._pieces[number] = piece  # last: with it the truth is complete
        self._changed()

    def _run(self, engine: str) -> None:
        """Run every method of one engine, one after the other, in one process."""
        own = [one for one in self.contestants if one.engine == engine]
        try:
            lease = self._pool.lease(engine, [one.method for one in own], lambda: not self._stopped)
        except BadEngine as error:
            lease = Failure(Status.CRASHED, str(error))
        if lease is None:
            return
        if isinstance(lease, Failure):
            for contestant in own:
                self._take(contestant, lease)
            return
        with self._lock:
            self._leases.add(lease)
        try:
            for contestant in own:
                if self._stopped:
                    return
                self._take(*self._answer(lease, self._renamed(contestant, self._pool.resolved(contestant))))
        except Halted:
            pass
        finally:
            with self._lock:
                self._leases.discard(lease)
            self._pool.take_back(lease)

    def _answer(self, lease: Lease, contestant: Contestant) -> tuple[Contestant, Trajectory | Failure]:
        """Run a contestant, or what its engine has for the plane or the forces that the method does not support."""
        answer = lease.run(self.scene, contestant.method)
        other = None if self.scene.is_free else self._pool.instead(contestant, self.scene)
        if isinstance(answer, Failure) and answer.status is Status.SKIPPED and other:
            return self._renamed(contestant, other), lease.run(self.scene, other.method)
        return contestant, answer

    def _renamed(self, contestant: Contestant, other: Contestant) -> Contestant:
        """Put another contestant into the place of one."""
        with self._lock:
            self.contestants = tuple(dict.fromkeys(other if one == contestant else one for one in self.contestants))
        return other

    def _take(self, contestant: Contestant, answer: Trajectory | Failure) -> None:
        with self._lock:
            if self._stopped:
                return
            self.answers[contestant] = answer
        self._changed()


def parts(count: int) -> list[slice]:
    """Return the instants of a truth in parts: few first, then more at once."""
    found, start, length = [], 0, FIRST
    while start < count:
        found.append(slice(start, min(start + length, count)))
        start, length = start + length, min(2 * length, MOST)
    return found
