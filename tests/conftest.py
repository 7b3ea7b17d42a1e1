"""What all tests share: in CI a skipped test is a failed one, and a way to run the command as a user does."""

import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

import in_process
import pytest
from patience import PATIENCE_S, without_progress
from tiers import (  # noqa: F401, the hooks of the two tiers
    pytest_addoption,
    pytest_collection_modifyitems,
    pytest_configure,
    pytest_runtest_protocol,
    pytest_terminal_summary,
)

if TYPE_CHECKING:
    from playwright.sync_api import Browser

# Whoever started the tests in the background (`nohup make test &`) may have Ctrl-C and the hang-up ignored, and
# children inherit that.
for one, usual in ((signal.SIGINT, signal.default_int_handler), (signal.SIGHUP, signal.SIG_DFL)):
    if signal.getsignal(one) == signal.SIG_IGN:
        signal.signal(one, usual)

Tumble = Callable[..., subprocess.CompletedProcess[str]]


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_auto_num_workers() -> int:
    """Return the number of cores: one worker more collects as long, and gains less than that while others wait."""
    return os.cpu_count() or 1


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo):
    report = yield
    if report.skipped and os.environ.get("CI") and not hasattr(report, "wasxfail"):
        report.outcome = "failed"
        report.longrepr = f"skipped in CI, where everything is installed: {report.longrepr}"
    return report


@pytest.fixture
def tumble(tmp_path) -> Tumble:
    """Run `tumble WORDS` in an empty folder: in a process of its own where anything is asked of that process."""

    def run(*words: str, **settings) -> subprocess.CompletedProcess[str]:
        if not settings:
            return in_process.tumble(tmp_path, *words)
        settings = {"cwd": tmp_path, "capture_output": True, "text": True, "timeout": PATIENCE_S, **settings}
        done = subprocess.run([sys.executable, "-P", "-m", "tumble", *words], **settings)
        if isinstance(done.stderr, str):
            done.stderr = without_progress(done.stderr)
        return done

    return run


# No connection of Chromium's own; and WebGL drawn in software, for the lab.
CHROMIUM = ("chromium", "chromium-browser", "google-chrome")
FLAGS = (
    "--no-sandbox", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync",
    "--enable-unsafe-swiftshader",
)  # fmt: skip
# What a page does at once takes a busy machine longer than Playwright's own 5 and 30 s.
BROWSER_MS = 120_000


@pytest.fixture(scope="session")
def browser() -> Iterator["Browser"]:
    """A real browser, one for all tests of a process: Playwright runs once there."""
    from playwright.sync_api import expect, sync_playwright

    found = next(filter(None, map(shutil.which, CHROMIUM)), None)
    if found is None:
        pytest.skip(f"none of {', '.join(CHROMIUM)} is installed, and pages must be seen in a real browser")
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=found, args=list(FLAGS), timeout=BROWSER_MS)
        expect.set_options(timeout=BROWSER_MS)
        yield chromium
        chromium.close()
