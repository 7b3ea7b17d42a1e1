"""Makes docs/picture.png, the README's picture, from the page: `.venv/bin/python docs/picture.py`."""

import shutil
from pathlib import Path

from playwright.sync_api import sync_playwright

HERE = Path(__file__).parent
PAGE = HERE / "example.html"


def main() -> None:
    """Photograph the first screen, the die at a moment when it is seen to be off."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        page = browser.new_page(
            viewport={"width": 1280, "height": 640}, reduced_motion="reduce", device_scale_factor=1.5
        )
        page.goto(f"{PAGE.as_uri()}#t=die-ray~0.42&scene=die-ray")
        page.locator("#hero canvas").wait_for()
        page.screenshot(path=HERE / "picture.png")
        browser.close()


if __name__ == "__main__":
    main()
