"""Makes the README's picture of the page, docs/picture.png, from report/tumble.html, in a real browser.

.venv/bin/python -m tools.page_picture [PAGE [PNG]]
"""

import shutil
from argparse import ArgumentParser
from pathlib import Path

from playwright.sync_api import sync_playwright

from tools.palette import reduced

ROOT = Path(__file__).parents[1]
PAGE, PICTURE = ROOT / "report/tumble.html", ROOT / "docs/picture.png"


def photograph(source: Path, picture: Path) -> None:
    """Photograph the first screen, at a time when the error of the die is visible."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        page = browser.new_page(
            viewport={"width": 1280, "height": 640}, reduced_motion="reduce", device_scale_factor=1.5
        )
        page.goto(f"{source.absolute().as_uri()}#t=die-ray~0.8&scene=die-ray")
        page.locator("#hero canvas").wait_for()
        picture.parent.mkdir(parents=True, exist_ok=True)
        picture.write_bytes(reduced(page.screenshot()))
        browser.close()


if __name__ == "__main__":
    parser = ArgumentParser(prog="tools.page_picture", description="Photograph the first screen of a page.")
    parser.add_argument("page", type=Path, nargs="?", default=PAGE, help="default: report/tumble.html")
    parser.add_argument("picture", type=Path, nargs="?", default=PICTURE, help="default: docs/picture.png")
    options = parser.parse_args()
    photograph(options.page, options.picture)
