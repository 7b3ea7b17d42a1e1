"""What every function returns: the tables that the command writes, with units, as text, as a page and as files."""

import html
from collections.abc import Iterable, Mapping
from io import StringIO
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import pandas as pd

from tumble.compare.tables.frames import read_tables, write_tables
from tumble.compare.tables.known import schema
from tumble.compare.tables.schema import BadTable, unit_of
from tumble.compare.tables.shared import CONDITIONS

if TYPE_CHECKING:
    import altair
    from rich.console import RenderableType

# Height of the frame in a notebook [px]: the answer, the ranking and the film are seen without scrolling.
FRAME_HEIGHT = 780
# VS Code and JupyterLab state their theme in an attribute only; the page in the frame follows `color-scheme`.
# In marimo the frame inherits it.  Elsewhere the page follows the system.
FRAME_STYLE = """\
[data-jp-theme-light="true"] .tumble-page, [data-vscode-theme-kind$="light"] .tumble-page { color-scheme: light }
[data-jp-theme-light="false"] .tumble-page, [data-vscode-theme-kind$="dark"] .tumble-page,
[data-vscode-theme-kind="vscode-high-contrast"] .tumble-page { color-scheme: dark }"""
# The column of an attribute's table that its file has not.
CONTESTANT = "contestant"
# Below the head of a printed table.
RULE = "───"


class Result:
    """The tables of one run of a command.

    Each table is an attribute: `vertex-errors.csv` is `result.vertex_errors`, with one column that the file has not:
    `contestant`, which is ENGINE:METHOD.  A table's `attrs` have the `units` and `meanings` of its columns.  In a
    notebook a result is shown as Tumble's page, in a frame of its own.

    Parameters
    ----------
    tables : file name -> table, as the command writes them.
    text : what the command prints.
    documents : file name -> text of what the command writes beside its tables.
    """

    def __init__(
        self, tables: Mapping[str, pd.DataFrame], text: str = "", *, documents: Mapping[str, str] = MappingProxyType({})
    ) -> None:
        self._tables = {name: described(name, table) for name, table in tables.items()}
        self._text, self._documents = text, dict(documents)
        self._attributes: dict[str, pd.DataFrame] = {}

    @property
    def tables(self) -> dict[str, pd.DataFrame]:
        """Every table as in its file, by the name of that file."""
        return dict(self._tables)

    @property
    def answer(self) -> str:
        """The answer in a sentence or two; empty where the command prints only tables, and for files that were read."""
        first = self._text.strip().partition("\n\n")[0]
        return "" if RULE in first else " ".join(first.split())

    @property
    def conditions(self) -> pd.DataFrame:
        """Versions, settings and machine: what the numbers depend on."""
        return self._tables[CONDITIONS.file]

    def save(self, folder: str | Path, *, parquet: bool = False) -> None:
        """Write the files that the command's `-o` writes: every table as CSV, all or none.

        Parameters
        ----------
        folder : created where it does not exist.
        parquet : also write the tables as Parquet; needs pyarrow.

        Raises
        ------
        UserError
            For `parquet` where pyarrow is not installed.
        OSError
            Where the folder cannot be written.
        """
        from tumble.compare.tables.parquet import check_parquet, write_parquet

        if parquet:
            check_parquet(str(folder))
        write_tables(Path(folder), self._tables, self._documents)
        if parquet:
            write_parquet(folder)

    def page(self) -> str:
        """Return Tumble's page of these tables.

        Returns
        -------
        str
            One self-contained HTML document that needs no network.
        """
        from tumble.reports.folders import completed
        from tumble.reports.page import page

        return page(completed(self._tables))

    def plot(self) -> "altair.TopLevelMixin":
        """Return the command's figure.

        Returns
        -------
        altair.TopLevelMixin
            Error by contestant, error against run time, or the largest stable step, by what the tables hold.

        Raises
        ------
        UserError
            Where Altair is not installed, or the tables have no figure.
        """
        from tumble.reports.figures import figure_of

        return figure_of(self._tables)

    def __getattr__(self, name: str) -> pd.DataFrame:
        file = f"{name.replace('_', '-')}.csv"
        tables = self.__dict__.get("_tables", {})
        if file in tables:
            if file not in self._attributes:
                self._attributes[file] = with_contestant(tables[file])
            return self._attributes[file]
        raise AttributeError(f"{type(self).__name__} has no {name}; tables: {', '.join(map(attribute, tables))}")

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *map(attribute, self._tables)})

    def __repr__(self) -> str:
        lines = (f"{attribute(name)}: {len(table)} rows" for name, table in self._tables.items())
        return self._text.rstrip() or "\n".join(["Tables:", *lines])

    def _repr_html_(self) -> str:
        """Return the answer, and the page in a frame of its own, so that its style and the notebook's do not meet."""
        try:
            page = self.page()
        except BadTable:  # of a command whose tables are not on the page, such as grade
            return f"<pre>{html.escape(repr(self))}</pre>"
        answer = f"<p>{html.escape(self.answer)}</p>" if self.answer else ""
        return (
            f"<style>{FRAME_STYLE}</style>{answer}"
            f'<iframe class="tumble-page" srcdoc="{html.escape(page)}" title="Tumble" loading="lazy" '
            f'style="width: 100%; height: {FRAME_HEIGHT}px; border: 0"></iframe>'
        )


def described(name: str, table: pd.DataFrame) -> pd.DataFrame:
    """Return a table whose attrs have the units and meanings of its columns.

    Parameters
    ----------
    name : of its file.
    table : the table; it is not changed.

    Returns
    -------
    pandas.DataFrame
    """
    found = table.copy(deep=False)
    if stated := schema(name):
        found.attrs = {
            "table": stated.meaning,
            "units": {column.name: column.unit for column in stated.columns if column.unit},
            "meanings": {column.name: column.meaning for column in stated.columns},
        }
    return found


def with_contestant(table: pd.DataFrame) -> pd.DataFrame:
    """Return a table with a column `contestant` behind `method`, where it has engines and methods.

    Parameters
    ----------
    table : as in its file; it is not changed.

    Returns
    -------
    pandas.DataFrame
    """
    if not {"engine", "method"} <= set(table.columns):
        return table
    found = table.copy(deep=False)
    column = found["engine"] + ":" + found["method"]
    found.insert(int(found.columns.get_loc("method")) + 1, CONTESTANT, column)  # type: ignore[arg-type]
    meanings = table.attrs.get("meanings", {})
    found.attrs = {**table.attrs, "meanings": {**meanings, CONTESTANT: "engine and method of the row, ENGINE:METHOD"}}
    return found


def attribute(file: str) -> str:
    """Return the attribute by which a result has a table.

    Parameters
    ----------
    file : name of the table's file.

    Returns
    -------
    str
    """
    return file.removesuffix(".csv").replace("-", "_")


def text_of(pieces: Iterable["RenderableType"]) -> str:
    """Return what a terminal would show, without colours.

    Parameters
    ----------
    pieces : as the functions of tumble.reports yield them.

    Returns
    -------
    str
    """
    from tumble.reports.terminal import console

    written = StringIO()
    out = console(file=written, force_terminal=False)  # a kernel of Jupyter asks for colours by FORCE_COLOR
    for piece in pieces:
        out.print(piece)
    return written.getvalue()


def with_units(table: pd.DataFrame) -> pd.DataFrame:
    """Return a table whose attrs have the units that its columns' names end with.

    Parameters
    ----------
    table : a trajectory, or any table with units in its columns' names; it is not changed.

    Returns
    -------
    pandas.DataFrame
    """
    found = table.copy(deep=False)
    units = {str(name): unit_of(str(name)) for name in table.columns}
    found.attrs = {"units": {name: unit for name, unit in units.items() if unit}}
    return found


def read(folder: str | Path) -> Result:
    """Return the tables that a command or `Result.save` wrote.

    Parameters
    ----------
    folder : where they are.

    Returns
    -------
    Result

    Raises
    ------
    UserError
        Where the folder has no tables, or a file is not the table that its name says.

    Examples
    --------
    >>> import tempfile, tumble
    >>> result = tumble.compare("two-hits", "tumble:exact", film=False)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     result.save(folder)
    ...     tumble.read(folder).runs.method.tolist()
    ['exact']
    """
    found = read_tables(Path(folder))
    if not found:
        raise BadTable(f"{folder}: has no tables; give a folder that -o or save() made")
    return Result(found)


def call(function: str, *operands: Any, **options: Any) -> str:
    """Return a call as the conditions of a result name it.

    Parameters
    ----------
    function : its name in `tumble`.
    *operands, **options : as they were given; options that are None are left out.

    Returns
    -------
    str
    """
    words = [*map(shown, operands), *(f"{name}={shown(value)}" for name, value in options.items() if value is not None)]
    return f"tumble.{function}({', '.join(words)})"


def shown(value: Any) -> str:
    """Return an argument as `call` names it: scenes and functions by their names.

    Parameters
    ----------
    value : a scene, a contestant, a number or a list of them.

    Returns
    -------
    str
    """
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(shown, value))}]"
    if isinstance(value, str | Path):
        return repr(str(value))
    if isinstance(value, Mapping):
        return "{...}"
    return str(getattr(value, "name", None) or getattr(value, "__name__", None) or value)
