"""The documentation site: built without a warning, every link inside it leads somewhere, and it needs no network."""

import argparse
import re
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest
from axe_playwright_python.sync_playwright import Axe

import tumble
from tumble.compare.run.engines import registry
from tumble.compare.tables.known import tables
from tumble.parser import parser

ROOT = Path(__file__).parents[2]
SHOWN = (
    "index.html",
    "guides/student.html",
    "generated/engines/pybullet.html",
    "generated/tables.html",
    "notebooks/engine-and-step.html",
)


class Page(HTMLParser):
    """What a page links to, what it loads, and the names of its places."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.links: set[str] = set()
        self.loaded: set[str] = set()
        self.places: set[str] = set()
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        stated = dict(attrs)
        self.places |= {stated["id"]} if stated.get("id") else set()
        if tag == "a" and stated.get("href"):
            self.links.add(stated["href"])
        elif tag == "link" and stated.get("rel") not in ("canonical",):
            self.loaded.add(stated.get("href") or "")
        elif stated.get("src"):
            self.loaded.add(stated["src"])


@pytest.fixture(scope="module")
def pages(site) -> dict[Path, Page]:
    own = (path for path in site.rglob("*.html") if "_static" not in path.parts)  # the theme's templates lie there
    return {path: Page(path.read_text(encoding="utf-8")) for path in own}


def test_every_link_inside_the_site_leads_somewhere(pages, site):
    broken = []
    for path, page in pages.items():
        for link in page.links | page.loaded:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            places = pages[target].places if target in pages else {unquote(parts.fragment)}
            if not target.is_file() or (parts.fragment and unquote(parts.fragment) not in places):
                broken.append((path.name, link))
    assert broken == []
    assert len(pages) > 35


def test_a_link_that_leads_nowhere_would_be_found():
    page = Page('<p id="here"><a href="#there">x</a><script src="https://far/away.js"></script>')
    assert (page.links, page.loaded, page.places) == ({"#there"}, {"https://far/away.js"}, {"here"})


def test_nothing_is_loaded_from_the_network(pages, site):
    outside = {(path.name, each) for path, page in pages.items() for each in page.loaded if urlsplit(each).netloc}
    assert outside == set()
    for sheet in site.rglob("*.css"):
        assert not re.search(r"(?:url\(|@import)\s*['\"]?(?:https?:)?//", sheet.read_text(encoding="utf-8")), sheet.name


def test_every_command_table_engine_and_public_name_has_its_place(pages, site):
    of = {name: pages[site / "generated" / f"{name}.html"].places for name in ("commands", "tables", "api")}
    (commands,) = (each for each in parser()._actions if isinstance(each, argparse._SubParsersAction))
    assert {f"tumble-{name}" for name in commands.choices} <= of["commands"]
    assert {f"table-{name.removesuffix('.csv')}" for name in tables()} <= of["tables"]
    assert {f"tumble.{name}" for name in getattr(tumble, "__all__", ())} <= of["api"]
    engines = {path.stem for path in (site / "generated/engines").glob("*.html")} - {"index"}
    assert engines == set(registry.names())


@pytest.mark.parametrize("width", [400, 1280])
@pytest.mark.parametrize("name", SHOWN)
def test_a_page_fits_its_screen_and_axe_finds_nothing(site, browser, name, width):
    context = browser.new_context(viewport={"width": width, "height": 900}, offline=True, reduced_motion="reduce")
    context.set_default_timeout(120_000)
    tab = context.new_page()
    asked: list[str] = []
    tab.on("request", lambda request: asked.append(request.url))
    tab.goto((site / name).as_uri())
    folder = ROOT / "report" / "screenshots"
    folder.mkdir(parents=True, exist_ok=True)
    tab.screenshot(path=folder / f"site-{width}-{name.replace('/', '-')}.png")
    assert tab.evaluate("document.documentElement.scrollWidth") <= width
    assert all(url.startswith(("file:", "data:")) for url in asked)
    found = Axe().run(tab).response["violations"]
    assert [(one["id"], one["nodes"][0]["html"]) for one in found] == []
    context.close()
