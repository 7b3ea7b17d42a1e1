"""Puts every law of compare.engines to a contestant, in its own process: a crash or a hang is an answer here too."""

from collections.abc import Iterator
from dataclasses import dataclass

from tumble.compare.engines import LAWS
from tumble.compare.run.engines.laws import laws_for
from tumble.compare.run.running_engines import RunningEngine
from tumble.compare.run.status import Failure, Status

LOOSE = 1e-3  # a tolerance at which the steps of an adaptive method are few


@dataclass(frozen=True)
class Examined:
    """What came of one law: the methods that keep it, how others break it, and why some or all were not asked."""

    law: str
    holds: tuple[str, ...]
    broken: dict[str, str]
    not_asked: dict[str, str]


def examined(running_engine: RunningEngine, only: str | None = None) -> Iterator[Examined]:
    """Yield what came of each law, or of one, put to every method, and to an adaptive one also at a loose tolerance.

    After the first timeout no more is asked.
    """
    info = running_engine.info
    assert not isinstance(info, Failure)
    loose = [f"{method}@{LOOSE:g}" for method in running_engine.methods if method in info.adaptive]
    binding = laws_for(info.features, info.optional, info.exempt)
    late = ""
    for law in LAWS if only is None else (only,):
        if law not in binding or late:
            lacking = "it has no gravity" if law == "gravity" else "it has nothing optional"
            why = info.exempt.get(law) or (late if law in binding else lacking)
            yield Examined(law=law, holds=(), broken={}, not_asked=dict.fromkeys(running_engine.methods, why))
            continue
        holds, broken, not_asked = [], {}, {}
        for method in (*running_engine.methods, *loose):
            if late:
                not_asked[method] = late
                continue
            said = running_engine.ensure_running() or running_engine.worker.law_broken(law, method)
            if isinstance(said, Failure) and said.status is Status.TIMEOUT:
                # Each further answer would be waited for as long.
                late = f"after a timeout no more is asked; {method} gave no answer to {law!r}"
            if isinstance(said, Failure) and said.status is Status.SKIPPED:
                not_asked[method] = said.reason
            elif said:
                broken[method] = str(said)
            else:
                holds.append(method)
        yield Examined(law=law, holds=tuple(holds), broken=broken, not_asked=not_asked)
