"""Tasks on the workers of a Dask cluster: one task each, whose result is data; what is saved is saved at home.

Every worker has engines of its own, in processes as here, and the reference solutions that a task waits for are sent
with it.  A task during which a worker ends is sent once more: ended twice, it is a row `crashed`.  Where the scheduler
ends, the tasks that are left run here.
"""

import logging
from collections import OrderedDict
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import CancelledError
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from ipaddress import ip_address
from itertools import count
from queue import SimpleQueue
from threading import Lock, Semaphore, Thread
from typing import TYPE_CHECKING, Any
from urllib.parse import urlsplit

from tumble.compare.run.digest import code_digest, digest
from tumble.compare.run.process.message import frame, split, unpacked
from tumble.compare.run.provenance import versions
from tumble.compare.run.running_engines import RunningEngine
from tumble.compare.run.status import Failure, Status
from tumble.compare.run.tasks import Task, work
from tumble.compare.run.truths import Truths
from tumble.compare.run.worker import Worker
from tumble.scenarios.refusal import UserError

if TYPE_CHECKING:
    from distributed import Client

# Tasks that a worker has, running and waiting, and its engine processes: the least used one makes room.
TASKS_EACH, ENGINES_EACH = 2, 4
# A task that a worker ended with is sent this many times.
ATTEMPTS = 2
CONNECT_S = 20
SETTINGS = {
    "distributed.worker.daemon": False,  # a daemon could have no processes of its own (dask/distributed#2142)
    "distributed.scheduler.allowed-failures": 0,  # ATTEMPTS decides
    "distributed.comm.timeouts.connect": f"{CONNECT_S}s",
}

log = logging.getLogger(__name__)


class BadCluster(UserError):
    """A cluster that cannot be used; the message is the one line for the user."""


@dataclass(frozen=True)
class Needed:
    """The engine of a task, and the versions that it must have on a worker; identity: of `RunningEngine`, digested."""

    engine: str
    title: str
    methods: tuple[str, ...]
    named: frozenset[str]
    unasked: bool
    time_limit: float
    memory_limit: int
    identity: str
    versions: tuple[tuple[str, str], ...]

    @classmethod
    def of(cls, one: RunningEngine) -> "Needed":
        """Return what a running engine is."""
        limits = one.worker.time_limit, one.worker.memory_limit
        return cls(one.engine, one.title, one.methods, one.named, one.unasked, *limits, digest(one.identity), here())


def here() -> tuple[tuple[str, str], ...]:
    """Return the versions of what results depend on, in this process."""
    return (("Tumble's code", code_digest()), *((row.what, row.value) for row in versions()))


# On a worker: its engines, the one used last at the end.  A worker has one thread, but a user's may have more.
_engines: "OrderedDict[Needed, RunningEngine]" = OrderedDict()
one_at_a_time = Lock()


def answer(needed: Needed, ask: bytes) -> bytes:
    """On a worker: return the result of a task as a frame.  Raises BadCluster where the worker has other versions."""
    import cloudpickle

    with one_at_a_time:
        engine = engine_of(needed)
        while len(_engines) > ENGINES_EACH:
            _engines.popitem(last=False)[1].worker.close()
        return b"".join(frame(cloudpickle.loads(ask)(engine)))


def engine_of(needed: Needed) -> RunningEngine:
    """On a worker: return an engine, started if needed.  Raises BadCluster where the worker has other versions."""
    engine = _engines.pop(needed, None) or running(needed)
    _engines[needed] = engine
    return engine


def running(needed: Needed) -> RunningEngine:
    """Start an engine on a worker.  Raises BadCluster for another version than at home."""
    mine = dict(here())
    for what, value in needed.versions:
        if mine.get(what, "none") != value:
            raise BadCluster(f"a worker has {what} {mine.get(what, 'none')}, here is {value}")
    worker = Worker(needed.engine, needed.time_limit, needed.memory_limit)
    info = worker.describe()
    engine = RunningEngine(
        needed.engine, needed.title, needed.methods, needed.named, info, worker, unasked=needed.unasked
    )
    if digest(engine.identity) != needed.identity:
        worker.close()
        found = str(info) if isinstance(info, Failure) else f"version {info.version}"
        raise BadCluster(f"a worker has another {needed.title} than here: {found}")
    return engine


def end_engines() -> None:
    """On a worker: end all engines, also one that is at work, whose task then fails."""
    while _engines:
        _engines.popitem()[1].halt(for_good=True)


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


@dataclass
class Cluster:
    """The workers of a scheduler; client: connected to it."""

    client: "Client"
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
            self._send(sent, record)
        except BaseException:
            if truths:
                truths.stop()
            raise
        left = [task for task in tasks if task not in results]
        if len(left) > len(tasks) - len(sent):
            log.info(f"the scheduler is gone: {len(left)} of {len(tasks)} tasks run here")
        work(left, truths, record)
        return [results[task] for task in tasks]

    def _send(self, tasks: Sequence[Task], record: Callable[[Task, Any], object]) -> None:
        """Record the results of tasks, all of them unless the scheduler ends."""
        events: SimpleQueue[tuple[Task, Any]] = SimpleQueue()
        room = Semaphore(TASKS_EACH * max(1, len(self.client.scheduler_info()["workers"])))
        attempts: dict[Task, int] = dict.fromkeys(tasks, 0)
        payloads: dict[Task, tuple[Needed, bytes]] = {}
        futures: dict[Task, Any] = {}
        ended = False

        def feed() -> None:
            """Make each task ready to be sent, which waits for its reference solution."""
            import cloudpickle

            for task in tasks:
                room.acquire()
                if ended:
                    return
                try:
                    events.put((task, (Needed.of(task.running_engine), cloudpickle.dumps(task.ask))))
                except BaseException as error:
                    events.put((task, error))
                    return

        def submit(task: Task) -> None:
            key = f"tumble-{next(self._numbers)}-{task.digest}"
            attempts[task] += 1
            # As annotations, these would be lost, or break transitions (dask/distributed#4491, #5937).
            future = self.client.submit(answer, *payloads[task], pure=False, key=key, retries=0)
            futures[task] = future
            future.add_done_callback(lambda done: events.put((task, done)))

        feeder = Thread(target=feed, daemon=True, name="tasks for workers")
        feeder.start()
        try:
            while attempts:
                task, event = events.get()
                if isinstance(event, BaseException):
                    raise event
                if isinstance(event, tuple):
                    payloads[task] = event
                    submit(task)
                    continue
                if event is not futures.get(task):
                    continue
                if event.status not in ("finished", "error"):
                    return  # cancelled or lost, which it is only with the scheduler
                if (error := event.exception() if event.status == "error" else None) is not None:
                    if type(error).__name__ != "KilledWorker":
                        raise error
                    if attempts[task] < ATTEMPTS:
                        submit(task)
                        continue
                    result = self._crashed(task)
                else:
                    try:
                        result = unframed(task.kind, event.result())
                    except (OSError, CancelledError):
                        return  # the scheduler ended while it handed the result over
                del attempts[task], payloads[task], futures[task]
                record(task, result)
                room.release()
        finally:
            ended = True
            room.release()
            for future in futures.values():
                future.cancel()

    @staticmethod
    def _crashed(task: Task) -> Any:
        """Return the result of a task whose engine crashes at whatever is asked."""
        failure = Failure(Status.CRASHED, f"{ATTEMPTS} workers ended while they ran it", process_died=True)
        return task.ask(replace(task.running_engine, worker=Lost(task.running_engine, failure)))


def unframed(kind: Any, data: bytes) -> Any:
    """Return the value of a frame."""
    return unpacked(kind, *split(data))


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
                n_workers=workers, threads_per_worker=1, memory_limit=0, host="127.0.0.1", dashboard_address="",
                silence_logs=logging.CRITICAL,
            )  # fmt: skip
            security = Security(require_encryption=True, **given) if tls else None
            client = Client(cluster or address, timeout=CONNECT_S, security=security, set_as_default=False)
        except (OSError, TimeoutError, ValueError, RuntimeError) as error:
            what = f"--scheduler {address}: cannot be reached" if address else f"--workers {workers}: cannot be started"
            raise BadCluster(f"{what}: {' '.join(str(error).split())}") from None
        try:
            with suppress(TimeoutError):
                client.wait_for_workers(1, timeout=CONNECT_S)
            threads = sum(dict(client.nthreads()).values())  # type: ignore[call-overload]
            if not threads:
                raise BadCluster(f"--scheduler {address}: no worker came within {CONNECT_S} s")
            dashboard = client.dashboard_link if "dashboard" in client.scheduler_info()["services"] else "none"
            log.info(f"{threads} worker{'s' * (threads > 1)} of {address or 'this machine'}; dashboard: {dashboard}")
            yield Cluster(client)
        finally:
            if client.status == "running":
                client.run(end_engines, on_error="ignore")
            client.close()
            if cluster:
                cluster.close()


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
