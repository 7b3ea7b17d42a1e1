"""True answers, worked out beside the flights: of one scene in a thread, of several in processes of their own.

A truth is minutes of pure Python at worst, and two threads of one process do not share the work.
"""

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from contextlib import contextmanager
from functools import partial
from multiprocessing.connection import Connection
from typing import NamedTuple, Self

from scenarios.impulse import RayMissed
from scenarios.scene import Scene
from scenarios.truth import NoTruth, Truth, truth


class Answer(NamedTuple):
    """The truth of a scene, or None and the reason there is none."""

    truth: Truth | None
    why: str


def true_answer(scene: Scene, floor: bool = True) -> Answer:
    """Return the truth, with its floor or without, or why there is none.

    Raises RayMissed where the true body is not in the way of a later ray.
    """
    try:
        return Answer(truth(scene, floor), "")
    except NoTruth as reason:
        return Answer(None, str(reason))
    except RayMissed as missed:
        raise RayMissed(f"{scene.name}: {missed}") from missed


class Truths:
    """The true answers of scenes, each a Future, in the order of the scenes.

    A context: when it is left what is still at work ends at once, and who waits for it is told (`stop`).
    tick: told of every truth as it is done; floor: whether the truths are to judge by, or only to be seen.
    """

    def __init__(
        self, scenes: Sequence[Scene], tick: Callable[[str], object] = lambda what: None, floor: bool = True
    ) -> None:
        self._pool: ProcessPoolExecutor | None = None
        if len(scenes) > 1:
            spawn = multiprocessing.get_context("spawn")
            # Its far end closes with this process, however that ends.
            self._far_end, self._lifeline = spawn.Pipe(duplex=False)
            count = min(os.cpu_count() or 1, len(scenes))
            with safe_path():
                self._pool = ProcessPoolExecutor(count, spawn, initializer=end_with, initargs=(self._far_end,))
                self.futures = [self._pool.submit(true_answer, scene, floor) for scene in scenes]
        else:
            self.futures = [in_a_thread(partial(true_answer, floor=floor), scene) for scene in scenes]
        for scene, future in zip(scenes, self.futures, strict=True):
            future.add_done_callback(lambda done, name=scene.name: done.cancelled() or tick(f"{name} truth"))

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    def stop(self) -> None:
        """End what is still at work; who waits for it gets CancelledError or BrokenProcessPool."""
        for future in self.futures:
            future.cancel()
        if self._pool is not None:
            self._lifeline.close()
            self._pool.shutdown(cancel_futures=True)
            self._far_end.close()


@contextmanager
def safe_path() -> Iterator[None]:
    """Let no interpreter that is started meanwhile run files of the working folder."""
    before = os.environ.get("PYTHONSAFEPATH")
    os.environ["PYTHONSAFEPATH"] = "1"
    try:
        yield
    finally:
        if before is None:
            del os.environ["PYTHONSAFEPATH"]
        else:
            os.environ["PYTHONSAFEPATH"] = before


def in_a_thread(function: Callable[[Scene], Answer], scene: Scene) -> "Future[Answer]":
    """Return what will be a function's result; the thread is no reason for this process to stay."""
    future: Future[Answer] = Future()

    def work() -> None:
        try:
            result, error = function(scene), None
        except BaseException as raised:
            result, error = None, raised
        if future.set_running_or_notify_cancel():
            future.set_exception(error) if error else future.set_result(result)  # type: ignore[arg-type]

    threading.Thread(target=work, daemon=True, name=f"truth of {scene.name}").start()
    return future


def end_with(lifeline: Connection) -> None:
    """Let this process end when the other end of the lifeline does; Ctrl-C is for that process to handle."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)

    def watch() -> None:
        try:
            lifeline.recv_bytes()
        except (EOFError, OSError):
            os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
