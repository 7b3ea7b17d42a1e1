"""`tumble.check`: what is measured now, compared with an accepted baseline."""

from dataclasses import asdict
from pathlib import Path

import pandas as pd

from tumble.api.contestants import Contestants, contestant_list
from tumble.api.limits import limits
from tumble.api.result import call
from tumble.api.scene import Scenes, is_empty, questions
from tumble.compare.check.changes import Change, Outcome, compare_records
from tumble.compare.check.markdown import summary
from tumble.compare.check.record import Record, is_record, read_record
from tumble.compare.check.study import Measuring, accept_record, check_scenes, measure_record
from tumble.compare.check.tolerances import Tolerances
from tumble.compare.run.running_engines import TIME_LIMIT_S
from tumble.compare.run.worker import MEMORY_LIMIT
from tumble.reports.numerals import counted
from tumble.scenarios.refusal import UserError


class Check:
    """What a check found; true if nothing is worse.

    Parameters
    ----------
    record : what was measured.
    outcome : what changed since the baseline; None where there was none.
    folder : the baseline.
    """

    def __init__(self, record: Record, outcome: Outcome | None, folder: Path) -> None:
        self._record, self._outcome, self._folder = record, outcome, folder

    def __bool__(self) -> bool:
        return self._outcome is None or not self._outcome.failed

    @property
    def changes(self) -> pd.DataFrame:
        """One row a change: `verdict`, `scene`, `engine`, `method`, `column`, `old`, `new`; empty if there is none."""
        rows = [asdict(change) for change in self._outcome.changes] if self._outcome else []
        return pd.DataFrame(rows, columns=list(Change.__dataclass_fields__))

    @property
    def cells(self) -> pd.DataFrame:
        """What was measured, one row a scene and contestant, as in cells.csv."""
        return self._record.cells

    @property
    def summary(self) -> str:
        """What changed, as Markdown: what `tumble check` prints."""
        return summary(self._outcome, ["--baseline", str(self._folder)]) if self._outcome else ""

    def __repr__(self) -> str:
        return self.summary.rstrip() or f"{counted(len(self.cells), 'cell')} recorded in {self._folder}"


def check(
    scenes: Scenes = (),
    contestants: Contestants = (),
    *,
    baseline: str | Path,
    accept: bool = False,
    accept_failures: bool = False,
    times: bool = True,
    tolerances: Tolerances | None = None,
    time_limit: float = TIME_LIMIT_S,
    memory_limit: int = MEMORY_LIMIT,
    progress: bool = True,
) -> Check:
    """Compare errors, orders, energy and run times with an accepted baseline.

    Parameters
    ----------
    scenes : one or several: a name, a path, a table as in TOML, or a `Scene`.  Empty: those of the baseline.
    contestants : one or several: ENGINE[@RELEASE][:METHOD], FILE[:METHOD], or a function as `tumble.engine` takes it.
        Empty: those of the baseline.
    baseline : folder of the record.
    accept : write the record that is measured into the folder.
    accept_failures : write it even if contestants crashed, hung or are missing.
    times : measure run times, too; set it to False where baseline and check run on different machines.
    tolerances : how much each column may change.
    time_limit : of each run [s].
    memory_limit : of each engine's process [B].
    progress : draw a bar in a terminal or a notebook.

    Returns
    -------
    Check

    Raises
    ------
    UserError
        Where there is no baseline and `accept` is not set, and where a failure keeps a record from being accepted.

    Examples
    --------
    >>> import tempfile, tumble
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     accepted = tumble.check("two-hits", "tumble:rk4", baseline=folder, accept=True, times=False)
    ...     bool(tumble.check("two-hits", "tumble:rk4", baseline=folder, times=False))
    True
    """
    folder, limit = Path(baseline), limits(time_limit, memory_limit, progress)
    old = read_record(folder) if is_record(folder) or not accept else None
    how = Measuring(
        scenes=() if is_empty(scenes) else questions(scenes),
        contestants=contestant_list(contestants),
        timed=times,
        time_limit=limit["time_limit"],
        memory_limit=limit["memory_limit"],
        command=call("check", scenes, contestants),
    )
    if not accept:
        assert old is not None
        return Check(*check_scenes(old, tolerances or Tolerances(), how, display=limit["display"]), folder)
    new = measure_record(how, old, limit["display"])
    if failed := accept_record(folder, new, accept_failures):
        reasons = "; ".join(f"{contestant}: {status}" for contestant, status in failed.items())
        raise UserError(f"{folder}: nothing was recorded ({reasons}); to record failures, set accept_failures")
    return Check(new, None if old is None else compare_records(old, new, tolerances or Tolerances()), folder)
