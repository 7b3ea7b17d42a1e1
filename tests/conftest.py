"""What all tests share: in CI a skipped test is a failed one, and a way to run the command as a user does."""

import os
import subprocess
import sys
from collections.abc import Callable

import pytest

Tumble = Callable[..., subprocess.CompletedProcess[str]]


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo):
    report = yield
    if report.skipped and os.environ.get("CI") and not hasattr(report, "wasxfail"):
        report.outcome = "failed"
        report.longrepr = f"skipped in CI, where everything is installed: {report.longrepr}"
    return report


@pytest.fixture
def tumble(tmp_path) -> Tumble:
    """Run `tumble WORDS` in an empty folder."""

    def run(*words: str, **settings) -> subprocess.CompletedProcess[str]:
        settings = {"cwd": tmp_path, "capture_output": True, "text": True, "timeout": 120, **settings}
        return subprocess.run([sys.executable, "-P", "-m", "tumble", *words], **settings)

    return run
