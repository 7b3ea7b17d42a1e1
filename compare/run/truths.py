"""True answers, worked out beside the flights: of one scene in a thread, of several in processes of their own.

A truth is minutes of pure Python at worst, and two threads of one process do not share the work.
"""

import os
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from dataclasses import fields, replace
from functools import partial
from typing import Any, NamedTuple, Self

import numpy as np

from tumble.compare.run.process.callers import Call, Callers
from tumble.compare.run.progress import Progress, ProgressCallback, no_progress
from tumble.scenarios.impulse import RayMissed
from tumble.scenarios.scene import Scene
from tumble.scenarios.truth import NoTruth, Truth, truth

BY_ROW = ("times", "states", "vertices", "bound", "input_error")


class Answer(NamedTuple):
    """The truth of a scene, or None and the reason there is none."""

    truth: Truth | None
    why: str

    def at(self, scene: Scene) -> "Answer":
        """Return the answer to a scene all of whose rows are among those that were asked for."""
        whole = self.truth
        if whole is None or np.array_equal(whole.times, scene.rows):
            return self
        known = scene.rows[scene.rows <= whole.horizon]
        if known[-1] < scene.times[0]:
            return Answer(None, f"there is no truth at the first sample: {whole.why}")
        rows = np.searchsorted(whole.times, scene.rows)
        parts: dict[str, Any] = {name: getattr(whole, name)[rows] for name in BY_ROW}
        # A scene's horizon is the last of its own rows that is known.
        all_known = len(known) == len(rows)
        parts |= {"horizon": np.inf, "why": ""} if all_known else {"horizon": float(known[-1])}
        return Answer(replace(whole, **parts), "")


def true_answer(
    scene: Scene,
    with_input_error: bool = True,
    tell: Callable[[float], object] = lambda share: None,
    limit_s: float = float("inf"),
) -> Answer:
    """Return the truth, with its input error or without, or why there is none.

    tell: is told what share of it is done; limit_s: wall time that each of its parts may take [s]
    (`tumble.scenarios.truth.deadline`).
    Raises RayMissed where the true body is not in the way of a later ray.
    """
    try:
        return Answer(truth(scene, with_input_error, tell, limit_s), "")
    except NoTruth as reason:
        return Answer(None, str(reason))
    except RayMissed as missed:
        raise RayMissed(f"{scene.name}: {missed}") from missed


class Truths:
    """The reference solutions of scenes, each a Future, in the order of the scenes.

    A context: leaving it ends unfinished work at once, and pending futures get an error (`stop`).

    Parameters
    ----------
    scenes : the scenes
    on_progress : called for each solution that is done, and for a long one with each share, below 1, that is done
    floor : whether to compute `Truth.input_error`, which is needed to evaluate errors but not to show a motion
    limit_s : wall time for each part of each solution [s], counted from the start of that part
    """

    def __init__(
        self,
        scenes: Sequence[Scene],
        on_progress: ProgressCallback = no_progress,
        floor: bool = True,
        limit_s: float = float("inf"),
    ) -> None:
        self._tick, self._floor, self._limit_s = on_progress, floor, limit_s
        self._callers: Callers | None = None
        self._ended = threading.Event()
        self._one_at_a_time = threading.Lock()  # starts processes, or ends them
        self.futures: list[Future[Answer]] = []
        self._asked = list(zip(scenes, self.more(scenes), strict=True))

    def more(self, scenes: Sequence[Scene]) -> list[Future[Answer]]:
        """Return the true answers of more scenes, by the same processes; `answer` does not look among them.

        After `stop` they are cancelled.
        """
        told = [Progress(f"{scene.name} truth", self._tick) for scene in scenes]
        of = partial(true_answer, with_input_error=self._floor, limit_s=self._limit_s)
        if len(scenes) > 1 or self._callers:
            futures = self._share_out(
                scenes, [Call(of, (scene,), tell) for scene, tell in zip(scenes, told, strict=True)]
            )
        else:
            futures = [in_a_thread(partial(of, scene, tell=tell)) for tell, scene in zip(told, scenes, strict=True)]
        self.futures += futures
        for one, future in zip(told, futures, strict=True):
            future.add_done_callback(lambda done, one=one: done.cancelled() or one.end())
        return futures

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    def answer(self, scene: Scene) -> Answer:
        """Return the answer to a scene that was asked for, or to one made of it that has fewer samples.

        Raises what working it out raised, KeyError where nobody asked.
        """
        for asked, future in self._asked:
            if is_same_motion(asked, scene):
                return future.result().at(scene)
        raise KeyError(scene.name)

    def each(self, function: Callable[..., Any], scenes: Sequence[Scene], *more: Sequence[Any]) -> list["Future[Any]"]:
        """Return what will be made of each scene, and of more that is its own, by a function, where the truths are."""
        if self._callers is None:
            return [in_a_thread(partial(function, *given)) for given in zip(scenes, *more, strict=True)]
        calls = [Call(function, given) for given in zip(scenes, *more, strict=True)]
        return self._share_out(scenes, calls)

    def _share_out(self, scenes: Sequence[Scene], calls: Sequence[Call]) -> list["Future[Any]"]:
        """Return what will be the calls' results, those of forces from one process: to load a compiler takes 1 s."""
        with self._one_at_a_time:
            if self._ended.is_set():
                return [cancelled() for _ in calls]
            if self._callers is None:
                self._callers = Callers(os.cpu_count() or 1)
            return self._callers.share_out(calls, [not scene.is_free for scene in scenes])

    def stop(self) -> None:
        """End what is still at work, from any thread; who waits for it gets CancelledError or Died."""
        # Studies that share the truths may all end them at one Ctrl-C, and a process is not ended twice at once.
        with self._one_at_a_time:
            self._ended.set()
            for future in self.futures:
                future.cancel()
            if self._callers is not None:
                self._callers.end()


def is_same_motion(one: Scene, other: Scene) -> bool:
    """Whether two scenes differ in their samples alone: one was made of the other, for two files may share a name."""
    same = (field.name for field in fields(Scene) if field.name not in ("times", "start"))
    return all(getattr(one, name) is getattr(other, name) for name in same) and np.array_equal(one.start, other.start)


def cancelled() -> "Future[Any]":
    """Return what will be no result."""
    future: Future[Any] = Future()
    future.cancel()
    return future


def in_a_thread(function: Callable[[], Any]) -> "Future[Any]":
    """Return what will be a function's result; the thread is no reason for this process to stay."""
    future: Future[Any] = Future()

    def work() -> None:
        try:
            result, error = function(), None
        except BaseException as raised:
            result, error = None, raised
        if future.set_running_or_notify_cancel():
            future.set_exception(error) if error else future.set_result(result)

    threading.Thread(target=work, daemon=True, name="truth").start()
    return future
