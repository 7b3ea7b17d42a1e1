"""The result of a task that is given up, because workers end with it: that of an engine that crashes."""

from dataclasses import replace
from typing import Any

from tumble.compare.run.running_engines import RunningEngine
from tumble.compare.run.status import Failure, Status
from tumble.compare.run.tasks import Task
from tumble.compare.run.worker import Worker


def crashed(task: Task, deaths: int) -> Any:
    """Return the result of a task whose engine crashes at whatever is asked; deaths: of workers that ran it."""
    failure = Failure(Status.CRASHED, f"{deaths} workers ended while they ran it", process_died=True)
    return task.ask(replace(task.running_engine, worker=Lost(task.running_engine, failure)))


class Lost(Worker):
    """In place of an engine's process: all that is asked of it has one answer."""

    def __init__(self, like: RunningEngine, failure: Failure) -> None:
        self.engine, self._failure = like.engine, failure
        self.time_limit, self.memory_limit = like.worker.time_limit, like.worker.memory_limit

    @property
    def alive(self) -> bool:
        """Whether it answers."""
        return True

    def _ask(self, question: object, hint: Any, most_bytes: int = 0) -> Failure:
        return self._failure
