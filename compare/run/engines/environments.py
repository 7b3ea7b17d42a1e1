"""Environments: an engine's own interpreter and packages, one folder each, so that any release of it can take part.

They lie in the user's cache folder, or where TUMBLE_ENVIRONMENTS says.  One is made under another name and moved into
place when its engine has been loaded in it: there is never a half-made one.  tumble.compare.run.engines.installing
makes them.
"""

import json
import os
import re
import subprocess
import sys
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

from tumble.compare.run.contestant import Contestant
from tumble.compare.run.engines import registry
from tumble.compare.run.engines.program import ENVIRONMENT
from tumble.compare.run.engines.registry import BadEngine

MARK = "environment.json"  # written last; a folder without it is no environment
LIBRARIES = "libraries"  # what Debian has beside its package of Python


@dataclass(frozen=True)
class Environment:
    """One environment that is installed.

    One without a Python of its own has packages of npm, and its engine is a program.

    Parameters
    ----------
    engine : name of the engine
    release : release of the engine
    python : release of Python; empty if the environment has none of its own
    packages : installed packages, PACKAGE==RELEASE of each
    size : size on disk [B]
    node : release of node; empty if the engine does not need node
    """

    engine: str
    release: str
    python: str
    packages: tuple[str, ...]
    size: int
    node: str = ""

    @property
    def name(self) -> str:
        """ENGINE@RELEASE."""
        return f"{self.engine}@{self.release}"

    @property
    def place(self) -> "Place":
        """Where its engine runs."""
        return place_of(folder() / self.name, self.node)


@dataclass(frozen=True)
class Place:
    """Where an engine's process runs: the path of its Python, and the environment variables that it has beyond ours."""

    python: str
    variables: Mapping[str, str] = field(default_factory=dict)


HERE = Place(sys.executable)


def place_of(environment: Path, node: str) -> Place:
    """Return where the engine of an environment runs, of node's where there is one."""
    if node:
        return Place(sys.executable, {ENVIRONMENT: str(environment)})
    libraries = environment / LIBRARIES
    return Place(interpreter(environment), {"LD_LIBRARY_PATH": str(libraries)} if libraries.is_dir() else {})


def folder() -> Path:
    """Return where environments lie."""
    if stated := os.environ.get("TUMBLE_ENVIRONMENTS"):
        return Path(stated).absolute()
    from platformdirs import user_cache_path  # 20 ms, and seldom needed

    return user_cache_path("tumble", appauthor=False) / "environments"


def interpreter(place: Path) -> str:
    """Return the path of the Python of an environment."""
    return str(place / ("Scripts/python.exe" if os.name == "nt" else "bin/python"))


def environments() -> list[Environment]:
    """Return the environments that are installed.

    Returns
    -------
    the environments, sorted by name
    """
    found = []
    for mark in sorted(folder().glob(f"*/{MARK}")):
        with suppress(OSError, ValueError, TypeError):
            stated = json.loads(mark.read_text(encoding="utf-8"))
            found.append(Environment(**{**stated, "packages": tuple(stated["packages"])}))
    return [
        one for one in found if (folder() / one.name / "node_modules" if one.node else Path(one.place.python)).exists()
    ]


def split_release(engine: str) -> tuple[str, str]:
    """Return name and release ('' where none is asked for) of ENGINE[@RELEASE].  Raises BadEngine."""
    asked = Contestant.parse(engine)
    if asked.release and not registry.package(asked.engine).pins:
        raise BadEngine(f"{engine}: {asked.engine} has no releases of its own")
    return asked.engine, asked.release


def beside(engine: str) -> str | None:
    """Return the release of an engine that is installed beside Tumble, '' for one that needs no package, or None."""
    packages = registry.package(engine).packages
    for package in packages:
        from importlib import metadata  # it brings a parser of letters, which only a named release has a use for

        with suppress(metadata.PackageNotFoundError):
            return metadata.version(package)
    return None if packages else ""


def located(engine: str) -> tuple[str, Place | None, str]:
    """Return where one of our own engines runs.

    Parameters
    ----------
    engine : ENGINE[@RELEASE]

    Returns
    -------
    name of the engine; where it runs, or None if it is not installed; the reason for None, else empty

    Raises
    ------
    BadEngine : the release is malformed, or the engine has no releases
    """
    name, release = split_release(engine)
    here = beside(name)
    if here is not None and release in ("", here):
        return name, HERE, ""
    found = [one for one in environments() if one.engine == name and release in ("", one.release)]
    if found:
        preferred = [one for one in found if one.release == pinned(name)]
        return name, (preferred or found)[-1].place, ""
    if not registry.package(name).pins:
        return name, HERE, ""  # where importing it says what is missing
    return name, None, f"not installed; tumble engines --install {engine}"


def pinned(engine: str) -> str:
    """Return the release that is installed where none is asked for."""
    return registry.package(engine).pins[0].partition("==")[2]


def releases_here(engine: str) -> list[str]:
    """Return the releases of an engine that can take part: beside Tumble and in environments, the oldest first."""
    here = beside(engine)
    return in_order({*(one.release for one in environments() if one.engine == engine), *((here,) if here else ())})


def releases_on_index(engine: str) -> list[str]:
    """Return the releases that the package index has for this machine, the oldest first.  Raises BadEngine."""
    package = registry.package(engine)
    if package.installer == "npm":
        done = asked_of(["npm", "view", package.packages[0], "versions", "--json"], engine)
        return in_order(json.loads(done))
    asked = [sys.executable, "-m", "pip", "index", "versions", package.packages[0], "--disable-pip-version-check"]
    found = re.search(r"^Available versions: (.*)$", asked_of([*asked, "--retries", "2"], engine), re.MULTILINE)
    return in_order(found.group(1).split(", ") if found else ())


def asked_of(command: list[str], engine: str) -> str:
    """Return what a client of the package index answers.  Raises BadEngine."""
    done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, errors="replace")
    if done.returncode:
        raise BadEngine(f"{engine}: the package index does not say which releases there are")
    return done.stdout


def in_order(releases: Iterable[str]) -> list[str]:
    """Return releases by their numbers, those with letters, which are no releases yet, left out."""
    plain = [release for release in releases if re.fullmatch(r"\d+(\.\d+)*(\.post\d+)?", release)]
    return sorted(plain, key=numbers_of)


def numbers_of(release: str) -> list[int]:
    """Return the numbers of a release, in its order."""
    return [int(number) for number in re.findall(r"\d+", release)]
