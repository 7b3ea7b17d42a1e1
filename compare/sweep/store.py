"""What `tumble sweep -o DIR` keeps while it works, and finds again when it was interrupted: whole scenes.

Less than a scene is not kept.  Its times are worth something only beside each other, taken in the same rounds; the
errors alone could be kept, but what is quoted of them stands beside times in every table.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from compare.comparison.results import SWEEP_TABLES
from compare.run.circumstances import changed_since
from compare.run.provenance import ConditionRow
from compare.sweep.frontier import ClockRow, DigitRow, OrderRow, SameRow, ThrowsRow
from compare.tables.files import write_whole
from compare.tables.rows import RunRow, cells, table_text, typed

ROW_TYPES = dict(zip(SWEEP_TABLES, (RunRow, DigitRow, OrderRow, ThrowsRow, SameRow, ClockRow), strict=True))
RUNS = "runs.csv"  # written last: a scene that has runs is done


class SweepStore:
    """The rows of the scenes that are done, by scene and table."""

    def __init__(self, folder: Path | None, scenes: Sequence[str], under: Sequence[ConditionRow]) -> None:
        self._folder, self._scenes, self._under = folder, list(scenes), list(under)
        self._rows: dict[str, dict[str, list[Any]]] = {}

    def resume(self) -> str:
        """Take up what the folder has, and return what to say of it; nothing where it has nothing."""
        if self._folder is None:
            return ""
        try:
            changed = changed_since(self._folder, self._under)
            if changed == "":
                self._take({name: (self._folder / name).read_text(encoding="utf-8") for name in ROW_TYPES})
                self._rows = {scene: self._rows[scene] for scene in self.done}
        except (OSError, ValueError, LookupError, StopIteration, RuntimeError):
            return f"{self._folder} has tables that cannot be read, and is begun anew"
        if changed:
            return f"{self._folder} is of another run, and is begun anew: {changed}"
        return f"{self._folder} has {', '.join(self.done)} already, with the times of then" if self.done else ""

    def keep(self, texts: dict[str, str]) -> None:
        """Take one scene's tables, file name -> CSV text, and write all there are."""
        self._take(texts)
        if self._folder is None:
            return
        for name, text in self.texts().items():
            write_whole(self._folder / name, text)

    def _take(self, texts: dict[str, str]) -> None:
        for name, row_type in ROW_TYPES.items():
            for row in typed(row_type, cells(texts[name])):
                self._rows.setdefault(row.scene, {}).setdefault(name, []).append(row)

    @property
    def done(self) -> list[str]:
        """The scenes there are, in order."""
        return [scene for scene in self._scenes if RUNS in self._rows.get(scene, {})]

    def texts(self) -> dict[str, str]:
        """Return file name -> CSV text of every table, the one that vouches for the others last."""
        made = {
            name: table_text(row_type, (row for scene in self.done for row in self._rows[scene].get(name, [])))
            for name, row_type in reversed(ROW_TYPES.items())
        }
        return {"conditions.csv": table_text(ConditionRow, self._under), **made}
