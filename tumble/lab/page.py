"""One browser: its session, and its picture in viser, updated by a thread of its own."""

import threading
import time
import traceback
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import viser

from tumble.compare.run.engines.registry import BadEngine
from tumble.lab.chart import Curve, chart
from tumble.lab.draft import Draft, usual_magnitude
from tumble.lab.looks import Look, Looks
from tumble.lab.magnify import AS_IT_IS, FACTORS, FIT, fitting, magnified, times
from tumble.lab.markup import chart_box, error_table, grade_box, places, readings_table
from tumble.lab.panel import Actions, Panel, moves_far, show
from tumble.lab.picture import captioned
from tumble.lab.pool import Contestant, Pool
from tumble.lab.readings import ErrorRow, Reading, error_rows, errors_over_time, readings, sensor_readings
from tumble.lab.refusals import Refused, in_words
from tumble.lab.report import ReportAtWork
from tumble.lab.save import Saved, download
from tumble.lab.sentences import sentence
from tumble.lab.session import Session, Shown
from tumble.lab.stage import BACKGROUND, FOREIGN, Ghost, Stage
from tumble.lab.ticks import Offer
from tumble.scenarios.impulse import RayMissed
from tumble.scenarios.published import VERTEX
from tumble.scenarios.read import BadScene, catalogue

FRAME_S, NUMBERS_S, CHART_S, PICTURE_S = 1 / 40, 0.12, 0.3, 20.0
TICKS_S = 2.0  # after a page is opened: its many boxes can wait for the first picture
PICTURE_WIDTH = 960
TABLE_4_1 = "table-4-1-ray"
FOREIGN_INK = f"rgb{FOREIGN}"


@dataclass
class View:
    """The user's choices: how errors are magnified, the vertex of the table, None for the one with the largest error,
    whether the camera follows the body; and the impulse of the next click [N s]."""

    magnify: str = FIT
    vertex: int | None = None
    follow: bool = False
    magnitude: float = 0.0


@dataclass(eq=False)
class Curves:
    """The errors of a throw over time [m] at its last result, and the magnification that fits the view."""

    times: np.ndarray
    errors: dict[Contestant, np.ndarray]
    limit: np.ndarray
    factor: float


class Page:
    """What one browser shows and commands."""

    def __init__(
        self, client: viser.ClientHandle, draft: Draft, contestants: Sequence[Contestant], pool: Pool, folder: Path
    ) -> None:
        self._client, self._pool, self._folder = client, pool, folder
        self._news = threading.Event()
        self._queue: deque[tuple[Callable[..., object], tuple[Any, ...]]] = deque()
        self._closed = self._is_table_4_1 = False
        self._refusal = self._notice = ""
        self._report = ReportAtWork(self._saved_report, self._notify)
        self._looks = Looks()
        self._view = View()
        self.session = Session(draft, contestants, pool, folder, self._news.set)
        actions = Actions(
            throwing=self._queued(self._throwing),
            magnitude=self._queued(lambda value: setattr(self._view, "magnitude", value)),
            play=self._queued(self._play_or_pause),
            go_to=self._queued(self.session.go_to),
            pace=self._queued(self.session.pace),
            magnify=self._queued(lambda value: setattr(self._view, "magnify", value)),
            vertex=self._queued(lambda value: setattr(self._view, "vertex", value)),
            follow=self._queued(lambda value: setattr(self._view, "follow", value)),
            open=self._queued(self._open),
            edit=self._queued(self._edit),
            defaults=self._queued(self.session.use_defaults),
            tick=self._queued(self._tick),
            save=self._queued(self._save),
            load=self._queued(self._load),
        )
        self._panel = Panel(client, actions, catalogue(), str(folder))
        self._stage = Stage(client, self._queued(self._click))
        self._drawn: Any = None
        self._curves: Curves | None = None
        self._curves_of: Any = None
        self._numbers_at = self._chart_at = 0.0
        self._opened_at = time.monotonic()
        self._needs_redraw = self._is_behind = True
        self._show_opened()
        threading.Thread(target=self._update, daemon=True, name="page").start()

    def close(self) -> None:
        """Stop all that it does."""
        self._closed = True
        self.session.close()
        self._report.close()
        self._news.set()

    # Commands: run by the page's own thread

    def _queued(self, action: Callable[..., object]) -> Callable[..., None]:
        """Return a function that queues an action behind those queued before.

        viser calls it from threads that all pages share: one page must not delay the others.
        """

        def queue(*arguments: Any) -> None:
            self._queue.append((action, arguments))
            self._news.set()

        return queue

    def _run_queued(self) -> None:
        """Run the queued actions in order, each under the lock; show the reason where one is refused."""
        while self._queue:
            action, arguments = self._queue.popleft()
            with self.session.lock:
                if self._closed:
                    return
                self._refusal = self._notice = ""
                try:
                    action(*arguments)
                except (Refused, BadScene, BadEngine, RayMissed, OSError) as error:
                    self._refusal = in_words(error)
                except Exception:  # a fault of ours: it is printed, and the page goes on
                    traceback.print_exc()
                self._needs_redraw = True

    def _click(self, origin: Sequence[float], direction: Sequence[float]) -> None:
        self.session.click(origin, direction, self._view.magnitude)

    def _throwing(self, what: str) -> None:
        match what:
            case "Reset":
                self.session.reset()
                self._set_up(look=True)
            case "Again":
                self.session.again()
            case "Table 4.1":
                self._throw_table_4_1()
            case _:
                self.session.throw_own()

    def _throw_table_4_1(self) -> None:
        self._open(TABLE_4_1)
        self.session.throw_own()
        self._is_table_4_1 = self._panel.marked.visible = True
        self._view.vertex, self._view.magnify = VERTEX, AS_IT_IS
        self._panel.vertex.value, self._panel.magnified.value = str(VERTEX), AS_IT_IS
        assert self.session.throw is not None
        self._stage.show_printed(self.session.throw.scene.rows)

    def _play_or_pause(self) -> None:
        if self.session.clock.is_running:
            self.session.pause()
        else:
            self.session.play()

    def _open(self, name: str) -> None:
        self.session.open(name)
        self._show_opened()

    def _edit(self, path: tuple[str, ...], value: Any) -> None:
        try:
            self.session.edit({path: list(value) if isinstance(value, tuple) else float(value)})
        finally:
            self._set_up(look=False)

    def _tick(self, one: Contestant, is_ticked: bool) -> None:
        others = [each for each in self.session.contestants if each != one]
        self.session.engage([*others, one] if is_ticked else others)

    def _save(self, what: str) -> None:
        files = self.session.files()
        throw = self.session.throw
        assert throw is not None
        match what:
            case "Scene":
                self._give(files.scene_file, files.scene_files)
            case "CSV":
                folder = files.tables(throw)
                self._give(folder, sorted(folder.iterdir()))
            case "Report":
                self._notice = self._report.make(files, throw.contestants)
            case "Screenshot":
                self._notice = "Taking the picture."
                threading.Thread(target=self._take_picture, args=(files,), daemon=True).start()

    def _give(self, path: Path, files: Sequence[Path]) -> None:
        """Let the browser download what was saved, and show its name.  Raises OSError."""
        name, content = download(path, files)
        self._client.send_file_download(name, content, save_immediately=True)
        self._notify(f"Saved and downloaded: {path.name}{'/' if path.is_dir() else ''}")

    def _saved_report(self, path: Path) -> None:
        try:
            self._give(path, [path])
        except OSError as error:
            self._notify(f"No report: {error}")

    def _take_picture(self, files: Saved) -> None:
        """Save the browser's picture at one instant; outside the lock, because the browser draws it."""
        with self.session.lock:
            self.session.pause()
            shown = self.session.shown()
            with self._client.atomic():
                self._show_picture(shown)
            shown_readings, size = self._readings(shown)
            rows = self._rows(shown, None)
            colours = {row.contestant: self._looks.of(row.contestant).colour for row in rows}
        try:
            camera = self._client.camera
            height = round(PICTURE_WIDTH * camera.image_height / camera.image_width)
            pixels = self._client.get_render(height, PICTURE_WIDTH, transport_format="png", timeout=PICTURE_S)
            path = files.picture(captioned(pixels, BACKGROUND, shown_readings, rows, colours, places(size)))
            self._give(path, [path])
        except (RuntimeError, TimeoutError, ValueError, ArithmeticError, OSError) as error:
            self._notify(f"No picture: {error}")

    def _load(self, name: str, content: bytes) -> None:
        self.session.load(name, content, self._loaded)
        self._notice = f"Reading and grading {name}: this can take a minute."

    def _loaded(self, refused: str) -> None:
        """Show the result of loading a trajectory: its verdict below the line, or the reason on it."""
        self._refusal, self._notice = refused, ""
        self._needs_redraw = True
        self._news.set()

    def _notify(self, line: str) -> None:
        """Show a line of a command that ran in the background."""
        self._notice = line
        self._needs_redraw = True
        self._news.set()

    def _show_opened(self) -> None:
        """Show a newly opened scene with its own default choices."""
        self._set_up(look=True)
        scene = self.session.draft.scene
        self._view = View(follow=moves_far(scene), magnitude=usual_magnitude(scene))
        self._panel.show_scene(scene, self.session.draft.path.stem, self._view.magnitude)

    def _set_up(self, *, look: bool) -> None:
        """Build the picture of the scene with its body at the start; look: from the usual place."""
        scene = (self.session.thrown or self.session.draft).scene
        self._stage.set_up(scene, look=look)
        self._is_table_4_1 = self._panel.marked.visible = False
        self._panel.show_values(scene)
        self._needs_redraw = True

    # Drawing: by the page's own thread

    def _update(self) -> None:
        while not self._closed:
            running = self.session.clock.is_running
            self._news.wait(FRAME_S if running else NUMBERS_S if self._is_behind else None)
            self._news.clear()
            self._run_queued()
            with self.session.lock:
                if not self._closed:
                    self._show()
        self.session.close()  # of a throw that was begun meanwhile

    def _show(self) -> None:
        """Update the browser to the state of the session; numbers and chart less often than the picture."""
        session, now = self.session, time.monotonic()
        shown, throw = session.shown(), session.throw
        news = None if throw is None else (throw, len(throw.answers), throw.known, throw.why_no_truth, session.foreign)
        if news != self._curves_of:
            self._curves_of, self._curves = news, self._compute_curves()
        chosen = self._view.magnify, self._view.vertex, self._view.follow
        view = (news, shown.frame, chosen, self._refusal, self._notice)
        if view != self._drawn or self._needs_redraw:
            self._needs_redraw = False
            with self._client.atomic():
                self._show_picture(shown)
            self._drawn, self._is_behind = view, True
        if self._is_behind and (now - self._numbers_at >= NUMBERS_S):
            self._numbers_at = now
            self._panel.show_time(shown.time, session.clock.is_running, session.clock.speed)
            self._show_numbers(shown)
            self._is_behind = False
        self._show_slowly(shown, now)

    def _show_slowly(self, shown: Shown, now: float) -> None:
        """Update what is expensive for a browser less often, and the boxes only when nothing moves."""
        is_running = self.session.clock.is_running
        if not is_running or now - self._chart_at >= CHART_S:
            self._chart_at = now
            show(self._panel.chart, self._chart(shown))
        if not is_running and now - self._opened_at >= TICKS_S:
            self._panel.ticks.show(self._offers())
        elif not is_running:
            self._is_behind = True  # until they are shown

    def _compute_curves(self) -> Curves | None:
        """Return the errors over time of the results so far."""
        throw, foreign = self.session.throw, self.session.foreign
        if throw is None:
            return None
        times, errors = errors_over_time(throw)
        largest = [] if foreign is None or foreign.is_right else [float(foreign.errors.max())]
        factor = fitting(errors.values(), throw.true_limit, throw.scene.body.reach, largest)
        return Curves(times, errors, throw.true_limit, factor)

    def _factor_of(self, shown: Shown) -> float:
        """Return the magnification of errors: 1 where there is no truth."""
        if not shown.is_true:
            return 1.0
        if self._view.magnify == FIT:
            return 1.0 if self._curves is None else self._curves.factor
        return FACTORS[self._view.magnify]

    def _show_picture(self, shown: Shown) -> None:
        session, stage, throw = self.session, self._stage, self.session.throw
        stage.follow(shown.state[0:3] if self._view.follow else None)
        stage.show_body(shown.state, shown.vertices, shown.whose)
        for one in session.running():  # looks in their order, not in that of their results
            self._looks.of(one)
        factor = self._factor_of(shown)
        note = f"error \N{MULTIPLICATION SIGN} {times(factor)}" if factor > 1 else ""
        stage.show_ghosts(self._ghosts(shown), note)
        stage.show_impulses(session.impulses_lately(shown.time))
        if throw is not None:
            known = slice(0, throw.known)
            stage.show_path(throw.true_states[known, 0:3])
            stage.show_printed_vertex(shown.vertices, throw.true_vertices[known])

    def _ghosts(self, shown: Shown) -> dict[str, Ghost]:
        """Return the bodies that are drawn beside the truth at a frame."""
        throw, foreign, factor = self.session.throw, self.session.foreign, self._factor_of(shown)
        ghosts = {}
        for one, flight in ({} if throw is None else throw.trajectories()).items():
            seen = flight.vertices[shown.frame, 0]
            if np.isfinite(seen).all():
                look = self._looks.of(one)
                name = f"{look.mark} {one.name}"
                ghosts[one.name] = Ghost(magnified(shown.vertices, seen, factor), look.colour, name)
        off = None if foreign is None else foreign.at(shown.time)
        if foreign is not None and off is not None and off.shape == shown.vertices.shape:
            moved = magnified(shown.vertices, shown.vertices + off, factor)
            ghosts[f"file {foreign.name}"] = Ghost(moved, FOREIGN, foreign.name)
        return ghosts

    def _show_numbers(self, shown: Shown) -> None:
        session, panel = self.session, self._panel
        shown_readings, size = self._readings(shown)
        show(panel.readings, readings_table(shown_readings, size))
        vertex = self._view.vertex
        rows = self._rows(shown, vertex)
        looks: dict[Contestant, Look] = {row.contestant: self._looks.of(row.contestant) for row in rows}
        show(panel.errors, error_table(rows, looks, size, vertex, shown.time) if rows else "")
        own = sentence(session, shown, rows, self._factor_of(shown), is_table_4_1=self._is_table_4_1)
        panel.show_status(self._refusal or self._notice or own, is_refusal=bool(self._refusal))
        show(panel.grade, grade_box(session.foreign) if session.foreign else "")

    def _rows(self, shown: Shown, vertex: int | None) -> list[ErrorRow]:
        """Return the error table at a frame, and whether each contestant is in the view."""
        throw = self.session.throw
        if throw is None:
            return []
        ghosts = self._ghosts(shown)
        seen = {name: self._stage.sees(ghost.vertices) for name, ghost in ghosts.items()}
        rows = error_rows(throw, shown.frame, vertex)
        return [replace(row, is_in_view=seen.get(row.contestant.name, True)) for row in rows]

    def _chart(self, shown: Shown) -> str:
        found = self._curves
        if found is None:
            return ""
        curves = []
        for one, errors in found.errors.items():
            look = self._looks.of(one)
            curves.append(Curve(one.name, found.times, errors, look.css, look.dash))
        if foreign := self.session.foreign:
            curves.append(Curve(foreign.name, foreign.times, foreign.errors, FOREIGN_INK, ""))
        return chart_box(chart(found.times, curves, found.limit, shown.frame))

    def _offers(self) -> list[Offer]:
        """Return every engine with the contestants that can be ticked."""
        pool, chosen_ones = self._pool, self.session.contestants
        scene = self.session.draft.scene
        by_engine: dict[str, list[Contestant]] = {}
        for one in pool.all_contestants():
            info = pool.engines.get(one.engine)
            has_use = info is None or one.method not in info.without_use(scene)
            if has_use or one in chosen_ones:
                by_engine.setdefault(one.engine, []).append(one)
        for one in chosen_ones:  # METHOD@TOLERANCE, and what is missing
            own = by_engine.setdefault(one.engine, [])
            if one not in own:
                own.append(one)
        return [
            Offer(own[0].title, tuple(own), frozenset(chosen_ones) & frozenset(own), pool.why_not(engine))
            for engine, own in by_engine.items()
        ]

    def _readings(self, shown: Shown) -> tuple[list[Reading], float]:
        """Return the coursework's screen and the size of the body [m]."""
        scene = (self.session.thrown or self.session.draft).scene
        impulses = self.session.impulses_until(shown.time)
        impulse, hit = impulses[-1] if impulses else (None, None)
        shown_readings = readings(scene.body.mass, shown.time, shown.state, shown.vertices, impulse, hit)
        shown_readings += sensor_readings(
            scene,
            shown.state,
            self.session.struck_point(shown.time),
            self.session.wrench,
            at_impulse=any(one.time == shown.time for one in scene.impulses),
        )
        return shown_readings, float(np.ptp(scene.body.points, axis=0).max())
