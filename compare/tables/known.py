"""Every table there is: the shared ones, and those that each study states in its `schemas.py`, found by its folder."""

from functools import cache
from importlib import import_module
from importlib.util import find_spec
from pkgutil import iter_modules

from tumble.compare import tables as home
from tumble.compare.tables import shared
from tumble.compare.tables.schema import Table

SWEEP = "sweep-"  # before the name of a sweep's table where it lies beside those of a comparison


@cache
def tables() -> dict[str, Table]:
    """Return every table by the name of its file.

    Returns
    -------
    the tables, by name of the file
    """
    compare = import_module(home.__name__.rpartition(".")[0])
    studies = [f"{compare.__name__}.{found.name}.schemas" for found in iter_modules(compare.__path__)]
    stated = [each for study in studies if find_spec(study) for each in import_module(study).TABLES]
    return {table.file: table for table in (*shared.TABLES, *stated)}


def schema(file: str) -> Table | None:
    """Return the table of that file name.

    Parameters
    ----------
    file : name of the file, such as runs.csv

    Returns
    -------
    the table; None where there is none of that name
    """
    return tables().get(file.removeprefix(SWEEP)) if file.startswith(SWEEP) else tables().get(file)
