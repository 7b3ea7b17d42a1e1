"""A process of our own that makes calls: functions of Tumble and what they are given, sent and answered in pickles.

It is started as any command is, and not by multiprocessing, which would run the user's script once more to begin with.
Both ends run the same code, so that a pickle is safe here; what an engine sends is data and never code (`message`).
"""

import logging
import math
import pickle
import sys
import threading
from collections.abc import Callable
from concurrent.futures import CancelledError, Future, InvalidStateError, ThreadPoolExecutor
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

import tumble
from tumble.compare.run.process.fork_server import Fork
from tumble.compare.run.process.message import PREFIX, frame, lengths, unpacked
from tumble.compare.run.process.process import Died, Process
from tumble.compare.run.process.start import end_with_parent, open_line
from tumble.compare.run.serve import CALLS

# What the process runs: it finds the package where this one has found it, and nothing else of the working folder.
HOME = str(Path(tumble.__path__[0]).parent)
BEGIN = f"import sys; sys.path.insert(0, {HOME!r}); from {__name__} import serve; serve(*sys.argv[1:])"
MOST_BYTES = 1 << 40
SHARE, RESULT, ERROR = "share", "result", "error"
Tell = Callable[[float], object]


class Caller:
    """A process that makes one call after the other: it starts with the first, and ends when this process does.

    Parameters
    ----------
    imports : modules that it shares with others where it may be forked; None: it may not
    """

    def __init__(self, imports: tuple[str, ...] | None = None) -> None:
        self._fork = None if imports is None else Fork((CALLS,), (__name__, *imports))
        self._process: Process | None = None
        self._thread = ThreadPoolExecutor(1)
        self._own_thread: int | None = None
        self._one_at_a_time, self._ended = threading.Lock(), False

    def submit(self, function: Callable[..., Any], *arguments: Any, tell: Tell | None = None) -> "Future[Any]":
        """Return what will be the function's result.

        tell: called with each share of the work that the function reports; it must take `tell`, too, then.
        Raises Died where the process was ended, or has died, OSError where it cannot be started.
        """
        with self._one_at_a_time:
            if self._ended or (self._process is not None and self._process.gone):
                raise Died("its process is gone")
            if self._process is None:
                self._process = Process([sys.executable, "-P", "-c", BEGIN], {}, self._fork)
            return self._thread.submit(self._call, self._process, function, arguments, tell)

    def _call(
        self, process: Process, function: Callable[..., Any], arguments: tuple[Any, ...], tell: Tell | None
    ) -> Any:
        self._own_thread = threading.get_ident()
        process.send(as_array((function, arguments, tell is not None)), math.inf)
        while True:
            kind, value = pickle.loads(process.receive(np.ndarray, MOST_BYTES, math.inf))
            if kind == ERROR:
                raise value
            if kind == RESULT:
                return value
            if tell is not None:
                tell(value)

    def end(self) -> None:
        """End the process at once, whatever it is doing: who waits for a call gets CancelledError or Died."""
        with self._one_at_a_time:
            ended, self._ended = self._ended, True
        if ended:
            return
        if self._process is not None:
            self._process.kill()
        # Who is told of a call may end the process there and then: that thread cannot wait for itself.
        self._thread.shutdown(wait=threading.get_ident() != self._own_thread, cancel_futures=True)
        if self._process is not None:
            self._process.end()


def hand_on(done: "Future[Any]", future: "Future[Any]") -> None:
    """Give a future what another has come to, unless it was cancelled meanwhile.

    Parameters
    ----------
    done : a future that is done: with a result, with an error, or cancelled
    future : the future that gets the same outcome
    """
    with suppress(InvalidStateError):
        if done.cancelled():
            if not future.cancel():  # it is waited for already
                future.set_exception(CancelledError())
        elif (
            error := done.exception()
        ) is not None:  # not raised: its traceback would keep a dead process's pipes open
            future.set_exception(error)
        else:
            future.set_result(done.result())


def as_array(value: object) -> np.ndarray:
    """Return a pickle as an array of bytes."""
    return np.frombuffer(pickle.dumps(value, pickle.HIGHEST_PROTOCOL), np.uint8)


def serve(line: str, lifeline: str) -> None:
    """In the process itself: make the calls that come along a line, until its other end closes."""
    connection = open_line(line)
    end_with_parent(lifeline)
    logging.basicConfig(format="tumble: %(message)s")
    with connection, connection.makefile("rb") as questions:

        def answer(kind: str, value: object) -> None:
            for part in frame(as_array((kind, value))):
                connection.sendall(part)

        while prefix := questions.read(PREFIX.size):
            head, body = lengths(prefix)
            sent = unpacked(np.ndarray, questions.read(head), questions.read(body))
            try:
                function, arguments, tells = pickle.loads(sent)
                answer(RESULT, function(*arguments, **({"tell": partial(answer, SHARE)} if tells else {})))
            except Exception as error:
                try:
                    answer(ERROR, error)
                except (pickle.PicklingError, TypeError, AttributeError):
                    answer(ERROR, RuntimeError(f"{type(error).__name__}: {error}"))
