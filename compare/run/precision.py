"""Classes of precision: what one rounding comes to, by what an engine says of its numbers."""

# Half an ulp of a number of size 1.
ROUNDINGS = {"double": 2.0**-53, "single": 2.0**-24}
DOUBLE = ROUNDINGS["double"]


def precision(rounding: float) -> str:
    """Return the name of a class of precision."""
    return "double" if rounding <= DOUBLE else "single"


def rounding(precision: str) -> float:
    """Return what one rounding moves a number of size 1; an engine that does not say has doubles."""
    return ROUNDINGS.get(precision, DOUBLE)
