"""What a command keeps while it works, and finds again when it was interrupted: the rows of every task that is done.

A task has a key, which stands in the first of its rows' columns, and is done whole or not at all: all of its rows are
handed over at once, and a folder is written as a whole.  conditions.csv says under what it was measured, and has a
digest of every table: what was measured under other circumstances does not count, and neither does what was damaged.
"""

import hashlib
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from time import monotonic

import pandas as pd

from tumble.compare.run.provenance import ConditionRow
from tumble.compare.tables.circumstances import TABLE, changed_since
from tumble.compare.tables.files import place, write_folder
from tumble.compare.tables.frames import csv_text, csv_texts, frame, read_text, rows, typed
from tumble.compare.tables.schema import BadTable, Table
from tumble.compare.tables.shared import CONDITIONS
from tumble.scenarios.files import plain_bytes
from tumble.scenarios.format import printable

Key = tuple[str, ...]
OFTEN_S = 2.0


class Store:
    """The tasks that are done, in memory and, where there is a folder, in its files.

    tables: those whose rows are kept; key: the columns that name a task in all of them; order: the keys of all tasks
    there will be, as the tables have them; under: the circumstances.
    """

    def __init__(
        self,
        folder: Path | None,
        tables: Sequence[Table],
        key: Sequence[str],
        order: Sequence[Key],
        under: Sequence[ConditionRow] = (),
    ) -> None:
        self._folder, self._tables, self._key, self._order = folder, list(tables), list(key), list(order)
        self._under = list(under)
        self._done: dict[Key, Mapping[str, pd.DataFrame]] = {}
        self._written, self._all_written = -math.inf, True

    def resume(self) -> str:
        """Take up what the folder has, all of it or nothing, and return what to say of it."""
        if self._folder is None:
            return ""
        shown = printable(str(self._folder))
        try:
            changed = changed_since(self._folder, self._under)
            found = self._read() if changed == "" else {}
        except (BadTable, OSError) as error:
            return f"{shown} is damaged, and is begun anew: {error}"
        if changed:
            return f"{shown} is of another run, and is begun anew: {changed}"
        self._done = {key: found[key] for key in self._order if key in found}
        return f"{shown} has {len(self._done)} of {len(self._order)} already; the others are flown" if found else ""

    def _read(self) -> dict[Key, dict[str, pd.DataFrame]]:
        assert self._folder is not None
        said = {row.what: row.value for row in rows(CONDITIONS, read(self._folder, CONDITIONS))}
        found: dict[Key, dict[str, pd.DataFrame]] = {}
        for table in self._tables:
            whole = read(self._folder, table, said.get(TABLE + table.file, ""))
            for _, own in whole.groupby(self._key, sort=False):
                found.setdefault(tuple(own[self._key].iloc[0]), {})[table.file] = own
        return found

    @property
    def done(self) -> frozenset[Key]:
        """The keys of the tasks that are done."""
        return frozenset(self._done)

    def keep(self, key: Key, made: Mapping[str, pd.DataFrame]) -> None:
        """Take the rows of a task that is done, by table, and write the files now and then."""
        self._done[key], self._all_written = made, False
        if monotonic() - self._written > OFTEN_S:
            self.write()

    def write(self) -> None:
        """Write all there is, unless it is written."""
        if self._folder is None or self._all_written:
            return
        texts = csv_texts(self.tables)
        write_folder(self._folder, texts | {CONDITIONS.file: csv_text(self._conditions(texts))})
        self._written, self._all_written = monotonic(), True

    def _conditions(self, texts: Mapping[str, str]) -> pd.DataFrame:
        digests = [ConditionRow(TABLE + name, digest_of(text)) for name, text in texts.items()]
        return frame(CONDITIONS, [*self._under, *digests])

    @property
    def conditions(self) -> pd.DataFrame:
        """The circumstances, and the digest of every table."""
        return self._conditions(csv_texts(self.tables))

    @property
    def tables(self) -> dict[str, pd.DataFrame]:
        """The tables, by file name, their rows in the order of the tasks."""
        made = [self._done[key] for key in self._order if key in self._done]
        return {
            table.file: pd.concat(
                [typed(table, {}), *(each[table.file] for each in made if table.file in each)], ignore_index=True
            )
            for table in self._tables
        }


def read(folder: Path, table: Table, digest: str | None = None) -> pd.DataFrame:
    """Return a table of a folder.  Raises BadTable, also where its digest is another; OSError."""
    path = place(folder, table.file)
    try:
        text = plain_bytes(path).decode("utf-8")
    except UnicodeDecodeError as error:
        raise BadTable(f"{table.file}: not CSV: {error}") from None
    found = read_text(table.file, text, table)
    if digest not in (None, digest_of(text)):
        raise BadTable(f"{table.file} is not as it was written")
    return found


def digest_of(text: str) -> str:
    """Return sixteen digits that are others for another text."""
    return hashlib.sha256(text.encode("utf-8", "backslashreplace")).hexdigest()[:16]
