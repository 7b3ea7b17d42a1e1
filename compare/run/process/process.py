"""A process that answers in messages, and that ends with its parent, as all that it has started itself ends with it."""

import socket
from collections.abc import Callable, Mapping, Sequence
from time import monotonic, sleep
from typing import Any

from tumble.compare.run.process import forks
from tumble.compare.run.process.child import Spawned
from tumble.compare.run.process.message import PREFIX, Malformed, frame, lengths, unpacked

# How often a process that does not answer is looked at [s], and one that is about to end.
LOOK_S, LOOK_AT_END_S = 0.5, 0.005


class Died(Exception):
    """The process is gone, or has nothing more to say."""


class Process:
    """A process of Tumble's in a session of its own, and the line to it.

    command: its words; variables: environment variables beyond this process's (`Spawned`).  what: what it is to serve,
    as `forks.fork` takes it, where it can be a fork instead.
    Raises OSError where it cannot be started.
    """

    def __init__(self, command: Sequence[str], variables: Mapping[str, str], what: Sequence[str] = ()) -> None:
        self._line, far_line = socket.socketpair()
        try:
            forked = forks.fork(what, far_line) if what else None
            self._process = forked or Spawned(command, variables, far_line)
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
        return self._process.gone

    def kill(self) -> None:
        """Kill the process and all that it has started; pending calls raise Died."""
        self._process.kill()

    def end(self, patience: float = 0.0) -> int | None:
        """End the group; return the exit code if the process ended by itself within that time [s], -N by signal N."""
        until, by_itself = monotonic() + patience, False
        while monotonic() < until and not (by_itself := self.gone):
            sleep(LOOK_AT_END_S)
        self.peak_bytes = self._process.reap()
        self.peak_is_its_own = self.peak_bytes > self._process.peak_before
        self._line.close()
        return self._process.returncode if by_itself else None
