"""The coordinates that a browser draws in."""

from dataclasses import dataclass

from tumble.scenarios.frames import Array
from tumble.scenarios.scene import Scene


@dataclass(frozen=True, eq=False)
class Space:
    """Lengths of the body from where it starts.

    A browser draws in single precision, walks two lengths a second, and sees nothing nearer than a hundredth: it is
    given lengths in the body's radius, from where the body starts.  root: the name of the scene's node in the browser.
    """

    root: str
    origin: Array
    radius: float

    @classmethod
    def of(cls, scene: Scene, root: str) -> "Space":
        """Return the coordinates of a scene."""
        return cls(root, scene.start[0, 0:3], scene.body.reach)

    def drawn(self, places: Array) -> Array:
        """Return where places [m], (..., 3), are drawn."""
        return (places - self.origin) / self.radius

    def meant(self, drawn: Array) -> Array:
        """Return the place [m] of what is drawn somewhere, (3,)."""
        return drawn * self.radius + self.origin
