"""One condition that numbers carry, as a row of conditions.csv."""

from dataclasses import dataclass
from typing import Annotated


@dataclass(frozen=True)
class ConditionRow:
    """One condition the numbers carry."""

    what: Annotated[str, "what it is: format, command, machine, a package, ..."]
    value: Annotated[str, "its value or version"]
