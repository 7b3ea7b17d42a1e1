"""True answers, worked out beside the flights: of one scene in a thread, of several in processes of their own.

A truth is minutes of pure Python at worst, and two threads of one process do not share the work.
"""

import os
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from contextlib import suppress
from dataclasses import dataclass, fields, replace
from functools import partial
from typing import Any, NamedTuple, Self

import numpy as np

from tumble.compare.run.digest import digest
from tumble.compare.run.execution import EXECUTION
from tumble.compare.run.process import fork_server
from tumble.compare.run.process.callers import Call, Callers
from tumble.compare.run.progress import Progress, ProgressCallback, no_progress
from tumble.scenarios.frames import Array
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


@dataclass(frozen=True, eq=False)
class SavedTruth:
    """A truth as it is saved: that of a scene without contact, whose events are no plain values."""

    times: Array
    states: Array
    vertices: Array
    bound: Array
    input_error: Array
    how: str
    horizon: float
    why: str

    @classmethod
    def of(cls, truth: Truth) -> "SavedTruth":
        """Return a truth without contact."""
        return cls(**{field.name: getattr(truth, field.name) for field in fields(cls)})

    @property
    def truth(self) -> Truth:
        """The truth."""
        return Truth(**{field.name: getattr(self, field.name) for field in fields(self)})


class Awaited(Future[Answer]):
    """The true answer of a scene, begun at the latest when it is waited for; identity: all that it depends on."""

    def __init__(self, scene: Scene, identity: Sequence[object], begin: Callable[["Awaited"], object]) -> None:
        super().__init__()
        self.scene, self.identity, self._begin = scene, identity, begin

    @property
    def digest(self) -> str:
        """The digest by which it is saved."""
        return digest(self.identity)

    def __reduce__(self) -> tuple[Callable[[Answer], "Future[Answer]"], tuple[Answer]]:
        """Wait for the answer: what is sent to another process has it."""
        return known, (self.result(),)

    def result(self, timeout: float | None = None) -> Answer:
        """Return the answer; as of a Future."""
        self._begin(self)
        return super().result(timeout)


def known(answer: Answer) -> "Future[Answer]":
    """Return what has an answer already."""
    future: Future[Answer] = Future()
    future.set_result(answer)
    return future


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
        self._execution = EXECUTION.get()
        self._callers: Callers | None = None
        self._ended = threading.Event()
        self._one_at_a_time = threading.Lock()  # starts processes, or ends them
        self.futures: list[Awaited] = []
        self.begun: list[Awaited] = []
        self._asked = list(zip(scenes, self.more(scenes), strict=True))

    def more(self, scenes: Sequence[Scene]) -> list[Awaited]:
        """Return the true answers of more scenes, by the same processes; `answer` does not look among them.

        Those that are saved are there at once; those of other shards are begun when they are waited for.
        After `stop` they are cancelled.
        """
        futures = [
            Awaited(scene, ["truth", scene, self._floor, self._limit_s], lambda one: self._begin([one]))
            for scene in scenes
        ]
        self.futures += futures
        own = self._execution.own(len(scenes))
        self._begin([one for number, one in enumerate(futures) if not self._found(one) and number in own])
        return futures

    def _found(self, one: Awaited) -> bool:
        """Give an answer that is saved; return whether there is one."""
        saved = self._execution.find(one.digest, self._key(one), SavedTruth) if self._execution.caches else None
        if saved is not None:
            one.set_running_or_notify_cancel()
            one.set_result(Answer(saved.truth, ""))
            self._tick(" ".join(self._key(one)))
            self.begun.append(one)
        return saved is not None

    def _begin(self, waiting: Sequence[Awaited]) -> None:
        """Begin to compute answers, those that are not begun yet."""
        with self._one_at_a_time:
            waiting = [one for one in waiting if one not in self.begun]
            self.begun += waiting
        if not waiting:
            return
        told = {one: Progress(f"{one.scene.name} truth", self._tick) for one in waiting}
        for one in waiting:
            one.add_done_callback(lambda done, one=one: done.cancelled() or told[one].end())
            if self._execution.caches:
                one.add_done_callback(lambda _, one=one: self._save(one))
        of = partial(true_answer, with_input_error=self._floor, limit_s=self._limit_s)
        several = len(waiting) > 1 or self._callers or len(self.futures) > len(self.begun)
        if several or fork_server.running:
            self._share_out(waiting, [Call(of, (one.scene,), told[one]) for one in waiting])
        else:
            for one in waiting:
                one.cancel() if self._ended.is_set() else in_a_thread(partial(of, one.scene, tell=told[one]), one)

    def _save(self, one: Awaited) -> None:
        """Save the truth that was computed, without contact: a failure to do so loses nothing but time."""
        # As of a Future: it is done, and begun.
        true = None if one.cancelled() or one.exception() else Future.result(one).truth
        if true is not None and not true.contacts:
            with suppress(OSError):
                self._execution.save(one.digest, self._key(one), SavedTruth.of(true))

    @staticmethod
    def _key(one: Awaited) -> tuple[str, str]:
        return one.scene.name, "truth"

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

    def each(
        self, function: Callable[..., Any], scenes: Sequence[Scene], *more: Sequence[Any]
    ) -> Sequence["Future[Any]"]:
        """Return what will be made of each scene, and of more that is its own, by a function, where the truths are."""
        futures = [Awaited(scene, (), lambda one: None) for scene in scenes]
        calls = [Call(function, given) for given in zip(scenes, *more, strict=True)]
        if self._callers is None:
            for call, future in zip(calls, futures, strict=True):
                in_a_thread(partial(function, *call.arguments), future)
        else:
            self._share_out(futures, calls)
        return futures

    def _share_out(self, futures: Sequence[Awaited], calls: Sequence[Call]) -> None:
        """Begin calls of scenes, a few of them that are compiled in one process: to load a compiler takes 1 s."""
        with self._one_at_a_time:
            if self._ended.is_set():
                for future in futures:
                    future.cancel()
                return
            if self._callers is None:
                compiled = any(is_compiled(one.scene) for one in self.futures)
                self._callers = Callers(os.cpu_count() or 1, (__name__, *(["numba"] if compiled else [])))
            self._callers.share_out(calls, [is_compiled(one.scene) for one in futures], futures)

    def stop(self) -> None:
        """End what is still at work, from any thread; who waits for it gets CancelledError or Died."""
        # Studies that share the truths may all end them at one Ctrl-C, and a process is not ended twice at once.
        with self._one_at_a_time:
            self._ended.set()
            for future in self.futures:
                future.cancel()
            if self._callers is not None:
                self._callers.end()


class Answered(NamedTuple):
    """A scene and its truth.

    Parameters
    ----------
    scene
    truth : None if there is none
    """

    scene: Scene
    truth: Truth | None


def answered(scenes: Sequence[Scene], limit_s: float) -> list[Answered]:
    """Return scenes with their truths.

    Parameters
    ----------
    scenes
    limit_s : wall time of each part of a truth [s]

    Returns
    -------
    one for each scene

    Raises
    ------
    RayMissed : a ray of a scene does not meet its body
    """
    with Truths(scenes, limit_s=limit_s) as truths:
        return [Answered(scene, truths.answer(scene).truth) for scene in scenes]


def is_compiled(scene: Scene) -> bool:
    """Whether kernels compute the truth of a scene, or its readings."""
    return bool(scene.sensors) or not scene.is_free


def is_same_motion(one: Scene, other: Scene) -> bool:
    """Whether two scenes differ in their samples alone: one was made of the other, for two files may share a name."""
    same = (field.name for field in fields(Scene) if field.name not in ("times", "start"))
    return all(getattr(one, name) is getattr(other, name) for name in same) and np.array_equal(one.start, other.start)


def in_a_thread(function: Callable[[], Any], future: "Future[Any]") -> None:
    """Give a future a function's result; the thread is no reason for this process to stay."""

    def work() -> None:
        try:
            result, error = function(), None
        except BaseException as raised:
            result, error = None, raised
        if future.set_running_or_notify_cancel():
            future.set_exception(error) if error else future.set_result(result)

    threading.Thread(target=work, daemon=True, name="truth").start()
