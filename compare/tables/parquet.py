"""Parquet copies of a folder's tables, with the unit and meaning of every column in the file's own metadata."""

from importlib.util import find_spec
from io import BytesIO
from pathlib import Path

import pandas as pd

from tumble.compare.tables.data_package import field
from tumble.compare.tables.files import write_folder
from tumble.compare.tables.frames import read_tables
from tumble.compare.tables.known import schema
from tumble.compare.tables.schema import BadTable


def check_parquet(output: str | None) -> None:
    """Refuse `--parquet` where it cannot be done.

    Parameters
    ----------
    output : folder that tables are written to.

    Raises
    ------
    BadTable
        Where there is no folder, or pyarrow is not installed.
    """
    if not output:
        raise BadTable("--parquet: give -o DIR, the folder that tables are written to")
    if not find_spec("pyarrow"):
        raise BadTable("--parquet needs pyarrow, which is not installed: pip install pyarrow")


def write_parquet(folder: str | Path) -> list[str]:
    """Write every table of a folder as Parquet, beside its CSV file, all of them or none; remove older copies.

    Parameters
    ----------
    folder : as `-o` left it.

    Returns
    -------
    list
        Names of the files.

    Raises
    ------
    BadTable
        Where a CSV file is no table.
    OSError
        Where a file cannot be written.
    """
    tables = read_tables(Path(folder))
    found = {f"{name.removesuffix('.csv')}.parquet": parquet(name, table) for name, table in tables.items()}
    copies = {path.name for path in Path(folder).glob("*.parquet") if schema(f"{path.stem}.csv")}
    write_folder(Path(folder), found, without=copies - found.keys())
    return list(found)


def parquet(name: str, frame: pd.DataFrame) -> bytes:
    """Return a table as a Parquet file; name: of its CSV file."""
    import pyarrow
    import pyarrow.parquet

    stated = schema(name)
    assert stated is not None  # read_tables returns tables only
    made = pyarrow.Table.from_pandas(frame, preserve_index=False)
    described = [
        made.schema.field(column.name).with_metadata(
            {key: value for key, value in field(column).items() if key in ("description", "unit")}
        )
        for column in stated.columns
    ]
    schema_of_file = pyarrow.schema(
        described, {**(made.schema.metadata or {}), b"description": stated.meaning.encode()}
    )
    written = BytesIO()
    pyarrow.parquet.write_table(made.cast(schema_of_file), written)
    return written.getvalue()
