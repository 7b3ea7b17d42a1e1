"""`tumble engines`: who can take part here, and whether an engine keeps the laws of engines."""

from argparse import Namespace
from collections.abc import Iterator

from compare.engines import LAWS
from compare.run.examine import Examined, examined
from compare.run.participants import launched
from compare.run.worker import Failure
from compare.tables.engines import engine_row
from reports.terminal import console, engine_list, plain

FAILED, DONE = 1, 0


def main(options: Namespace) -> int:
    """List every engine with its version, methods and precision, or why it is missing; or check some."""
    if options.check:
        return check(options.check, options.time_limit)
    with launched(options.engine) as participants:
        console().print(engine_list([engine_row(participant) for participant in participants]))
    return DONE


def check(engines: list[str], time_limit: float) -> int:
    """Say in one line each which laws hold; 1 where one does not, or where an engine cannot be asked."""
    code = DONE
    screen = console()
    with launched(engines, time_limit) as participants:
        for participant in participants:
            if isinstance(participant.info, Failure):
                screen.print(plain(f"{participant.title}: {participant.info.status}"), soft_wrap=True)
                code = FAILED
                continue
            screen.print(plain(f"{participant.title}: {', '.join(participant.methods)}"), soft_wrap=True)
            for one in examined(participant):
                for line in lines(one):
                    screen.print(plain(f"  {line}"), soft_wrap=True)
                code = FAILED if one.broken else code
    return code


def lines(one: Examined) -> Iterator[str]:
    """Yield what came of one law: a line where it holds, and one for each method that breaks it."""
    law = f"{one.law:<17}"
    if one.holds:
        but = f"; not asked: {', '.join(one.not_asked)}" if one.not_asked else ""
        yield f"holds      {law} {LAWS[one.law]}{but}"
    elif not one.broken:
        yield f"not asked  {law} {next(iter(one.not_asked.values()))}"
    for method, how in one.broken.items():
        yield f"BROKEN     {law} {method}: {how}"
