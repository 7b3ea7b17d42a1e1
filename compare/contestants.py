"""Who takes part: ENGINE or ENGINE:METHOD, as everywhere in Tumble."""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from compare import roster
from compare.roster import BadEngine, Card
from compare.worker import Failure, Worker
from scenarios.format import nearest
from scenarios.needs import FORCES, needs
from scenarios.scene import Scene


@dataclass
class Entrant:
    """An engine that takes part: its name or file, its methods, its card or why it has none, and its worker.

    named: whether the methods were asked for by name, so that they fly whatever the scene.
    """

    engine: str
    methods: tuple[str, ...]
    named: bool
    card: Card | Failure
    worker: Worker

    @property
    def title(self) -> str:
        """The engine's name in tables."""
        return roster.title(self.engine)

    def methods_for(self, scene: Scene) -> tuple[str, ...]:
        """Return the methods that take part in this scene: the forced ones where another force than gravity acts."""
        if self.named or not scene.is_free or isinstance(self.card, Failure):
            return self.methods
        return tuple(method for method in self.methods if method not in self.card.forced)

    def barred(self, scene: Scene) -> Failure | None:
        """Return why this engine cannot be put this question, or None."""
        if isinstance(self.card, Failure):
            return self.card
        lacking = [need for need in needs(scene) if need in FORCES and need not in self.card.features]
        return Failure(f"skipped: {self.title} has no {' or '.join(lacking)}") if lacking else None

    def hire(self) -> Failure | None:
        """Take a new worker where the last one crashed or hung; return why it does not come up, or None."""
        if self.worker.alive:
            return None
        self.worker = Worker(self.engine, self.worker.time_limit)
        card = self.worker.describe()
        return card if isinstance(card, Failure) else None


def flights(entrants: Iterable[Entrant], scenes: Iterable[Scene]) -> int:
    """Return how many pairs there are of a method and a scene that it takes part in."""
    entrants = list(entrants)
    return sum(len(entrant.methods_for(scene)) for scene in scenes for entrant in entrants)


def split(item: str) -> tuple[str, str]:
    """Return engine and method ('' for all of them) of ENGINE[:METHOD].  Raises BadEngine for an unknown engine."""
    head, dot_py, tail = item.rpartition(".py")
    if dot_py and tail[:1] in ("", ":"):
        engine, method = head + dot_py, tail[1:]
        if not Path(engine).is_file():
            raise BadEngine(f"{engine}: no such engine file")
        return engine, method
    engine, _, method = item.partition(":")
    if engine not in roster.names():
        raise BadEngine(f"unknown engine {engine!r}: {nearest(engine, roster.names())}")
    return engine, method


def wanted(asked: Iterable[str]) -> dict[str, list[str]]:
    """Return the engines asked for with the methods named for each; nothing asked means every engine of ours."""
    engines: dict[str, list[str]] = {}
    for item in asked:
        engine, method = split(item)
        engines.setdefault(engine, [])
        if method:
            engines[engine].append(method)
    return engines or {engine: [] for engine in roster.names()}


def chosen(engine: str, asked: list[str], card: Card | Failure) -> tuple[str, ...]:
    """Return the methods that take part; of an engine that is not here, what was asked for.  Raises BadEngine."""
    if isinstance(card, Failure):
        return tuple(asked) or ("",)
    for method in asked:
        known = (*card.methods, *card.forced, *card.on_request)
        if method not in known and not is_tolerance(method, card):
            raise BadEngine(f"unknown method of {roster.title(engine)} {method!r}: {nearest(method, known)}")
    return tuple(dict.fromkeys(asked)) or (*card.methods, *card.forced)


def is_tolerance(method: str, card: Card) -> bool:
    """Whether this is METHOD@TOLERANCE of an adaptive method."""
    name, at, tolerance = method.partition("@")
    try:
        return bool(at) and name in card.adaptive and 0 < float(tolerance) < 1
    except ValueError:
        return False
