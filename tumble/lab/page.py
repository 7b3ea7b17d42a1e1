"""One browser: its session, and what viser shows of it, kept up by a thread of its own."""

import threading
import time
from collections.abc import Callable, Hashable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import viser

from compare.run.registry import BadEngine
from scenarios.impulse import RayMissed
from scenarios.published import VERTEX, table_4_1
from scenarios.read import BadScene, catalogue
from tumble.lab.crew import Contestant, Crew
from tumble.lab.draft import Draft, usual_magnitude
from tumble.lab.keep import Kept
from tumble.lab.magnified import magnified
from tumble.lab.markup import error_table, grade_box, places, readings_table
from tumble.lab.panel import WORST, Actions, Panel
from tumble.lab.picture import captioned
from tumble.lab.readings import Reading, error_rows, errors_over_time, readings
from tumble.lab.report import ReportAtWork
from tumble.lab.sentences import sentence
from tumble.lab.session import Refused, Session, Shown
from tumble.lab.stage import FOREIGN, PALETTE, Colour, Ghost, Stage, css

FRAME_S, NUMBERS_S, CHART_S, PICTURE_S = 1 / 40, 0.12, 1.0, 20.0
PICTURE_WIDTH = 960
TABLE_4_1 = "table-4-1-ray"


class Page:
    """What one browser sees and asks."""

    def __init__(
        self, client: viser.ClientHandle, draft: Draft, contestants: Sequence[Contestant], crew: Crew, folder: Path
    ) -> None:
        self._client, self._crew = client, crew
        self._news = threading.Event()
        self._closed = self._is_table_4_1 = False
        self._refused = self._said = ""
        self._report = ReportAtWork(self._tell)
        self._colours: dict[Contestant, int] = {}
        self.session = Session(draft, contestants, crew, folder, self._news.set)
        actions = Actions(
            throwing=self._asked(self._throwing),
            play=self._asked(self._play_or_pause),
            go_to=self._asked(self.session.go_to),
            pace=self._asked(self.session.pace),
            redraw=self._asked(lambda: None),
            open=self._asked(self._open),
            edit=self._asked(self._edit),
            defaults=self._asked(self.session.use_defaults),
            contestant=self._asked(self._add_or_drop),
            keep=self._asked(self._keep),
            load=self._asked(self._load),
        )
        self._panel = Panel(client, actions, catalogue())
        self._stage = Stage(client, self._asked(self._click))
        self._drawn: Any = None
        self._charted: Any = None
        self._numbers_at = self._chart_at = 0.0
        self._is_asked = self._is_behind = True
        self._show_opened()
        threading.Thread(target=self._keep_up, daemon=True, name="page").start()

    def close(self) -> None:
        """End what it does."""
        self._closed = True
        self.session.close()
        self._report.close()
        self._news.set()

    # What is asked: called by viser from threads of its own

    def _asked(self, action: Callable[..., object]) -> Callable[..., None]:
        """Return a function that does it alone, and says why not where it is refused."""

        def do(*arguments: Any) -> None:
            with self.session.lock:
                if self._closed:
                    return
                self._refused = self._said = ""
                try:
                    action(*arguments)
                except (Refused, BadScene, BadEngine, RayMissed, OSError) as error:
                    self._refused = str(error)
                self._is_asked = True
            self._news.set()

        return do

    def _click(self, origin: Sequence[float], direction: Sequence[float]) -> None:
        self.session.click(origin, direction, float(self._panel.magnitude.value))

    def _throwing(self, what: str) -> None:
        match what:
            case "Reset":
                self.session.reset()
                self._set_up(look=True)
            case "Again":
                self.session.again()
            case "As written":
                self.session.fly_as_written()
            case _:
                self._fly_table_4_1()

    def _fly_table_4_1(self) -> None:
        self._open(TABLE_4_1)
        self.session.fly_as_written()
        self._is_table_4_1 = self._panel.marked.visible = True
        self._panel.vertex.value = str(VERTEX)
        printed = table_4_1()
        self._stage.show_printed(printed.calculated, printed.application)

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

    def _keep(self, what: str) -> None:
        files = self.session.files()
        throw = self.session.throw
        assert throw is not None
        match what:
            case "Scene":
                self._said = f"Written: {files.scene_file.name}"
            case "CSV":
                self._said = f"Written: {files.tables(throw).name}/"
            case "Report":
                self._said = self._report.make(files, throw.contestants)
            case "Screenshot":
                self._said = "Taking the picture."
                threading.Thread(target=self._take_picture, args=(files,), daemon=True).start()

    def _take_picture(self, files: Kept) -> None:
        """Keep what the browser sees, at an instant; outside the lock, for it is the browser that draws it."""
        with self.session.lock:
            self.session.pause()
            shown, throw = self.session.shown(), self.session.throw
            with self._client.atomic():
                self._show_picture(shown)
            told, size = self._readings(shown)
            rows = [] if throw is None else error_rows(throw, shown.frame, None)
            colours = {row.contestant: self._colour(row.contestant) for row in rows}
        try:
            camera = self._client.camera
            height = round(PICTURE_WIDTH * camera.image_height / camera.image_width)
            pixels = self._client.get_render(height, PICTURE_WIDTH, transport_format="png", timeout=PICTURE_S)
            path = files.picture(captioned(pixels, told, rows, colours, places(size)))
            self._tell(f"Written: {path.name}")
        except (RuntimeError, TimeoutError, OSError) as error:
            self._tell(f"No picture: {error}")

    def _load(self, name: str, content: bytes) -> None:
        self.session.load(name, content, lambda refused: self._tell(refused or "Graded: see Keep."))
        self._said = "Reading and grading it."

    def _tell(self, line: str) -> None:
        """Say something that was not asked for just now."""
        self._said = line
        self._is_asked = True
        self._news.set()

    def _add_or_drop(self, name: str) -> None:
        one = next(each for each in self._crew.all_contestants() if each.name == name)
        others = [each for each in self.session.contestants if each != one]
        self.session.engage(others if one in self.session.contestants else [*others, one])

    def _show_opened(self) -> None:
        """Show a scene that is new: what was chosen for the last one does not hold for it."""
        self._set_up(look=True)
        scene = self.session.draft.scene
        self._panel.show_scene(scene, self.session.draft.path.stem, usual_magnitude(scene))

    def _set_up(self, *, look: bool) -> None:
        """Build what is seen of the scene as it is now, its body at the start; look: at it, from the usual place."""
        scene = (self.session.thrown or self.session.draft).scene
        self._stage.set_up(scene, look=look)
        self._is_table_4_1 = self._panel.marked.visible = False
        self._panel.show_question(scene)
        self._is_asked = True

    # What is shown: by the page's own thread

    def _keep_up(self) -> None:
        while not self._closed:
            running = self.session.clock.is_running
            self._news.wait(FRAME_S if running else NUMBERS_S if self._is_behind else None)
            self._news.clear()
            with self.session.lock:
                if not self._closed:
                    self._show()

    def _show(self) -> None:
        """Bring the browser up to what the session is; numbers and chart less often than the picture."""
        session, panel, now = self.session, self._panel, time.monotonic()
        shown, throw = session.shown(), session.throw
        news = None if throw is None else (throw, len(throw.answers), throw.known, throw.why_no_truth)
        view = (
            news,
            shown.frame,
            panel.magnified.value,
            panel.follow.value,
            panel.vertex.value,
            self._refused,
            self._said,
            session.foreign,
        )
        if view != self._drawn or self._is_asked:
            self._is_asked = False
            with self._client.atomic():
                self._show_picture(shown)
            self._drawn, self._is_behind = view, True
        if self._is_behind and (now - self._numbers_at >= NUMBERS_S):
            self._numbers_at = now
            panel.show_time(shown.time, session.clock.is_running, session.clock.speed)
            self._show_numbers(shown)
            self._is_behind = False
        if news != self._charted and now - self._chart_at >= CHART_S:
            self._charted, self._chart_at = news, now
            self._show_chart()
        self._is_behind = self._is_behind or news != self._charted

    def _show_picture(self, shown: Shown) -> None:
        session, stage, throw = self.session, self._stage, self.session.throw
        stage.follow(shown.state[0:3] if self._panel.follow.value else None)
        stage.show_body(shown.state, shown.vertices, shown.is_true)
        factor = float(self._panel.magnified.value)
        for one in session.flying():  # colours in their order, not in that of their answers
            self._colour(one)
        ghosts: dict[Hashable, Ghost] = {}
        for contestant, flight in ({} if throw is None else throw.flights()).items():
            seen = flight.vertices[shown.frame, 0]
            if np.isfinite(seen).all():
                state = flight.states[shown.frame, 0] if factor == 1.0 else None
                ghosts[contestant] = Ghost(magnified(shown.vertices, seen, factor), state, self._colour(contestant))
        foreign = None if session.foreign is None else session.foreign.at(shown.time)
        if session.foreign is not None and foreign is not None and foreign.shape == shown.vertices.shape:
            ghosts[session.foreign.name] = Ghost(magnified(shown.vertices, foreign, factor), None, FOREIGN)
        stage.show_ghosts(ghosts)
        stage.show_blows(session.impulses_until(shown.time))

    def _show_numbers(self, shown: Shown) -> None:
        session, panel, throw = self.session, self._panel, self.session.throw
        told, size = self._readings(shown)
        panel.readings.content = readings_table(told, size)
        panel.show_contestants([one.name for one in self._crew.all_contestants()])
        vertex = None if panel.vertex.value == WORST else int(panel.vertex.value)
        rows = [] if throw is None else error_rows(throw, shown.frame, vertex)
        colours = {row.contestant: css(self._colour(row.contestant)) for row in rows}
        panel.errors.content = error_table(rows, colours, size, vertex, shown.time) if rows else ""
        own = sentence(session, shown, rows, is_table_4_1=self._is_table_4_1)
        panel.say(self._refused or self._said or own, is_refusal=bool(self._refused))
        panel.grade.content = grade_box(session.foreign) if session.foreign else ""

    def _readings(self, shown: Shown) -> tuple[list[Reading], float]:
        """Return the coursework's screen and the size of the body [m]."""
        scene = (self.session.thrown or self.session.draft).scene
        blows = self.session.impulses_until(shown.time)
        impulse, hit = blows[-1] if blows else (None, None)
        told = readings(scene.body.mass, shown.time, shown.state, shown.vertices, impulse, hit)
        return told, float(np.ptp(scene.body.points, axis=0).max())

    def _show_chart(self) -> None:
        throw = self.session.throw
        if throw is None:
            self._panel.show_chart(np.empty(0), {}, np.empty(0))
            return
        times, curves = errors_over_time(throw)
        self._panel.show_chart(
            times, {one: (errors, css(self._colour(one))) for one, errors in curves.items()}, throw.true_limit
        )

    def _colour(self, contestant: Contestant) -> Colour:
        """Return a contestant's colour, the same as long as the page is open."""
        return PALETTE[self._colours.setdefault(contestant, len(self._colours)) % len(PALETTE)]
