"""Environments: an engine's own interpreter and packages, one folder each, so that any release of it can take part.

They lie in the user's cache folder, or where TUMBLE_ENVIRONMENTS says.  One is made under another name and moved into
place when its engine has been loaded in it: there is never a half-made one.  Only `install` downloads anything.
"""

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from pathlib import Path

from compare.run import registry
from compare.run.program import ENVIRONMENT
from compare.run.registry import BadEngine

MARK = "environment.json"  # written last; a folder without it is no environment
RELEASE = re.compile(r"[0-9A-Za-z][0-9A-Za-z.!+_-]*")
UNREACHED = re.compile(
    "NewConnectionError|Failed to establish|Temporary failure|dns error|Timeout|versions: none"
    "|ENOTFOUND|ECONNREFUSED|EAI_AGAIN|ETIMEDOUT"
)
NO_SPACE = re.compile(r"No space left on device|Errno 28|os error 28|ENOSPC")


@dataclass(frozen=True)
class Environment:
    """One that is there: engine, release, Python's release, what is installed, its size [bytes], node's release.

    One without a Python of its own has packages of npm, and its engine is a program.
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
    """Where an engine's process runs: the path of its Python, and what its environment variables say beyond ours."""

    python: str
    told: Mapping[str, str] = field(default_factory=dict)


HERE = Place(sys.executable)


def place_of(environment: Path, node: str) -> Place:
    """Return where the engine of an environment runs, of node's where there is one."""
    return Place(sys.executable, {ENVIRONMENT: str(environment)}) if node else Place(interpreter(environment))


def folder() -> Path:
    """Return where environments lie."""
    if stated := os.environ.get("TUMBLE_ENVIRONMENTS"):
        return Path(stated).absolute()
    cache = os.environ.get("XDG_CACHE_HOME") or (
        Path.home() / ("Library/Caches" if sys.platform == "darwin" else ".cache")
    )
    return Path(cache, "tumble", "environments")


def interpreter(place: Path) -> str:
    """Return the path of the Python of an environment."""
    return str(place / ("Scripts/python.exe" if os.name == "nt" else "bin/python"))


def environments() -> list[Environment]:
    """Return those that are there, by name."""
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
    name, at, release = engine.partition("@")
    if at and not RELEASE.fullmatch(release):
        raise BadEngine(f"{engine}: a release is written as in {name}@1.2.3")
    if at and not registry.package(name).pins:
        raise BadEngine(f"{engine}: {name} has no releases of its own")
    return name, release


def beside(engine: str) -> str | None:
    """Return the release of an engine that is installed beside Tumble, '' for one that needs no package, or None."""
    packages = registry.package(engine).packages
    for package in packages:
        from importlib import metadata  # it brings a parser of letters, which only a named release has a use for

        with suppress(metadata.PackageNotFoundError):
            return metadata.version(package)
    return None if packages else ""


def located(engine: str) -> tuple[str, Place | None, str]:
    """Return the name of ENGINE[@RELEASE] of ours and where it runs, or None and why it is nowhere."""
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


def install(engine: str) -> Environment:
    """Make the environment of ENGINE[@RELEASE], or find it there.  Raises BadEngine; then nothing of it is left."""
    name, release = split_release(engine)
    package = registry.package(name)
    if not package.pins:
        raise BadEngine(f"{name} comes with Tumble: there is nothing to install")
    release = release or pinned(name)
    if present := next((one for one in environments() if one.name == f"{name}@{release}"), None):
        return present
    pins = [f"{package.pins[0].partition('==')[0]}=={release}", *package.pins[1:]]
    place = folder() / f"{name}@{release}"
    try:
        folder().mkdir(parents=True, exist_ok=True)
        making = Path(tempfile.mkdtemp(prefix=f"making-{name}-", dir=folder()))
    except OSError as error:
        raise BadEngine(f"{error.filename}: {error.strerror}") from error
    try:
        node = make_node(making, pins) if package.installer == "npm" else ""
        if not node:
            make(making, pins, package.python)
        fly_once(name, place_of(making, node))
        python = "" if node else python_of(making)
        found = Environment(name, release, python, tuple(pins), size_of(making), node)
        (making / MARK).write_text(json.dumps(asdict(found), indent=1), encoding="utf-8")
        if present := next((one for one in environments() if one.name == found.name), None):
            return present  # another process was faster
        shutil.rmtree(place, ignore_errors=True)  # a broken one
        making.rename(place)
    except OSError as error:
        raise BadEngine(f"{name}@{release}: {error.filename or place}: {error.strerror or error}") from error
    except BadEngine as error:
        raise BadEngine(f"{name}@{release}: {error}") from error
    finally:
        shutil.rmtree(making, ignore_errors=True)
    return found


def make(place: Path, pins: list[str], python: str) -> None:
    """Make an interpreter with those packages.  Raises BadEngine."""
    own = f"{sys.version_info.major}.{sys.version_info.minor}"
    wanted = python or own
    uv = shutil.which("uv")
    if uv:
        run([uv, "venv", "--quiet", "--clear", "--python", wanted, str(place)])
        run([uv, "pip", "install", "--quiet", "--only-binary", ":all:", "--python", interpreter(place), *pins])
        return
    base = sys.executable if wanted == own else shutil.which(f"python{wanted}")
    if base is None:
        raise BadEngine(f"it needs Python {wanted}, and there is no python{wanted} here")
    run([base, "-m", "venv", str(place)])
    quiet = ("--quiet", "--disable-pip-version-check", "--no-input", "--retries", "2")
    run([interpreter(place), "-m", "pip", "install", *quiet, "--only-binary", ":all:", *pins])


def run(command: list[str]) -> None:
    """Run a command.  Raises BadEngine with what went wrong in one line."""
    done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, errors="replace")
    if done.returncode == 0:
        return
    said = done.stdout + done.stderr
    if NO_SPACE.search(said):
        raise BadEngine("no space left on the disk; nothing was kept")
    lines = [line.strip() for line in said.splitlines() if line.strip()]
    told = [line.removeprefix("ERROR: ") for line in lines if line.startswith("ERROR: ")] or lines
    where = " (the package index was not reached, or has none)" if UNREACHED.search(said) else ""
    raise BadEngine(
        f"{told[-1] if told else f'{command[0]} ended with code {done.returncode}'}{where}; nothing was kept"
    )


def make_node(place: Path, pins: list[str]) -> str:
    """Install those packages of npm there, without running any script of theirs, and return node's release.

    Raises BadEngine.
    """
    node, npm = shutil.which("node"), shutil.which("npm")
    if node is None or npm is None:
        raise BadEngine("it needs node and npm, which are not here")
    (place / "package.json").write_text("{}")
    quiet = (
        "--no-audit",
        "--no-fund",
        "--no-update-notifier",
        "--loglevel=error",
        "--fetch-retries=1",
        "--fetch-retry-mintimeout=1000",
    )
    exact = [pin.replace("==", "@") for pin in pins]
    run([npm, "install", "--prefix", str(place), "--ignore-scripts", *quiet, *exact])
    done = subprocess.run([node, "--version"], capture_output=True, text=True, check=True)
    return done.stdout.strip().removeprefix("v")


def fly_once(engine: str, place: Place) -> None:
    """See that the engine can be used there.  Raises BadEngine."""
    from compare.run.worker import Failure, Worker

    with Worker(engine, 120.0, place=place) as worker:
        said = worker.describe()
        if not isinstance(said, Failure):
            said = worker.law_broken("the scene", said.methods[0])
    if isinstance(said, Failure):
        raise BadEngine(f"installed, but it cannot be used: {said.status}; nothing was kept")


def python_of(place: Path) -> str:
    """Return the release of an environment's Python."""
    words = [interpreter(place), "-c", "import platform; print(platform.python_version())"]
    return subprocess.run(words, capture_output=True, text=True, check=True).stdout.strip()


def size_of(place: Path) -> int:
    """Return what all files of a folder take [bytes]."""
    return sum(file.lstat().st_size for file in place.rglob("*"))


def remove(engine: str) -> list[Environment]:
    """Remove the environment of ENGINE@RELEASE, or all of ENGINE, and return them.  Raises BadEngine for none."""
    name, release = split_release(engine)
    gone = [one for one in environments() if one.engine == name and release in ("", one.release)]
    if not gone:
        there = ", ".join(one.name for one in environments()) or "none"
        raise BadEngine(f"{engine} is not installed in an environment of its own; there is {there}")
    for one in gone:
        (folder() / one.name / MARK).unlink()  # from here on it is none
        shutil.rmtree(folder() / one.name)
    return gone


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
