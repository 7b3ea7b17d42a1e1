"""Types of the page's JavaScript: writes tables.d.ts from the tables' schemas, and lets TypeScript check the modules.

.venv/bin/python -m tools.page_types [--check]
"""

import os
import shutil
import subprocess
import sys
from argparse import ArgumentParser
from collections.abc import Iterable, Iterator
from pathlib import Path

from tumble.compare.tables.frames import frame
from tumble.compare.tables.known import SWEEP, tables
from tumble.compare.tables.schema import Column
from tumble.compare.tables.shared import CONDITIONS, FINDING_WORDS, RUNS
from tumble.reports.folders import SWEPT, changes
from tumble.reports.modules import JAVASCRIPT

TYPESCRIPT = "5.9.3"
HERE = Path(sys.prefix) / "typescript"  # in the environment: it goes where the environment goes
COMPILER = HERE / "node_modules" / "typescript"
FILE = JAVASCRIPT / "tables.d.ts"
HEAD = (
    "// The rows of every table that a page can carry, and the names of findings.\n"
    "// Written by tools/page_types.py: do not edit.\n"
)
KINDS = {str: "string", int: "number", float: "number", bool: "boolean"}


def declarations() -> str:
    """Return the text of tables.d.ts."""
    stated = {name: dict(properties(table.columns)) for name, table in tables().items()}
    rows = {f"{SWEEP}{name}" if name in SWEPT else name: own for name, own in stated.items()}
    rows[f"{SWEEP}{RUNS.file}"] = stated[RUNS.file]
    rows |= {name: changed_properties(columns) for name, columns in changed_columns().items()}
    lines = (line for name in sorted(rows) for line in one_table(name, rows[name]))
    findings = " | ".join(f'"{name}"' for name in FINDING_WORDS)
    return "\n".join([HEAD, "interface Tables {", *lines, "}\n", f"type FindingName = {findings};\n"])


def properties(columns: Iterable[Column]) -> Iterator[tuple[str, str]]:
    """Yield column and TypeScript type; an empty cell is null in a column of numbers, '' in one of text."""
    for column in columns:
        yield column.name, KINDS[column.kind] + (" | null" if column.optional and column.kind is not str else "")


def changed_columns() -> dict[str, list[str]]:
    """Return the columns of the tables of what changed between two folders, which state no schema."""
    folder = {table.file: frame(table, []) for table in (RUNS, CONDITIONS)}
    return {name: list(table.columns) for name, table in changes(folder, folder).items()}


def changed_properties(columns: Iterable[str]) -> dict[str, str]:
    """Return column -> TypeScript type: that of the column that was compared, a number where there is none."""
    kinds = dict(properties((*RUNS.columns, *CONDITIONS.columns)))
    return {name: kinds.get(name.removesuffix("_before").removesuffix("_after"), "number | null") for name in columns}


def one_table(name: str, row: dict[str, str]) -> Iterator[str]:
    """Yield the lines of one table."""
    yield f'  "{name}": {{'
    yield from (f"    {column}: {kind};" for column, kind in row.items())
    yield "  };"


def checked(folder: Path = JAVASCRIPT) -> int:
    """Let TypeScript check the modules of a folder; return its exit code, 0 where there is no node to run it."""
    node, npm = shutil.which("node"), shutil.which("npm")
    if node is None or npm is None:
        sys.stderr.write("node and npm are not installed: the page's JavaScript was not checked\n")
        return int("CI" in os.environ)
    package = COMPILER / "package.json"
    if not package.exists() or f'"version": "{TYPESCRIPT}"' not in package.read_text(encoding="utf-8"):
        quiet = ["--no-save", "--no-package-lock", "--no-audit", "--no-fund", "--ignore-scripts", "--loglevel=error"]
        HERE.mkdir(exist_ok=True)
        subprocess.run([npm, "install", "--prefix", HERE, *quiet, f"typescript@{TYPESCRIPT}"], check=True)
    return subprocess.run([node, COMPILER / "bin" / "tsc", "--project", folder], check=False).returncode


if __name__ == "__main__":
    parser = ArgumentParser(prog="tools.page_types", description="Write tables.d.ts, or check types without writing.")
    parser.add_argument(
        "--check", action="store_true", help="fail where tables.d.ts is stale or TypeScript finds an error"
    )
    if not parser.parse_args().check:
        FILE.write_text(declarations(), encoding="utf-8")
        sys.exit()
    if FILE.read_text(encoding="utf-8") != declarations():
        sys.exit(f"{FILE}: not as the tables' schemas say: run `make types` and commit it")
    sys.exit(checked())
