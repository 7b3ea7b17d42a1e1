"""Tick boxes for contestants: a folder for each engine that is up, a box for each that is not; missing ones marked."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import viser

from tumble.lab.pool import Contestant


class Offer(NamedTuple):
    """An engine, its contestants, the selected ones, and why it cannot run, '' where it can."""

    title: str
    contestants: tuple[Contestant, ...]
    ticked: frozenset[Contestant]
    why_not: str


class Drawn(NamedTuple):
    """What viser has of an offer: the node to remove, and a box for each contestant."""

    contestants: tuple[Contestant, ...]
    why_not: str
    node: Any
    boxes: dict[Contestant, Any]


class Ticks:
    """The boxes.  ticked: called with a contestant and whether it is ticked, when the user changes a box."""

    def __init__(self, gui: viser.GuiApi, folder: Any, ticked: Callable[[Contestant, bool], object]) -> None:
        self._gui, self._folder, self._ticked = gui, folder, ticked
        self._drawn: dict[str, Drawn] = {}
        self._shown: tuple[Offer, ...] = ()

    def show(self, offers: Sequence[Offer]) -> None:
        """Offer these, in their order."""
        if tuple(offers) == self._shown:
            return
        self._shown = tuple(offers)
        for gone in set(self._drawn) - {offer.title for offer in offers}:
            self._drawn.pop(gone).node.remove()
        for number, offer in enumerate(offers):
            drawn = self._drawn.get(offer.title)
            if drawn is None or (drawn.contestants, drawn.why_not) != (offer.contestants, offer.why_not):
                if drawn is not None:
                    drawn.node.remove()
                drawn = self._drawn[offer.title] = self._draw(offer, 100.0 + number)
            for one, box in drawn.boxes.items():
                if box.value != (one in offer.ticked):
                    box.value = one in offer.ticked
            if isinstance(drawn.node, viser.GuiFolderHandle):
                label = f"{offer.title}: {len(offer.ticked)} of {len(offer.contestants)}"
                if drawn.node.label != label:
                    drawn.node.label = label

    def _draw(self, offer: Offer, order: float) -> Drawn:
        with self._folder:
            if len(offer.contestants) == 1:
                (one,) = offer.contestants
                name = f"{one.name} (missing)" if offer.why_not else one.name
                box = self._box(one, name, offer.why_not or None, order=order)
                return Drawn(offer.contestants, offer.why_not, box, {one: box})
            node = self._gui.add_folder(offer.title, order=order, expand_by_default=False)
        with node:
            boxes = {one: self._box(one, one.method, None) for one in offer.contestants}
        return Drawn(offer.contestants, offer.why_not, node, boxes)

    def _box(self, one: Contestant, label: str, hint: str | None, order: float | None = None) -> Any:
        # One that is missing and takes part nevertheless can be unticked.
        box = self._gui.add_checkbox(label, initial_value=False, hint=hint, order=order)

        @box.on_update
        def _(event: Any) -> None:
            if event.client is not None:
                self._ticked(one, bool(event.target.value))

        return box
