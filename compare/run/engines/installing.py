"""Makes environments, and removes them: the only file that downloads anything.

One is made under another name and moved into place when its engine has been loaded in it.
"""

import importlib.util
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Collection, Iterator, Sequence
from concurrent.futures import as_completed
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from time import sleep

from tumble.compare.run.engines import registry
from tumble.compare.run.engines.environments import (
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
from tumble.compare.run.engines.registry import BadEngine, Package
from tumble.compare.run.process.callers import Call, Callers
from tumble.compare.run.process.process import Died
from tumble.compare.run.progress import ProgressCallback, no_progress

# What the folder is called in which one is made, and the file in it that is locked meanwhile.
MAKING, LOCK = "making-", "lock"
# Of a line that pip, uv, npm or apt prints, as much as a line of progress has room for.
SHOWN = 60
UNREACHED = re.compile(
    "NewConnectionError|Failed to establish|Temporary failure|dns error|Timeout|versions: none"
    "|ENOTFOUND|ECONNREFUSED|EAI_AGAIN|ETIMEDOUT"
)
# What npm says first of what went wrong, after its code and before advice and where its log lies.
OF_NPM = re.compile(r"npm error (?!code )(?:[a-z]+ )?([A-Z].*)")
NO_SPACE = re.compile(r"No space left on device|Errno 28|os error 28|ENOSPC")


@dataclass(frozen=True)
class Site:
    """Where an environment is being made: a folder of its own, its lock, and who is told how far it is.

    Whoever works in the folder has the lock open; when nobody has, not even a child of a killed process, it is rubbish.
    """

    folder: Path
    lock: int
    on_progress: ProgressCallback

    @property
    def environment(self) -> Path:
        """The environment."""
        return self.folder / "environment"

    def run(self, command: list[str], folder: Path | None = None) -> None:
        """Run a command in a folder, and report what it prints.  Raises BadEngine with what went wrong in one line."""
        run(command, folder, self.on_progress, (self.lock,))


@contextmanager
def site(engine: str, on_progress: ProgressCallback) -> Iterator[Site]:
    """Give a place to make an environment in, and remove it, and what killed processes have left.  Raises OSError."""
    folder().mkdir(parents=True, exist_ok=True)
    sweep()
    made, lock = Path(), -1
    while lock < 0:
        made = Path(tempfile.mkdtemp(prefix=f"{MAKING}{engine}-", dir=folder()))
        lock = taken(made)
    try:
        yield Site(made, lock, on_progress)
    finally:
        os.close(lock)
        shutil.rmtree(made, ignore_errors=True)


def sweep() -> None:
    """Remove what killed processes have left: folders of ours in which nobody works."""
    for name in registry.names():
        for left in folder().glob(f"{MAKING}{name}-*"):
            with suppress(OSError):
                if (lock := taken(left)) >= 0:
                    os.close(lock)
                    shutil.rmtree(left, ignore_errors=True)


def taken(place: Path) -> int:
    """Return the lock of a folder, -1 where another process has it or has removed the folder.  Raises OSError."""
    from filelock import lock_descriptor  # 40 ms, and most commands install nothing

    try:
        lock = os.open(place / LOCK, os.O_RDWR | os.O_CREAT, 0o600)
    except FileNotFoundError:
        return -1
    try:
        if lock_descriptor(lock, blocking=False) and (place / LOCK).exists():
            return lock
    except BaseException:
        os.close(lock)
        raise
    os.close(lock)
    return -1


def full_name(engine: str) -> str:
    """Return the name of the environment that an engine is installed into.

    Parameters
    ----------
    engine : ENGINE[@RELEASE]

    Returns
    -------
    ENGINE@RELEASE

    Raises
    ------
    BadEngine : the engine is unknown, or comes with Tumble
    """
    name, release = split_release(engine)
    if not registry.package(name).pins:
        raise BadEngine(f"{name} comes with Tumble: there is nothing to install")
    return f"{name}@{release or pinned(name)}"


def installed(name: str) -> Environment | None:
    """Return the environment of a release.

    Parameters
    ----------
    name : ENGINE@RELEASE

    Returns
    -------
    None if it is not installed
    """
    return next((one for one in environments() if one.name == name), None)


def install_all(
    engines: Sequence[str],
    on_progress: ProgressCallback = no_progress,
    finished: Callable[[Environment], object] = lambda environment: None,
) -> list[BadEngine]:
    """Make several environments at once, each in a process of its own, the largest first.

    One more than there are cores, because some of them wait for a download.

    Parameters
    ----------
    engines : ENGINE@RELEASE of each, each once
    on_progress : called with each engine as it is done
    finished : called with each environment as it is made

    Returns
    -------
    why each of the others could not be made
    """
    failed: list[BadEngine] = []
    if not engines:
        return []
    *rest, largest = sorted(engines, key=lambda engine: registry.package(engine.partition("@")[0]).megabytes)
    callers = Callers(min(len(engines), (os.cpu_count() or 1) + 1))
    try:
        # The first process begins at the front, the others at the back.
        first = [largest, *rest]
        calls = [Call(install, (engine,)) for engine in first]
        made = dict(zip(callers.share_out(calls, [False] * len(calls)), first, strict=True))
        for future in as_completed(made):
            try:
                finished(future.result())
            except BadEngine as error:
                failed.append(error)
            except Died:
                failed.append(BadEngine(f"{made[future]}: its installation was killed; nothing was kept"))
            on_progress(made[future])
    except BaseException:
        callers.end()
        remove_left({engine.partition("@")[0] for engine in engines})
        raise
    callers.end()
    return failed


def remove_left(names: Collection[str]) -> None:
    """Remove what installations of those engines have left whose processes are being killed."""
    for _ in range(100):
        sweep()
        if not any(any(folder().glob(f"{MAKING}{name}-*")) for name in names):
            return
        sleep(0.02)


def install(engine: str, on_progress: ProgressCallback = no_progress) -> Environment:
    """Make the environment of ENGINE[@RELEASE], or find the one that is installed.

    Parameters
    ----------
    engine : ENGINE[@RELEASE]; without a release the pinned one
    on_progress : called with each stage of the work, with share 0 because the remaining work is unknown

    Returns
    -------
    the environment

    Raises
    ------
    BadEngine : it cannot be installed; nothing of it is left on disk
    """
    name, _, release = full_name(engine).partition("@")
    package = registry.package(name)
    if present := installed(f"{name}@{release}"):
        return present
    pins = [f"{package.pins[0].partition('==')[0]}=={release}", *package.pins[1:]]
    place = folder() / f"{name}@{release}"
    try:
        with site(name, on_progress) as made:
            node = make_one(made, pins, package)
            fly_once(name, place_of(made.environment, node), on_progress)
            python = "" if node else python_of(made.environment)
            found = Environment(
                engine=name,
                release=release,
                python=python,
                packages=tuple(pins),
                size=size_of(made.environment),
                node=node,
            )
            (made.environment / MARK).write_text(json.dumps(asdict(found), indent=1), encoding="utf-8")
            if present := installed(found.name):
                return present  # another process was faster
            shutil.rmtree(place, ignore_errors=True)  # a broken one
            made.environment.rename(place)
    except OSError as error:
        raise BadEngine(f"{name}@{release}: {error.filename or place}: {error.strerror or error}") from error
    except BadEngine as error:
        raise BadEngine(f"{name}@{release}: {error}") from error
    return found


def make_one(made: Site, pins: list[str], package: Package) -> str:
    """Make an environment by what brings the package, and return node's release, '' without it.  Raises BadEngine."""
    if package.installer == "npm":
        return make_node(made, pins)
    if package.installer == "apt":
        make_debian(made, pins, package)
    else:
        make(made, pins, package.python)
    return ""


def make(made: Site, pins: list[str], python: str) -> None:
    """Make an interpreter with those packages.  Raises BadEngine."""
    own = f"{sys.version_info.major}.{sys.version_info.minor}"
    wanted = python or own
    base = sys.executable if wanted == own else shutil.which(f"python{wanted}")
    own_python = interpreter(made.environment)
    # Neither compiles modules: those that the engine imports are compiled when it is loaded.
    if uv := shutil.which("uv") or shutil.which("uv", path=str(Path(sys.executable).parent)):
        made.run([uv, "venv", "--quiet", "--python", base or wanted, str(made.environment)])
        made.run([uv, "pip", "install", "--no-progress", "--only-binary", ":all:", "--python", own_python, *pins])
        return
    if base is None:
        raise BadEngine(f"it needs Python {wanted}, and there is no python{wanted} here")
    if importlib.util.find_spec("pip") is None:
        raise BadEngine("it needs uv or pip, and neither is here")
    made.run([base, "-m", "venv", "--without-pip", str(made.environment)])
    quiet = ("--progress-bar", "off", "--disable-pip-version-check", "--no-input", "--retries", "2", "--no-compile")
    made.run([sys.executable, "-m", "pip", "--python", own_python, "install", *quiet, "--only-binary", ":all:", *pins])


def make_debian(made: Site, pins: list[str], package: Package) -> None:
    """Make an interpreter with a module of Debian's, which needs no root: it is taken out of its archive.

    The archive says by its name which Python it is for.  Raises BadEngine.
    """
    if not (shutil.which("apt-get") and shutil.which("dpkg-deb")):
        raise BadEngine("it is Debian's, and needs apt-get and dpkg-deb, which are not here")
    scratch = made.folder / "archives"
    scratch.mkdir()
    made.run(["apt-get", "download", "-q", *package.debian], scratch)
    archives = sorted(scratch.glob("*.deb"))
    release = pins[0].partition("==")[2]
    if not any(archive.name.startswith(f"{package.debian[0]}_{release}-") for archive in archives):
        found = next((one.name.split("_")[1] for one in archives if one.name.startswith(package.debian[0])), "none")
        raise BadEngine(f"Debian here has {found} of it; nothing was kept")
    for archive in archives:
        made.run(["dpkg-deb", "-x", str(archive), f"{scratch}/all"])
    tags = [tag for file in scratch.rglob("*.cpython-*.so") if (tag := re.search(r"\.cpython-3(\d+)-", file.name))]
    if not tags:
        raise BadEngine(f"Debian's {package.debian[0]} has no module for CPython; nothing was kept")
    make(made, pins[1:], f"3.{tags[0][1]}")
    place = made.environment
    (packages,) = place.glob("lib/python3*/site-packages")
    shutil.copytree(f"{scratch}/all/usr/lib/python3/dist-packages", packages, dirs_exist_ok=True)
    (place / LIBRARIES).mkdir()
    for library in Path(scratch, "all").glob("usr/lib/*/*.so.*"):
        shutil.copy(library, place / LIBRARIES / library.name, follow_symlinks=False)


def run(
    command: list[str],
    folder: Path | None = None,
    on_progress: ProgressCallback = no_progress,
    held: Collection[int] = (),
) -> None:
    """Run a command in a folder, and report each line that it prints as it comes.

    held: descriptors that stay open in it.  Raises BadEngine with what went wrong in one line.
    """
    pipe = subprocess.PIPE
    lines: list[str] = []
    with subprocess.Popen(
        command, cwd=folder, stdin=subprocess.DEVNULL, stdout=pipe, stderr=subprocess.STDOUT, text=True,
        errors="replace", pass_fds=() if sys.platform == "win32" else tuple(held),
    ) as process:  # fmt: skip
        try:
            assert process.stdout is not None
            for line in process.stdout:
                if stripped := line.strip():
                    lines.append(stripped)
                    on_progress(stripped[:SHOWN], 0.0)
        except BaseException:
            process.kill()
            raise
    if process.returncode == 0:
        return
    said = "\n".join(lines)
    if NO_SPACE.search(said):
        raise BadEngine("no space left on the disk; nothing was kept")
    told = [line.split(": ", 1)[1] for line in lines if line.startswith(("ERROR: ", "E: "))]
    told = told or [found[1] for line in lines if (found := OF_NPM.match(line))][:1] or lines
    where = " (the package index was not reached, or has none)" if UNREACHED.search(said) else ""
    raise BadEngine(
        f"{told[-1] if told else f'{command[0]} ended with code {process.returncode}'}{where}; nothing was kept"
    )


def make_node(made: Site, pins: list[str]) -> str:
    """Install those packages of npm there, without running any script of theirs, and return node's release.

    Raises BadEngine.
    """
    node, npm = shutil.which("node"), shutil.which("npm")
    if node is None or npm is None:
        raise BadEngine("it needs node and npm, which are not here")
    made.environment.mkdir()
    (made.environment / "package.json").write_text("{}")
    quiet = (
        "--no-audit",
        "--no-fund",
        "--no-update-notifier",
        "--loglevel=error",
        "--fetch-retries=1",
        "--fetch-retry-mintimeout=1000",
    )
    exact = [pin.replace("==", "@") for pin in pins]
    made.on_progress(f"npm install {' '.join(exact)}", 0.0)
    made.run([npm, "install", "--prefix", str(made.environment), "--ignore-scripts", *quiet, *exact])
    done = subprocess.run([node, "--version"], capture_output=True, text=True, check=True)
    return done.stdout.strip().removeprefix("v")


def fly_once(engine: str, place: Place, on_progress: ProgressCallback) -> None:
    """See that every method of the engine can be used there.  Raises BadEngine."""
    from tumble.compare.run.status import Failure
    from tumble.compare.run.worker import Worker

    with Worker(engine, 900.0, place=place) as worker:  # what some compile first they keep in their environment
        on_progress(f"loading {engine}", 0.0)
        said = worker.describe()
        has_plane = not isinstance(said, Failure) and "plane" in said.features
        for method in () if isinstance(said, Failure) else said.methods:
            on_progress(f"trying {engine}:{method}", 0.0)
            said = worker.check_failure("the scene", method)
            if isinstance(said, Failure):
                break
            if has_plane:
                worker.check_failure("stays above", method)  # whatever comes of it
    if isinstance(said, Failure):
        raise BadEngine(f"installed, but it cannot be used: {said}; nothing was kept")


def python_of(place: Path) -> str:
    """Return the release of an environment's Python."""
    words = [interpreter(place), "-c", "import platform; print(platform.python_version())"]
    return subprocess.run(words, capture_output=True, text=True, check=True).stdout.strip()


def size_of(place: Path) -> int:
    """Return what all files of a folder take [bytes]."""
    return sum(file.lstat().st_size for file in place.rglob("*"))


def remove(engine: str) -> list[Environment]:
    """Remove the environment of ENGINE@RELEASE, or all environments of ENGINE.

    Parameters
    ----------
    engine : ENGINE[@RELEASE]

    Returns
    -------
    the environments that were removed

    Raises
    ------
    BadEngine : no such environment is installed
    """
    name, release = split_release(engine)
    gone = [one for one in environments() if one.engine == name and release in ("", one.release)]
    if not gone:
        there = ", ".join(one.name for one in environments()) or "none"
        raise BadEngine(f"{engine} is not installed in an environment of its own; there is {there}")
    for one in gone:
        with site(one.engine, no_progress) as rubbish:
            (folder() / one.name).rename(rubbish.environment)  # from here on it is none
    return gone
