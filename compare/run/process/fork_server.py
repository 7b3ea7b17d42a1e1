"""A process that has imported what the process of any engine needs, and forks: numpy is imported once for all of them.

A command has one for as long as it runs (`fork_server`), begun before its own imports; it has one thread, so that a
fork has all that it needs.  Only Linux has it, where a library that was imported may be forked.  What it does not
take, a process with other environment variables or one that is not ours, starts as a program, as everywhere else.
"""

import importlib
import json
import os
import socket
import sys
import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from tumble.compare.run.process import usage
from tumble.compare.run.process.start import KEPT_MEMORY, end_with_parent, environment, kill_group, open_line, start
from tumble.garbage import importing

SERVE = str(Path(__file__).parents[1].absolute() / "serve.py")
NEEDED = "tumble.compare.run.questions"
# It imports a compiler at worst before it answers [s].
PATIENCE_S = 60.0
MOST_BYTES = 1 << 16
STDERR = 2


@dataclass(frozen=True)
class Fork:
    """What a fork does: the words that `serve.py` would be started with, and what is imported for it and later ones."""

    words: tuple[str, ...]
    imports: tuple[str, ...] = ()


class Forked:
    """A process that was forked, the server's child; begun_with: its peak of memory when it began [B]."""

    def __init__(self, server: "ForkServer", pid: int, begun_with: int) -> None:
        self._server, self.pid, self.begun_with = server, pid, begun_with
        self.returncode: int | None = None

    def reap(self) -> tuple[int, int]:
        """Wait for it; return its exit code, -N after signal N, and the most memory it has held [B]."""
        code, peak = self._server.ask({"reap": self.pid}) or (-9, 0)
        return code, peak


class ForkServer:
    """The process, and the line to it.  Raises OSError where it cannot be started."""

    def __init__(self) -> None:
        self.env = {**KEPT_MEMORY, **environment()}
        self._one_at_a_time, self._is_lost = threading.Lock(), False
        self._line, far_line = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._line.settimeout(PATIENCE_S)
        try:
            self._process, self._lifeline = start([sys.executable, "-P", SERVE], self.env, far_line)
        finally:
            far_line.close()

    def ask(self, request: Mapping[str, object], descriptors: Sequence[int] = ()) -> list[int] | None:
        """Return the answer to a request, None where there is none: from then on nothing is asked any more."""
        with self._one_at_a_time:
            if self._is_lost:
                return None
            try:
                socket.send_fds(self._line, [json.dumps(request).encode()], descriptors)
                answer = self._line.recv(MOST_BYTES)
            except OSError:
                answer = b""
            except BaseException:  # an interrupt: what comes is the answer to another question
                self._is_lost = True
                raise
            self._is_lost = not answer
            return json.loads(answer) if answer else None

    def begin_imports(self, names: Sequence[str]) -> None:
        """Import modules that later forks will need, while this process does something else."""
        with self._one_at_a_time, suppress(OSError):  # the next question finds that it is lost
            self._line.send(json.dumps({"imports": names}).encode())

    def fork(self, wanted: Fork, far_line: socket.socket) -> tuple[Forked, int] | None:
        """Return a fork with the ends of its line and of a lifeline, and our end of that; None where there is none."""
        far_lifeline, lifeline = os.pipe()
        here = os.open(".", os.O_PATH)
        try:
            request = {"words": wanted.words, "imports": wanted.imports}
            answer = self.ask(request, [far_line.fileno(), far_lifeline, STDERR, here])
        except BaseException:
            os.close(lifeline)
            raise
        finally:
            os.close(far_lifeline)
            os.close(here)
        if not answer:
            os.close(lifeline)
            return None
        return Forked(self, *answer), lifeline

    def end(self) -> None:
        """End the process; what it has forked stays."""
        kill_group(self._process.pid)
        self._process.wait()
        self._line.close()
        os.close(self._lifeline)


# That of the command that runs.
running: list[ForkServer] = []


@contextmanager
def fork_server(imports: Sequence[str] = ()) -> Iterator[None]:
    """Have a fork server for a while, where the system has it; imports: what its forks will need."""
    server = None
    if sys.platform == "linux" and hasattr(os, "fork"):
        with suppress(OSError):
            server = ForkServer()
    if server is None:
        yield
        return
    running.append(server)
    if imports:
        server.begin_imports(imports)
    try:
        yield
    finally:
        running.remove(server)
        server.end()


def forked(wanted: Fork, env: Mapping[str, str], far_line: socket.socket) -> tuple[Forked, int] | None:
    """Return a fork with these environment variables, as `ForkServer.fork`; None where it must be started otherwise."""
    for server in running:
        if server.env == env:
            return server.fork(wanted, far_line)
    return None


def serve_forks(line: str, lifeline: str) -> list[str]:
    """In the process itself: fork as it is asked; return, in each fork, the words that it would be started with."""
    end_with_parent(lifeline)
    connection = open_line(line)
    with importing():
        importlib.import_module(NEEDED)
    while True:
        message, descriptors, _, _ = socket.recv_fds(connection, MOST_BYTES, 4)
        if not message:
            os._exit(0)
        request = json.loads(message)
        if "reap" in request:
            connection.send(json.dumps(usage.reap(request["reap"])).encode())
            continue
        for name in request["imports"]:
            with importing(), suppress(ImportError):  # who needs it says so
                importlib.import_module(name)
        if "words" not in request:
            continue
        try:
            pid = os.fork()
        except OSError:
            connection.send(json.dumps([]).encode())
            pid = -1
        if pid == 0:
            far_line, far_lifeline, stderr, here = descriptors
            os.setsid()  # before anybody knows it: its group is what is killed
            os.dup2(stderr, STDERR)
            os.fchdir(here)
            connection.send(json.dumps([os.getpid(), usage.peak_bytes()]).encode())
            connection.close()
            for each in (int(lifeline), stderr, here):
                os.close(each)
            return [*request["words"], str(far_line), str(far_lifeline)]
        for each in descriptors:
            os.close(each)
