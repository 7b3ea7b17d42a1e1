"""What `tumble stability -o DIR` keeps while it works, and finds again when it was interrupted.

A folder holds stability.csv, limits.csv and extremes.csv, each written whole, pieces in the order of the tables whoever
was done first; and conditions.csv, which says under what they were measured.  What was measured under others does not
count.  A piece is found where it has a row of limits, or one of extremes: those are written after the cells.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from time import monotonic

from compare.run.circumstances import changed_since
from compare.run.participants import Participant
from compare.run.provenance import ConditionRow
from compare.stability.contest import Done, Key, keys, stability
from compare.stability.extremes import ExtremeRow
from compare.stability.stability import LimitRow, Piece, StabilityRow
from compare.tables.files import write_whole
from compare.tables.rows import Row, cells, table_text, typed
from scenarios.scene import Scene

TABLES = ("stability.csv", "limits.csv", "extremes.csv")
OFTEN_S = 2.0


def quick_tables(
    participants: Sequence[Participant], scenes: Sequence[Scene], tick: Callable[[str], object] = lambda what: None
) -> dict[str, str]:
    """Return the tables of scenes at their own values only: the limits, and one row of each map."""
    store = Store(None, keys(participants, scenes, []), [])
    stability(participants, scenes, [], store.keep, tick, factors=[1.0])
    return {name: text for name, text in store.texts().items() if name in TABLES}


def kept_tables(folder: Path) -> dict[str, str]:
    """Return the tables that `tumble stability -o` left in a folder, nothing where it did not."""
    if not all((folder / name).exists() for name in TABLES):
        return {}
    return {name: (folder / name).read_text(encoding="utf-8") for name in TABLES}


class Store:
    """The pieces that are done, in memory and, where there is a folder, in its files.

    order: the keys of all pieces there will be, as the tables have them; under: the circumstances.
    """

    def __init__(self, folder: Path | None, order: Sequence[Key], under: Sequence[ConditionRow]) -> None:
        self._folder, self._order, self._under = folder, list(order), list(under)
        self._pieces: dict[Key, Done] = {}
        self._written = -math.inf

    def resume(self) -> str:
        """Take up what the folder has, and return what to say of it; nothing where it has nothing."""
        if self._folder is None:
            return ""
        try:
            changed = changed_since(self._folder, self._under)
            found = {piece.key: piece for piece in self._read()} if changed == "" else {}
        except (OSError, ValueError, LookupError, StopIteration, RuntimeError):
            return f"{self._folder} has tables that cannot be read, and is begun anew"
        if changed is None:
            return ""
        if changed:
            return f"{self._folder} is of another run, and is begun anew: {changed}"
        self._pieces = {key: found[key] for key in self._order if key in found}
        return f"{self._folder} has {len(self._pieces)} of {len(self._order)} pieces; the others are flown"

    def _read(self) -> Iterator[Done]:
        maps: dict[Key, list[StabilityRow]] = {}
        for row in self._rows(StabilityRow, "stability.csv"):
            maps.setdefault((row.scene, row.engine, row.method), []).append(row)
        for limit in self._rows(LimitRow, "limits.csv"):
            yield Piece(tuple(maps[limit.scene, limit.engine, limit.method]), limit)
        yield from self._rows(ExtremeRow, "extremes.csv")

    def _rows(self, row_type: type[Row], name: str) -> list[Row]:
        assert self._folder is not None
        return list(typed(row_type, cells((self._folder / name).read_text(encoding="utf-8"))))

    @property
    def done(self) -> frozenset[Key]:
        """The keys of the pieces there are."""
        return frozenset(self._pieces)

    def keep(self, piece: Done) -> None:
        """Take a piece, and write the files now and then."""
        self._pieces[piece.key] = piece
        if monotonic() - self._written > OFTEN_S:
            self.write()

    def write(self) -> None:
        """Write what there is, the conditions first and the cells before what vouches for them."""
        if self._folder is None:
            return
        for name, text in self.texts().items():
            write_whole(self._folder / name, text)
        self._written = monotonic()

    @property
    def pieces(self) -> list[Piece]:
        """The scenes' pieces, in order."""
        return [piece for piece in self._in_order() if isinstance(piece, Piece)]

    @property
    def extremes(self) -> list[ExtremeRow]:
        """The extreme rows, in order."""
        return [piece for piece in self._in_order() if isinstance(piece, ExtremeRow)]

    def _in_order(self) -> list[Done]:
        return [self._pieces[key] for key in self._order if key in self._pieces]

    def texts(self) -> dict[str, str]:
        """Return file name -> CSV text of every table, in the order in which they are written."""
        return {
            "conditions.csv": table_text(ConditionRow, self._under),
            "stability.csv": table_text(StabilityRow, (row for piece in self.pieces for row in piece.rows)),
            "limits.csv": table_text(LimitRow, (piece.limit for piece in self.pieces)),
            "extremes.csv": table_text(ExtremeRow, self.extremes),
        }
