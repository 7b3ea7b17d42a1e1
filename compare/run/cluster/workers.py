"""How many workers a scheduler has: some come late, some end."""

from dataclasses import dataclass
from time import monotonic
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from distributed import Client

# How often they are counted [s].
COUNT_S = 1.0


@dataclass
class Workers:
    """How many workers a scheduler has; client: connected to it; number: when they were counted last."""

    client: "Client"
    number: int = 0
    _next: float = 0.0

    def __str__(self) -> str:
        """Return the number in words."""
        return f"{self.number} worker{'s' * (self.number != 1)}"

    def __bool__(self) -> bool:
        return self.number > 0

    def counted(self) -> bool:
        """Count them unless that was done within COUNT_S; return whether they were counted now and there are some."""
        if monotonic() < self._next:
            return False
        self.number = len(dict(self.client.nthreads()))  # type: ignore[call-overload]
        self._next = monotonic() + COUNT_S
        return self.number > 0
