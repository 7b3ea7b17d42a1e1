"""Brings up those who take part, each engine in a process of its own."""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager

from compare.contestants import Entrant, chosen, wanted
from compare.worker import Worker

TIME_LIMIT_S = 60.0


@contextmanager
def crew(asked: Iterable[str], time_limit: float = TIME_LIMIT_S) -> Iterator[list[Entrant]]:
    """Give who takes part, each with a process of its own, and end the processes afterwards, whatever happened.

    asked: ENGINE[:METHOD] ..., nothing for every engine of ours; time_limit [s] for each answer of an engine.
    Raises BadEngine with one line.
    """
    engines = wanted(asked)
    # All are started before any is waited for: importing the engines takes longest.
    workers = [Worker(engine, time_limit) for engine in engines]
    entrants: list[Entrant] = []
    try:
        for worker, (engine, methods) in zip(workers, engines.items(), strict=True):
            card = worker.describe()
            entrants.append(Entrant(engine, chosen(engine, methods, card), bool(methods), card, worker))
        yield entrants
    finally:
        for worker in {*workers, *(entrant.worker for entrant in entrants)}:
            worker.close()
