"""`tumble engines`: who can take part here, their environments, laws put to an engine, and one to begin with."""

from argparse import Namespace
from collections.abc import Iterator
from pathlib import Path

from tumble.compare.engines import LAWS
from tumble.compare.run.engines import environments, installing, registry
from tumble.compare.run.engines.examine import Examined, examined
from tumble.compare.run.engines.registry import BadEngine
from tumble.compare.run.running_engines import launched, split
from tumble.compare.run.worker import Failure
from tumble.compare.tables.engines import engine_row
from tumble.compare.tables.files import write_together
from tumble.notes import display, note
from tumble.reports.terminal import console, engine_list, plain
from tumble.starters import STARTERS, Starter

FAILED, DONE = 1, 0


def main(options: Namespace) -> int:
    """List every engine with its version, methods and precision, or why it is missing; or do what is asked."""
    for engine in options.remove:
        for gone in installing.remove(known(engine)):
            print_line(f"removed {described(gone)}")
    for engine in options.install:
        note(f"making an environment for {known(engine)}")
        with display(options)(doing=f"installing {engine}") as on_progress:
            made = installing.install(engine, on_progress)
        print_line(described(made))
    if options.template:
        begin(STARTERS[options.template])
    if options.check:
        return check(options.check, options.time_limit)
    if not (options.install or options.remove or options.template):
        listing(options.engine)
    return DONE


def listing(asked: list[str]) -> None:
    """Print who can take part, the environments there are, and those that could be."""
    with launched(asked or registry.names()) as running_engines:
        console().print(engine_list([engine_row(running_engine) for running_engine in running_engines]))
    if asked:
        return
    there = environments.environments()
    for environment in there:
        print_line(described(environment))
    for name in registry.names():
        package = registry.package(name)
        if package.apart and not any(environment.engine == name for environment in there):
            print_line(
                f"{name} needs an environment of its own, {package.megabytes} MB: tumble engines --install {name}"
            )


def begin(starter: Starter) -> None:
    """Write a starter's files into the current folder, all or none, and say how to go on.  Raises BadEngine."""
    texts = starter.files
    for name in texts:
        if Path(name).exists():
            raise BadEngine(f"{name} is here already: nothing was written")
    write_together({Path(name): text for name, text in texts.items()})
    print_line(f"wrote {' and '.join(texts)}; next:")
    check_it, compare_it = (
        f"tumble engines --check ./{starter.engine}",
        f"tumble compare brick-tumble -e ./{starter.engine}",
    )
    for line in filter(None, (starter.build, check_it, compare_it)):
        print_line(f"  {line}")


def described(environment: environments.Environment) -> str:
    """Return what an environment is, in one line."""
    size = f"{environment.size / 1e6:.0f} MB"
    runs = f"node {environment.node}" if environment.node else f"Python {environment.python}"
    return f"{environment.name}: {runs}, {', '.join(environment.packages)}, {size}"


def known(engine: str) -> str:
    """Return ENGINE[@RELEASE] of ours.  Raises BadEngine for another, and for one with a method."""
    name, method = split(engine)
    if method or registry.is_file(name):
        raise BadEngine(f"{engine}: what is installed is ENGINE or ENGINE@RELEASE")
    return engine


def print_line(text: str) -> None:
    """Print a line of results, however long."""
    console().print(plain(text), soft_wrap=True)


def check(engines: list[str], time_limit: float) -> int:
    """Say in one line each which laws hold; 1 where one does not, or where an engine cannot be asked."""
    code = DONE
    with launched(engines, time_limit) as running_engines:
        for running_engine in running_engines:
            if isinstance(running_engine.info, Failure):
                print_line(f"{running_engine.title}: {running_engine.info.status}")
                code = FAILED
                continue
            print_line(f"{running_engine.title}: {', '.join(running_engine.methods)}")
            for one in examined(running_engine):
                for line in lines(one):
                    print_line(f"  {line}")
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
