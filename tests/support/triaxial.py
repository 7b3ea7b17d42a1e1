"""The triaxial box of the laws, for the tests of engines.

Three different moments, because a cube cannot show a wrong gyroscopic term.
"""

from tumble.compare.run.engines.brick import GRAVITY, MASS, MOMENTS, SIZE, THROWS, scene

__all__ = ["GRAVITY", "MASS", "MOMENTS", "SIZE", "THROWS", "scene"]
