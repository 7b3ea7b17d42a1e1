"""A process that answers in messages, and that ends with its parent, as all that it has started itself ends with it."""

import fcntl
import os
import resource
import select
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Mapping, Sequence
from contextlib import suppress
from time import monotonic
from typing import Any

from tumble.compare.run.process.message import PREFIX, Malformed, frame, lengths, unpacked

# A system call waits no longer than this at a time [s]; a deadline may be further away than it can count.
LONGEST_WAIT_S = 3600.0
# What ru_maxrss counts in [B].
MAXRSS = 1 if sys.platform == "darwin" else 1024
# glibc gives back every large block that is freed; a PyBullet world, a few MB, took 20 ms to be made of fresh pages.
KEPT_MEMORY = {"MALLOC_TRIM_THRESHOLD_": str(64 << 20), "MALLOC_MMAP_THRESHOLD_": str(32 << 20)}


class Died(Exception):
    """The process is gone, or has nothing more to say."""


class Process:
    """A command in a session of its own, and the line to it.

    command: its words; the descriptors of its ends of line and lifeline are added to them.  The lifeline is a pipe that
    nobody writes to: it closes when this process ends.  told: what its environment variables say beyond ours.
    Raises OSError where it cannot be started.
    """

    def __init__(self, command: Sequence[str], told: Mapping[str, str]) -> None:
        self._line, far_line = socket.socketpair()
        far_lifeline, self._lifeline = os.pipe()
        far_ends = far_line.fileno(), far_lifeline
        # A new process's ru_maxrss begins with that of the one that started it: only more than that is surely its own.
        self._begun_with = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        try:
            self._process = subprocess.Popen(
                [*command, *map(str, far_ends)],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                pass_fds=far_ends,
                env={**KEPT_MEMORY, **environment(), **told},
                start_new_session=True,
            )
        except BaseException:
            self._line.close()
            os.close(self._lifeline)
            raise
        finally:
            far_line.close()
            os.close(far_lifeline)
        self._line.setblocking(False)
        self._sentinel = sentinel(self._process.pid)
        self.peak_bytes, self.peak_is_its_own = 0, False

    def send(self, value: object, by: float) -> None:
        """Send a message before that instant of the monotonic clock [s].  Raises TimeoutError, Died, TypeError."""
        for part in map(memoryview, frame(value)):
            rest = part
            while rest:
                self._wait(select.POLLOUT, by)
                try:
                    rest = rest[self._line.send(rest) :]
                except BlockingIOError:
                    continue
                except OSError as error:
                    raise Died from error

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
            self._wait(select.POLLIN, by)
            try:
                took = self._line.recv_into(rest)
            except BlockingIOError:
                continue
            except OSError as error:
                raise Died from error
            if not took:
                raise Died
            rest = rest[took:]
        return found

    def _wait(self, event: int, by: float) -> None:
        """Wait until the line can be used.  What it has started may hold the line open after the process is dead."""
        poll = select.poll()
        poll.register(self._line, event)
        poll.register(self._sentinel, select.POLLIN)
        while True:
            left = by - monotonic()
            ready = [descriptor for descriptor, _ in poll.poll(1e3 * min(max(left, 0.0), LONGEST_WAIT_S))]
            if self._line.fileno() in ready:
                return
            if ready:
                raise Died
            if left <= 0:
                raise TimeoutError

    @property
    def gone(self) -> bool:
        """Whether it has ended, by itself or not."""
        return self._process.returncode is not None or bool(select.select([self._sentinel], [], [], 0.0)[0])

    def kill(self) -> None:
        """Kill the whole group, whatever it is doing; who waits for an answer is told that it died."""
        if self._process.returncode is None:
            # Nobody has waited for it yet, so that no other process can have been given its number.
            kill_group(self._process.pid)

    def end(self, patience: float = 0.0) -> int | None:
        """End the group; return the exit code if the process ended by itself within that time [s], -N by signal N."""
        by_itself = bool(select.select([self._sentinel], [], [], patience)[0])
        kill_group(self._process.pid)
        _, status, usage = os.wait4(self._process.pid, 0)
        self._process.returncode = os.waitstatus_to_exitcode(status)
        self.peak_bytes = usage.ru_maxrss * MAXRSS
        self.peak_is_its_own = usage.ru_maxrss > self._begun_with
        self._line.close()
        os.close(self._sentinel)
        os.close(self._lifeline)
        return self._process.returncode if by_itself else None


def environment() -> dict[str, str]:
    """Return this process's environment variables, from any thread: another may take one away while they are read."""
    seen = ((name, os.environ.get(name)) for name in list(os.environ))
    return {name: value for name, value in seen if value is not None}


def kill_group(leader: int) -> None:
    """Kill every process of a group."""
    with suppress(ProcessLookupError, PermissionError):  # of macOS, where all that is left of it has ended already
        os.killpg(leader, signal.SIGKILL)


def sentinel(pid: int) -> int:
    """Return a descriptor that can be read once a child of this process has ended, whoever holds its pipes."""
    with suppress(OSError, AttributeError):  # what the system has not got, or Python on it
        return os.pidfd_open(pid)
    with suppress(OSError, AttributeError):
        bsd: Any = select
        queue = bsd.kqueue()
        watch = bsd.kevent(pid, bsd.KQ_FILTER_PROC, bsd.KQ_EV_ADD, bsd.KQ_NOTE_EXIT)
        queue.control([watch], 0)
        return os.dup(queue.fileno())
    ended, far_end = os.pipe()
    threading.Thread(target=_close_at_its_end, args=(pid, far_end), daemon=True).start()
    return ended


def _close_at_its_end(pid: int, descriptor: int) -> None:
    """Close a descriptor when a process has ended, and leave it to others to wait for it."""
    # Where it cannot be waited for, kqueue was there and has refused it: it has ended already.
    with suppress(OSError, AttributeError):
        os.waitid(os.P_PID, pid, os.WEXITED | os.WNOWAIT)
    os.close(descriptor)


def end_with_parent(lifeline: int) -> None:
    """In the process itself: end its whole group when the other end of the lifeline closes.

    Linux sends the signal itself, so that no thread is needed, and none that holds a lock is in the way; elsewhere a
    thread waits.  The signal that follows a parent's death (PR_SET_PDEATHSIG) would follow the end of the thread that
    started the process, too.
    """
    if hasattr(fcntl, "F_SETSIG"):
        fcntl.fcntl(lifeline, fcntl.F_SETOWN, -os.getpgrp())
        fcntl.fcntl(lifeline, fcntl.F_SETSIG, signal.SIGKILL)
        fcntl.fcntl(lifeline, fcntl.F_SETFL, fcntl.fcntl(lifeline, fcntl.F_GETFL) | os.O_ASYNC)
    else:
        threading.Thread(target=_wait_and_end, args=(lifeline,), daemon=True).start()
    if select.select([lifeline], [], [], 0.0)[0]:  # it was closed before anybody watched
        kill_group(os.getpgrp())


def _wait_and_end(lifeline: int) -> None:
    os.read(lifeline, 1)
    kill_group(os.getpgrp())


def signal_name(number: int) -> str:
    """Return what a signal is called, its number where it has no name."""
    return signal.Signals(number).name if number in set(signal.Signals) else f"signal {number}"
