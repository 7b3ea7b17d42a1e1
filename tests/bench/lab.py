"""The lab in a real browser that draws in software: first picture, click to motion, frames a second.

    python tests/bench/lab.py [-o FILE.csv]

What a person waits for, by the browser's own clock: from asking for the address until the body is drawn; from the click
until the time on the screen is later than that of the throw, with four contestants that have run before; and the
pictures a second that the browser draws while a throw is watched.  All of it is wall time: a busy machine is slower.
Figures are the mean, the least and the greatest of PASSES.
"""

import shutil
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from figures import FigureRow, figure, output_option, show
from playwright.sync_api import Browser, Page, sync_playwright

from tumble.commands.lab import USUAL

sys.path[:0] = [str(Path(__file__).parents[1] / "support")]
from lab_pages import PATIENCE_MS, serving  # noqa: E402

PASSES, WATCHED_MS, SETTLED_MS = 2, 3800, 1500
SIZE = {"width": 1280, "height": 720}
SCENE = "two-hits"
# The first picture with the body in it: the first after the lab's own words are there.
DRAWN = """() => new Promise(drawn => {
  const look = () => document.querySelector('[data-lab=message]')?.innerText.includes('Click the body')
    ? requestAnimationFrame(() => requestAnimationFrame(() => drawn(performance.now()))) : requestAnimationFrame(look);
  look();
})"""
# From the button's going up until the screen says another time, then the pictures drawn in so many milliseconds.
WATCH = """(watched) => { window.seen = new Promise(tell => addEventListener('pointerup', () => {
  const clicked = performance.now();
  const count = (end, pictures) => requestAnimationFrame(now => now < end ? count(end, pictures + 1)
    : tell([(moved - clicked) / 1000, 1000 * pictures / watched]));
  let moved = 0;
  const look = () => {
    const time = document.querySelector('[data-lab=time]');
    if (time && Number(time.innerText) > 0) { moved = performance.now(); count(moved + watched, 0); }
    else requestAnimationFrame(look);
  };
  look();
}, {once: true, capture: true})) }"""


def measured(browser: Browser, address: str) -> Iterator[float]:
    """Yield the time until the first picture [s], that from the click to motion [s], and pictures a second."""
    page = browser.new_page(viewport=SIZE)
    page.set_default_timeout(PATIENCE_MS)
    page.goto(address)
    yield page.evaluate(DRAWN) / 1000  # by the page's clock, which begins when it is asked for
    page.wait_for_timeout(SETTLED_MS)
    throw(page)  # an engine that has never run a scene of the kind does
    page.get_by_role("button", name="Reset").click()
    page.wait_for_timeout(SETTLED_MS)
    page.evaluate(WATCH, WATCHED_MS)
    page.mouse.click(*middle(page))
    yield from page.evaluate("window.seen")
    page.close()


def middle(page: Page) -> tuple[float, float]:
    """Return the middle of the canvas, between the panels: there is the body."""
    box = page.locator("canvas").first.bounding_box()
    assert box is not None
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def throw(page: Page) -> None:
    """Click the body and wait until all have answered."""
    page.mouse.click(*middle(page))
    errors = page.locator("[data-lab=errors]")
    errors.wait_for()
    page.wait_for_function("!document.querySelector('[data-lab=errors]').innerText.includes('running')")
    page.get_by_role("button", name="Play").wait_for()


def figures() -> Iterator[FigureRow]:
    """Yield what was asked beside what is reached."""
    with tempfile.TemporaryDirectory() as folder, serving(Path(folder), SCENE) as lab, sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=["--no-sandbox", "--enable-unsafe-swiftshader"]
        )
        first, motion, pictures = zip(*(measured(browser, lab.address) for _ in range(PASSES)), strict=True)
        browser.close()
    yield figure("first picture, at most", "", "s", 5.0, first)
    yield figure("click to motion, at most", f"{len(USUAL)} contestants", "s", 0.5, motion)
    yield figure("pictures while it is watched", f"{len(USUAL)} contestants", "1/s", 20.0, pictures)


if __name__ == "__main__":
    show(list(figures()), output_option(__doc__.partition("\n")[0]))
