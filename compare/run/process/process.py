"""A process that answers in messages, and that ends with its parent, as all that it has started itself ends with it."""

import os
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from time import monotonic, sleep
from typing import Any

from tumble.compare.run.process import usage
from tumble.compare.run.process.message import PREFIX, Malformed, frame, lengths, unpacked

# How often a process that does not answer is looked at [s], and one that is about to end.
LOOK_S, LOOK_AT_END_S = 0.5, 0.005
# glibc gives back every large block that is freed; a PyBullet world, a few MB, took 20 ms to be made of fresh pages.
KEPT_MEMORY = {"MALLOC_TRIM_THRESHOLD_": str(64 << 20), "MALLOC_MMAP_THRESHOLD_": str(32 << 20)}
# Standard input, which is the lifeline where no other descriptor is inherited.
STDIN = 0


class Died(Exception):
    """The process is gone, or has nothing more to say."""


class Process:
    """A command in a session of its own, and the line to it.

    command: its words; two more are added, for `open_line` and `end_with_parent`.  The lifeline is a pipe that is never
    written to: it closes when this process ends.  variables: environment variables beyond this process's.
    Raises OSError where it cannot be started.
    """

    def __init__(self, command: Sequence[str], variables: Mapping[str, str]) -> None:
        # A new process's peak begins with that of the one that started it: only more than that is surely its own.
        self._begun_with = usage.peak_bytes()
        env = {**KEPT_MEMORY, **environment(), **variables}
        self._line, far_line = socket.socketpair()
        try:
            start = _start_on_windows if sys.platform == "win32" else _start
            self._process, self._lifeline = start(command, env, far_line)
        except BaseException:
            self._line.close()
            raise
        finally:
            far_line.close()
        self.peak_bytes, self.peak_is_its_own = 0, False

    def send(self, value: object, by: float) -> None:
        """Send a message before that instant of the monotonic clock [s].  Raises TimeoutError, Died, TypeError."""
        for part in map(memoryview, frame(value)):
            rest = part
            while rest:
                rest = rest[self._once_ready(self._line.send, rest, by) :]

    def receive(self, hint: Any, most_bytes: int, by: float) -> Any:
        """Return a message as the type of that hint before that instant of the monotonic clock [s].

        most_bytes: what its arrays may take.  Raises TimeoutError, Died, Malformed.
        """
        head, body = lengths(bytes(self._bytes(PREFIX.size, by)))
        if body > most_bytes:
            raise Malformed(f"what it sent is longer than any answer: {body} bytes")
        return unpacked(hint, bytes(self._bytes(head, by)), self._bytes(body, by))

    def _bytes(self, count: int, by: float) -> bytearray:
        found = bytearray(count)
        rest = memoryview(found)
        while rest:
            took = self._once_ready(self._line.recv_into, rest, by)
            if not took:
                raise Died
            rest = rest[took:]
        return found

    def _once_ready(self, call: Callable[[memoryview], int], data: memoryview, by: float) -> int:
        """Call once the line is ready.  What the process has started may hold the line open after it is dead."""
        was_gone = False
        while True:
            left = by - monotonic()
            self._line.settimeout(min(max(left, 1e-6), LOOK_S))
            try:
                return call(data)
            except TimeoutError:
                if was_gone:
                    raise Died from None
                if left <= 0:
                    raise
                was_gone = self.gone
            except OSError as error:
                raise Died from error

    @property
    def gone(self) -> bool:
        """Whether it has ended, by itself or not."""
        if sys.platform == "win32":
            return self._process.poll() is not None
        if self._process.returncode is not None:
            return True
        import psutil

        try:  # `poll` would wait for it, and then its number could be given to another process
            return psutil.Process(self._process.pid).status() == psutil.STATUS_ZOMBIE
        except psutil.NoSuchProcess:
            return True

    def kill(self) -> None:
        """Kill the process and all that it has started; pending calls raise Died."""
        if self._process.returncode is None:
            # It has not been waited for, so that no other process can have been given its number.
            kill_group(self._process.pid)

    def end(self, patience: float = 0.0) -> int | None:
        """End the group; return the exit code if the process ended by itself within that time [s], -N by signal N."""
        until, by_itself = monotonic() + patience, False
        while monotonic() < until and not (by_itself := self.gone):
            sleep(LOOK_AT_END_S)
        kill_group(self._process.pid)
        if hasattr(os, "wait4"):
            self._process.returncode, self.peak_bytes = usage.reap(self._process.pid)
        else:
            self._process.wait()
        self.peak_is_its_own = self.peak_bytes > self._begun_with
        self._line.close()
        os.close(self._lifeline)
        return self._process.returncode if by_itself else None


def _start(
    command: Sequence[str], env: Mapping[str, str], far_line: socket.socket
) -> tuple[subprocess.Popen[bytes], int]:
    """Start a process that inherits its ends of line and lifeline; return it and our end of the lifeline."""
    far_lifeline, lifeline = os.pipe()
    far_ends = far_line.fileno(), far_lifeline
    try:
        process = subprocess.Popen(
            [*command, *map(str, far_ends)],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            pass_fds=far_ends,
            env=env,
            start_new_session=True,
        )
    except BaseException:
        os.close(lifeline)
        raise
    finally:
        os.close(far_lifeline)
    return process, lifeline


def _start_on_windows(
    command: Sequence[str], env: Mapping[str, str], far_line: socket.socket
) -> tuple[subprocess.Popen[bytes], int]:
    """Start a process where sockets are not inherited: its end of the line is shared along its standard input."""
    process = subprocess.Popen(
        [*command, "shared", str(STDIN)],
        stdin=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        env=env,
    )
    assert process.stdin is not None
    lifeline = os.dup(process.stdin.fileno())
    process.stdin.close()
    shared = far_line.share(process.pid)  # type: ignore[attr-defined]
    os.write(lifeline, len(shared).to_bytes(4, "little") + shared)
    return process, lifeline


def open_line(line: str) -> socket.socket:
    """In the process itself: return its end of the line, from the first word that `Process` has added."""
    if line != "shared":
        os.set_inheritable(int(line), False)
        return socket.socket(fileno=int(line))
    shared = os.read(STDIN, int.from_bytes(os.read(STDIN, 4), "little"))
    return socket.fromshare(shared)  # type: ignore[attr-defined]


def end_with_parent(lifeline: str) -> None:
    """In the process itself, after `open_line`: end its whole group when the other end of the lifeline closes.

    Linux sends the signal itself, so that no thread is needed, and none that holds a lock is in the way; elsewhere a
    thread waits.  The signal that follows a parent's death (PR_SET_PDEATHSIG) would follow the end of the thread that
    started the process, too.

    lifeline: the second word that `Process` has added.
    """
    with suppress(ImportError, AttributeError):
        import fcntl

        fcntl.fcntl(int(lifeline), fcntl.F_SETOWN, -os.getpgrp())
        fcntl.fcntl(int(lifeline), fcntl.F_SETSIG, signal.SIGKILL)
        fcntl.fcntl(int(lifeline), fcntl.F_SETFL, fcntl.fcntl(int(lifeline), fcntl.F_GETFL) | os.O_ASYNC)
        os.set_blocking(int(lifeline), False)
        with suppress(BlockingIOError):
            _wait_and_end(int(lifeline))  # it was closed before the system watched it
        return
    threading.Thread(target=_wait_and_end, args=(int(lifeline),), daemon=True).start()


def _wait_and_end(lifeline: int) -> None:
    os.read(lifeline, 1)
    if hasattr(os, "killpg"):
        kill_group(os.getpgrp())
    os._exit(1)


def environment() -> dict[str, str]:
    """Return this process's environment variables, from any thread: another may take one away while they are read."""
    seen = ((name, os.environ.get(name)) for name in list(os.environ))
    return {name: value for name, value in seen if value is not None}


def kill_group(leader: int) -> None:
    """Kill every process of a group; where there are no groups, a process and all that it has started.

    Parameters
    ----------
    leader : process id of the group's leader
    """
    if hasattr(os, "killpg"):
        with suppress(ProcessLookupError, PermissionError):  # macOS: all that is left of it has ended already
            os.killpg(leader, signal.SIGKILL)
        return
    import psutil

    with suppress(psutil.NoSuchProcess):
        process = psutil.Process(leader)
        for each in (*process.children(recursive=True), process):
            with suppress(psutil.Error):
                each.kill()


def signal_name(number: int) -> str:
    """Return what a signal is called, its number where it has no name."""
    return signal.Signals(number).name if number in set(signal.Signals) else f"signal {number}"
