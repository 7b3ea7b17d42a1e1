"""Names of contestants, as every table and figure has them."""

from typing import Any


def contestant(row: Any) -> str:
    """Return ENGINE:METHOD of any row that has both, ENGINE where the method is not known."""
    return f"{row.engine}:{row.method}" if row.method else row.engine
