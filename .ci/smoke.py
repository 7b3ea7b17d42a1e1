#!/usr/bin/env python3
"""Installs Tumble as its users do, and runs every command, on every Python that it finds.

Each Python gets two environments: one with the newest dependencies that pyproject.toml allows, one with the lowest.
The newest Python runs every command with the newest; the reference Python runs with the lowest, because the tests have
run with newer ones, the commands that load a library each.  The remaining environments run a few commands.  `--all`
runs every command in each.
This file does not depend on the layout of the package.  It needs uv, or gets it from the package index.
"""

import argparse
import glob
import json
import os
import shutil
import signal
import subprocess
import sys
import tarfile
import tempfile
import time
import urllib.request
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PYTHONS = ("3.11", "3.12", "3.13")
REFERENCE = "3.11"
RESOLUTIONS = {"newest": "highest", "lowest": "lowest-direct"}
SHOWN = ("numpy", "numba", "pandas", "scipy", "rich")
# A command takes seconds; one that takes longer than this hangs, however busy the machine is [s].
COMMAND_S, LAB_S = 600.0, 120.0

# Short scenes, so that every command is quick; the second has a stiff force.
BODY = """
duration = 0.2
samples = 4
step = 0.01

[body]
shape = "box"
size = [0.4, 0.15, 0.1]
mass = 2.4
angular_velocity = [0.2, 3.0, 0.4]

[[impulse]]
time = 0.0
value = [-3.1, 0.9, 2.2]
vertex = 0
"""
DENSE = """
[ensemble]
throws = 100
seed = 1
magnitude = 0.1
"""
SPRING = """
[[tether]]
vertex = 7
anchor = [0.0, 1.0, 0.0]
stiffness = 80.0
damping = 0.6
"""


class Failed(Exception):
    """A step that failed; the message has the command and the end of its output."""


@dataclass(frozen=True)
class Step:
    """A command with its expected exit code, a text that it prints, and a file that it writes."""

    words: str
    prints: str = ""
    writes: str = ""
    code: int = 0


# The error of rk4 at 0.01 s is 1e-5 m, of Euler 1e-2 m: one is graded as right, the other as wrong.
TWO = "-e tumble:rk4 -e mujoco:euler"
STEPS = (
    Step("--version"),
    Step("--help", prints="COMMAND"),
    Step("scenes", prints="two-hits"),
    Step("scenes yardstick", prints="[body]"),
    Step("engines -e tumble -e mujoco -e scipy -e handcalc", prints="mujoco"),
    Step("engines --template python", writes="mine.py"),
    Step("engines --check ./mine.py", prints="passed   converges"),
    Step("run free.toml -e tumble:rk4 -o rk4.csv", writes="rk4.csv"),
    Step("run free.toml -e mujoco:euler -o euler.csv", writes="euler.csv"),
    Step(f"compare free.toml {TWO} -e scipy:dop853 -o compared", prints="most accurate", writes="compared/runs.csv"),
    Step("compare table-4-1 -e handcalc:as-printed", prints="handcalc"),
    Step(f"sweep free.toml {TWO} -o swept", prints="mujoco:euler", writes="swept/work-precision.csv"),
    Step(f"advise free.toml --tolerance 1e-3 {TWO}", prints="tumble:rk4"),
    Step("stability spring.toml -e mujoco:euler -o stable", prints="mujoco:euler", writes="stable/limits.csv"),
    Step("ablate free.toml -e mujoco:euler -o ablated", prints="mujoco", writes="ablated/ablation.csv"),
    Step("run dense.toml -e tumble:rk4 -o dense.csv", writes="dense.csv"),
    Step(f"compare dense.toml {TWO}", prints="most accurate"),  # 400 samples of 100 throws
    Step("grade euler.csv --scene free.toml", prints="MuJoCo"),
    Step("grade rk4.csv --scene free.toml --tolerance 0.01 --json", prints='"'),
    Step(f"check free.toml {TWO} --no-times --accept -o record", writes="record"),
    Step("check --baseline record --no-times"),
    Step(f"report free.toml {TWO} -o page.html", writes="page.html"),
    Step("report --from page-tables -o again.html", writes="again.html"),
    Step("compare free.toml -e mujoco:euler --shard 1/1", writes="shard-1-of-1"),
    Step("merge shard-1-of-1 -o merged", writes="merged/runs.csv"),
    Step("columns", prints="runs.csv"),
    Step("columns runs", prints="max_error_m"),
    Step("releases --help", prints="ENGINE"),
    Step("releases mujoco free.toml", code=2),  # only one release is installed
    Step("lab --help", prints="SCENE"),
)
# Commands that load kernels and engines, so that they find what another release of a library breaks.
FEW = ("--version", "scenes", "run free.toml -e tumble:rk4 -o rk4.csv", "run free.toml -e mujoco:euler -o euler.csv")
# With the lowest dependencies also one command for each library that commands load.
LOADING = (*FEW, "compare", "grade euler.csv", "check", "report free.toml", "engines --")
# Commands that need the extras.
EXTRA_STEPS = (Step("compare free.toml -e mujoco:euler --svg errors.svg", writes="errors.svg"),)


@dataclass
class Cell:
    """One environment: a Python, newest or lowest dependencies, and its results."""

    version: str
    python: Path
    resolution: str
    folder: Path
    whole: bool  # whether the extras and the lab are tried too, and more commands than FEW
    words: tuple[str, ...]  # how the commands that run begin
    releases: dict[str, str] = field(default_factory=dict)
    times: dict[str, float] = field(default_factory=dict)  # of each command that passed [s]
    seconds: float = 0.0
    failure: str = ""

    @property
    def name(self) -> str:
        """Its name in the results."""
        return f"Python {self.version}, {self.resolution} dependencies"

    @property
    def bin(self) -> Path:
        """The folder of its commands."""
        return self.folder / "env" / "bin"


def main() -> int:
    """Test every environment; return 1 if one failed, or if a required Python is missing."""
    options = parsed()
    # A shell starts its background jobs with Ctrl-C ignored, and what they start inherits that: the lab would not end.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    found = {version: interpreter(version) for version in options.python}
    missing = [version for version, path in found.items() if path is None]
    if options.missing:
        say(" ".join(missing))
        return 0
    for version in missing:
        say(f"Python {version}: not found on PATH, in pyenv or by uv; not tested")
    here = [version for version, path in found.items() if path]
    if os.environ.get("CI") and not options.chosen and (REFERENCE not in here or len(here) < 2):
        say(f"CI needs Python {REFERENCE} and a newer one; found: {', '.join(here) or 'none'}")
        return 1
    if not here:
        return 1
    work = Path(tempfile.mkdtemp(prefix="tumble-smoke-"))
    uv = find_uv(work)
    wheel = built(uv, work)
    cells = [
        Cell(version, path, resolution, work / f"{version}-{resolution}", more, begins(options, resolution, more))
        for version, path in found.items()
        if path
        for resolution in RESOLUTIONS
        for more in (whole(options, version, resolution, here[-1]),)
    ]
    started = time.monotonic()
    with ThreadPoolExecutor(options.jobs) as threads:
        for cell in threads.map(lambda cell: smoked(cell, uv, wheel), cells):
            say(line_of(cell))
    failed = [cell for cell in cells if cell.failure]
    for cell in failed:
        say(f"\nFAILED  {cell.name}\n{cell.failure}")
    took = time.monotonic() - started
    say(f"\n{len(cells) - len(failed)} of {len(cells)} environments passed, {took:.0f} s")
    if failed or options.keep:
        say(f"their files: {work}")
    else:
        shutil.rmtree(work)
    return 1 if failed else 0


def parsed() -> argparse.Namespace:
    """Return the options."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--python", action="append", metavar="3.N", help=f"default: {', '.join(PYTHONS)}")
    parser.add_argument(
        "--jobs", type=int, default=os.cpu_count() or 1, help="environments in parallel; default: one per core"
    )
    parser.add_argument("--keep", action="store_true", help="keep the environments and their files")
    parser.add_argument("--all", action="store_true", help="run every command in each environment")
    parser.add_argument("--missing", action="store_true", help="only print the Pythons that are not found")
    options = parser.parse_args()
    options.chosen, options.python = bool(options.python), options.python or PYTHONS
    return options


def begins(options: argparse.Namespace, resolution: str, more: bool) -> tuple[str, ...]:
    """Return how the commands begin that run: all of them, those that load a library each, or few."""
    if not more:
        return FEW
    return LOADING if resolution == "lowest" and not (options.all or options.chosen) else ("",)


def whole(options: argparse.Namespace, version: str, resolution: str, newest: str) -> bool:
    """Whether more than a few commands run with these dependencies on that Python."""
    all_commands = (REFERENCE, "lowest"), (newest, "newest")
    return options.all or options.chosen or (version, resolution) in all_commands


def say(line: str) -> None:
    """Print a line at once."""
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


def interpreter(version: str) -> Path | None:
    """Return a working Python of that version: on PATH, from pyenv, or found by uv."""
    name = f"python{version}"
    pyenv = os.environ.get("PYENV_ROOT") or Path.home() / ".pyenv"
    candidates = [str(Path(place, name)) for place in os.get_exec_path()]
    candidates += sorted(glob.glob(f"{pyenv}/versions/{version}.*/bin/{name}"), reverse=True)
    if uv := shutil.which("uv"):
        asked = subprocess.run(
            [uv, "python", "find", "--no-python-downloads", version], capture_output=True, text=True, check=False
        )
        candidates += asked.stdout.split("\n")[:1]
    for candidate in filter(os.path.isfile, candidates):
        asked = subprocess.run(
            [candidate, "-c", "import sys; print('%d.%d' % sys.version_info[:2], sys.executable)"],
            capture_output=True,
            text=True,
            check=False,
        )
        found, _, path = asked.stdout.strip().partition(" ")
        if asked.returncode == 0 and found == version:
            return Path(path)
    return None


def find_uv(work: Path) -> str:
    """Return the path of uv, installed from the package index if it is not on PATH."""
    if found := shutil.which("uv"):
        return found
    run([sys.executable, "-m", "venv", str(work / "uv")])
    run([str(work / "uv/bin/python"), "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "uv"])
    return str(work / "uv/bin/uv")


def built(uv: str, work: Path) -> Path:
    """Return a wheel of the files that git lists, made from their source distribution, which contains all of them.

    Raises Failed.
    """
    source = work / "source"
    listed = run(["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"], cwd=ROOT)
    names = {name for name in listed.split("\0") if name and (ROOT / name).is_file()}
    for name in names:
        (source / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(ROOT / name, source / name)
    run([uv, "build", "--quiet", "--out-dir", str(work / "wheel"), str(source)])
    ((wheel,), (archive,)) = ((work / "wheel").glob(pattern) for pattern in ("*.whl", "*.tar.gz"))
    with tarfile.open(archive) as files:
        held = {name.partition("/")[2] for name in files.getnames()}
    if left_out := sorted(names - held):
        raise Failed(f"{len(left_out)} files are missing from {archive.name}: {', '.join(left_out[:5])}")
    return wheel


def smoked(cell: Cell, uv: str, wheel: Path) -> Cell:
    """Make the environment and run every command in it; `failure` of the cell has what failed."""
    started = time.monotonic()
    try:
        (cell.folder / "work").mkdir(parents=True)
        (cell.folder / "work/free.toml").write_text(f'title = "A brick, hit once"\n{BODY}')
        many = BODY.replace("samples = 4", "samples = 400")
        (cell.folder / "work/dense.toml").write_text(f'title = "A hundred bricks, 400 samples"\n{many}{DENSE}')
        (cell.folder / "work/spring.toml").write_text(f'title = "A brick on a spring"\n{BODY}{SPRING}')
        run([uv, "venv", "--quiet", "--python", str(cell.python), str(cell.folder / "env")])
        install(cell, uv, "-r", str(ROOT / "pyproject.toml"))
        run([uv, "pip", "install", "--quiet", "--no-deps", "--python", str(cell.bin / "python"), str(wheel)])
        cell.releases = releases(cell, uv)
        for step in STEPS:
            if step.words.startswith(cell.words):
                ran(cell, step)
        if not cell.whole:
            return cell
        # Only now: an extra may need an older release of a dependency.
        install(cell, uv, "-r", str(ROOT / "pyproject.toml"), "--all-extras")
        for step in EXTRA_STEPS:
            ran(cell, step)
        lab_starts(cell)
    except Failed as failure:
        cell.failure = str(failure)
    finally:
        cell.seconds = time.monotonic() - started
    return cell


def install(cell: Cell, uv: str, *what: str) -> None:
    """Install with the cell's resolution, from wheels only: users do not compile dependencies."""
    resolution = ("--resolution", RESOLUTIONS[cell.resolution])
    run([uv, "pip", "install", "--quiet", "--no-build", *resolution, "--python", str(cell.bin / "python"), *what])


def releases(cell: Cell, uv: str) -> dict[str, str]:
    """Return the installed releases by name."""
    listed = run([uv, "pip", "list", "--quiet", "--format", "json", "--python", str(cell.bin / "python")])
    return {one["name"]: one["version"] for one in json.loads(listed)}


def environment(cell: Cell) -> dict[str, str]:
    """Return a user's environment variables, with the cell's own caches and engine environments."""
    own = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "NUMBA", "TUMBLE"))}
    caches = {"NUMBA_CACHE_DIR": "kernels", "TUMBLE_ENVIRONMENTS": "engines"}
    return own | {name: str(cell.folder / folder) for name, folder in caches.items()}


def ran(cell: Cell, step: Step) -> None:
    """Run a command as a user does.  Raises Failed."""
    folder, started = cell.folder / "work", time.monotonic()
    try:
        done = subprocess.run(
            [str(cell.bin / "tumble"), *step.words.split()],
            cwd=folder,
            env=environment(cell),
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=COMMAND_S,
            check=False,
        )
    except subprocess.TimeoutExpired as late:
        raise Failed(f"$ tumble {step.words}\nnot finished within {COMMAND_S:g} s") from late
    wrong = "; ".join(complaints(step, done, folder))
    if wrong:
        raise Failed(f"$ tumble {step.words}\n{wrong}\n{ends(done.stdout)}{ends(done.stderr)}")
    cell.times[step.words] = time.monotonic() - started


def complaints(step: Step, done: subprocess.CompletedProcess[str], folder: Path) -> Iterator[str]:
    """Yield what is wrong with the result of a command."""
    if done.returncode != step.code:
        yield f"exit code {done.returncode}, not {step.code}"
    if step.prints not in done.stdout:
        yield f"{step.prints!r} is missing from its output"
    for word in ("Traceback", "Warning", "a bug in Tumble", "crashed: "):
        if word in done.stdout + done.stderr:
            yield f"{word!r} is in its output"
    written = folder / step.writes
    if not written.exists() or (written.is_file() and not written.stat().st_size):
        yield f"{step.writes} was not written"


def ends(text: str, lines: int = 25) -> str:
    """Return the last lines of a text, indented."""
    return "".join(f"    {line}\n" for line in text.splitlines()[-lines:])


def lab_starts(cell: Cell) -> None:
    """Start the lab, get its page, and end it with Ctrl-C.  Raises Failed."""
    started = time.monotonic()
    words = [str(cell.bin / "tumble"), "lab", "free.toml", "-e", "tumble:rk4", "--no-open", "--port", "0"]
    with (
        tempfile.TemporaryFile("w+") as errors,
        subprocess.Popen(
            words, cwd=cell.folder / "work", env=environment(cell), stdout=subprocess.PIPE, stderr=errors, text=True
        ) as lab,
    ):
        # Ends the lab in any case, so that reading its line cannot block for ever.
        watchdog = subprocess.Popen(["sh", "-c", f"sleep {LAB_S:g}; kill -9 {lab.pid}"], stderr=subprocess.DEVNULL)
        try:
            assert lab.stdout is not None
            address = lab.stdout.readline().strip()
            page = urllib.request.urlopen(address, timeout=LAB_S).read() if address else b""
            lab.send_signal(signal.SIGINT)
            code = lab.wait(LAB_S)
        except (OSError, subprocess.TimeoutExpired) as error:
            raise Failed(f"$ {' '.join(words[1:])}\n{error}") from error
        finally:
            watchdog.kill()
            watchdog.wait()
            lab.kill()
        errors.seek(0)
        shown = errors.read()
    if b"<html" not in page.lower() or code or "Traceback" in shown:
        raise Failed(f"$ tumble {' '.join(words[1:])}\n{len(page)} bytes of page, exit code {code}\n{ends(shown)}")
    cell.times["lab"] = time.monotonic() - started


def run(words: list[str], cwd: Path | None = None) -> str:
    """Return the output of a command.  Raises Failed."""
    done = subprocess.run(words, cwd=cwd, capture_output=True, text=True, check=False)
    if done.returncode:
        raise Failed(f"$ {' '.join(words)}\nexit code {done.returncode}\n{ends(done.stdout)}{ends(done.stderr)}")
    return done.stdout


def line_of(cell: Cell) -> str:
    """Return the results of a cell in one line."""
    shown = " ".join(f"{name} {cell.releases.get(name, '-')}" for name in SHOWN)
    if cell.failure:
        return f"{cell.name}: FAILED after {len(cell.times)} commands ({shown})"
    slowest = sorted(cell.times, key=cell.times.__getitem__, reverse=True)[:3]
    longest = ", ".join(f"{words.split()[0]} {cell.times[words]:.0f}" for words in slowest)
    return f"{cell.name}: {len(cell.times)} commands, {cell.seconds:.0f} s ({longest}; {shown})"


if __name__ == "__main__":
    try:
        sys.exit(main())
    except Failed as failure:
        say(f"FAILED\n{failure}")
        sys.exit(1)
