"""What a table is: its file, what one row of it says, and its columns, each with its kind, its unit and its meaning.

A table is stated once, as a class of annotations, one line a column: `error_m: Annotated[float, "what it means"]`.
`tumble columns` prints them; the files are written and read by them.  The unit of a column is in its name.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from types import NoneType
from typing import Annotated, Any, get_args, get_origin, get_type_hints

from tumble.scenarios.refusal import UserError

# The longest first: `wall_ns_per_step` is no number of steps.
UNITS = {
    "_ns_per_step": "ns",
    "_per_sim_s": "1",
    "_per_s": "1/s",
    "_rad_s": "rad/s",
    "_m_s": "m/s",
    "_us": "us",
    "_ns": "ns",
    "_s": "s",
    "_m": "m",
}
EMPTY = "may be empty"  # said of a column of floats, in which NaN then is an empty cell
DTYPES = {str: "str", int: "int64", float: "float64", bool: "bool"}


class BadTable(UserError):
    """A file that is not the table it should be; the message is the one line for the user."""


@dataclass(frozen=True)
class Column:
    """One column: its name, the kind of its values, whether a cell may be empty, and what it means.

    kind: str, int, float or bool.
    """

    name: str
    kind: type
    optional: bool
    meaning: str

    @property
    def unit(self) -> str:
        """The unit that its name ends with, nothing for text and pure numbers."""
        return unit_of(self.name) if self.kind in (int, float) else ""

    @property
    def dtype(self) -> str:
        """The pandas dtype: an empty cell is NaN in a column of floats, NA in one of counts, and '' in text."""
        return "Int64" if self.kind is int and self.optional else DTYPES[self.kind]


@dataclass(frozen=True)
class Table:
    """One table: its file, its columns, and the columns that identify a row.

    Parameters
    ----------
    file : name of the file
    row : class that states the columns as annotations
    key : names of the columns that together identify a row; empty if there are none
    """

    file: str
    row: type
    key: tuple[str, ...] = ()

    @property
    def meaning(self) -> str:
        """What one row says, in one line."""
        return (self.row.__doc__ or "").partition("\n")[0]

    @cached_property
    def columns(self) -> tuple[Column, ...]:
        """The columns, in the order of the file."""
        return tuple(columns(self.row))

    @property
    def names(self) -> list[str]:
        """The names of the columns, which are the file's first line."""
        return [column.name for column in self.columns]


def unit_of(name: str) -> str:
    """Return the unit that a column's name ends with.

    Parameters
    ----------
    name : name of the column

    Returns
    -------
    the unit; empty for pure numbers
    """
    return next((unit for ending, unit in UNITS.items() if name.endswith(ending)), "")


def columns(row: type) -> Iterator[Column]:
    """Yield the columns that a class states."""
    for name, hint in get_type_hints(row, include_extras=True).items():
        said, meaning, *more = get_args(hint) if get_origin(hint) is Annotated else (hint, "")
        yield Column(name, kind(said), NoneType in get_args(said) or EMPTY in more, meaning)


def kind(hint: Any) -> type:
    """Return the kind of value of a hint, which may be None as well."""
    return next((each for each in get_args(hint) if each is not NoneType), hint)
