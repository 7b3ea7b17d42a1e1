"""A disc as engines have it: a cylinder, which has a thickness."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tumble.scenarios.scene import Disc


def cylinder(disc: "Disc") -> tuple[float, float]:
    """Return radius and half the height of a cylinder [m].  Raises NotImplementedError for a disc that is none."""
    if not disc.thickness:
        raise NotImplementedError("it has no disc without thickness")
    return disc.radius, disc.thickness / 2
