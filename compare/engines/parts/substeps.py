"""For engines whose step is several substeps, over which a force that is told once a step is held."""

from collections.abc import Callable


def held_over(substeps: int) -> Callable[[float, float, float], list[list[float]]]:
    """Return the scheme of a step of so many semi-implicit substeps, as SCHEMES has it: of u'' + c u' + s u = 0."""
    carried = (substeps + 1) / (2 * substeps)  # of h^2 times the acceleration: the sum of k/substeps^2

    def scheme(s: float, c: float, h: float) -> list[list[float]]:
        return [[1 - carried * h * h * s, h - carried * h * h * c], [-h * s, 1 - h * c]]

    return scheme
