"""`tumble engines`: list engines, install them, check one against the engine contract, write an example."""

from argparse import Namespace
from collections.abc import Iterator
from pathlib import Path

from tumble.compare.engines import CHECKS, CONTACT_CHECKS
from tumble.compare.run.asked import known_contestant
from tumble.compare.run.engines import environments, installing, registry
from tumble.compare.run.engines.examine import Examined, examined
from tumble.compare.run.engines.registry import BadEngine
from tumble.compare.run.running_engines import launched
from tumble.compare.run.status import Failure
from tumble.compare.tables.engines import engine_row
from tumble.compare.tables.files import write_together
from tumble.notes import display, note, notes
from tumble.reports.terminal import console, engine_list, plain
from tumble.starters import STARTERS, Starter

DONE, FAILED, WRONG = 0, 1, 2


def main(options: Namespace) -> int:
    """List every engine with version, methods and precision, or why it is missing; or do what is asked."""
    for engine in options.remove:
        for gone in installing.remove(known(engine)):
            print_line(f"removed {described(gone)}")
    if options.install and (code := install(options)):
        return code
    if options.template:
        begin(STARTERS[options.template])
    if options.check:
        return check(options.check, options.time_limit)
    if not (options.install or options.remove or options.template):
        listing(options.engine)
    return DONE


def install(options: Namespace) -> int:
    """Install every engine asked for, and print a line for each; return 2 if one cannot be installed."""
    asked = dict.fromkeys(installing.full_name(known(engine)) for engine in options.install)
    here = {name: found for name in asked if (found := installing.installed(name))}
    for name, found in here.items():
        note(f"{name} is installed already")
        print_line(described(found))
    missing = [name for name in asked if name not in here]
    if not missing:
        return DONE
    note(f"making {'an environment' if len(missing) == 1 else 'environments'} for {', '.join(missing)}")
    with display(options)(len(missing), "installing") as on_progress:
        failed = installing.install_all(missing, on_progress, lambda made: print_line(described(made)))
    notes(map(str, failed))
    return WRONG if failed else DONE


def listing(engines: list[str]) -> None:
    """Print the engines, their environments, and how to install those that need one."""
    with launched(engines or registry.names()) as running_engines:
        console().print(engine_list([engine_row(running_engine) for running_engine in running_engines]))
    if engines:
        return
    there = environments.environments()
    for environment in there:
        print_line(described(environment))
    for name in registry.names():
        package = registry.package(name)
        if package.apart and not any(environment.engine == name for environment in there):
            print_line(
                f"{name} needs its own environment ({package.megabytes} MB): type `tumble engines --install {name}`"
            )


def begin(starter: Starter) -> None:
    """Write an example engine into the current folder, all files or none, and print what to type.  Raises BadEngine."""
    texts = starter.files
    for name in texts:
        if Path(name).exists():
            raise BadEngine(f"{name} exists already: nothing was written")
    write_together({Path(name): text for name, text in texts.items()})
    print_line(f"wrote {' and '.join(texts)}; next:")
    check_it, compare_it = (
        f"tumble engines --check ./{starter.engine}",
        f"tumble compare brick-tumble -e ./{starter.engine}",
    )
    for line in filter(None, (starter.build, check_it, compare_it)):
        print_line(f"  {line}")


def described(environment: environments.Environment) -> str:
    """Describe an environment in one line."""
    size = f"{environment.size / 1e6:.0f} MB"
    runs = f"node {environment.node}" if environment.node else f"Python {environment.python}"
    return f"{environment.name}: {runs}, {', '.join(environment.packages)}, {size}"


def known(engine: str) -> str:
    """Return ENGINE[@RELEASE].  Raises BadEngine for an engine file, and for an engine with a method."""
    asked = known_contestant(engine)
    name, method = asked.engine_release, str(asked.method)
    if method or registry.is_file(name):
        raise BadEngine(f"{engine}: give ENGINE or ENGINE@RELEASE, without a method")
    return engine


def print_line(text: str) -> None:
    """Print a line of results, however long."""
    console().print(plain(text), soft_wrap=True)


def check(engines: list[str], time_limit: float) -> int:
    """Print the result of every contract check; return 1 if one fails, or if an engine cannot be checked."""
    code = DONE
    with launched(engines, time_limit) as running_engines:
        for running_engine in running_engines:
            if isinstance(running_engine.info, Failure):
                print_line(f"{running_engine.title}: {running_engine.info}")
                code = FAILED
                continue
            print_line(f"{running_engine.title}: {', '.join(running_engine.methods)}")
            for one in examined(running_engine):
                for line in lines(one):
                    print_line(f"  {line}")
                code = FAILED if one.broken else code
    return code


def lines(one: Examined) -> Iterator[str]:
    """Yield the result of one check: a line if it passed, and one for each method that fails it."""
    name = f"{one.check:<17}"
    if one.holds:
        but = f"; skipped: {', '.join(one.not_asked)}" if one.not_asked else ""
        yield f"passed   {name} {(CHECKS | CONTACT_CHECKS)[one.check]}{but}"
    elif not one.broken and not one.known:
        yield f"skipped  {name} {next(iter(one.not_asked.values()))}"
    for method, how in one.known.items():
        yield f"known    {name} {method}: {how}"
    for method, how in one.broken.items():
        yield f"FAILED   {name} {method}: {how}"
