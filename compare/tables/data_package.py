"""datapackage.json of a folder of tables: every file, column, unit, meaning and key, for programs that read them.

The format is Data Package 2.0 (Frictionless Data, 2024), https://datapackage.org/standard/.
"""

import json
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

from tumble.compare.tables.known import schema
from tumble.compare.tables.schema import Column, Table

FILE = "datapackage.json"
PROFILE = "https://datapackage.org/profiles/2.0/"
TYPES = {str: "string", int: "integer", float: "number", bool: "boolean"}


def with_package(
    folder: Path, texts: Mapping[str, str | bytes], without: Collection[str] = ()
) -> Mapping[str, str | bytes]:
    """Return the files of a folder with its datapackage.json, where any of them is a table.

    Parameters
    ----------
    folder : where they will be written; tables of other commands that are there are described too.
    texts : file name -> text of the files that will be written.
    without : names of files that will be removed.

    Returns
    -------
    Mapping
        File name -> text; `texts` itself where none of them is a table.
    """
    if not any(schema(name) for name in texts):
        return texts
    left = {path.name for path in folder.glob("*.csv") if path.name not in without and has_its_columns(path)}
    return {**texts, FILE: json.dumps(data_package({*left, *texts}), indent=1, ensure_ascii=False) + "\n"}


def has_its_columns(path: Path) -> bool:
    """Whether a file begins with the columns of the table it is named after; one of an older format does not."""
    table = schema(path.name)
    if table is None or not path.is_file():
        return False
    with path.open(encoding="utf-8", errors="replace") as file:
        return file.readline(100_000).rstrip("\r\n") == ",".join(table.names)


def data_package(names: Collection[str]) -> dict[str, Any]:
    """Return the description of tables.

    Parameters
    ----------
    names : names of files; those that are no tables are left out.

    Returns
    -------
    dict
        The content of datapackage.json.
    """
    found = [(name, table) for name in sorted(names) if (table := schema(name))]
    return {
        "$schema": f"{PROFILE}datapackage.json",
        "name": "tumble-tables",
        "title": "Tables written by tumble",
        "resources": [resource(name, table) for name, table in found],
    }


def resource(name: str, table: Table) -> dict[str, Any]:
    """Return the description of one file."""
    fields: dict[str, Any] = {"fields": [field(column) for column in table.columns]}
    if table.key:
        fields["primaryKey"] = list(table.key)
    return {
        "name": name.removesuffix(".csv"),
        "path": name,
        "description": table.meaning,
        "type": "table",
        "format": "csv",
        "mediatype": "text/csv",
        "encoding": "utf-8",
        "schema": fields,
    }


def field(column: Column) -> dict[str, Any]:
    """Return the description of one column; `unit` is our own key: the standard has none."""
    required = {"constraints": {"required": True}} if column.kind is not str and not column.optional else {}
    unit = {"unit": column.unit} if column.unit else {}
    return {"name": column.name, "type": TYPES[column.kind], "description": column.meaning, **unit, **required}
