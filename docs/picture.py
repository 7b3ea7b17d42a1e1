"""Makes the README's picture from docs/example.html, or another from another page: `docs/picture.py [PAGE PNG]`."""

import shutil
import sys
from pathlib import Path

from playwright.sync_api import sync_playwright

HERE = Path(__file__).parent
PAGE, PICTURE = HERE / "example.html", HERE / "picture.png"


def main(source: Path = PAGE, picture: Path = PICTURE) -> None:
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
    main(*map(Path, sys.argv[1:]))
