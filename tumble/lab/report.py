"""The report of a throw while it is being made: one at a time for each page, and none when the page is closed."""

import os
import signal
import subprocess
import threading
from collections.abc import Callable, Sequence

from tumble.lab.crew import Contestant
from tumble.lab.keep import Kept
from tumble.lab.session import Refused


class ReportAtWork:
    """What becomes of *Save report*.  tell: called, from a thread, with a line when it is made or cannot be."""

    def __init__(self, tell: Callable[[str], object]) -> None:
        self._tell = tell
        self._report: subprocess.Popen[str] | None = None

    def make(self, files: Kept, contestants: Sequence[Contestant]) -> str:
        """Begin one; return what to say meanwhile.  Raises Refused."""
        if self._is_at_work():
            raise Refused("a report is being made already")
        report = self._report = files.report(contestants)

        def wait() -> None:
            _, errors = report.communicate()
            last = (errors.strip().splitlines() or ["it was ended"])[-1]
            self._tell(f"Written: {files.report_file.name}" if report.returncode == 0 else f"No report: {last}")

        threading.Thread(target=wait, daemon=True).start()
        return f"Making {files.report_file.name}: half a minute or so."

    def close(self) -> None:
        """End the one that is being made."""
        if self._report is not None and self._is_at_work():
            os.killpg(self._report.pid, signal.SIGKILL)

    def _is_at_work(self) -> bool:
        return self._report is not None and self._report.poll() is None
