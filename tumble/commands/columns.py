"""`tumble columns`: the tables, and the columns of each, from the schemas that write and read them."""

import sys
from argparse import Namespace
from collections.abc import Iterator
from textwrap import fill

from tumble.compare.tables.known import tables
from tumble.compare.tables.schema import BadTable, Table
from tumble.scenarios.format import nearest

WIDTH = 80


def main(options: Namespace) -> int:
    """List every table, or the columns of one."""
    known = tables()
    if options.table:
        name = options.table if options.table.endswith(".csv") else f"{options.table}.csv"
        if name not in known:
            raise BadTable(f"no table {options.table!r}: {nearest(name, sorted(known))}")
        lines = described(known[name])
    else:
        lines = aligned([(name, table.meaning) for name, table in sorted(known.items())])
    sys.stdout.writelines(f"{line}\n" for line in lines)
    return 0


def described(table: Table) -> Iterator[str]:
    """Yield a table's meaning and key, then each column with its unit and its meaning."""
    yield fill(f"{table.file}: {table.meaning}", WIDTH)
    if table.key:
        yield fill(f"one row per {', '.join(table.key)}", WIDTH, subsequent_indent="  ")
    yield ""
    yield from aligned(
        [(each.name, f"[{each.unit}] {each.meaning}" if each.unit else each.meaning) for each in table.columns]
    )


def aligned(pairs: list[tuple[str, str]]) -> Iterator[str]:
    """Yield names with their meanings beside them, within WIDTH."""
    wide = max(len(name) for name, _ in pairs) + 2
    for name, meaning in pairs:
        yield fill(f"{name:{wide}}{meaning}", WIDTH, subsequent_indent=" " * wide)
