"""Tests that are started in the background, as `nohup make test &` does: Ctrl-C and hanging up are ignored there."""

import signal
import subprocess
import sys
from pathlib import Path

from patience import PATIENCE_S

ROOT = Path(__file__).parents[2]
TESTS = ("-p", "no:cacheprovider", "-n", "0", "tests/compare/run/test_tasks.py", "-k", "ctrl_c and compare")


def test_the_tests_of_ctrl_c_pass_where_it_is_ignored():
    done = subprocess.run(
        [sys.executable, "-m", "pytest", *TESTS],
        cwd=ROOT,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
        preexec_fn=lambda: [signal.signal(each, signal.SIG_IGN) for each in (signal.SIGINT, signal.SIGHUP)],
    )
    assert done.returncode == 0, done.stdout[-2000:]


def test_children_heed_ctrl_c_whoever_started_the_tests():
    code = "import signal; raise SystemExit(signal.getsignal(signal.SIGINT) == signal.SIG_IGN)"
    assert subprocess.run([sys.executable, "-c", code], timeout=PATIENCE_S).returncode == 0
