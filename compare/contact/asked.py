"""What a scene asks of an engine: one number each, with its true value and what can be told of it."""

from dataclasses import dataclass

# Of an observable of a soft engine: its true value is that of the law which the engine states.
BY_OWN_LAW = ", by its own law"
# How fast a body moves that must rest.
CREEP = "creep speed"


@dataclass(frozen=True)
class Asked:
    """One observable.

    impact: which one of the scene, counted from 1, None of the whole run; unit; true: its true value; scale: what an
    error is held against to say how large it is, in the same unit; one_step: what the shift by one step of the scene
    does to it, the least error that shows beside that of a step; known_to: bound and input error of the true value.
    """

    observable: str
    impact: int | None
    unit: str
    true: float
    scale: float
    one_step: float
    known_to: float

    @property
    def key(self) -> tuple[str, int | None]:
        """What tells it from the scene's others."""
        return self.observable, self.impact

    def resolution(self, rounding: float) -> float:
        """Return the least difference that is none of rounding; rounding: of a number of size 1, by the engine."""
        return self.known_to + ROUNDINGS * rounding * self.scale


# Roundings that a number may have taken by the end of a ladder's run: about the square root of its steps.
ROUNDINGS = 64
