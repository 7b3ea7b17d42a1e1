"""Processes that share out calls: one takes those of a kind, the others the rest, and then all what is left."""

from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import CancelledError, Future, ProcessPoolExecutor
from functools import partial
from multiprocessing.context import BaseContext
from typing import Any

Call = Callable[[], Any]
Task = tuple[Call, "Future[Any]"]


class Processes:
    """So many processes, each started with the first call that it gets; initializer and initargs: its first words."""

    def __init__(self, count: int, context: BaseContext, initializer: Callable[..., object], initargs: tuple) -> None:
        self._executors = [
            ProcessPoolExecutor(1, context, initializer=initializer, initargs=initargs) for _ in range(count)
        ]

    def share_out(self, calls: Sequence[Call], of_a_kind: Sequence[bool]) -> list["Future[Any]"]:
        """Return what will be the results of calls; the first process takes those of a kind before any other."""
        futures: list[Future[Any]] = [Future() for _ in calls]
        ordered = sorted(range(len(calls)), key=lambda number: not of_a_kind[number])
        waiting = deque((calls[number], futures[number]) for number in ordered)
        for number, executor in enumerate(self._executors):
            _go_on(executor, waiting.pop if number else waiting.popleft)
        return futures

    def end(self) -> None:
        """Wait for the processes to end; calls that wait are not made."""
        for executor in self._executors:
            executor.shutdown(cancel_futures=True)


def _go_on(executor: ProcessPoolExecutor, take: Callable[[], Task]) -> None:
    """Let a process make the next call that nobody has cancelled, and so on when it is done."""
    while True:
        try:
            call, future = take()
        except IndexError:
            return
        if not future.set_running_or_notify_cancel():
            continue
        try:
            made = executor.submit(call)
        except RuntimeError as ended:  # it has been told to, or has died
            future.set_exception(ended)
            continue
        made.add_done_callback(partial(_tell, future))
        made.add_done_callback(lambda _: _go_on(executor, take))
        return


def _tell(future: "Future[Any]", made: "Future[Any]") -> None:
    """Tell what a call has come to."""
    error = CancelledError() if made.cancelled() else made.exception()
    if error is None:
        future.set_result(made.result())
    else:
        future.set_exception(error)
