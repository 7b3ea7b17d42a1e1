"""Makes the README's picture from docs/example.html, or another from another page.

.venv/bin/python -m tools.page_picture [PAGE PNG]
"""

import shutil
from argparse import ArgumentParser
from pathlib import Path

from playwright.sync_api import sync_playwright

DOCS = Path(__file__).parents[1] / "docs"
PAGE, PICTURE = DOCS / "example.html", DOCS / "picture.png"


def photograph(source: Path, picture: Path) -> None:
    """Photograph the first screen, the die at a moment when it is seen to be off."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        page = browser.new_page(
            viewport={"width": 1280, "height": 640}, reduced_motion="reduce", device_scale_factor=1.5
        )
        page.goto(f"{source.absolute().as_uri()}#t=die-ray~0.8&scene=die-ray")
        page.locator("#hero canvas").wait_for()
        page.screenshot(path=picture)
        browser.close()


if __name__ == "__main__":
    parser = ArgumentParser(prog="tools.page_picture", description="Photograph the first screen of a page.")
    parser.add_argument("page", type=Path, nargs="?", default=PAGE, help="default: docs/example.html")
    parser.add_argument("picture", type=Path, nargs="?", default=PICTURE, help="default: docs/picture.png")
    options = parser.parse_args()
    photograph(options.page, options.picture)
