"""Who is asked for: the engines and methods that words such as ENGINE[@RELEASE][:METHOD] name, and their titles."""

import os
from collections.abc import Iterable, Iterator
from contextlib import suppress
from itertools import count
from pathlib import Path

from tumble.compare.run.contestant import Contestant, MethodName
from tumble.compare.run.engines import registry
from tumble.compare.run.engines.environments import split_release
from tumble.compare.run.engines.registry import BadEngine, EngineInfo
from tumble.compare.run.status import Failure
from tumble.scenarios.format import nearest


def known_contestant(item: str) -> Contestant:
    """Return the contestant that a text names, and check that its engine exists.

    Parameters
    ----------
    item : ENGINE[@RELEASE][:METHOD] or FILE[:METHOD]

    Returns
    -------
    the contestant; its method is not checked

    Raises
    ------
    BadEngine : the engine is unknown or has no releases, its release is malformed, or the file does not exist
    """
    asked = Contestant.parse(item)
    if registry.is_file(asked.engine):
        if not Path(asked.engine).is_file():
            raise BadEngine(f"{asked.engine}: no such engine file")
    elif asked.engine not in registry.names():
        raise BadEngine(f"unknown engine {asked.engine!r}: {nearest(asked.engine, registry.names())}")
    else:
        split_release(asked.engine_release)
    return asked


def wanted(asked: Iterable[str]) -> dict[str, list[str]]:
    """Return the engines that were asked for, with their methods.

    Parameters
    ----------
    asked : ENGINE[@RELEASE][:METHOD] or FILE[:METHOD] of each; empty: the usual engines of Tumble

    Returns
    -------
    the methods asked for, by engine, in the order given; an empty name stands for the usual methods

    Raises
    ------
    BadEngine : an engine is unknown or has no releases, its release is malformed, or a file does not exist
    """
    engines: dict[str, dict[str, None]] = {}
    for one in map(known_contestant, asked):
        engines.setdefault(one.engine_release, {})[str(one.method)] = None
    return {engine: [*methods] for engine, methods in engines.items()} or {engine: [""] for engine in registry.usual()}


def engine_files(asked: Iterable[str]) -> Iterator[str]:
    """Yield the user's engine files among FILE.py[:METHOD], FILE.toml[:METHOD], ENGINE[:METHOD] ..."""
    for item in asked:
        with suppress(BadEngine):
            if registry.is_file(engine := Contestant.parse(item).engine):
                yield engine


def titles(engines: Iterable[str]) -> dict[str, str]:
    """Return the names of engines in tables.

    Parameters
    ----------
    engines : ENGINE[@RELEASE], or path of a user's file, of each

    Returns
    -------
    the title of each engine, by engine; files of one name have as much of their paths as makes the titles distinct
    """
    named = {engine: registry.title(engine) for engine in engines}
    for title in set(named.values()):
        folders = {file: Path(os.path.abspath(file)).parts[:-1] for file in named if named[file] == title}
        apart = set(folders.values())
        if len(apart) > 1:
            depth = next(n for n in count(1) if len({parts[-n:] for parts in apart}) == len(apart))
            named |= {file: "/".join((*parts[-depth:], title)) for file, parts in folders.items()}
    return named


def chosen(engine: str, asked: list[str], info: EngineInfo | Failure, few: bool = False) -> tuple[str, ...]:
    """Return the methods of an engine that take part.

    Parameters
    ----------
    engine : ENGINE[@RELEASE], or path of a user's file
    asked : methods that were asked for; an empty name: the usual ones
    info : what the engine's file states, or why the engine is not available
    few : whether the usual methods are only those that a page shows

    Returns
    -------
    the methods, each once; of an engine that is not available, those in `asked`

    Raises
    ------
    BadEngine : the engine has no method of that name
    """
    if isinstance(info, Failure):
        return tuple(asked)
    usual = (*info.shown, *info.contact) if few else (*info.methods, *info.forced, *info.contact)
    found: dict[str, None] = {}
    for method in asked:
        known = info.every_method
        if method and method not in known and not is_tolerance(method, info):
            raise BadEngine(f"unknown method of {registry.title(engine)} {method!r}: {nearest(method, known)}")
        found |= dict.fromkeys([method] if method else usual)
    return tuple(found)


def is_tolerance(method: str, info: EngineInfo) -> bool:
    """Whether this is METHOD@TOLERANCE of an adaptive method."""
    asked = MethodName.parse(method)
    try:
        return str(asked.without_tolerance) in info.adaptive and 0 < float(asked.tolerance) < 1
    except ValueError:
        return False
