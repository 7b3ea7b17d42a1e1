"""A process that answers in messages, and that ends with its parent, as all that it has started itself ends with it."""

import os
import signal
import socket
import sys
from collections.abc import Callable, Mapping, Sequence
from time import monotonic, sleep
from typing import Any

from tumble.compare.run.process import usage
from tumble.compare.run.process.fork_server import Fork, Forked, forked
from tumble.compare.run.process.message import PREFIX, Malformed, frame, lengths, unpacked
from tumble.compare.run.process.start import KEPT_MEMORY, environment, kill_group, start, start_on_windows

# How often a process that does not answer is looked at [s], and one that is about to end.
LOOK_S, LOOK_AT_END_S = 0.5, 0.005


class Died(Exception):
    """The process is gone, or has nothing more to say."""


class Process:
    """A command in a session of its own, and the line to it.

    command: its words; two more are added, for `open_line` and `end_with_parent`.  The lifeline is a pipe that is never
    written to: it closes when this process ends.  variables: environment variables beyond this process's; fork: what a
    fork of the command's fork server does in its place, None where only the command will do.
    Raises OSError where it cannot be started.
    """

    def __init__(self, command: Sequence[str], variables: Mapping[str, str], fork: Fork | None = None) -> None:
        env = {**KEPT_MEMORY, **environment(), **variables}
        self._line, far_line = socket.socketpair()
        try:
            begin = start_on_windows if sys.platform == "win32" else start
            begun = forked(fork, env, far_line) if fork else None
            self._process, self._lifeline = begun or begin(command, env, far_line)
        except BaseException:
            self._line.close()
            raise
        finally:
            far_line.close()
        # A new process's peak begins with that of the one that started it: only more than that is surely its own.
        process = self._process
        self._begun_with = process.begun_with if isinstance(process, Forked) else usage.peak_bytes()
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
        if sys.platform == "win32" and not isinstance(self._process, Forked):
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
        if isinstance(self._process, Forked):
            self._process.returncode, self.peak_bytes = self._process.reap()
        elif hasattr(os, "wait4"):
            self._process.returncode, self.peak_bytes = usage.reap(self._process.pid)
        else:
            self._process.wait()
        self.peak_is_its_own = self.peak_bytes > self._begun_with
        self._line.close()
        os.close(self._lifeline)
        return self._process.returncode if by_itself else None


def signal_name(number: int) -> str:
    """Return what a signal is called, its number where it has no name."""
    return signal.Signals(number).name if number in set(signal.Signals) else f"signal {number}"
