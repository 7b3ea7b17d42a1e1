"""A lab at work and a browser before it: how tests click its canvas and where they then look."""

import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import NamedTuple

import numpy as np
from playwright.sync_api import Browser, Locator, Page, expect

from tumble.lab.eye import FIELD_OF_VIEW, axes, first_view
from tumble.scenarios.read import read_scene

WIDTH, HEIGHT = 1280, 720
LISTENING_MS, PATIENCE_MS = 1_000, 180_000  # of a fresh clone, whose kernels are compiled while the first throw waits
CUBE = "table-4-1-ray"
# Places on three faces of the cube of 5 m at (0, 2.5, 0), those that the eye sees [m].
PLACES = {"front": (1.2, 3.4, 2.5), "side": (2.5, 1.6, 0.9), "top": (-0.8, 5.0, 1.3)}

# Drawn in software, a page takes all cores for its pictures: some ten a second leave them to what is tested.
FEW_PICTURES = """
    const draw = window.requestAnimationFrame.bind(window);
    window.requestAnimationFrame = (then) => setTimeout(() => draw(then), 80);
    window.cancelAnimationFrame = clearTimeout;
"""

SAVED = "Saved and downloaded: "
ENDINGS = {"Scene": ".toml", "CSV": "/", "Report": ".html", "Screenshot": ".png"}


class Lab(NamedTuple):
    """A lab at work: its address, the folder it was started in, and its process."""

    address: str
    folder: Path
    process: subprocess.Popen[str]


@contextmanager
def serving(folder: Path, *words: str, errors: int = subprocess.DEVNULL) -> Iterator[Lab]:
    """Run `tumble lab` in a folder and end it as a person does; errors: where its standard error goes."""
    command = [sys.executable, "-P", "-m", "tumble", "lab", "--no-open", *words]
    with subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, stderr=errors, text=True) as process:
        try:
            assert process.stdout is not None
            yield Lab(process.stdout.readline().strip(), folder, process)
        finally:
            process.send_signal(signal.SIGINT)
            try:
                process.wait(20)
            finally:
                process.kill()


@contextmanager
def opening(browser: Browser) -> Iterator[Callable[..., Page]]:
    """Open labs in browsers of their own, with nothing over the canvas; `asked` are the addresses a page asked for."""
    contexts = []

    def open_lab(lab: Lab, asked: list[str] | None = None, width: int = WIDTH, height: int = HEIGHT) -> Page:
        contexts.append(browser.new_context(viewport={"width": width, "height": height}))
        contexts[-1].add_init_script(FEW_PICTURES)
        page = contexts[-1].new_page()
        page.set_default_timeout(PATIENCE_MS)
        if asked is not None:
            page.on("request", lambda request: asked.append(request.url))
            page.on("websocket", lambda socket: asked.append(socket.url))
        page.goto(lab.address)
        expect(page.locator("[data-lab=message]")).to_contain_text("Click the body", timeout=PATIENCE_MS)
        for close in page.locator(".mantine-Notification-closeButton").all():
            close.click()
        return page

    yield open_lab
    for context in contexts:
        context.close()


def reset(page: Page) -> None:
    """Press Reset and wait until the die stands at its start."""
    page.get_by_role("button", name="Reset").click()
    expect(page.locator("[data-lab=message]")).to_contain_text("Click the body", timeout=PATIENCE_MS)


class Camera:
    """The pinhole that the lab looks through when it begins, made from its place, its target and its angle alone."""

    def __init__(self, page: Page, scene: str, is_narrow: bool = False) -> None:
        box = page.locator("canvas").first.bounding_box()
        assert box is not None
        self.left, self.top, self.width, self.height = box["x"], box["y"], box["width"], box["height"]
        found = read_scene(scene)
        self.place, target = first_view(found, is_narrow=is_narrow)
        self.forward = (target - self.place) / np.linalg.norm(target - self.place)
        self.right = np.cross(self.forward, axes(found).up)
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


def click(page: Page, place, scene: str = CUBE, is_narrow: bool = False) -> np.ndarray:
    """Click the pixel nearest to a place [m], and return that pixel.

    On a machine that is short of time a browser shows the body before it listens to clicks, so it is given a moment.
    """
    page.wait_for_timeout(LISTENING_MS)
    pixel = np.round(Camera(page, scene, is_narrow).pixel(place))
    page.mouse.click(*pixel.tolist())
    return pixel


def wait_for(what: Callable[[], object]) -> None:
    """Wait until something holds."""
    end = time.monotonic() + PATIENCE_MS / 1000
    while not what():
        assert time.monotonic() < end, "it never came"
        time.sleep(0.05)


def press(control: Locator, expected: Callable[[float], None]) -> None:
    """Click until what is expected is seen: a row that appears may move a control from under the pointer."""
    for _ in range(3):
        control.click()
        with suppress(AssertionError):
            return expected(PATIENCE_MS / 6)
    control.click()
    return expected(PATIENCE_MS / 2)


def saved(lab: Lab, page: Page, what: str) -> Path:
    """Press a button under Save and return the new file or folder once the page says that it is there."""
    button = page.get_by_role("button", name=what, exact=True)
    if not button.is_visible():
        page.get_by_text("Save and load", exact=True).click()
    said = page.locator("[data-lab=message]")
    ending = re.compile(rf"{SAVED}.*{re.escape(ENDINGS[what])}\s*")
    press(button, lambda patience_ms: expect(said).to_have_text(ending, timeout=patience_ms))
    return lab.folder / said.inner_text().removeprefix(SAVED).strip().removesuffix("/")


def over(page: Page) -> None:
    """Wait until the throw is over and every contestant has answered."""
    expect(page.get_by_role("button", name="Play")).to_be_visible(timeout=PATIENCE_MS)
    expect(page.locator("[data-lab=errors]")).not_to_contain_text("running", timeout=PATIENCE_MS)
    expect(page.locator("[data-lab=time]")).to_have_text("0.5", timeout=PATIENCE_MS)
    wait_for(lambda: "\N{EN DASH}" not in page.locator("[data-lab=off]").all_inner_texts())


def thrown(page: Page) -> None:
    """Wait until something is thrown."""
    expect(page.locator("[data-lab=errors]")).to_be_visible(timeout=PATIENCE_MS)
