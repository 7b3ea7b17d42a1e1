"""Makes the README's picture of the lab, docs/lab.png, in a real browser: `docs/lab_picture.py [PNG]`."""

import re
import shutil
import sys
import tempfile
from pathlib import Path

from playwright.sync_api import Page, expect, sync_playwright

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE.parent / "tests" / "support")]
from lab_pages import PATIENCE_MS, serving  # noqa: E402

PICTURE = HERE / "lab.png"
SCENE, MAGNIFIED, SHOWN_S = "two-hits", "100", "0.24"
SIZE = {"width": 1280, "height": 720}
PLACE = SIZE["width"] / 2 - 44, SIZE["height"] / 2  # between the panels: there is the body
SETTLED_MS = 6_000


def throw(page: Page) -> None:
    """Strike the body, wait until all have answered, and show them apart at a moment of the flight."""
    said, errors = page.locator("[data-lab=said]"), page.locator("[data-lab=errors]")
    expect(said).to_contain_text("Click the body", timeout=PATIENCE_MS)
    page.wait_for_timeout(SETTLED_MS)
    for close in page.locator(".mantine-Notification-closeButton").all():  # "no GPU here": true, and no part of the lab
        close.click()
    page.mouse.click(*PLACE)
    page.get_by_role("button", name="Pause").click()
    expect(page.get_by_role("button", name="Play")).to_be_visible(timeout=PATIENCE_MS)
    expect(errors).not_to_contain_text("flying", timeout=PATIENCE_MS)
    page.get_by_label("Errors drawn times").click()
    page.get_by_role("option", name=MAGNIFIED, exact=True).click()
    page.locator("input[inputmode=decimal], input[inputmode=numeric]").nth(1).fill(SHOWN_S)
    expect(page.locator("[data-lab=time]")).to_have_text(re.compile(r"^0\.2"), timeout=PATIENCE_MS)
    page.mouse.move(SIZE["width"] / 2, SIZE["height"] - 1)
    page.wait_for_timeout(SETTLED_MS)


def main(picture: Path = PICTURE) -> None:
    """Photograph a body just struck."""
    with tempfile.TemporaryDirectory() as folder, serving(Path(folder), SCENE) as lab, sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=["--no-sandbox", "--enable-unsafe-swiftshader"]
        )
        page = browser.new_page(viewport=SIZE)
        page.set_default_timeout(PATIENCE_MS)
        page.goto(lab.address)
        throw(page)
        page.screenshot(path=picture)
        browser.close()


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
