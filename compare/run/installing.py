"""Makes environments, and removes them: the only file that downloads anything.

One is made under another name and moved into place when its engine has been loaded in it.
"""

import json
import re
import shutil
import subprocess
import sys
import tempfile
from dataclasses import asdict
from pathlib import Path

from compare.run import registry
from compare.run.environments import (
    LIBRARIES,
    MARK,
    Environment,
    Place,
    environments,
    folder,
    interpreter,
    pinned,
    place_of,
    split_release,
)
from compare.run.registry import BadEngine, Package

UNREACHED = re.compile(
    "NewConnectionError|Failed to establish|Temporary failure|dns error|Timeout|versions: none"
    "|ENOTFOUND|ECONNREFUSED|EAI_AGAIN|ETIMEDOUT"
)
# What npm says first of what went wrong, after its code and before advice and where its log lies.
OF_NPM = re.compile(r"npm error (?!code )(?:[a-z]+ )?([A-Z].*)")
NO_SPACE = re.compile(r"No space left on device|Errno 28|os error 28|ENOSPC")


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
        node = make_one(making, pins, package)
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


def make_one(place: Path, pins: list[str], package: Package) -> str:
    """Make an environment by what brings the package, and return node's release, '' without it.  Raises BadEngine."""
    if package.installer == "npm":
        return make_node(place, pins)
    if package.installer == "apt":
        make_debian(place, pins, package)
    else:
        make(place, pins, package.python)
    return ""


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


def make_debian(place: Path, pins: list[str], package: Package) -> None:
    """Make an interpreter with a module of Debian's, which needs no root: it is taken out of its archive.

    The archive says by its name which Python it is for.  Raises BadEngine.
    """
    if not (shutil.which("apt-get") and shutil.which("dpkg-deb")):
        raise BadEngine("it is Debian's, and needs apt-get and dpkg-deb, which are not here")
    with tempfile.TemporaryDirectory(prefix=f"{place.name}-", dir=place.parent) as scratch:
        run(["apt-get", "download", "-qq", *package.debian], scratch)
        archives = sorted(Path(scratch).glob("*.deb"))
        release = pins[0].partition("==")[2]
        if not any(archive.name.startswith(f"{package.debian[0]}_{release}-") for archive in archives):
            found = next((one.name.split("_")[1] for one in archives if one.name.startswith(package.debian[0])), "none")
            raise BadEngine(f"Debian here has {found} of it; nothing was kept")
        for archive in archives:
            run(["dpkg-deb", "-x", str(archive), f"{scratch}/all"])
        tags = [
            tag for file in Path(scratch).rglob("*.cpython-*.so") if (tag := re.search(r"\.cpython-3(\d+)-", file.name))
        ]
        if not tags:
            raise BadEngine(f"Debian's {package.debian[0]} has no module for CPython; nothing was kept")
        make(place, pins[1:], f"3.{tags[0][1]}")
        (site,) = place.glob("lib/python3*/site-packages")
        shutil.copytree(f"{scratch}/all/usr/lib/python3/dist-packages", site, dirs_exist_ok=True)
        (place / LIBRARIES).mkdir()
        for library in Path(scratch, "all").glob("usr/lib/*/*.so.*"):
            shutil.copy(library, place / LIBRARIES / library.name, follow_symlinks=False)


def run(command: list[str], folder: str | None = None) -> None:
    """Run a command in a folder.  Raises BadEngine with what went wrong in one line."""
    done = subprocess.run(
        command, cwd=folder, stdin=subprocess.DEVNULL, capture_output=True, text=True, errors="replace"
    )
    if done.returncode == 0:
        return
    said = done.stdout + done.stderr
    if NO_SPACE.search(said):
        raise BadEngine("no space left on the disk; nothing was kept")
    lines = [line.strip() for line in said.splitlines() if line.strip()]
    told = [line.split(": ", 1)[1] for line in lines if line.startswith(("ERROR: ", "E: "))]
    told = told or [found[1] for line in lines if (found := OF_NPM.match(line))][:1] or lines
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
    """See that every method of the engine can be used there.  Raises BadEngine."""
    from compare.run.worker import Failure, Worker

    with Worker(engine, 900.0, place=place) as worker:  # what some compile first they keep in their environment
        said = worker.describe()
        for method in () if isinstance(said, Failure) else said.methods:
            said = worker.law_broken("the scene", method)
            if isinstance(said, Failure):
                break
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
