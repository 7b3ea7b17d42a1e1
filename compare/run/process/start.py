"""Starts processes that have a line to this one, and ends them with it.

It is imported before numpy is, by what begins before anything else (`fork_server`).
"""

import os
import signal
import socket
import subprocess
import threading
from collections.abc import Mapping, Sequence
from contextlib import suppress

# glibc gives back every large block that is freed; a PyBullet world, a few MB, took 20 ms to be made of fresh pages.
KEPT_MEMORY = {"MALLOC_TRIM_THRESHOLD_": str(64 << 20), "MALLOC_MMAP_THRESHOLD_": str(32 << 20)}
# Standard input, which is the lifeline where no other descriptor is inherited.
STDIN = 0


def start(
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


def start_on_windows(
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
