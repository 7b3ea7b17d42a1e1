"""The lab in a real browser: the canvas is really clicked, and what is written is held against where the click was."""

import csv
import re
import signal
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import urlsplit

import numpy as np
import pytest
from lab_pages import CUBE, PATIENCE_MS, PLACES, Camera, Lab, click, over, reset, saved, serving, thrown, wait_for
from playwright.sync_api import Page, expect

from tumble.lab.markup import metres
from tumble.reports.numerals import fixed
from tumble.scenarios.impulse import strike_point
from tumble.scenarios.read import read_scene
from tumble.scenarios.scene import Impulse, Ray
from tumble.scenarios.truth import truth

BALL = "ball-drop-half"
WHO = ("-e", "tumble:rk4", "-e", "mujoco:euler", "-e", "pybullet:multibody")
HUNG = """
METHODS, FEATURES, ABOUT = ("forever",), {"gravity"}, {"version": "1"}


def build(scene, method): return scene
def write(world, states): pass
def read(world): return world.start
def advance(world, n, dt):
    while True: pass
"""


@pytest.fixture(scope="module")
def lab(tmp_path_factory) -> Iterator[Lab]:
    with serving(tmp_path_factory.mktemp("lab"), CUBE, *WHO) as lab:
        yield lab


@pytest.fixture(scope="module")
def asked() -> list[str]:
    """What the page that most tests use has asked the network for."""
    return []


@pytest.fixture(scope="module")
def first_page(lab, opened, asked) -> Page:
    return opened(lab, asked)


@pytest.fixture
def page(first_page) -> Page:
    """A page on which nothing is thrown yet."""
    reset(first_page)
    return first_page


@pytest.mark.parametrize("face", PLACES)
def test_the_ray_of_the_saved_scene_hits_where_the_click_was_to_a_pixel(lab, page, face):
    pixel = click(page, PLACES[face])
    try:
        expect(page.locator("[data-lab=errors]")).to_be_visible(timeout=PATIENCE_MS / 4)
    except AssertionError:  # the first click of a process that was not listening yet
        pixel = click(page, PLACES[face])
    thrown(page)
    (impulse,) = tomllib.loads(saved(lab, page, "Scene").read_text(encoding="utf-8"))["impulse"]
    origin, direction = (np.array(impulse["ray"][key]) for key in ("origin", "direction"))
    axis = {"front": 2, "side": 0, "top": 1}[face]
    hit = origin + direction * (PLACES[face][axis] - origin[axis]) / direction[axis]
    assert np.abs(Camera(page, CUBE).pixel(hit) - pixel).max() < 1.0
    assert hit == pytest.approx(PLACES[face], abs=0.05)


def test_a_ball_is_thrown_from_the_point_of_its_surface_that_was_clicked(opened_here, tmp_path):
    scene = read_scene(BALL)
    state, radius = scene.start[0], scene.body.radius
    with serving(tmp_path, BALL, "-e", "tumble:moreau") as ball:
        page = opened_here(ball)
        aside = np.array([0.3, 0.4, 0.5]) * radius
        camera = Camera(page, BALL)
        # The point of the sphere that the eye sees there.
        spot = strike_point(Impulse(0.0, aside, ray=ray_between(camera.place, state[0:3] + aside)), state, scene.body)
        pixel = click(page, spot, BALL)
        thrown(page)
        thrown_scene = read_scene(str(saved(ball, page, "Scene")))
        (impulse,) = thrown_scene.impulses
        hit = strike_point(impulse, state, scene.body)
        assert np.linalg.norm(hit - state[0:3]) == pytest.approx(radius, rel=1e-12)
        assert np.abs(camera.pixel(hit) - pixel).max() < 1.0
        assert hit == pytest.approx(spot, abs=0.05 * radius)
        assert truth(thrown_scene, False).contacts[0].events[0].kind == "impulse"


def ray_between(origin, place) -> Ray:
    """A ray from one place towards another [m]."""
    return Ray(origin, (place - origin) / np.linalg.norm(place - origin))


# How often the row of buttons under the message has moved.
WATCH = """
    window.moves = 0;
    const isRow = (node) => node?.innerText?.startsWith("Throw");
    new PerformanceObserver((list) => {
        for (const shift of list.getEntries()) window.moves += shift.sources.filter(({ node }) => isRow(node)).length;
    }).observe({ type: "layout-shift" });
"""


def test_what_was_clicked_is_what_run_flies_and_what_the_table_says(lab, page):
    page.evaluate(WATCH)
    click(page, PLACES["front"])
    over(page)
    assert page.evaluate("window.moves") == 0, "a message must not move the buttons from under the pointer"
    folder = saved(lab, page, "CSV")
    done = subprocess.run(
        [sys.executable, "-P", "-m", "tumble", "run", f"{folder.name}.toml", "-e", "mujoco:euler"],
        cwd=lab.folder, capture_output=True, text=True, timeout=120,
    )  # fmt: skip
    assert (folder / "trajectory-mujoco-euler.csv").read_text(encoding="utf-8") == done.stdout
    hold_table_against_csv(page, folder)


def test_the_report_of_a_throw_is_made_while_the_page_lives_on(lab, page):
    click(page, PLACES["front"])
    thrown(page)
    report = saved(lab, page, "Report")
    assert report.suffix == ".html"
    text = report.read_text(encoding="utf-8")
    assert "</html>" in text
    assert report.stem in text
    assert report.with_suffix(".toml").exists()


def hold_table_against_csv(page: Page, folder: Path) -> None:
    """Hold what the page says at the time shown against what was written."""
    at = float(page.locator("[data-lab=time]").inner_text())
    with (folder / "vertex-errors.csv").open(encoding="utf-8", newline="") as file:
        rows = [row for row in csv.DictReader(file) if float(row["t_s"]) == pytest.approx(at, rel=1e-8)]
    contestants = page.locator("[data-contestant]")
    assert contestants.count() == 3
    for shown in contestants.all():
        name = shown.get_attribute("data-contestant")
        own = [row for row in rows if f"{row['engine']}:{row['method']}" == name]
        worst = max(own, key=lambda row: float(row["error_m"]))
        off = shown.locator("[data-lab=off]").inner_text()
        if not off.startswith("\N{LESS-THAN OR EQUAL TO}"):
            assert off == metres(float(worst["error_m"]))
        place = ", ".join(fixed(float(worst[f"{axis}_m"]), 2) for axis in "xyz")
        assert off.startswith("\N{LESS-THAN OR EQUAL TO}") or place in page.locator("[data-lab=errors]").inner_text()


def test_a_click_beside_the_die_throws_nothing_and_says_so(lab, page):
    click(page, (-3.4, 3.5, 2.5))
    expect(page.locator("[data-lab=message]")).to_contain_text("missed the body", timeout=PATIENCE_MS)
    assert page.locator("[data-lab=errors]").count() == 0
    click(page, PLACES["front"])
    thrown(page)
    assert len(read_scene(str(saved(lab, page, "Scene"))).impulses) == 1


def test_the_first_click_throws_and_the_second_does_not(lab, page):
    click(page, PLACES["front"])
    thrown(page)
    page.get_by_role("button", name="Pause").click()
    page.get_by_role("slider").nth(1).press("Home")
    expect(page.locator("[data-lab=time]")).to_have_text("0", timeout=PATIENCE_MS)
    click(page, PLACES["side"])
    expect(page.locator("[data-lab=message]")).to_contain_text("already thrown", timeout=PATIENCE_MS)
    assert len(read_scene(str(saved(lab, page, "Scene"))).impulses) == 1


def test_two_browsers_do_not_disturb_each_other(lab, page, opened_here):
    other = opened_here(lab)
    click(page, PLACES["side"])
    thrown(page)
    expect(other.locator("[data-lab=message]")).to_contain_text("Click the body")
    assert other.locator("[data-lab=errors]").count() == 0
    click(other, PLACES["front"])
    thrown(other)
    rays = {tuple(read_scene(str(saved(lab, one, "Scene"))).impulses[0].ray.direction) for one in (page, other)}
    assert len(rays) == 2


def test_no_request_leaves_the_machine(page, asked):
    click(page, PLACES["side"])
    thrown(page)
    hosts = {urlsplit(url).hostname for url in asked if urlsplit(url).scheme in ("http", "https", "ws", "wss")}
    assert hosts == {"127.0.0.1"}
    assert any(url.startswith("ws:") for url in asked)


def test_a_hung_engine_leaves_the_page_alive(tmp_path, opened_here):
    (tmp_path / "hung.py").write_text(HUNG, encoding="utf-8")
    words = CUBE, "-e", "./hung.py", "-e", "mujoco:euler", "--time-limit", "20"
    with serving(tmp_path, *words) as lab:
        page = opened_here(lab)
        click(page, PLACES["front"])
        flown = page.locator("[data-contestant='mujoco:euler'] [data-lab=off]")
        expect(flown).to_have_text(re.compile(r"\d"), timeout=PATIENCE_MS)
        errors = page.locator("[data-lab=errors]")
        expect(errors).to_contain_text("running")
        expect(errors).to_contain_text("timeout", timeout=PATIENCE_MS)
        reset(page)


def test_ctrl_c_ends_it_and_leaves_no_process(tmp_path):
    with serving(tmp_path, CUBE, "-e", "mujoco:euler") as first, serving(
        tmp_path, CUBE, "-e", "mujoco:euler", "--port", str(urlsplit(first.address).port)
    ) as second:  # fmt: skip
        assert second.address != first.address
        assert urlsplit(second.address).hostname == "127.0.0.1"
        begun = descendants(second.process.pid)
        assert begun
        second.process.send_signal(signal.SIGINT)
        assert second.process.wait(20) == 0
        wait_for(lambda: not [pid for pid in begun if Path(f"/proc/{pid}").exists()])
        assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("--port", "70000"), "0 to 65535"),
        (("-e", "mujoco:nosuch"), "unknown method"),
        (("nosuch",), "unknown scene"),
    ],
)
def test_mistakes_are_refused_in_one_line(tumble, words, says):
    done = tumble("lab", "--no-open", *words)
    assert done.returncode == 2
    assert says in done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert done.stdout == ""


def descendants(parent: int) -> list[int]:
    """Return the processes that one has started, and those that they have."""
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                status = (entry / "stat").read_text()
            except OSError:
                continue
            if int(status.rpartition(")")[2].split()[1]) == parent:
                found += [int(entry.name), *descendants(int(entry.name))]
    return found
