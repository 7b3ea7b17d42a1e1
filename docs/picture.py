"""Makes docs/picture.png, the README's picture, from the page: `make report && .venv/bin/python docs/picture.py`."""

import shutil
from pathlib import Path

from playwright.sync_api import sync_playwright

HERE = Path(__file__).parent
PAGE = HERE.parent / "report/tumble.html"
# From what each mistake costs to the cube at the five times.
FROM, TO = "h3:has-text('What each mistake costs')", "h3:has-text('Figure 4.2') ~ div"


def main() -> None:
    """Photograph that part of the page."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": 1000, "height": 4000})
        page.goto(PAGE.as_uri())
        top, bottom = page.locator(FROM).bounding_box(), page.locator(TO).first.bounding_box()
        assert top is not None
        assert bottom is not None
        height = bottom["y"] + bottom["height"] - top["y"] + 20
        page.screenshot(path=HERE / "picture.png", clip={"x": 0, "y": top["y"] - 10, "width": 1000, "height": height})
        browser.close()


if __name__ == "__main__":
    main()
