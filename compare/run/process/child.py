"""A process in a session of its own, as its parent starts and ends it, and as it begins and ends itself.

It gets two descriptors: its end of a line, and a lifeline, a pipe that is never written to, which closes when the
parent ends.  Nothing here needs numpy: a command begins processes before it imports anything large.
"""

import os
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Mapping, Sequence
from contextlib import suppress

from tumble.compare.run.process import usage

# glibc gives back every large block that is freed; a PyBullet world, a few MB, took 20 ms to be made of fresh pages.
KEPT_MEMORY = {"MALLOC_TRIM_THRESHOLD_": str(64 << 20), "MALLOC_MMAP_THRESHOLD_": str(32 << 20)}
# Standard input, which is the lifeline where no other descriptor is inherited.
STDIN = 0


class Child:
    """A process of this one's, in a session of its own.

    Parameters
    ----------
    pid : its number, and that of its group
    lifeline : this process's end of its lifeline
    """

    # What a peak of its memory begins with [B]: only more than that is surely its own.
    peak_before = 0

    def __init__(self, pid: int, lifeline: int) -> None:
        self.pid, self.lifeline = pid, lifeline
        self.returncode: int | None = None

    @property
    def gone(self) -> bool:
        """Whether it has ended, by itself or not; it is not waited for, and its number is not given to another."""
        if self.returncode is not None:
            return True
        import psutil

        try:
            return psutil.Process(self.pid).status() == psutil.STATUS_ZOMBIE
        except psutil.NoSuchProcess:
            return True

    def kill(self) -> None:
        """Kill it and all that it has started."""
        if self.returncode is None:
            # It has not been waited for, so that no other process can have been given its number.
            kill_group(self.pid)

    def reap(self) -> int:
        """Kill its group and wait for it; return the most memory that it has held [B]."""
        kill_group(self.pid)
        self.returncode, peak_bytes = self._wait()
        os.close(self.lifeline)
        return peak_bytes

    def _wait(self) -> tuple[int, int]:
        return usage.reap(self.pid)


class Spawned(Child):
    """A command; two words are added, for `open_line` and `end_with_parent`.

    Parameters
    ----------
    command : its words
    variables : environment variables beyond this process's
    far_line : its end of the line
    """

    def __init__(self, command: Sequence[str], variables: Mapping[str, str], far_line: socket.socket) -> None:
        # It begins with the peak of the process that started it.
        self.peak_before = usage.peak_bytes()
        env = {**KEPT_MEMORY, **environment(), **variables}
        start = _start_on_windows if sys.platform == "win32" else _start
        self._process, lifeline = start(command, env, far_line)
        super().__init__(self._process.pid, lifeline)

    @property
    def gone(self) -> bool:
        """Whether it has ended."""
        return self._process.poll() is not None if sys.platform == "win32" else super().gone

    def _wait(self) -> tuple[int, int]:
        if not hasattr(os, "wait4"):
            return self._process.wait(), 0
        code, peak_bytes = super()._wait()
        self._process.returncode = code
        return code, peak_bytes


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
    """In the process itself: return its end of the line, from the first word that was added."""
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

    lifeline: the second word that was added.
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
