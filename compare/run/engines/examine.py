"""Runs every check of the engine contract on a contestant, in its own process: a crash or a hang is an outcome too."""

from collections.abc import Iterator
from dataclasses import dataclass

from tumble.compare.engines import CHECKS, CONTACT_CHECKS
from tumble.compare.run.engines.contract_checks import checks_for, known_failure
from tumble.compare.run.running_engines import RunningEngine
from tumble.compare.run.status import Failure, Status

# Why a check does not apply to an engine.
LACKING = {
    "gravity": "it has no gravity",
    "optional": "it has nothing optional",
    "sensors": "it has no sensors",
    **dict.fromkeys(CONTACT_CHECKS, "it has no plane"),
}
LOOSE = 1e-3  # a tolerance at which the steps of an adaptive method are few


@dataclass(frozen=True)
class Examined:
    """The outcome of one check.

    Parameters
    ----------
    check : name of the check
    holds : methods that pass
    broken : why the other methods fail, by method
    not_asked : why methods were not checked, by method
    known : why the methods fail that are stated to fail it, by method
    """

    check: str
    holds: tuple[str, ...]
    broken: dict[str, str]
    not_asked: dict[str, str]
    known: dict[str, str]


def examined(running_engine: RunningEngine, only: str | None = None) -> Iterator[Examined]:
    """Yield the outcome of each check, or of one, on every method, and on an adaptive one also at a loose tolerance.

    After the first timeout no further check is run.

    Parameters
    ----------
    running_engine : the engine to check; it must be loaded, that is, its info is no Failure
    only : name of the one check to run; None: all of them

    Yields
    ------
    the outcome of each check, in the order of the contract
    """
    info = running_engine.info
    assert not isinstance(info, Failure)
    loose = [f"{method}@{LOOSE:g}" for method in running_engine.methods if method in info.adaptive]
    binding = checks_for(info)
    late = ""
    every = tuple(dict.fromkeys((*CHECKS, *binding)))  # those of contact where they apply
    for check in every if only is None else (only,):
        if check not in binding or late:
            why = info.exempt.get(check) or (late if check in binding else LACKING[check])
            not_asked = dict.fromkeys(running_engine.methods, why)
            yield Examined(check=check, holds=(), broken={}, not_asked=not_asked, known={})
            continue
        holds, broken, not_asked, known = [], {}, {}, {}
        # In contact no force is held: those methods are others under another name.
        twice = info.forced if check in CONTACT_CHECKS else ()
        for method in (*(one for one in running_engine.methods if one not in twice), *loose):
            if late:
                not_asked[method] = late
                continue
            said = running_engine.ensure_running() or running_engine.worker.check_failure(check, method)
            if isinstance(said, Failure) and said.status is Status.TIMEOUT:
                # Each further answer would be waited for as long.
                late = f"after a timeout no more is asked; {method} gave no answer to {check!r}"
            if isinstance(said, Failure) and said.status is Status.SKIPPED:
                by_law = known_failure(info.known_failures, check, method)
                (known if by_law else not_asked)[method] = said.reason
            elif said:
                broken[method] = str(said)
            else:
                holds.append(method)
        yield Examined(check=check, holds=tuple(holds), broken=broken, not_asked=not_asked, known=known)
