"""The controls and numbers beside the scene, in viser.  Every control calls one function of the page."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from decimal import Decimal
from importlib.resources import files
from typing import Any

import numpy as np
import viser

from tumble.lab.clock import SPEEDS
from tumble.lab.guard import take_uploads_of
from tumble.lab.magnify import MAGNIFIED
from tumble.lab.markup import folder_line, status_line
from tumble.lab.pool import Contestant
from tumble.lab.refusals import OWN_THROW
from tumble.lab.ticks import Ticks
from tumble.scenarios.published import table_4_1
from tumble.scenarios.scene import Scene

WORST = "largest error"
PLAY, PAUSE = "Play", "Pause"
PRINTED_S = table_4_1().physics_times.tolist()
TYPED = 12  # decimals that can be typed
INK = (26, 90, 158)  # the page's colour of links


@dataclass(frozen=True)
class Actions:
    """The user's commands: each is called with the value of its control."""

    throwing: Callable[[str], object]
    magnitude: Callable[[float], object]
    play: Callable[[], object]
    go_to: Callable[[float], object]
    pace: Callable[[float], object]
    magnify: Callable[[str], object]
    vertex: Callable[[int | None], object]
    follow: Callable[[bool], object]
    open: Callable[[str], object]
    edit: Callable[[tuple[str, ...], Any], object]
    defaults: Callable[[bool], object]
    tick: Callable[[Contestant, bool], object]
    save: Callable[[str], object]
    load: Callable[[str, bytes], object]


class Panel:
    """All of one browser's controls.  folder: where files are saved, as it is shown."""

    def __init__(self, client: viser.ClientHandle, actions: Actions, scenes: Sequence[str], folder: str) -> None:
        gui = client.gui
        self._gui, self._actions = gui, actions
        gui.configure_theme(show_logo=False, show_share_button=False, control_width="medium", brand_color=INK)
        gui.set_panel_label("Tumble lab")
        gui.main_panel.dock_right()
        gui.main_panel.set_width(360)
        numbers = gui.add_panel()
        with numbers.add_tab("The body", viser.Icon.RULER_MEASURE):
            self.readings = gui.add_html("")
            self.chart = gui.add_html("")
        numbers.dock_left()
        numbers.set_width(300)
        gui.add_html(f"<style>{style()}</style>")
        self.status_line = gui.add_html("")
        self.grade = gui.add_html("")
        self._add_throwing(gui)
        self._add_time(gui)
        self.errors = gui.add_html("")
        self._add_view(gui)
        engines = gui.add_folder("Engines", expand_by_default=False)
        with engines:
            self.defaults = gui.add_checkbox(
                "Default settings", initial_value=False, hint="Run engines with their own default settings"
            )
            self._connect(self.defaults, lambda value: self._actions.defaults(bool(value)))
        self.ticks = Ticks(gui, engines, actions.tick)
        with gui.add_folder("Scene", expand_by_default=False):
            self._add_scene(gui, scenes)
        with gui.add_folder("Save and load", expand_by_default=False):
            self._add_saving(gui, folder)

    def show_status(self, line: str, *, is_refusal: bool = False) -> None:
        """Show a line above the controls."""
        show(self.status_line, status_line(line, is_refusal=is_refusal))

    # The parts

    def _add_throwing(self, gui: viser.GuiApi) -> None:
        self.magnitude = gui.add_slider("Impulse [N s]", 0.0, 1.0, 0.01, 0.5)
        self._connect(self.magnitude, lambda value: self._actions.magnitude(float(value)))
        throwing = gui.add_button_group("Throw", ("Reset", "Again", OWN_THROW, "Table 4.1"))
        self._connect(throwing, lambda value: self._actions.throwing(value))

    def _add_time(self, gui: viser.GuiApi) -> None:
        self.play = gui.add_button(PLAY, icon=viser.Icon.PLAYER_PLAY)
        self._connect(self.play, lambda _: self._actions.play())
        self.time = gui.add_slider("Time [s]", 0.0, 1.0, 0.5, 0.0)
        self._connect(self.time, lambda value: self._actions.go_to(float(value)))
        self.marked = gui.add_button_group("Table 4.1 at", [f"{at:g}" for at in PRINTED_S], visible=False)
        self._connect(self.marked, lambda value: self._actions.go_to(float(value)))

    def _add_view(self, gui: viser.GuiApi) -> None:
        self.magnified = gui.add_dropdown("Magnify errors", MAGNIFIED)
        self._connect(self.magnified, lambda value: self._actions.magnify(str(value)))
        self.vertex = gui.add_dropdown("Vertex", list_of(WORST))
        self._connect(self.vertex, lambda value: self._actions.vertex(None if value == WORST else int(value)))
        self.speed = gui.add_dropdown("Speed", tuple(speed_name(speed) for speed in SPEEDS))
        self._connect(self.speed, lambda value: self._actions.pace(SPEEDS[list(map(speed_name, SPEEDS)).index(value)]))
        self.follow = gui.add_checkbox("Follow the body", initial_value=False)
        self._connect(self.follow, lambda value: self._actions.follow(bool(value)))

    def _add_scene(self, gui: viser.GuiApi, scenes: Sequence[str]) -> None:
        self.scene = gui.add_dropdown("Scene", tuple(scenes), initial_value=scenes[0])
        self._connect(self.scene, lambda value: self._actions.open(str(value)))
        self.size = gui.add_vector3("Size [m]", (1.0, 1.0, 1.0))
        self.mass = gui.add_number("Mass [kg]", 1.0, step=None)
        self.gravity = gui.add_vector3("Gravity [m/s²]", (0.0, 0.0, 0.0))
        self.step = gui.add_number("Step [s]", 0.01, step=None)
        self.duration = gui.add_number("Duration [s]", 1.0, step=None)
        for control, path in (
            (self.size, ("body", "size")),
            (self.mass, ("body", "mass")),
            (self.gravity, ("gravity",)),
            (self.step, ("step",)),
            (self.duration, ("duration",)),
        ):
            self._connect(control, lambda value, path=path: self._actions.edit(path, value))

    def _add_saving(self, gui: viser.GuiApi, folder: str) -> None:
        saving = gui.add_button_group("Save", ("Scene", "CSV", "Report", "Screenshot"))
        self._connect(saving, lambda value: self._actions.save(value))
        gui.add_html(folder_line(folder))
        load = gui.add_upload_button("Load trajectory (CSV)", icon=viser.Icon.UPLOAD)

        take_uploads_of(load)

        @load.on_upload
        def _(event: Any) -> None:
            self._actions.load(event.target.value.name, event.target.value.content)

    def _connect(self, control: Any, action: Callable[[Any], object]) -> None:
        """Call an action when the user, not the lab itself, changes a control."""

        def changed(event: Any) -> None:
            if event.client is not None and could_be(control, event.target.value):
                action(event.target.value)

        (control.on_click if hasattr(control, "on_click") else control.on_update)(changed)

    # Updates

    def show_scene(self, scene: Scene, name: str, magnitude: float) -> None:
        """Set the choices for a throw to what suits a newly opened scene, with an impulse [N s]."""
        scenes = self.scene.options
        if name not in scenes:
            self.scene.options = (*scenes, name)
        self.scene.value = name
        self.magnified.value = MAGNIFIED[0]
        self.vertex.value = WORST
        self.vertex.options = (WORST, *map(str, range(len(scene.body.points))))
        self.follow.value = moves_far(scene)
        top = 4 * magnitude
        self.magnitude.max, self.magnitude.step = top, top / 200
        self.magnitude.precision = worth_showing(top)
        self.magnitude.value = magnitude

    def show_values(self, scene: Scene) -> None:
        """Set the controls to a scene that was opened or edited."""
        body = scene.body
        self.size.visible = body.size is not None
        shown: Any = (
            (self.size, (1.0, 1.0, 1.0) if body.size is None else tuple(body.size.tolist())),
            (self.gravity, (0.0, 0.0, 0.0) if scene.gravity is None else tuple(scene.gravity.tolist())),
            (self.mass, (body.mass,)),
            (self.step, (scene.step,)),
            (self.duration, (scene.duration,)),
        )
        for control, numbers in shown:
            # With fewer decimals a browser would show, and send back, another number, or refuse a typed one.
            control.precision = max(TYPED, *map(decimals, numbers))
            control.value = numbers if len(numbers) == 3 else numbers[0]
        self.time.max, self.time.step = scene.duration, scene.duration / (len(scene.rows) - 1)
        self.time.precision = worth_showing(scene.duration)

    def show_time(self, time: float, is_running: bool, speed: float) -> None:
        """Show the time."""
        label = PAUSE if is_running else PLAY
        if self.time.value == time and not is_running and self.play.label == PAUSE:
            # A slider set while the time ran may have been overtaken by a later time on its way: send it again.
            self.time.value = 0.0 if time else self.time.max
        if self.time.value != time:
            self.time.value = time
        if self.play.label != label:
            self.play.label = label
            self.play.icon = viser.Icon.PLAYER_PAUSE if is_running else viser.Icon.PLAYER_PLAY
        if self.speed.value != speed_name(speed):
            self.speed.value = speed_name(speed)


def speed_name(speed: float) -> str:
    """Return a speed in words."""
    return "real time" if speed == 1.0 else f"{1 / speed:.0f} times slower"


def decimals(value: float) -> int:
    """Return how many decimals a number is written out with."""
    return max(0, -int(Decimal(repr(value)).normalize().as_tuple().exponent))


def worth_showing(most: float) -> int:
    """Return how many decimals resolve thousandths of the largest number that is shown."""
    return max(4, 3 - math.floor(math.log10(most)))


def moves_far(scene: Scene) -> bool:
    """Whether the body leaves the picture by itself, by its velocity and gravity."""
    fall = 0.0 if scene.gravity is None else float(np.linalg.norm(scene.gravity)) * scene.duration**2 / 2
    run = float(np.linalg.norm(scene.start[0, 7:10])) * scene.duration
    return fall + run > 3.0 * float(np.ptp(scene.body.points, axis=0).max())


def list_of(*options: str) -> tuple[str, ...]:
    """Return options of a dropdown that change later: a type checker takes a literal tuple for its only options."""
    return options


def could_be(control: Any, value: Any) -> bool:
    """Whether a user can have set a control to a value: a program may have sent it."""
    if hasattr(control, "options"):
        return value in control.options
    if isinstance(control, viser.GuiSliderHandle | viser.GuiNumberHandle | viser.GuiVector3Handle):
        numbers = value if isinstance(value, tuple) else (value,)
        return all(isinstance(one, int | float) and math.isfinite(one) for one in numbers)
    return isinstance(value, bool)


def show(element: Any, content: str) -> None:
    """Give an element of HTML that content, unless it has it."""
    if element.content != content:
        element.content = content


def style() -> str:
    """Return the lab's own style sheet."""
    return files(__package__ or "").joinpath("lab.css").read_text(encoding="utf-8")
