"""A command's connection to the workers of a Dask cluster, on which it runs its tasks.

Every worker has engines of its own, in processes as here, and the reference solutions that a task waits for are sent
with it.  Where the scheduler ends, the tasks that are left run here.
"""

import logging
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import dataclass, field
from itertools import count
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from tumble.compare.run.cluster.on_worker import BadCluster, end_engines
from tumble.compare.run.cluster.own_workers import FEW_MESSAGES, own_workers
from tumble.compare.run.cluster.sending import Sending
from tumble.compare.run.cluster.workers import Workers
from tumble.compare.run.tasks import Task, work
from tumble.compare.run.truths import Truths

if TYPE_CHECKING:
    from distributed import Client

# A scheduler and its first worker have so long to answer [s].
CONNECT_S = 20

log = logging.getLogger(__name__)


@dataclass
class Cluster:
    """The workers of a scheduler; client: connected to it; workers: how many there are."""

    client: "Client"
    workers: Workers
    _numbers: Iterator[int] = field(default_factory=count)

    def work(
        self,
        tasks: Sequence[Task],
        truths: Truths | None = None,
        finished: Callable[[Task, Any], object] = lambda task, result: None,
    ) -> list[Any]:
        """Return the results of all tasks, in their order; as `tasks.work`.  Raises BadCluster."""
        sent = [task for task in tasks if task.digest]
        results: dict[Task, Any] = {}

        def record(task: Task, result: Any) -> None:
            results[task] = result
            finished(task, result)

        try:
            Sending(self.client, sent, record, self._numbers, self.workers).run()
        except BaseException:
            if truths:
                truths.stop()
            raise
        left = [task for task in tasks if task not in results]
        if len(left) > len(tasks) - len(sent):
            self.workers.number = 0
            log.info(f"the scheduler is gone: {len(left)} of {len(tasks)} tasks run here")
        work(left, truths, record)
        return [results[task] for task in tasks]


@contextmanager
def connected(
    address: str | None, workers: int | None = None, tls: Mapping[str, str] = MappingProxyType({})
) -> Iterator[Cluster]:
    """Give the workers of a scheduler, or workers of our own.

    Parameters
    ----------
    address : of a scheduler, checked (`address.check_address`); None: workers of our own
    workers : number of our own
    tls : files of authority, certificate and key (ca, cert, key)

    Yields
    ------
    the workers

    Raises
    ------
    BadCluster : they cannot be used
    """
    try:
        import distributed
        from dask import config
    except ImportError as error:
        raise BadCluster(f"{error}: Dask is an extra: type `pip install '.[dask]'`") from None
    for name in ("distributed", "distributed.client"):  # what they log of dead workers is dealt with here
        logging.getLogger(name).setLevel(logging.CRITICAL)
    security = None
    if tls:
        files: dict[str, Any] = {"tls_ca_file": tls["ca"], "tls_client_cert": tls["cert"], "tls_client_key": tls["key"]}
        security = distributed.Security(require_encryption=True, **files)
    with nullcontext(address) if address else own_workers(workers or 1) as scheduler:
        try:
            with config.set(FEW_MESSAGES):
                client = distributed.Client(scheduler, timeout=CONNECT_S, security=security, set_as_default=False)
        except (OSError, TimeoutError, ValueError, RuntimeError) as error:
            why = " ".join(str(error).split())
            raise BadCluster(f"--scheduler {scheduler}: cannot be reached: {why}") from None
        try:
            client.run_on_scheduler(first_death_reported())
            found = Workers(client)
            with suppress(TimeoutError):
                client.wait_for_workers(1, timeout=CONNECT_S)
            if not found.counted():
                raise BadCluster(f"--scheduler {scheduler}: no worker came within {CONNECT_S} s")
            log.info(f"{found} of {address or 'this machine'}; dashboard: {dashboard_of(client)}")
            yield Cluster(client, found)
        finally:
            if client.status == "running":
                client.run(end_engines, client.id, on_error="ignore")
            client.close()


def first_death_reported() -> Callable[..., None]:
    """Return what makes a scheduler report a task of ours as soon as a worker ends with it.

    Its setting `allowed-failures` is of everyone's tasks.  A local function, sent whole: a scheduler may lack Tumble.
    """

    def report(dask_scheduler: Any = None) -> None:
        from distributed.diagnostics.plugin import SchedulerPlugin

        class Reporting(SchedulerPlugin):
            def transition(self, key: object, start: str, finish: str, *args: object, **kwargs: object) -> None:
                if finish == "processing" and str(key).startswith("tumble-"):
                    dask_scheduler.tasks[key].suspicious = dask_scheduler.allowed_failures

        dask_scheduler.add_plugin(Reporting(), name="tumble", idempotent=True)

    return report


def dashboard_of(client: "Client") -> str:
    """Return the link of Dask's dashboard, or why there is none."""

    # A scheduler without bokeh, or with --no-dashboard, serves some pages too, but not these.
    def serves(dask_scheduler: Any = None) -> bool:
        return bool(dask_scheduler.http_application.applications)

    link = client.run_on_scheduler(serves) and client.dashboard_link
    return link or "none, bokeh is missing or it is switched off"
