"""Looks of contestants: the engine's colour, as on the page, and a mark and a dash of the contestant's own."""

from typing import NamedTuple

from tumble.lab.pool import Contestant
from tumble.reports.hues import places, rgb

Colour = tuple[int, int, int]
MARKS = ("\N{BLACK CIRCLE}", "\N{BLACK SQUARE}", "\N{BLACK UP-POINTING TRIANGLE}", "\N{BLACK DIAMOND}",
         "\N{BLACK DOWN-POINTING TRIANGLE}", "\N{HEAVY GREEK CROSS}")  # fmt: skip
DASHES = ("", "7 3", "2 3", "9 3 2 3", "5 2 5 2 1 2", "1 2")


class Look(NamedTuple):
    """colour: red, green and blue; mark: one character; dash: as SVG has it."""

    colour: Colour
    mark: str
    dash: str

    @property
    def css(self) -> str:
        """The colour as a page writes it."""
        return f"rgb({', '.join(map(str, self.colour))})"


class Looks:
    """Looks of contestants, fixed as long as the page is open."""

    def __init__(self) -> None:
        self._places: dict[str, int] = {}
        self._given: dict[Contestant, Look] = {}

    def of(self, one: Contestant) -> Look:
        """Return a contestant's look."""
        if one not in self._given:
            engine = one.title
            if engine not in self._places:
                self._places[engine] = places([*self._places, engine]).get(engine, 0)
            number = sum(other.title == engine for other in self._given)
            look = Look(rgb(self._places[engine]), MARKS[number % len(MARKS)], DASHES[number % len(DASHES)])
            self._given[one] = look
        return self._given[one]
