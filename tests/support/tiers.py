"""Two tiers: `make test` runs every quick test and the first case of some slow ones, `make test-rest` more of these.

tests/slow.txt lists slow tests, a function a line.  Of each that `first` stands behind, `--quick` runs the first case.
`--rest` runs three tenths of the other first cases, and a twelfth of all other cases, others with each commit.  A test
that is slow and not listed fails, if it is slow a second time too: what is compiled or imported once counts for no
test.

These are the shares of a machine of pace 1.  One that takes three times as long runs a third of them.
"""

import hashlib
import os
import resource
import subprocess
import time
from pathlib import Path

import pytest
from _pytest.runner import runtestprotocol

ROOT = Path(__file__).parents[2]
LIST = ROOT / "tests" / "slow.txt"
# Processor time that a test may take which is not listed [s], where `a_fixed_amount_of_work` takes WORK_S.
MOST_S = 3.0
WORK_S = 0.0175
QUICK, REST = "quick", "rest"
# Shares of first cases and of others that `--rest` runs.
FIRST_CASES, OTHERS = 0.3, 1 / 12
# Every process of a run draws the same tests: the first one measures the pace for all.
PACE = "TUMBLE_TESTS_PACE"
taken = pytest.StashKey[float]()


def slow_tests() -> dict[str, bool]:
    """Return the listed tests, each with whether its first case is a quick one."""
    lines = (line.partition(" ") for line in LIST.read_text(encoding="utf-8").splitlines() if line and line[0] != "#")
    return {name: word == "first" for name, _, word in lines}


def function_of(item: pytest.Item) -> str:
    """Return a test's name without its case."""
    return item.nodeid.partition("[")[0]


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add `--quick`, `--rest` and `--times`."""
    parser.addoption("--quick", action="store_true", help="leave out nearly all of the slow tests")
    parser.addoption("--rest", action="store_true", help="run a part of what --quick leaves out")
    parser.addoption("--times", type=Path, help="append each test's processor time [s] to this file")


def pytest_configure(config: pytest.Config) -> None:
    """Measure the pace of the machine before any test runs."""
    if config.getoption("--rest") and PACE not in os.environ:
        os.environ[PACE] = str(pace())


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave out what is listed, but for first cases, or with `--rest` but for the part of this commit."""
    slow = slow_tests()
    if not (config.getoption("--quick") or config.getoption("--rest")):
        return
    head = subprocess.run(["git", "rev-parse", "HEAD"], cwd=ROOT, capture_output=True, text=True, check=False).stdout
    seen, slowness = set[str](), float(os.environ.get(PACE, "1"))

    def tier(item: pytest.Item) -> str | None:
        """Return the tier in which a test runs with this commit, None: in neither."""
        name = function_of(item)
        is_first = name not in seen
        seen.add(name)
        if name not in slow or (is_first and slow[name]):
            return QUICK
        digest = hashlib.sha256(f"{head}{item.nodeid}".encode()).digest()
        drawn = int.from_bytes(digest[:4]) / 2**32
        return REST if drawn < (FIRST_CASES if is_first else OTHERS) / slowness else None

    wanted = QUICK if config.getoption("--quick") else REST
    left_out = {item for item in items if tier(item) != wanted}
    config.hook.pytest_deselected(items=[*left_out])
    items[:] = [item for item in items if item not in left_out]


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_protocol(item: pytest.Item, nextitem: pytest.Item | None) -> bool:
    """Run a test, and once more if it was slow and is not listed; with what it was first to make."""
    item.ihook.pytest_runtest_logstart(nodeid=item.nodeid, location=item.location)
    reports = measured(item, nextitem)
    if is_slow(item) and all(report.passed for report in reports):
        reports = measured(item, nextitem)
        if is_slow(item) and all(report.passed for report in reports):
            call = next(report for report in reports if report.when == "call")
            call.outcome, call.longrepr = "failed", complaint(item)
    for report in reports:
        item.ihook.pytest_runtest_logreport(report=report)
    item.ihook.pytest_runtest_logfinish(nodeid=item.nodeid, location=item.location)
    return True


def measured(item: pytest.Item, nextitem: pytest.Item | None) -> list[pytest.TestReport]:
    """Run a test with its fixtures, and note the processor time of both."""
    before = processor_time()
    reports = runtestprotocol(item, log=False, nextitem=nextitem)
    item.stash[taken] = processor_time() - before
    if item.config.getoption("--times"):
        with item.config.getoption("--times").open("a", encoding="utf-8") as file:
            file.write(f"{item.stash[taken]:.2f} {item.nodeid}\n")
    return reports


def is_slow(item: pytest.Item) -> bool:
    """Whether a test that is not listed took too long, for the pace of this machine at this moment."""
    seconds = item.stash.get(taken, 0.0)
    return seconds > MOST_S and function_of(item) not in slow_tests() and seconds > MOST_S * pace()


def complaint(item: pytest.Item) -> str:
    """Return what is wrong with a test that took long twice."""
    return (
        f"{function_of(item)} took {item.stash[taken]:.1f} s of processor time with its fixtures: "
        "make it quicker, or list it in tests/slow.txt"
    )


def pace() -> float:
    """Return the processor time of a fixed amount of work in units of WORK_S, at least 1."""
    before = time.process_time()
    for _ in range(10):
        a_fixed_amount_of_work()
    return max(1.0, (time.process_time() - before) / 10 / WORK_S)


def a_fixed_amount_of_work() -> float:
    """Fill a table with sums."""
    total, table = 0.0, {}
    for index in range(300_000):
        table[index % 997] = total
        total += index * 0.5
    return total


def processor_time() -> float:
    """Return the processor time of this process and of the children that it has waited for [s]."""
    used = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(each.ru_utime + each.ru_stime for each in used)


def pytest_terminal_summary(terminalreporter, config: pytest.Config) -> None:
    """Say what was left out, and how to run it."""
    if "PYTEST_XDIST_WORKER" in os.environ:
        return
    if config.getoption("--rest"):
        slowness = float(os.environ[PACE])
        terminalreporter.write_line(
            f"pace {slowness:.1f}: the first cases of {FIRST_CASES / slowness:.0%} of the slow tests, and "
            f"{OTHERS / slowness:.0%} of their other cases"
        )
    if config.getoption("--quick"):
        terminalreporter.write_line(
            f"left out: {len(slow_tests())} slow tests (tests/slow.txt) but the first cases of some; "
            "`make test-all` runs them"
        )
