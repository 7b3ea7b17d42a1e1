"""Processes that begin as forks of one that has imported what all of them need: each is ready 0.1 s sooner.

A fork server is an interpreter of Tumble's own, of one thread, with numpy and what an engine's process consists of; it
knows no engine.  It begins before its parent has imported anything large, and lives as long as a fork of it does.  A
fork has a session, a lifeline and limits of its own, as a process that is started.  Files of a user are never run in
a fork, and only on Linux are there any: elsewhere the system's own libraries do not allow for them.
"""

import errno
import gc
import importlib
import json
import os
import socket
import sys
import threading
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from tumble.compare.run.process import usage
from tumble.compare.run.process.child import Child, Spawned, end_with_parent, environment, open_line

# What a fork serves: the calls of a `Caller`, or an engine, whose name and memory limit [B] follow.
CALLS, ENGINE = "calls", "engine"
SERVER = "--forks"
PROGRAM = Path(__file__).parents[1] / "serve.py"
IMPORTED = "tumble.compare.run.questions"
MOST_BYTES = 1 << 16
# A machine that is very busy still makes a fork in that time [s].
PATIENCE_S = 60.0


class ForkServer:
    """The process that forks, from its parent's side; users: its forks, and who will need one.

    Raises OSError where it cannot be started.
    """

    def __init__(self) -> None:
        self._parent, self._environment = os.getpid(), environment()
        self._one_at_a_time = threading.Lock()
        self.users = 0
        self._answers = True
        # Messages are sent whole.
        self._line, far_line = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._line.settimeout(PATIENCE_S)
        with far_line:
            self._process = Spawned([sys.executable, "-P", str(PROGRAM), SERVER], {}, far_line)

    def suits(self) -> bool:
        """Whether a fork of it is what would be started now: of this process, with these environment variables."""
        return self._answers and self._parent == os.getpid() and self._environment == environment()

    def fork(self, what: Sequence[str], far_line: socket.socket) -> "Fork":
        """Return a fork.  Raises OSError where there is none."""
        asked = {"what": [*what], "folder": os.getcwd(), "cores": [*os.sched_getaffinity(0)]}
        far_lifeline, lifeline = os.pipe()
        try:
            number, _ = self._ask(asked, [far_line.fileno(), far_lifeline, sys.__stderr__.fileno()])  # type: ignore
        except BaseException:
            os.close(lifeline)
            raise
        finally:
            os.close(far_lifeline)
        return Fork(number, lifeline, self)

    def wait(self, pid: int) -> tuple[int, int]:
        """Wait for a fork; return its exit code, -N after signal N, and the most memory that it has held [B]."""
        try:
            return self._ask({"wait": pid}, [])
        except OSError:  # the server is gone, and nobody knows
            return -1, 0
        finally:
            leave(self)

    def _ask(self, asked: dict[str, object], descriptors: list[int]) -> tuple[int, int]:
        try:
            with self._one_at_a_time:
                socket.send_fds(self._line, [json.dumps(asked).encode()], descriptors)
                answer = self._line.recv(MOST_BYTES)
            if not answer:
                raise ConnectionResetError(errno.ECONNRESET, os.strerror(errno.ECONNRESET))
        except OSError:
            self._answers = False
            raise
        first, second, failed = json.loads(answer)
        if failed:
            raise OSError(failed, os.strerror(failed))
        return first, second

    def end(self) -> None:
        """End it."""
        self._line.close()
        self._process.reap()


class Fork(Child):
    """A fork of a server, which alone can wait for it.

    Parameters
    ----------
    pid : its number, and that of its group
    lifeline : this process's end of its lifeline
    server : of which it is a fork
    """

    def __init__(self, pid: int, lifeline: int, server: ForkServer) -> None:
        super().__init__(pid, lifeline)
        self._server = server

    def _wait(self) -> tuple[int, int]:
        return self._server.wait(self.pid)


_lock = threading.Lock()
_newest: ForkServer | None = None


def enter() -> ForkServer | None:
    """Return a server that lives until the caller leaves it, None where there can be none."""
    global _newest
    if sys.platform != "linux":
        return None
    with _lock, suppress(OSError):
        if _newest is None or not _newest.suits():
            _newest = ForkServer()  # one with other variables lives as long as its forks
        _newest.users += 1
        return _newest
    return None


def leave(server: ForkServer | None) -> None:
    """End a server that nobody uses any more."""
    global _newest
    if server is None:
        return
    with _lock:
        server.users -= 1
        if server.users:
            return
        if server is _newest:
            _newest = None
    server.end()


def fork(what: Sequence[str], far_line: socket.socket) -> Fork | None:
    """Return a fork that serves CALLS, or ENGINE with its words, None where there can be none.

    far_line: its end of the line.
    """
    if (server := enter()) is None:
        return None
    try:
        return server.fork(what, far_line)
    except (OSError, AttributeError):  # without a working folder or a standard error, for instance
        leave(server)
        return None


def forked(line: str, lifeline: str) -> list[str]:
    """In the server: fork as often as is asked; return in every fork what that is to serve, and its two descriptors."""
    connection = open_line(line)
    end_with_parent(lifeline)
    importlib.import_module(IMPORTED)
    gc.freeze()  # what nobody changes is shared
    while True:
        message, descriptors, *_ = socket.recv_fds(connection, MOST_BYTES, 3)
        if not message:
            os._exit(0)  # the other end is closed
        asked = json.loads(message)
        try:
            if "wait" in asked:
                connection.send(json.dumps((*usage.reap(asked["wait"]), 0)).encode())
            elif not os.fork():
                os.setsid()
                connection.send(json.dumps((os.getpid(), 0, 0)).encode())
                connection.close()
                os.close(int(lifeline))
                return [*asked["what"], *begun(asked, *descriptors)]
        except OSError as error:
            connection.send(json.dumps((0, 0, error.errno or errno.EIO)).encode())
        for descriptor in descriptors:
            os.close(descriptor)


def begun(asked: dict, line: int, lifeline: int, standard_error: int) -> tuple[str, str]:
    """In a fork: be where the parent is; return the words for `open_line` and `end_with_parent`."""
    os.dup2(standard_error, 2)
    os.close(standard_error)
    os.sched_setaffinity(0, asked["cores"])
    with suppress(OSError):  # it was removed meanwhile
        os.chdir(asked["folder"])
    with suppress(OSError):  # the name that `top` shows
        Path("/proc/self/comm").write_text(" ".join(asked["what"][:2])[:15])
    return str(line), str(lifeline)
