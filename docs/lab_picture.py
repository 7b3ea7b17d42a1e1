"""Makes the README's picture of the lab, docs/lab.png, in a real browser: `docs/lab_picture.py [PNG]`."""

import re
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from playwright.sync_api import Page, expect, sync_playwright

PICTURE = Path(__file__).parent / "lab.png"
SCENE, MAGNIFIED, SHOWN_S = "two-hits", "100", "0.24"
SIZE = {"width": 1280, "height": 720}
PLACE = SIZE["width"] / 2 - 44, SIZE["height"] / 2  # between the panels: there is the body
PATIENCE_MS, SETTLED_MS = 180_000, 6_000


@contextmanager
def lab() -> Iterator[str]:
    """Give the address of a lab at work."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-P", "-m", "tumble", "lab", SCENE, "--no-open"]
        with subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, text=True) as process:
            try:
                assert process.stdout is not None
                yield process.stdout.readline().strip()
            finally:
                process.send_signal(signal.SIGINT)


def throw(page: Page) -> None:
    """Strike the body, wait until all have answered, and show them apart at a moment of the flight."""
    said, errors = page.locator("[data-lab=said]"), page.locator("[data-lab=errors]")
    expect(said).to_contain_text("Click the body", timeout=PATIENCE_MS)
    page.wait_for_timeout(SETTLED_MS)
    for close in page.locator(".mantine-Notification-closeButton").all():  # "no GPU here": true, and no part of the lab
        close.click()
    page.mouse.click(*PLACE)
    expect(page.get_by_role("button", name="Play")).to_be_visible(timeout=PATIENCE_MS)
    expect(errors).not_to_contain_text("flying", timeout=PATIENCE_MS)
    page.get_by_label("Errors drawn times").click()
    page.get_by_role("option", name=MAGNIFIED, exact=True).click()
    time = page.locator("input[inputmode=decimal], input[inputmode=numeric]").nth(1)
    time.fill(SHOWN_S)
    time.press("Enter")
    expect(page.locator("[data-lab=time]")).to_have_text(re.compile(r"^0\.2"), timeout=PATIENCE_MS)
    page.mouse.move(SIZE["width"] / 2, SIZE["height"] - 1)
    page.wait_for_timeout(SETTLED_MS)


def main(picture: Path = PICTURE) -> None:
    """Photograph a body just struck."""
    with lab() as address, sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=["--no-sandbox", "--enable-unsafe-swiftshader"]
        )
        page = browser.new_page(viewport=SIZE)
        page.set_default_timeout(PATIENCE_MS)
        page.goto(address)
        throw(page)
        page.screenshot(path=picture)
        browser.close()


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
