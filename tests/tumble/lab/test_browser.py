"""The lab in a real browser: the canvas is really clicked, and what is written is held against where the click was."""

import csv
import re
import signal
import subprocess
import sys
import time
import tomllib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple
from urllib.parse import urlsplit

import numpy as np
import pytest
from playwright.sync_api import Page, expect

from reports.numerals import figure, fixed
from scenarios.read import read_scene
from tumble.lab.stage import FIELD_OF_VIEW, eye

WIDTH, HEIGHT = 1280, 720
LISTENING_MS, PATIENCE_MS = 1_000, 180_000  # of a fresh clone, whose kernels are compiled while the first throw waits
WHO = ("-e", "tumble:rk4", "-e", "mujoco:euler", "-e", "pybullet:multibody")
CUBE = "table-4-1-ray"
# Places on three faces of the cube of 5 m at (0, 2.5, 0), those that the eye sees [m].
PLACES = {"front": (1.2, 3.4, 2.5), "side": (2.5, 1.6, 0.9), "top": (-0.8, 5.0, 1.3)}
HUNG = """
METHODS, FEATURES, ABOUT = ("forever",), {"gravity"}, {"version": "1"}


def build(scene, method): return scene
def write(world, states): pass
def read(world): return world.start
def advance(world, n, dt):
    while True: pass
"""


class Lab(NamedTuple):
    """A lab at work: its address, the folder it was started in, and its process."""

    address: str
    folder: Path
    process: subprocess.Popen[str]


@contextmanager
def serving(folder: Path, *words: str) -> Iterator[Lab]:
    """Run `tumble lab` in a folder and end it as a person does."""
    command = [sys.executable, "-P", "-m", "tumble", "lab", "--no-open", *words]
    with subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as process:
        try:
            assert process.stdout is not None
            yield Lab(process.stdout.readline().strip(), folder, process)
        finally:
            process.send_signal(signal.SIGINT)
            try:
                process.wait(20)
            finally:
                process.kill()


@pytest.fixture(scope="module")
def lab(tmp_path_factory) -> Iterator[Lab]:
    with serving(tmp_path_factory.mktemp("lab"), CUBE, *WHO) as lab:
        yield lab


@pytest.fixture(scope="module")
def opened(browser) -> Iterator[Callable[[Lab], Page]]:
    """Open a lab in a browser of its own, with nothing over its canvas; `asked` are the addresses it asked for."""
    contexts = []

    def open_lab(lab: Lab, asked: list[str] | None = None) -> Page:
        contexts.append(browser.new_context(viewport={"width": WIDTH, "height": HEIGHT}))
        page = contexts[-1].new_page()
        page.set_default_timeout(PATIENCE_MS)
        if asked is not None:
            page.on("request", lambda request: asked.append(request.url))
            page.on("websocket", lambda socket: asked.append(socket.url))
        page.goto(lab.address)
        expect(page.locator("[data-lab=said]")).to_contain_text("Click the body", timeout=PATIENCE_MS)
        for close in page.locator(".mantine-Notification-closeButton").all():
            close.click()
        return page

    yield open_lab
    for context in contexts:
        context.close()


@pytest.fixture(scope="module")
def asked() -> list[str]:
    """What the page that most tests use has asked the network for."""
    return []


@pytest.fixture(scope="module")
def first_page(lab, opened, asked) -> Page:
    return opened(lab, asked)


@pytest.fixture
def page(first_page) -> Page:
    """A page on which nothing is thrown yet."""
    reset(first_page)
    return first_page


def reset(page: Page) -> None:
    """Press Reset and wait until the die stands at its start."""
    page.get_by_role("button", name="Reset").click()
    expect(page.locator("[data-lab=said]")).to_contain_text("Click the body", timeout=PATIENCE_MS)


class Camera:
    """The pinhole that the lab looks through when it begins, made from its place, its target and its angle alone."""

    def __init__(self, page: Page, scene: str) -> None:
        box = page.locator("canvas").first.bounding_box()
        assert box is not None
        self.left, self.top, self.width, self.height = box["x"], box["y"], box["width"], box["height"]
        self.place, target = eye(read_scene(scene))
        self.forward = (target - self.place) / np.linalg.norm(target - self.place)
        self.right = np.cross(self.forward, (0.0, 1.0, 0.0))
        self.right /= np.linalg.norm(self.right)
        self.up = np.cross(self.right, self.forward)
        self.pixels = self.height / 2 / np.tan(FIELD_OF_VIEW / 2)

    def pixel(self, point) -> np.ndarray:
        """Return where a place [m] is on the page."""
        away = np.asarray(point) - self.place
        across, over = away @ self.right, away @ self.up
        scale = self.pixels / (away @ self.forward)
        middle = np.array([self.left + self.width / 2, self.top + self.height / 2])
        return middle + scale * np.array([across, -over])


def click(page: Page, place, scene: str = CUBE) -> np.ndarray:
    """Click the pixel nearest to a place [m], and return that pixel.

    On a machine that is short of time a browser shows the body before it listens to clicks, so it is given a moment.
    """
    page.wait_for_timeout(LISTENING_MS)
    pixel = np.round(Camera(page, scene).pixel(place))
    page.mouse.click(*pixel.tolist())
    return pixel


def wait_for(what: Callable[[], object]) -> None:
    """Wait until something holds."""
    end = time.monotonic() + PATIENCE_MS / 1000
    while not what():
        assert time.monotonic() < end, "it never came"
        time.sleep(0.05)


def saved(lab: Lab, page: Page, what: str) -> Path:
    """Press a button under Keep and return the new file or folder once the page says that it is there."""
    button = page.get_by_role("button", name=what, exact=True)
    if not button.is_visible():
        page.get_by_text("Keep", exact=True).click()
    button.click()
    said = page.locator("[data-lab=said]")
    expect(said).to_contain_text("Written: ", timeout=PATIENCE_MS)
    return lab.folder / said.inner_text().removeprefix("Written: ").strip().removesuffix("/")


def over(page: Page) -> None:
    """Wait until the flight is over and everybody has answered."""
    expect(page.get_by_role("button", name="Play")).to_be_visible(timeout=PATIENCE_MS)
    expect(page.locator("[data-lab=errors]")).not_to_contain_text("flying", timeout=PATIENCE_MS)
    expect(page.locator("[data-lab=time]")).to_have_text("0.5", timeout=PATIENCE_MS)
    wait_for(lambda: "\N{EN DASH}" not in page.locator("[data-lab=off]").all_inner_texts())


def thrown(page: Page) -> None:
    """Wait until something flies."""
    expect(page.locator("[data-lab=errors]")).to_be_visible(timeout=PATIENCE_MS)


@pytest.mark.parametrize("face", PLACES)
def test_the_ray_of_the_saved_scene_hits_where_the_click_was_to_a_pixel(lab, page, face):
    pixel = click(page, PLACES[face])
    try:
        expect(page.locator("[data-lab=errors]")).to_be_visible(timeout=PATIENCE_MS / 4)
    except AssertionError:  # the first click of a process that was not listening yet
        pixel = click(page, PLACES[face])
    thrown(page)
    (impulse,) = tomllib.loads(saved(lab, page, "Scene").read_text(encoding="utf-8"))["impulse"]
    origin, direction = (np.array(impulse["ray"][key]) for key in ("origin", "direction"))
    axis = {"front": 2, "side": 0, "top": 1}[face]
    hit = origin + direction * (PLACES[face][axis] - origin[axis]) / direction[axis]
    assert np.abs(Camera(page, CUBE).pixel(hit) - pixel).max() < 1.0
    assert hit == pytest.approx(PLACES[face], abs=0.05)


def test_what_was_clicked_is_what_run_flies_and_what_the_table_says(lab, page):
    click(page, PLACES["front"])
    over(page)
    folder = saved(lab, page, "CSV")
    done = subprocess.run(
        [sys.executable, "-P", "-m", "tumble", "run", f"{folder.name}.toml", "-e", "mujoco:euler"],
        cwd=lab.folder, capture_output=True, text=True, timeout=120,
    )  # fmt: skip
    assert (folder / "trajectory-mujoco-euler.csv").read_text(encoding="utf-8") == done.stdout
    hold_table_against_csv(page, folder)


def hold_table_against_csv(page: Page, folder: Path) -> None:
    """Hold what the page says at the time shown against what was written."""
    at = float(page.locator("[data-lab=time]").inner_text())
    with (folder / "vertex-errors.csv").open(encoding="utf-8", newline="") as file:
        rows = [row for row in csv.DictReader(file) if float(row["t_s"]) == pytest.approx(at, rel=1e-8)]
    contestants = page.locator("[data-contestant]")
    assert contestants.count() == 3
    for shown in contestants.all():
        name = shown.get_attribute("data-contestant")
        own = [row for row in rows if f"{row['engine']}:{row['method']}" == name]
        worst = max(own, key=lambda row: float(row["error_m"]))
        off = shown.locator("[data-lab=off]").inner_text()
        if not off.startswith("\N{LESS-THAN OR EQUAL TO}"):
            assert off == figure(float(worst["error_m"]))
        place = ", ".join(fixed(float(worst[f"{axis}_m"]), 2) for axis in "xyz")
        assert off.startswith("\N{LESS-THAN OR EQUAL TO}") or place in page.locator("[data-lab=errors]").inner_text()


def test_a_click_beside_the_die_throws_nothing(lab, page):
    click(page, (3.4, 2.5, 2.5))
    click(page, PLACES["front"])  # this one is answered, so that the one before it has been, too
    thrown(page)
    assert len(read_scene(str(saved(lab, page, "Scene"))).impulses) == 1


def test_the_first_click_throws_and_the_second_does_not(lab, page):
    click(page, PLACES["front"])
    thrown(page)
    page.get_by_role("button", name="Pause").click()
    page.get_by_role("slider").nth(1).press("Home")
    expect(page.locator("[data-lab=time]")).to_have_text("0", timeout=PATIENCE_MS)
    click(page, PLACES["side"])
    expect(page.locator("[data-lab=said]")).to_contain_text("thrown already", timeout=PATIENCE_MS)
    assert len(read_scene(str(saved(lab, page, "Scene"))).impulses) == 1


def test_two_browsers_do_not_disturb_each_other(lab, page, opened):
    other = opened(lab)
    click(page, PLACES["side"])
    thrown(page)
    expect(other.locator("[data-lab=said]")).to_contain_text("Click the body")
    assert other.locator("[data-lab=errors]").count() == 0
    click(other, PLACES["front"])
    thrown(other)
    rays = {tuple(read_scene(str(saved(lab, one, "Scene"))).impulses[0].ray.direction) for one in (page, other)}
    assert len(rays) == 2


def test_no_request_leaves_the_machine(page, asked):
    click(page, PLACES["side"])
    thrown(page)
    hosts = {urlsplit(url).hostname for url in asked if urlsplit(url).scheme in ("http", "https", "ws", "wss")}
    assert hosts == {"127.0.0.1"}
    assert any(url.startswith("ws:") for url in asked)


def test_a_hung_engine_leaves_the_page_alive(tmp_path, opened):
    (tmp_path / "hung.py").write_text(HUNG, encoding="utf-8")
    words = CUBE, "-e", "./hung.py", "-e", "mujoco:euler", "--time-limit", "8"
    with serving(tmp_path, *words) as lab:
        page = opened(lab)
        click(page, PLACES["front"])
        flown = page.locator("[data-contestant='mujoco:euler'] [data-lab=off]")
        expect(flown).to_have_text(re.compile(r"\d"), timeout=PATIENCE_MS)
        errors = page.locator("[data-lab=errors]")
        expect(errors).to_contain_text("flying")
        expect(errors).to_contain_text("timeout", timeout=PATIENCE_MS)
        reset(page)


def test_ctrl_c_ends_it_and_leaves_no_process(tmp_path):
    with serving(tmp_path, CUBE, "-e", "mujoco:euler") as first, serving(
        tmp_path, CUBE, "-e", "mujoco:euler", "--port", str(urlsplit(first.address).port)
    ) as second:  # fmt: skip
        assert second.address != first.address
        assert urlsplit(second.address).hostname == "127.0.0.1"
        begun = descendants(second.process.pid)
        assert begun
        second.process.send_signal(signal.SIGINT)
        assert second.process.wait(20) == 0
        wait_for(lambda: not [pid for pid in begun if Path(f"/proc/{pid}").exists()])
        assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("--port", "70000"), "0 to 65535"),
        (("-e", "mujoco:nosuch"), "unknown method"),
        (("nosuch",), "unknown scene"),
    ],
)
def test_mistakes_are_refused_in_one_line(tumble, words, says):
    done = tumble("lab", "--no-open", *words)
    assert done.returncode == 2
    assert says in done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert done.stdout == ""


def descendants(parent: int) -> list[int]:
    """Return the processes that one has started, and those that they have."""
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                status = (entry / "stat").read_text()
            except OSError:
                continue
            if int(status.rpartition(")")[2].split()[1]) == parent:
                found += [int(entry.name), *descendants(int(entry.name))]
    return found
