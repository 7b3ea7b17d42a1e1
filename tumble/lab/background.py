"""What is computed beside the pages: truths and grades, each in a process that can be ended at any time."""

import threading
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from functools import partial
from typing import Any

from tumble.compare.run.process.caller import Caller, hand_on
from tumble.compare.run.process.process import Died

# Processes that wait for work; and how many there are at most, whatever the number of pages: further jobs wait.
IDLE, MOST = 2, 4
Call = tuple[Callable[..., Any], *tuple[Any, ...]]


def standing() -> Caller:
    """Return a process that has imported what truths need before the first is asked for."""
    caller = Caller()
    caller.submit(get_ready)
    return caller


def get_ready() -> None:
    """Import this module where it runs."""


class Job:
    """Calls that one worker makes in their order: a future for each.

    A job that is stopped before it began is cancelled; one at work ends its process.
    """

    def __init__(self, calls: Sequence[Call], stopped: Callable[["Job"], object]) -> None:
        self.calls = calls
        self.futures: list[Future[Any]] = [Future() for _ in calls]
        self._stopped = stopped

    def stop(self) -> None:
        """End what is not done."""
        self._stopped(self)

    def cancel(self) -> None:
        """Cancel every call that is not done."""
        for future in self.futures:
            future.cancel()

    def begin(self, worker: Caller, done: Callable[["Job"], object]) -> None:
        """Let a worker make the calls; done: called after the last.  Raises Died, and nothing is begun."""
        inner = [worker.submit(*call) for call in self.calls]
        for one, future in zip(inner, self.futures, strict=True):
            one.add_done_callback(partial(hand_on, future=future))
        inner[-1].add_done_callback(lambda _: done(self))


class Workers:
    """Processes that stand ready, so that a throw does not wait for one to be started."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._closed = False
        self._waiting: list[Job] = []
        self._at_work: dict[Job, Caller] = {}
        self._idle = [standing() for _ in range(IDLE)]

    def send(self, calls: Sequence[Call]) -> Job:
        """Let a process that has nothing else to do make these calls, the next that is free where there are MOST."""
        job = Job(calls, self._stop)
        with self._lock:
            self._waiting.append(job)
        self._assign()
        return job

    def close(self) -> None:
        """End all."""
        with self._lock:
            self._closed = True
            waiting, self._waiting = self._waiting, []
            workers, self._idle = [*self._idle, *self._at_work.values()], []
            self._at_work.clear()
        for job in waiting:
            job.cancel()
        for worker in workers:
            worker.end()

    def _assign(self) -> None:
        """Give what waits to workers that are idle, or new ones, and have one more ready where there may be one."""
        while True:
            with self._lock:
                if self._closed or not self._waiting or not (self._idle or len(self._at_work) < MOST):
                    return
                job = self._waiting.pop(0)
                worker = self._at_work[job] = self._idle.pop() if self._idle else standing()
            try:
                job.begin(worker, self._take_back)
            except Died:  # it died while idle, killed or out of memory
                worker.end()
                with self._lock:
                    del self._at_work[job]
                    self._waiting.insert(0, job)
                continue
            with self._lock:
                if not self._idle and not self._closed and len(self._at_work) < MOST:
                    self._idle.append(standing())

    def _take_back(self, job: Job) -> None:
        """Keep a job's worker for the next."""
        with self._lock:
            worker = self._at_work.pop(job, None)
            if worker is not None and not self._closed and len(self._idle) < IDLE:
                self._idle.append(worker)
                worker = None
        if worker is not None:
            worker.end()
        self._assign()

    def _stop(self, job: Job) -> None:
        """End a job and, where it is at work, its worker."""
        with self._lock:
            worker = self._at_work.pop(job, None)
            if job in self._waiting:
                self._waiting.remove(job)
        if worker is not None:
            worker.end()
        job.cancel()
        self._assign()
