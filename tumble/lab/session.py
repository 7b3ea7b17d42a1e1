"""One browser's lab: what it asks, the throw that answers, and the time shown.  No browser is needed to use it."""

import threading
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from compare.engines import SHIPPED
from scenarios.frames import Array, vertices
from scenarios.impulse import RayMissed, strike_point
from scenarios.read import BadScene
from scenarios.scene import Impulse
from tumble.lab.aside import Errand
from tumble.lab.click import hit_point, impulse_table
from tumble.lab.clock import Clock, pace
from tumble.lab.crew import Contestant, Crew
from tumble.lab.draft import Draft
from tumble.lab.foreign import Foreign, loading
from tumble.lab.keep import Kept
from tumble.lab.throw import Throw


class Refused(ValueError):
    """What the lab does not do; the text is the one line for the user."""


@dataclass(frozen=True, eq=False)
class Shown:
    """What is seen at one frame: state (13,) and vertices [m], (n, 3); is_true: whether they are the truth's."""

    frame: int
    time: float
    state: Array
    vertices: Array
    is_true: bool


class Session:
    """The lab of one browser.

    folder: where what is kept goes; changed: called, from any thread, when there is something new to show.  Its methods
    may be called from any thread, by one that holds `lock`.
    """

    def __init__(
        self,
        draft: Draft,
        contestants: Sequence[Contestant],
        crew: Crew,
        folder: Path,
        changed: Callable[[], object],
    ) -> None:
        self.folder = folder
        self.lock = threading.RLock()
        self.at_defaults = False
        self.aiming = False
        self.draft = draft
        self.thrown: Draft | None = None
        self.throw: Throw | None = None
        self.kept: Kept | None = None
        self.foreign: Foreign | None = None
        self._crew, self._changed = crew, changed
        self._asked = list(contestants)
        self._loading: Errand | None = None
        self.clock = self._stopped_clock()

    def close(self) -> None:
        """End what still flies or is read."""
        if self.throw:
            self.throw.stop()
        if self._loading:
            self._loading.stop()

    @property
    def contestants(self) -> list[Contestant]:
        """Who is asked to fly."""
        return [self._crew.resolved(one) for one in self._asked]

    # What is asked

    def open(self, name_or_path: str) -> None:
        """Take another scene.  Raises BadScene."""
        self.draft = Draft.opened(name_or_path)
        self.reset()

    def edit(self, values: Mapping[tuple[str, ...], Any]) -> None:
        """Change values of the scene; what was thrown is thrown again.  Raises BadScene, and nothing is changed."""
        try:
            draft = self.draft.edited(values)
        except BadScene:
            # The file's own throw may be what does not fit; without it the body can still be clicked.
            draft = self.draft.without_impulses().edited(values)
        if self.thrown is None:
            self.draft = draft
            self.reset()
            return
        again = self.thrown.edited(values)
        self._check(again)
        self.draft = draft
        self._fly(again)

    def engage(self, contestants: Sequence[Contestant]) -> None:
        """Let others fly; what was thrown is thrown again."""
        self._asked = list(contestants)
        self._fly_again()

    def use_defaults(self, at_defaults: bool) -> None:
        """Fly engines as they ship, where they have such settings, or in fair ones; thrown again."""
        self.at_defaults = at_defaults
        self._fly_again()

    # Throwing

    def click(self, origin: Sequence[float], direction: Sequence[float], magnitude: float) -> None:
        """Strike the body along a ray, origin [m], with so many N s: the first throws it, the next only after `again`.

        Raises Refused, BadScene.
        """
        if self.thrown is not None and not self.aiming:
            raise Refused("thrown already: Reset allows the next throw, Again adds an impulse to this one")
        shown = self.shown()
        try:
            hit_point(origin, direction, shown.state, self.draft.scene.body)
        except RayMissed:
            raise Refused("the ray just misses the body") from None
        table = impulse_table(origin, direction, magnitude, shown.time)
        before = self.draft.without_impulses() if self.thrown is None else self.thrown
        struck = before.struck(table)
        if not struck.scene.impulses or not magnitude > 0:
            raise Refused("an impulse of 0 N s throws nothing")
        self.aiming = False
        self._fly(struck, shown.frame)

    def fly_as_written(self) -> None:
        """Fly the scene with the impulses of its own file.  Raises Refused, BadScene."""
        self._check(self.draft)
        self._fly(self.draft)

    def again(self) -> None:
        """Stop the time and let the next click be another impulse.  Raises Refused."""
        if self.throw is None:
            raise Refused("nothing flies yet: the first click throws")
        self.pause()
        if self.shown().frame >= len(self.throw.scene.rows) - 1:
            raise Refused("the flight is over here: go back in time, or Reset")
        if not self.shown().is_true:
            raise Refused("no truth at this time yet: nothing to aim at")
        self.aiming = True
        self._changed()

    def reset(self) -> None:
        """Put the body where it starts, ready for the next throw."""
        self.close()
        self.throw, self.thrown, self.aiming = None, None, False
        self.kept, self.foreign, self._loading = None, None, None
        self.clock = self._stopped_clock()
        self._changed()

    def _check(self, draft: Draft) -> None:
        """Raise BadScene where an impulse of the start does not land."""
        scene = draft.scene
        for impulse in scene.impulses:
            if impulse.ray is not None and impulse.time == 0.0:
                try:
                    hit_point(impulse.ray.origin.tolist(), impulse.ray.direction.tolist(), scene.start[0], scene.body)
                except RayMissed as missed:
                    raise BadScene(f"{scene.name}: {missed}") from None

    def _fly_again(self) -> None:
        if self.thrown is not None:
            self._fly(self.thrown)
        self._changed()

    def _fly(self, draft: Draft, frame: int = 0) -> None:
        self.close()
        self.thrown, self.aiming = draft, False
        self.throw = Throw(draft.scene, self.flying(), self._crew, self._changed)
        self.kept, self.foreign, self._loading = None, None, None
        self.clock = self._stopped_clock().put(frame).started(time.monotonic())
        self._changed()

    def flying(self) -> list[Contestant]:
        """Return who flies: at an engine's defaults where they are asked for and it has them."""
        found = []
        for one in self.contestants:
            info = self._crew.engines.get(one.engine)
            shipped = one.method.partition("+")[0] + SHIPPED
            has = self.at_defaults and info is not None and shipped in info.on_request
            found.append(self._crew.contestant(one.engine, shipped) if has else one)
        return list(dict.fromkeys(found))

    # What is kept, and what is brought along

    def files(self) -> Kept:
        """Return where this throw is kept.  Raises Refused."""
        if self.thrown is None:
            raise Refused("nothing is thrown yet: there is nothing to keep")
        if self.kept is None:
            self.kept = Kept(self.thrown, self.folder)
        return self.kept

    def load(self, name: str, content: bytes, done: Callable[[str], object]) -> None:
        """Grade a trajectory that some other program made of this throw and let it fly along; done: told why not.

        Raises Refused, OSError.
        """
        if self.thrown is None or self.throw is None:
            raise Refused("nothing is thrown yet: there is nothing to hold a trajectory against")
        if self._loading:
            self._loading.stop()
        errand = self._loading = loading(self._crew.hands, self.folder, name, content, self.throw.scene)

        def take(future: "Future[Foreign]") -> None:
            with self.lock:
                if self._loading is not errand or future.cancelled():
                    return
                self._loading, error = None, future.exception()
                if error is None:
                    self.foreign = future.result()
                done(str(error) if error else "")
            self._changed()

        errand.futures[0].add_done_callback(take)

    # The time shown

    def _stopped_clock(self) -> Clock:
        scene = (self.thrown or self.draft).scene
        former = getattr(self, "clock", None)
        same = former is not None and former.instants[-1] == scene.duration
        return Clock(scene.rows.tolist(), former.speed if former is not None and same else pace(scene.duration))

    def play(self) -> None:
        """Let time go on, from the start again at the end; there is nothing to play before a throw."""
        if self.throw is not None:
            self.aiming = False
            self.clock = self.clock.started(time.monotonic())
            self._changed()

    def pause(self) -> None:
        """Stop the time at the instant shown."""
        self.clock = self.clock.stopped(time.monotonic())
        self._changed()

    def go_to(self, at: float) -> None:
        """Stop the time at the instant nearest to one [s]."""
        self.clock = self.clock.put(int(np.argmin(np.abs(np.array(self.clock.instants) - at))))
        self._changed()

    def pace(self, speed: float) -> None:
        """Let time go at another speed."""
        self.clock = self.clock.paced(time.monotonic(), speed)

    def shown(self) -> Shown:
        """Return what is seen now: the truth, or, where it is not there yet, the first flight that is."""
        scene, throw = (self.thrown or self.draft).scene, self.throw
        watch = time.monotonic()
        flights = [] if throw is None else list(throw.flights().values())
        if throw is not None and not flights and not throw.known:
            self.clock = self.clock.kept_at(watch, self.clock.at)  # nothing is there to be shown
        frame = self.clock.frame(watch)
        if self.clock.is_running and frame == len(self.clock.instants) - 1:
            self.clock = self.clock.stopped(watch)
        at = self.clock.instants[frame]
        if throw is None:
            return Shown(frame, at, scene.start[0], vertices(scene.start, scene.body.points)[0], True)
        if np.isfinite(throw.true_states[frame]).all():
            return Shown(frame, at, throw.true_states[frame], throw.true_vertices[frame], True)
        for flight in flights:
            if np.isfinite(flight.states[frame]).all():
                return Shown(frame, at, flight.states[frame, 0], flight.vertices[frame, 0], False)
        return Shown(frame, at, scene.start[0], vertices(scene.start, scene.body.points)[0], False)

    def impulses_until(self, at: float) -> list[tuple[Impulse, Array]]:
        """Return the impulses that acted until a time [s], each with the point of the true body that it struck [m].

        Before a throw nothing acted; one whose point is not known yet is left out.
        """
        impulses = () if self.thrown is None else self.thrown.scene.impulses
        acted = [impulse for impulse in impulses if impulse.time <= at]
        places = [(impulse, self._struck(impulse)) for impulse in acted]
        return [(impulse, place) for impulse, place in places if place is not None]

    def _struck(self, impulse: Impulse) -> Array | None:
        scene = (self.thrown or self.draft).scene
        state = scene.start[0]
        if impulse.time > 0:
            if self.throw is None:
                return None
            state = self.throw.true_states[int(np.searchsorted(scene.rows, impulse.time))]
        try:
            return strike_point(impulse, state, scene.body) if np.isfinite(state).all() else None
        except RayMissed:
            return None
