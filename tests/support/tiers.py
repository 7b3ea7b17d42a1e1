"""Two tiers: `make test` runs every quick test and a part of the slow ones, `make test-rest` the others.

tests/slow.txt lists slow tests, a function a line.  Of each, `--quick` runs the first case where `first` stands behind
it, and of the other cases one in thirty, others with each commit.  A test that is slow and not listed fails.
"""

import hashlib
import os
import resource
import subprocess
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
LIST = ROOT / "tests" / "slow.txt"
# Processor time that a test may take which is not listed [s]: what takes 3 s alone takes up to 5 on a busy machine.
MOST_S = 5.0
PARTS = 30
FOLDERS = ("solver", "scenarios", "compare")
taken = pytest.StashKey[float]()


def slow_tests() -> dict[str, bool]:
    """Return the listed tests, each with whether `--quick` runs its first case."""
    lines = (line.split() for line in LIST.read_text(encoding="utf-8").splitlines() if line and line[0] != "#")
    return {words[0]: words[1:] == ["first"] for words in lines}


def function_of(item: pytest.Item) -> str:
    """Return a test's name without its case."""
    return item.nodeid.partition("[")[0]


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add `--quick` and `--rest`."""
    parser.addoption("--quick", action="store_true", help="leave out most of the slow tests")
    parser.addoption("--rest", action="store_true", help="run only what --quick leaves out")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave out what is listed, but for first cases and the part of this commit."""
    slow = slow_tests()
    if not (config.getoption("--quick") or config.getoption("--rest")):
        return
    head = subprocess.run(["git", "rev-parse", "HEAD"], cwd=ROOT, capture_output=True, text=True, check=False).stdout
    seen: set[str] = set()

    def stays(item: pytest.Item) -> bool:
        name = function_of(item)
        is_first = name not in seen
        seen.add(name)
        digest = hashlib.sha256(f"{head}{item.nodeid}".encode()).digest()
        return name not in slow or (is_first and slow[name]) or digest[0] % PARTS == 0

    left_out = {item for item in items if stays(item) is config.getoption("--rest")}
    config.hook.pytest_deselected(items=[*left_out])
    items[:] = [item for item in items if item not in left_out]


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item):
    """Measure the processor time of a test and of the processes that it has waited for."""
    begun, before = time.time(), processor_time()
    try:
        return (yield)
    finally:
        seconds = processor_time() - before
        # To compile a kernel takes a second, and only the first who needs it.
        item.stash[taken] = seconds if seconds <= MOST_S or not compiled_since(begun) else 0.0


def too_slow(item: pytest.Item) -> str:
    """Return what is wrong with a test that took long, '' where nothing is."""
    seconds = item.stash.get(taken, 0.0)
    if seconds <= MOST_S or function_of(item) in slow_tests():
        return ""
    return f"{function_of(item)} took {seconds:.1f} s of processor time: make it quicker, or list it in tests/slow.txt"


def processor_time() -> float:
    """Return the processor time of this process and of the children that it has waited for [s]."""
    used = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(each.ru_utime + each.ru_stime for each in used)


def compiled_since(begun: float) -> bool:
    """Whether a kernel was put beside its source after an instant [s since 1970]."""
    kernels = (path for folder in FOLDERS for path in (ROOT / folder).rglob("__pycache__/kernels-*/*/*.nbc"))
    return any(path.stat().st_mtime >= begun for path in kernels)


def pytest_terminal_summary(terminalreporter, config: pytest.Config) -> None:
    """Say what was left out, and how to run it."""
    if config.getoption("--quick") and "PYTEST_XDIST_WORKER" not in os.environ:
        count = len(slow_tests())
        terminalreporter.write_line(
            f"left out: 29 of 30 cases of {count} slow tests (tests/slow.txt); `make test-all` runs them"
        )
