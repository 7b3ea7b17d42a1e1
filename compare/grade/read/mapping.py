"""The user's names of foreign columns: COLUMN=NAME on the command line, or the same in a TOML file."""

import tomllib
from collections.abc import Sequence
from pathlib import Path

from tumble.compare.grade.read.columns import BadTrajectory
from tumble.scenarios.files import plain_bytes, why_unread
from tumble.scenarios.format import printable, short


def mapping_of(pairs: Sequence[str]) -> dict[str, str]:
    """Return the mapping of columns that `--map` gives.

    Parameters
    ----------
    pairs : COLUMN=NAME of each; a column's name may contain `=`

    Returns
    -------
    name by column

    Raises
    ------
    BadTrajectory : a pair is not COLUMN=NAME, or a column is given twice
    """
    mapping: dict[str, str] = {}
    for pair in pairs:
        column, equals, name = pair.rpartition("=")
        column, name = column.strip(), name.strip()
        if not equals or not column or not name:
            raise BadTrajectory(f"--map {short(pair)}: must be COLUMN=NAME, e.g. --map Time=t_s")
        if column in mapping:
            raise BadTrajectory(f"--map {short(column)}: given twice")
        mapping[column] = name
    return mapping


def mapping_file(path: Path) -> dict[str, str]:
    """Return column -> name from the table [columns] of a TOML file.  Raises BadTrajectory."""
    description = printable(str(path))
    try:
        document = tomllib.loads(plain_bytes(path).decode("utf-8-sig"))
    except OSError as error:
        raise BadTrajectory(f"{description}: {why_unread(error)}") from None
    except UnicodeDecodeError:
        raise BadTrajectory(f"{description}: not UTF-8 text") from None
    except (ValueError, RecursionError) as error:
        raise BadTrajectory(f"{description}: not TOML: {printable(str(error))[:200]}") from None
    for key in document:
        if key != "columns":
            raise BadTrajectory(f"{description}: {short(key)}: unknown key; the file has only the table [columns]")
    columns = document.get("columns")
    if not isinstance(columns, dict):
        raise BadTrajectory(f"{description}: columns: must be a table of column = name, e.g. Time = 't_s'")
    for column, name in columns.items():
        if not isinstance(name, str):
            raise BadTrajectory(
                f"{description}: columns.{printable(column)} = {short(name)}: must be a name, e.g. 't_s'"
            )
    return {column.strip(): name for column, name in columns.items()}
