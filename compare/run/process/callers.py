"""Processes that share out calls: one takes those of a kind, the others the rest, and of many of a kind some, too."""

from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from functools import partial
from typing import Any, NamedTuple

from tumble.compare.run.process.caller import Caller, Tell, hand_on
from tumble.compare.run.process.process import Died


class Call(NamedTuple):
    """A function, what it is given, and what is called with each share of the work that it reports, if it does."""

    function: Callable[..., Any]
    arguments: Sequence[Any] = ()
    tell: Tell | None = None


Task = tuple[Call, "Future[Any]"]
# So many calls of a kind are left to one process: what it loads or compiles for them another would do again.
FEW = 12


class Callers:
    """At most so many processes, each of which makes one call after the other; imports: as of `Caller`."""

    def __init__(self, count: int, imports: tuple[str, ...] | None = None) -> None:
        self._callers = [Caller(imports) for _ in range(count)]

    def share_out(
        self, calls: Sequence[Call], of_a_kind: Sequence[bool], futures: Sequence["Future[Any]"] = ()
    ) -> Sequence["Future[Any]"]:
        """Return what will be the results of calls; the first process takes those of a kind before any other.

        The others take of those only while more than a few are left.
        futures: get the results; none: new ones.
        """
        futures = futures or [Future() for _ in calls]
        alike: deque[Task] = deque()
        others: deque[Task] = deque()
        for call, future, is_alike in zip(calls, futures, of_a_kind, strict=True):
            (alike if is_alike else others).append((call, future))

        def first() -> Task:
            return (alike or others).popleft()

        def next_to_it() -> Task:
            return (others if others or len(alike) <= FEW else alike).pop()

        for number, caller in enumerate(self._callers):
            _go_on(caller, next_to_it if number else first)
        return futures

    def end(self) -> None:
        """End the processes, whatever they are doing; calls that wait are not made."""
        for caller in self._callers:
            caller.end()


def _go_on(caller: Caller, take: Callable[[], Task]) -> None:
    """Let a process make the next call that nobody has cancelled, and so on when it is done."""
    while True:
        try:
            call, future = take()
        except IndexError:
            return
        if not future.set_running_or_notify_cancel():
            continue
        try:
            made = caller.submit(call.function, *call.arguments, tell=call.tell)
        except Died as ended:
            future.set_exception(ended)
            continue
        made.add_done_callback(partial(hand_on, future=future))
        made.add_done_callback(lambda _: _go_on(caller, take))
        return
