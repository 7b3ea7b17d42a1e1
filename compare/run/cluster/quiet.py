"""Run times measured on a worker of a cluster that does nothing else: all contestants of a scene are one task.

Such a worker has the Dask resource `quiet=1`, and one such task at a time.  Without such a worker run times are
measured here: ratios never cross machines.
"""

import logging
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from itertools import count
from threading import Event
from time import monotonic
from typing import TYPE_CHECKING, Any

from tumble.compare.run.cluster.on_quiet_worker import Measured, measure, where
from tumble.compare.run.cluster.on_worker import Needed
from tumble.compare.run.digest import NoValue, digest
from tumble.compare.run.execution import EXECUTION
from tumble.compare.run.process.message import unframed
from tumble.compare.run.status import Failure
from tumble.compare.run.timing import machine_load
from tumble.compare.run.timing.readings import Sampling
from tumble.compare.run.timing.timing import Cost, Load

if TYPE_CHECKING:
    from distributed import Client, Future

RESOURCE = {"quiet": 1}
# A task whose worker ended is sent this many times.
ATTEMPTS = 2
# A quiet worker that ended has this long to come again [s].
WAIT_S, LOOK_S = 20.0, 0.5

log = logging.getLogger(__name__)


@dataclass
class QuietWorkers:
    """Measures run times on the quiet workers of a scheduler.

    Parameters
    ----------
    client : connected to it
    """

    client: "Client"
    _said: set[str] = field(default_factory=set)
    _numbers: Iterator[int] = field(default_factory=count)
    _is_known: bool = False

    def __call__(self, loads: Mapping[str, Load], sampling: Sampling) -> dict[str, Cost | Failure] | None:
        """Return what each load costs, all measured in one task; None: to be measured here.  Raises BadCluster."""
        if not loads:
            return {}
        engines = {load.running_engine.title: load.running_engine for load in loads.values()}
        scene = ", ".join(dict.fromkeys(load.scene.name for load in loads.values()))
        workers = self._workers()
        try:
            question = [[[key, load.running_engine.identity, as_sent(load)] for key, load in loads.items()], sampling]
            needed = {title: Needed.of(engine, self.client.id) for title, engine in engines.items()}
        except NoValue as why:
            return self._here(str(why))
        self._is_known = self._is_known or bool(workers)
        if not self._is_known:
            return self._here("no worker has the resource quiet=1")
        execution, key = EXECUTION.get(), (scene, "times")
        machines: dict[str, str] = self.client.run(where, workers=workers, on_error="ignore")  # type: ignore[assignment]
        for machine in sorted({*machines.values()}):
            if execution.caches and (found := execution.find(digest([question, machine]), key, Measured)):
                return self._there(scene, found)
        found = self._measured(needed, loads, sampling)
        if isinstance(found, str):
            return self._here(found)
        if execution.caches:
            execution.save(digest([question, found.where]), key, found)
        return self._there(scene, found)

    def _measured(self, needed: dict[str, Needed], loads: Mapping[str, Load], sampling: Sampling) -> Measured | str:
        """Return what a quiet worker measured, or why none did."""
        import cloudpickle

        payload = cloudpickle.dumps({key: (load.running_engine.title, as_sent(load)) for key, load in loads.items()})
        for _ in range(ATTEMPTS):
            future = self.client.submit(
                measure, needed, payload, sampling, resources=RESOURCE, pure=False, retries=0,
                key=f"tumble-times-{self.client.id}-{next(self._numbers)}-{digest([*loads])}",
            )  # fmt: skip
            try:
                if not self._awaited(future):
                    return f"no worker with the resource quiet=1 came within {WAIT_S:g} s"
                if future.status == "finished":
                    return unframed(Measured, future.result())
                if future.status != "error":
                    return "the scheduler is gone"
                error = future.exception()
                if type(error).__name__ != "KilledWorker":
                    raise error  # type: ignore[misc]
            finally:
                future.cancel()
        return f"{ATTEMPTS} workers ended while they measured"

    def _awaited(self, future: "Future") -> bool:
        """Wait until a task is done; return whether it is, not where its workers are gone for too long."""
        done, last = Event(), monotonic()
        future.add_done_callback(lambda _: done.set())
        while not done.wait(LOOK_S):
            if self._workers():
                last = monotonic()
            elif monotonic() - last > WAIT_S:
                return False
        return True

    def _workers(self) -> list[str]:
        """Return the addresses of quiet workers; none where the scheduler is gone."""

        # `scheduler_info` tells of five workers in some releases of Dask.
        def found(dask_scheduler: Any = None) -> list[str]:
            workers = dask_scheduler.workers.items()
            return [address for address, worker in workers if worker.resources.get("quiet", 0) >= 1]

        with suppress(OSError):
            return self.client.run_on_scheduler(found)  # type: ignore[return-value]
        return []

    def _there(self, scene: str, found: Measured) -> dict[str, Cost | Failure]:
        self._say(f"run times are measured on {found.where}, one scene at a time: ratios never cross machines")
        machine_load.measured.setdefault(scene, []).append(f"{found.where}, {found.under}")
        return found.costs

    def _here(self, why: str) -> None:
        self._say(f"run times are measured here, alone, and not on workers, for {why}: ratios never cross machines")

    def _say(self, words: str) -> None:
        """Log once."""
        if words not in self._said:
            self._said.add(words)
            log.info(words)


def as_sent(load: Load) -> Any:
    """Return a load without its engine, which has another process on a worker."""
    return replace(load, running_engine=None)  # type: ignore[arg-type]
