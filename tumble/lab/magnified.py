"""How far off, made visible: every vertex drawn where it would be were its error so many times larger."""

from scenarios.frames import Array

MOST = 1000.0


def magnified(true: Array, seen: Array, factor: float) -> Array:
    """Return true + factor (seen - true) [m], (n, 3): the true body itself where there is no error."""
    return true + factor * (seen - true)
