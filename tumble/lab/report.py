"""The report of a throw while it is being made: one at a time per page, stopped when the page is closed."""

import subprocess
import threading
from collections.abc import Callable, Sequence
from pathlib import Path

from tumble.compare.run.process.start import kill_group
from tumble.lab.pool import Contestant
from tumble.lab.refusals import Refused
from tumble.lab.save import Saved


class ReportAtWork:
    """The command of *Report*.  made: called, from a thread, with the file; failed: with the reason for none."""

    def __init__(self, made: Callable[[Path], object], failed: Callable[[str], object]) -> None:
        self._made, self._failed = made, failed
        self._report: subprocess.Popen[str] | None = None

    def make(self, files: Saved, contestants: Sequence[Contestant]) -> str:
        """Begin one; return what to say meanwhile.  Raises Refused."""
        if self._is_at_work():
            raise Refused("A report is already being made.")
        report = self._report = files.report(contestants)

        def wait() -> None:
            _, errors = report.communicate()
            if report.returncode == 0:
                self._made(files.report_file)
            else:
                self._failed(f"No report: {(errors.strip().splitlines() or ['it was stopped'])[-1]}")

        threading.Thread(target=wait, daemon=True).start()
        return f"Making {files.report_file.name}: this takes about half a minute."

    def close(self) -> None:
        """End the one that is being made."""
        if self._report is not None and self._is_at_work():
            kill_group(self._report.pid)

    def _is_at_work(self) -> bool:
        return self._report is not None and self._report.poll() is None
