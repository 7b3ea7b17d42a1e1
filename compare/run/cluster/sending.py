"""Sends tasks to the workers of a Dask cluster, and takes their results as they come.

Short tasks go in batches, as many as take `BATCH_S`: a batch costs Dask some milliseconds.  When a worker ends, nobody
knows which of the tasks that were sent to it ended it, or whether someone killed it.  Each of them is sent again in a
batch of its own; a task with which another worker ends is sent once more when nothing else runs, so that it has no
neighbour to suffer from; and if that worker ends too, the task is a row `crashed`.
"""

import pickle
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import CancelledError
from dataclasses import dataclass, field
from queue import SimpleQueue
from threading import Condition, Thread
from typing import TYPE_CHECKING, Any

from tumble.compare.run.cluster.given_up import crashed
from tumble.compare.run.cluster.on_worker import Needed, answer
from tumble.compare.run.cluster.workers import COUNT_S, Workers
from tumble.compare.run.process.message import unframed
from tumble.compare.run.running_engines import RunningEngine
from tumble.compare.run.tasks import Task, by_engine

if TYPE_CHECKING:
    from distributed import Client, Future

# Batches that a worker has, running and waiting.
BATCHES_EACH = 2
# Time of a batch [s], and most tasks and bytes of one.
BATCH_S, MOST_TASKS, MOST_BYTES = 0.1, 64, 1 << 20
# Workers that end with a task: it then has no neighbours, and it is given up.
SUSPECT, GIVEN_UP = 2, 3


@dataclass(eq=False)
class Ready:
    """A task that waits for nothing, pickled: the engine that it needs, and what it asks.

    deaths: of workers that it was sent to
    """

    task: Task
    asked: tuple[bytes, bytes]
    deaths: int = 0


def together(tasks: Sequence[Task]) -> Iterator[Task]:
    """Yield those of one engine after each other, which a worker then starts once, unless the next has to wait."""
    own = by_engine(tasks)
    while own:
        engine = next((one for one, left in own.items() if not left[0].is_waiting), next(iter(own)))
        yield own[engine].popleft()
        if not own[engine]:
            del own[engine]


@dataclass
class Sending:
    """The tasks of one call; each is recorded with its result, once.

    numbers: of what is sent, each other than all before.
    """

    client: "Client"
    tasks: Sequence[Task]
    record: Callable[[Task, Any], object]
    numbers: Iterator[int]
    workers: Workers
    _size: int = 1  # of a batch
    _held: int = 0  # tasks that are ready or sent
    _ended: bool = False
    _room: Condition = field(default_factory=Condition)
    _events: "SimpleQueue[Ready | Future | BaseException]" = field(default_factory=SimpleQueue)
    _ready: deque[Ready] = field(default_factory=deque)
    _again: deque[Ready] = field(default_factory=deque)
    _suspect: deque[Ready] = field(default_factory=deque)
    _sent: "dict[str, tuple[Future, list[Ready]]]" = field(default_factory=dict)

    def run(self) -> None:
        """Record the results of all tasks; of some of them where the scheduler ends.  Raises what a task raises."""
        left = len(self.tasks)
        Thread(target=self._make_ready, daemon=True, name="tasks for workers").start()
        try:
            while left:
                event = self._events.get()
                if isinstance(event, BaseException):
                    raise event
                if isinstance(event, Ready):
                    self._ready.append(event)
                else:
                    results = self._results(event)
                    if results is None:
                        return
                    for task, result in results:
                        self.record(task, result)
                    left -= len(results)
                    with self._room:
                        self._held -= len(results)
                        self._room.notify()
                self._fill()
        finally:
            with self._room:
                self._ended = True
                self._room.notify()
            for future, _ in self._sent.values():
                future.cancel()

    def _make_ready(self) -> None:
        """Make each task ready to be sent, which waits for its reference solution; not more than workers can have."""
        import cloudpickle

        needed: dict[RunningEngine, bytes] = {}
        for task in together(self.tasks):
            try:
                with self._room:
                    while not self._ended and self._held >= self._most_sent * self._size:
                        if not self.workers.counted():
                            self._room.wait(COUNT_S)
                    if self._ended:
                        return
                    self._held += 1
                engine = task.running_engine
                if engine not in needed:
                    needed[engine] = pickle.dumps(Needed.of(engine, self.client.id))
                self._events.put(Ready(task, (needed[engine], cloudpickle.dumps(task.ask))))
            except BaseException as error:
                self._events.put(error)
                return

    @property
    def _most_sent(self) -> int:
        """How many batches are running or waiting at most."""
        return BATCHES_EACH * max(1, self.workers.number)

    def _fill(self) -> None:
        """Send what workers have room for."""
        if self._suspect:
            if not self._sent:
                self._send([self._suspect.popleft()])
            return
        while len(self._sent) < self._most_sent and (batch := self._next_batch()):
            self._send(batch)

    def _next_batch(self) -> list[Ready]:
        """Return the tasks to be sent next, none if none is ready."""
        if self._again:
            return [self._again.popleft()]
        batch: list[Ready] = []
        size = 0
        while self._ready and len(batch) < self._size and size < MOST_BYTES:
            batch.append(self._ready.popleft())
            size += sum(map(len, batch[-1].asked))
        return batch

    def _send(self, batch: list[Ready]) -> None:
        # Another command may send the same task at the same time, in another batch.
        key = f"tumble-{self.client.id}-{next(self.numbers)}-{batch[0].task.digest}"
        # As annotations, these would be lost, or break transitions (dask/distributed#4491, #5937).
        future = self.client.submit(answer, [one.asked for one in batch], pure=False, key=key, retries=0)
        self._sent[key] = future, batch
        future.add_done_callback(self._events.put)

    def _results(self, future: "Future") -> list[tuple[Task, Any]] | None:
        """Return the results of a batch, none where its worker ended; None: the scheduler ended."""
        _, batch = self._sent.pop(str(future.key))
        status = future.status  # it may change at any moment
        if status == "lost" and self.client.status == "running":
            # Its worker ended with the results before they were fetched: no task of it ended that worker.
            future.cancel()
            self._again += batch
            return []
        if status not in ("finished", "error"):
            return None  # cancelled, which it is only with the scheduler
        try:
            took_s, frames = future.result()
        except (OSError, CancelledError):
            if status == "error":
                raise
            return None  # the scheduler ended while it handed the result over
        except Exception as error:
            # Also of results that were lost while they were fetched, and whose next worker ended.
            if type(error).__name__ != "KilledWorker":
                raise
            return self._after_death(batch)
        self._size = max(1, min(2 * self._size, MOST_TASKS, int(BATCH_S * len(batch) / max(took_s, 1e-6))))
        return [(one.task, unframed(one.task.kind, data)) for one, data in zip(batch, frames, strict=True)]

    def _after_death(self, batch: list[Ready]) -> list[tuple[Task, Any]]:
        """Have tasks whose worker ended sent again; return the result of one that is given up."""
        for one in batch:
            one.deaths += 1
            if one.deaths < GIVEN_UP:
                (self._suspect if one.deaths == SUSPECT else self._again).append(one)
        return [(one.task, crashed(one.task, one.deaths)) for one in batch if one.deaths == GIVEN_UP]
