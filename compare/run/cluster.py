"""The workers of a Dask cluster: tasks run there, and what is saved is saved at home.

Every worker has engines of its own, in processes as here, and the reference solutions that a task waits for are sent
with it.  Where the scheduler ends, the tasks that are left run here.
"""

import logging
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from ipaddress import ip_address
from itertools import count
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

from tumble.compare.run.on_worker import BadCluster, end_engines
from tumble.compare.run.sending import Sending, Workers
from tumble.compare.run.tasks import Task, work
from tumble.compare.run.truths import Truths

if TYPE_CHECKING:
    from distributed import Client

CONNECT_S = 20
SETTINGS = {
    "distributed.comm.timeouts.connect": f"{CONNECT_S}s",
}

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
    address: str | None, workers: int | None, tls: Mapping[str, str], is_insecure: bool = False
) -> Iterator[Cluster]:
    """Give the workers of a scheduler, or workers of our own.

    Parameters
    ----------
    address : of a scheduler; None: workers of our own
    workers : number of our own
    tls : files of authority, certificate and key (ca, cert, key)
    is_insecure : whether an address of another machine may do without those

    Yields
    ------
    the workers

    Raises
    ------
    BadCluster : they cannot be used
    """
    if address:
        check_address(address, tls, is_insecure)
    try:
        from dask import config
        from distributed import Client, LocalCluster
        from distributed.security import Security
    except ImportError as error:
        raise BadCluster(f"{error}: Dask is an extra: type `pip install '.[dask]'`") from None
    for name in ("distributed", "distributed.client"):  # what they log of dead workers is dealt with here
        logging.getLogger(name).setLevel(logging.CRITICAL)
    names = {"ca": "tls_ca_file", "cert": "tls_client_cert", "key": "tls_client_key"}
    given: dict[str, Any] = {names[name]: file for name, file in tls.items()}
    with config.set(SETTINGS):
        try:
            cluster = None if address else LocalCluster(
                n_workers=workers, threads_per_worker=1, memory_limit=0, host="127.0.0.1",
                dashboard_address="127.0.0.1:0", silence_logs=logging.CRITICAL,
            )  # fmt: skip
            security = Security(require_encryption=True, **given) if tls else None
            client = Client(cluster or address, timeout=CONNECT_S, security=security, set_as_default=False)
        except (OSError, TimeoutError, ValueError, RuntimeError) as error:
            what = f"--scheduler {address}: cannot be reached" if address else f"--workers {workers}: cannot be started"
            raise BadCluster(f"{what}: {' '.join(str(error).split())}") from None
        try:
            client.run_on_scheduler(first_death_reported())
            with suppress(TimeoutError):
                client.wait_for_workers(1, timeout=CONNECT_S)
            found = Workers(client)
            if not found.counted():
                raise BadCluster(f"--scheduler {address}: no worker came within {CONNECT_S} s")
            is_served = client.run_on_scheduler(has_dashboard())
            dashboard = client.dashboard_link if is_served else "none, bokeh is missing or it is switched off"
            log.info(f"{found} of {address or 'this machine'}; dashboard: {dashboard}")
            yield Cluster(client, found)
        finally:
            if client.status == "running":
                client.run(end_engines, on_error="ignore")
            client.close()
            if cluster:
                cluster.close()


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


def has_dashboard() -> Callable[..., bool]:
    """Return what asks a scheduler whether it serves pages: without bokeh it has a port and one page, which says so."""

    def serves(dask_scheduler: Any = None) -> bool:
        from importlib.util import find_spec

        return "dashboard" in dask_scheduler.services and find_spec("bokeh") is not None

    return serves


def check_address(address: str, tls: Mapping[str, str], is_insecure: bool) -> None:
    """Refuse an address of another machine without encryption: Dask's protocol runs code that it is sent."""
    parts = urlsplit(address if "://" in address else f"tcp://{address}")
    try:
        host, port = parts.hostname or "", parts.port
    except ValueError:
        host, port = "", None
    if parts.scheme not in ("tcp", "tls") or not host or not port:
        raise BadCluster(f"--scheduler {address}: must be HOST:PORT, tcp://HOST:PORT or tls://HOST:PORT")
    if parts.scheme == "tls" and {*tls} != {"ca", "cert", "key"}:
        raise BadCluster(f"--scheduler {address}: give --tls-ca, --tls-cert and --tls-key")
    if parts.scheme == "tcp" and not is_insecure and not is_loopback(host):
        raise BadCluster(
            f"--scheduler {address}: whoever reaches this port can run code here and there: use tls://HOST:PORT with "
            "--tls-ca, --tls-cert and --tls-key, or --insecure-scheduler in a network that you trust"
        )


def is_loopback(host: str) -> bool:
    """Whether a name or address is this machine's own."""
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"
