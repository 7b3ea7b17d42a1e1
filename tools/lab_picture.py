"""Makes the README's picture of the lab, docs/lab.png, in a real browser.

.venv/bin/python -m tools.lab_picture [PNG]
"""

import re
import shutil
import sys
import tempfile
from argparse import ArgumentParser
from pathlib import Path

from playwright.sync_api import Page, ViewportSize, expect, sync_playwright

from tools.palette import reduced

ROOT = Path(__file__).parents[1]
sys.path[:0] = [str(ROOT / "tests/support")]
from lab_pages import PATIENCE_MS, serving  # noqa: E402

PICTURE = ROOT / "docs/lab.png"
SCENE, SHOWN_S = "die-ray", "0.72"
SIZE: ViewportSize = {"width": 1280, "height": 720}
SETTLED_MS = 6_000


def throw(page: Page) -> None:
    """Throw the body, wait for all contestants, and show their errors at one time."""
    said, errors = page.locator("[data-lab=message]"), page.locator("[data-lab=errors]")
    expect(said).to_contain_text("Click the body", timeout=PATIENCE_MS)
    page.wait_for_timeout(SETTLED_MS)
    for close in page.locator(".mantine-Notification-closeButton").all():  # viser's note that there is no GPU
        close.click()
    box = page.locator("canvas").first.bounding_box()
    assert box is not None
    page.mouse.click(box["x"] + 0.62 * box["width"], box["y"] + 0.45 * box["height"])  # on the die, beside its centre
    page.get_by_role("button", name="Pause").click()
    expect(page.get_by_role("button", name="Play")).to_be_visible(timeout=PATIENCE_MS)
    expect(errors).not_to_contain_text("running", timeout=PATIENCE_MS)
    page.locator("input[inputmode=decimal], input[inputmode=numeric]").nth(1).fill(SHOWN_S)
    expect(page.locator("[data-lab=time]")).to_have_text(re.compile(rf"^{re.escape(SHOWN_S)}"), timeout=PATIENCE_MS)
    page.mouse.move(SIZE["width"] / 2, SIZE["height"] - 1)
    page.wait_for_timeout(SETTLED_MS)


def photograph(picture: Path) -> None:
    """Photograph the die in flight."""
    with tempfile.TemporaryDirectory() as folder, serving(Path(folder), SCENE) as lab, sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=["--no-sandbox", "--enable-unsafe-swiftshader"]
        )
        page = browser.new_page(viewport=SIZE)
        page.set_default_timeout(PATIENCE_MS)
        page.goto(lab.address)
        throw(page)
        picture.write_bytes(reduced(page.screenshot()))
        browser.close()


if __name__ == "__main__":
    parser = ArgumentParser(prog="tools.lab_picture", description="Photograph the lab with a die in flight.")
    parser.add_argument("picture", type=Path, nargs="?", default=PICTURE, help="default: docs/lab.png")
    photograph(parser.parse_args().picture)
