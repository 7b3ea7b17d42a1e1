"""Compares ./mine.py with its baseline.  Accept an intended change with:

tumble check two-hits -e ./mine.py --no-times --accept -o baseline
"""

import subprocess


def test_my_engine_is_no_worse():
    done = subprocess.run(
        ["tumble", "check", "-e", "./mine.py", "--baseline", "baseline"], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stdout + done.stderr
