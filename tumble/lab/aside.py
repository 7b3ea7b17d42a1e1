"""What is worked out beside the pages: truths and grades, each in a process that can be ended at any time."""

import multiprocessing
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from typing import Any

from compare.run.truths import end_with, safe_path

IDLE = 2  # processes that wait for work
Call = tuple[Callable[..., Any], *tuple[Any, ...]]


class Hand:
    """A process that does one thing after the other.  It ends with this process, however that ends."""

    def __init__(self) -> None:
        spawn = multiprocessing.get_context("spawn")
        self._far_end, self._lifeline = spawn.Pipe(duplex=False)
        self._pool = ProcessPoolExecutor(1, spawn, initializer=end_with, initargs=(self._far_end,))
        with safe_path():
            self._pool.submit(come_up)

    def submit(self, function: Callable[..., Any], *arguments: Any) -> "Future[Any]":
        """Return what will be the function's result.  Raises BrokenProcessPool where the process is gone."""
        return self._pool.submit(function, *arguments)

    def close(self) -> None:
        """End it at once, whatever it is at; who waits for that gets CancelledError or BrokenProcessPool."""
        self._lifeline.close()
        self._pool.shutdown(wait=False, cancel_futures=True)


def come_up() -> None:
    """Import this module where it runs, and with it what truths need, before the first is asked for."""


class Errand:
    """Calls that one hand does in their order: a future for each."""

    def __init__(self, hand: Hand, calls: Sequence[Call], done: Callable[[Hand], object]) -> None:
        self.futures = [hand.submit(*call) for call in calls]
        self._hand = hand
        self._lock, self._is_over = threading.Lock(), False
        self.futures[-1].add_done_callback(lambda _: self._end(done))

    def stop(self) -> None:
        """End the process if it is still at work."""
        self._end(Hand.close)

    def _end(self, leave: Callable[[Hand], object]) -> None:
        with self._lock:
            was_over, self._is_over = self._is_over, True
        if not was_over:
            leave(self._hand)


class Hands:
    """Processes that stand ready, so that a throw does not wait for one to be started."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._closed = False
        self._idle = [Hand() for _ in range(IDLE)]

    def send(self, calls: Sequence[Call]) -> Errand:
        """Let a process that has nothing else to do make these calls."""
        while True:
            with self._lock:
                hand = self._idle.pop() if self._idle else Hand()
            try:
                errand = Errand(hand, calls, self._take_back)
            except BrokenProcessPool:  # it died while it was idle, of memory or by somebody's hand
                hand.close()
                continue
            with self._lock:
                if not self._idle and not self._closed:
                    self._idle.append(Hand())
            return errand

    def _take_back(self, hand: Hand) -> None:
        with self._lock:
            if not self._closed and len(self._idle) < IDLE:
                self._idle.append(hand)
                return
        hand.close()

    def close(self) -> None:
        """End those that are idle; who sent the others ends them."""
        with self._lock:
            self._closed = True
            idle, self._idle = self._idle, []
        for hand in idle:
            hand.close()
