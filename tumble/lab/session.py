"""The lab of one browser: its commands, its throw and the time shown.  It runs without a browser, too."""

import threading
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tumble.compare.engines import SHIPPED
from tumble.compare.run.contestant import MethodName
from tumble.lab.background import Job
from tumble.lab.click import hit_point, impulse_table
from tumble.lab.clock import Clock, pace
from tumble.lab.draft import Draft
from tumble.lab.foreign import Foreign, loading
from tumble.lab.pool import Contestant, Pool
from tumble.lab.readings import Wrench
from tumble.lab.refusals import OWN_THROW, Refused, in_words
from tumble.lab.save import Saved
from tumble.lab.throw import Throw
from tumble.scenarios.frames import Array, rotation_matrix, vertices
from tumble.scenarios.impulse import RayMissed, strike_point
from tumble.scenarios.read import BadScene
from tumble.scenarios.scene import Impulse, Scene

START = "the start"  # what is shown before any result
PATIENCE_S, LEAD_S = 5.0, 0.25  # total wait of a throw for its truth; how far it may run ahead of it, of watching
LATELY = 0.25  # share of a throw, as on the page


@dataclass(frozen=True, eq=False)
class Shown:
    """The body at one frame: state (13,), vertices [m], (n, 3), and the contestant they belong to, '' for the truth."""

    frame: int
    time: float
    state: Array
    vertices: Array
    whose: str = ""

    @property
    def is_true(self) -> bool:
        """Whether it is the truth."""
        return not self.whose


class Session:
    """The lab of one browser.

    folder: where files are saved; changed: called, from any thread, when there is something new to show.  Its methods
    may be called from any thread that holds `lock`.
    """

    def __init__(
        self,
        draft: Draft,
        contestants: Sequence[Contestant],
        pool: Pool,
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
        self.saved: Saved | None = None
        self.foreign: Foreign | None = None
        self.wrench: Wrench | None = None
        self._pool, self._changed = pool, changed
        self._requested = list(contestants)
        self._loading: Job | None = None
        self._patience_s = 0.0
        self.clock = self._stopped_clock()

    def close(self) -> None:
        """End all that still runs."""
        if self.throw:
            self.throw.stop()
        if self._loading:
            self._loading.stop()

    @property
    def contestants(self) -> list[Contestant]:
        """The contestants that are selected."""
        return [self._pool.resolved(one) for one in self._requested]

    # Commands

    def open(self, name_or_path: str) -> None:
        """Open another scene.  Raises BadScene."""
        self.draft = Draft.opened(name_or_path)
        self.reset()

    def edit(self, values: Mapping[tuple[str, ...], Any]) -> None:
        """Change values of the scene and repeat the throw.  Raises BadScene, and nothing is changed."""
        try:
            draft = self.draft.edited(values)
        except BadScene:
            # The file's own throw may be what no longer fits; without it the body can still be clicked.
            draft = self.draft.without_impulses().edited(values)
        if self.thrown is None:
            self.draft = draft
            self.reset()
            return
        again = self.thrown.edited(values)
        self._check(again)
        self.draft = draft
        self._throw(again)

    def engage(self, contestants: Sequence[Contestant]) -> None:
        """Select other contestants and repeat the throw."""
        self._requested = list(contestants)
        self._throw_again()

    def use_defaults(self, at_defaults: bool) -> None:
        """Run engines with default settings, where they have them, or with fair ones; repeat the throw."""
        self.at_defaults = at_defaults
        self._throw_again()

    # Throwing

    def click(self, origin: Sequence[float], direction: Sequence[float], magnitude: float) -> None:
        """Apply an impulse [N s] along a ray, origin [m]: the first throws the body, the next only after `again`.

        A click beside the body is refused before a throw, and ignored after one.

        Raises Refused, BadScene.
        """
        shown, body = self.shown(), self.draft.scene.body
        is_over = self.thrown is not None and not self.aiming
        if not body.has_surface:
            raise Refused(f"This body has no surface to click: press {OWN_THROW}.")
        try:
            hit_point(origin, direction, shown.state, body)
        except RayMissed:
            if is_over:
                return
            raise Refused("The click missed the body: click the body itself.") from None
        if is_over:
            raise Refused("The body is already thrown. Press Reset for a new throw, or Again for another impulse.")
        table = impulse_table(origin, direction, magnitude, shown.time)
        before = self.draft.without_impulses() if self.thrown is None else self.thrown
        draft = before.with_impulse(table)
        if not draft.scene.impulses or not magnitude > 0:
            raise Refused("An impulse of 0 N s does not move the body: set Impulse first.")
        self.aiming = False
        self._throw(draft, shown.frame)

    def throw_own(self) -> None:
        """Throw the body with the impulses of the scene's own file.  Raises Refused, BadScene."""
        self._check(self.draft)
        self._throw(self.draft)

    def again(self) -> None:
        """Stop the time; the next click applies another impulse.  Raises Refused."""
        if self.throw is None:
            raise Refused("There is no throw yet: click the body first.")
        self.pause()
        if self.shown().frame >= len(self.throw.scene.rows) - 1:
            raise Refused("The throw has ended at this time: go back in time, or press Reset.")
        if not self.shown().is_true:
            if self.shown().time > self.throw.truth_ends:
                raise Refused("The truth ends before this time: go back in time, or press Reset.")
            raise Refused("The truth is not computed up to this time yet: wait a moment.")
        self.aiming = True
        self._changed()

    def reset(self) -> None:
        """Put the body back to its start, ready for the next throw."""
        self.close()
        self.throw, self.thrown, self.aiming = None, None, False
        self.saved, self.foreign, self._loading = None, None, None
        self.clock = self._stopped_clock()
        self._changed()

    def _check(self, draft: Draft) -> None:
        """Raise BadScene where an impulse at t = 0 misses the body."""
        scene = draft.scene
        for impulse in scene.impulses:
            if impulse.ray is not None and impulse.time == 0.0:
                try:
                    hit_point(impulse.ray.origin.tolist(), impulse.ray.direction.tolist(), scene.start[0], scene.body)
                except RayMissed as missed:
                    raise BadScene(f"{scene.name}: {missed}") from None

    def _throw_again(self) -> None:
        if self.thrown is not None:
            self._throw(self.thrown)
        self._changed()

    def _throw(self, draft: Draft, frame: int = 0) -> None:
        self.close()
        self.thrown, self.aiming = draft, False
        self.throw = Throw(draft.scene, self.running(), self._pool, self._changed)
        self._patience_s = PATIENCE_S
        self._prepare_wrench(draft.scene)
        self.saved, self.foreign, self._loading = None, None, None
        self.clock = self._stopped_clock().put(frame).started(time.monotonic())
        self._changed()

    def _prepare_wrench(self, scene: Scene) -> None:
        """Have what gives the forces of a scene at any state: compiled meanwhile, a throw does not wait for it."""
        self.wrench = None
        if scene.is_free or scene.plane is not None:
            return

        def work() -> None:
            from tumble.scenarios.wrench import wrench  # it brings a compiler, which a free throw has no use for

            made = wrench(scene)
            with self.lock:
                if self.throw is not None and self.throw.scene is scene:
                    self.wrench = made
            self._changed()

        threading.Thread(target=work, daemon=True, name="wrench").start()

    def running(self) -> list[Contestant]:
        """Return the contestants that run: at an engine's default settings where those are selected and it has them."""
        found = []
        for one in self.contestants:
            info = self._pool.engines.get(one.engine)
            shipped = MethodName.parse(one.method).name + SHIPPED
            has = self.at_defaults and info is not None and shipped in info.on_request
            found.append(self._pool.contestant(one.engine, shipped) if has else one)
        return list(dict.fromkeys(found))

    # Saving and loading

    def files(self) -> Saved:
        """Return the files of this throw.  Raises Refused."""
        if self.thrown is None:
            raise Refused("There is no throw to save: click the body first.")
        if self.saved is None:
            self.saved = Saved(self.thrown, self.folder)
        return self.saved

    def load(self, name: str, content: bytes, done: Callable[[str], object]) -> None:
        """Grade another program's trajectory of this throw, and show it; done: called with the reason why not, or "".

        Raises Refused, OSError.
        """
        if self.thrown is None or self.throw is None:
            raise Refused("There is no throw to compare with: click the body first.")
        if self._loading:
            self._loading.stop()
        job = self._loading = loading(self._pool.background, self.folder, name, content, self.throw.scene)

        def take(future: "Future[Foreign]") -> None:
            with self.lock:
                if self._loading is not job or future.cancelled():
                    return
                self._loading, error = None, future.exception()
                if error is None:
                    self.foreign = future.result()
                done(in_words(error) if isinstance(error, Exception) else "")
            self._changed()

        job.futures[0].add_done_callback(take)

    # The time shown

    def _stopped_clock(self) -> Clock:
        scene = (self.thrown or self.draft).scene
        former = getattr(self, "clock", None)
        same = former is not None and former.instants[-1] == scene.duration
        return Clock(scene.rows.tolist(), former.speed if former is not None and same else pace(scene.duration))

    def play(self) -> None:
        """Let time run, from the start again at the end; before a throw nothing happens."""
        if self.throw is not None:
            self.aiming = False
            self.clock = self.clock.started(time.monotonic())
            self._changed()

    def pause(self) -> None:
        """Stop the time at the frame shown."""
        self.clock = self.clock.stopped(time.monotonic())
        self._changed()

    def go_to(self, at: float) -> None:
        """Stop the time at the frame nearest to a time [s]."""
        self.clock = self.clock.put(int(np.argmin(np.abs(np.array(self.clock.instants) - at))))
        self._changed()

    def pace(self, speed: float) -> None:
        """Change the speed."""
        self.clock = self.clock.paced(time.monotonic(), speed)

    def shown(self) -> Shown:
        """Return what to show now: the truth, or, where it is not computed yet, the first trajectory that is."""
        scene, throw = (self.thrown or self.draft).scene, self.throw
        watch = time.monotonic()
        trajectories = {} if throw is None else throw.trajectories()
        if throw is not None and not trajectories and not throw.known:
            self.clock = self.clock.limited_to(watch, self.clock.at)  # there is nothing to show
        elif throw is not None and not throw.truth_is_complete and self._patience_s > 0:
            # Errors are shown as the body moves, so it waits for the truth, but not for ever.
            known = max(self.clock.instants[max(throw.known - 1, 0)], self.clock.at) + LEAD_S * self.clock.speed
            self._patience_s -= max(self.clock.time(watch) - known, 0.0) / self.clock.speed
            self.clock = self.clock.limited_to(watch, known)
        frame = self.clock.frame(watch)
        if self.clock.is_running and frame == len(self.clock.instants) - 1:
            self.clock = self.clock.stopped(watch)
        at = self.clock.instants[frame]
        if throw is None:
            return Shown(frame, at, scene.start[0], vertices(scene.start, scene.body.points)[0])
        if np.isfinite(throw.true_states[frame]).all():
            return Shown(frame, at, throw.true_states[frame], throw.true_vertices[frame])
        for one, flight in trajectories.items():
            if np.isfinite(flight.states[frame]).all():
                return Shown(frame, at, flight.states[frame, 0], flight.vertices[frame, 0], one.name)
        return Shown(frame, at, scene.start[0], vertices(scene.start, scene.body.points)[0], START)

    def impulses_lately(self, at: float) -> list[tuple[Impulse, Array]]:
        """Return the impulses that acted shortly before a time [s]."""
        while_s = LATELY * self.clock.instants[-1]
        return [one for one in self.impulses_until(at) if one[0].time >= at - while_s]

    def impulses_until(self, at: float) -> list[tuple[Impulse, Array]]:
        """Return the impulses that acted until a time [s], each with its point on the true body [m].

        An impulse whose point is not known yet is left out.
        """
        impulses = () if self.thrown is None else self.thrown.scene.impulses
        acted = [impulse for impulse in impulses if impulse.time <= at]
        places = [(impulse, self._impulse_point(impulse)) for impulse in acted]
        return [(impulse, place) for impulse, place in places if place is not None]

    def struck_point(self, at: float) -> Array | None:
        """Return the point of the body at which the last impulse until a time [s] acted [m], (3,), principal axes."""
        impulses = self.impulses_until(at)
        if not impulses:
            return None
        impulse, place = impulses[-1]
        state = self._state_at(impulse)
        return None if state is None else rotation_matrix(state[3:7]).T @ (place - state[0:3])

    def _impulse_point(self, impulse: Impulse) -> Array | None:
        scene, state = (self.thrown or self.draft).scene, self._state_at(impulse)
        try:
            return None if state is None else strike_point(impulse, state, scene.body)
        except RayMissed:
            return None

    def _state_at(self, impulse: Impulse) -> Array | None:
        """Return the state of the true body at an impulse, (13,), whose pose it does not change; None if not known."""
        scene = (self.thrown or self.draft).scene
        if impulse.time == 0:
            return scene.start[0]
        if self.throw is None:
            return None
        state = self.throw.true_states[int(np.searchsorted(scene.rows, impulse.time))]
        return state if np.isfinite(state).all() else None
