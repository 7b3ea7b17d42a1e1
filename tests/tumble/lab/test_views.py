"""What a person sees of the lab and does to see it, in a real browser: eye, windows, sizes, Table 4.1, who flies."""

import re
from collections.abc import Iterator

import numpy as np
import pytest
from lab_pages import PATIENCE_MS, Camera, Lab, click, press, reset, saved, serving, thrown
from PIL import Image
from playwright.sync_api import Page, expect

from tumble.reports.hues import places, rgb
from tumble.scenarios.read import read_scene
from tumble.scenarios.scene import Impulse

GRAIN = """
title = "A grain, a kilometre away"
duration = 0.05
step = 0.0005
samples = 20

[body]
shape = "box"
size = [2e-4, 3e-4, 4e-4]
mass = 1e-7
position = [1000.0, 0.0, -2000.0]
"""
CENTRE, CORNER = np.array([1000.0, 0.0, -2000.0]), np.array([1e-4, 1.5e-4, 2e-4])
SETTLED_MS = 500
WALKED = 0.05  # of the body's reach: a walk of one picture makes 0.18
# Ends after three pictures: a walk of one at least, and not of so many seconds that a busy machine walks past the body,
# from which the eye goes back before.
THREE_PICTURES = """() => new Promise((done) => {
    let left = 3;
    const next = () => left-- ? requestAnimationFrame(next) : done();
    next();
})"""
BESIDE = 560, 690  # on the canvas, beside the body
SPOT = 20  # pixels that are surely no accident


@pytest.fixture(scope="module")
def lab(tmp_path_factory) -> Iterator[Lab]:
    folder = tmp_path_factory.mktemp("views")
    (folder / "grain.toml").write_text(GRAIN, encoding="utf-8")
    with serving(folder, "grain.toml", "-e", "tumble:rk4", "-e", "mujoco:euler") as lab:
        yield lab


@pytest.fixture(scope="module")
def first_page(lab, opened) -> Page:
    return opened(lab)


@pytest.fixture
def page(first_page) -> Page:
    """A page on which nothing is thrown yet."""
    reset(first_page)
    return first_page


def with_impulse(lab: Lab, page: Page, place, *, is_narrow: bool = False) -> Impulse:
    """Click a place [m] of the grain as the lab shows it at first, and return the impulse of the scene it saves."""
    click(page, place, str(lab.folder / "grain.toml"), is_narrow)
    thrown(page)
    (impulse,) = read_scene(str(saved(lab, page, "Scene"))).impulses
    return impulse


def go_back(page: Page) -> None:
    """Turn the wheel, so that the eye is 2.8 times as far from the body as at first."""
    page.mouse.move(*BESIDE)
    for _ in range(2):
        page.mouse.wheel(0, 1000)
        page.wait_for_timeout(SETTLED_MS)


def test_a_grain_far_from_the_origin_is_struck_where_it_is_clicked(lab, page):
    place = CENTRE + CORNER * (0.4, -0.3, 1.0)
    ray = with_impulse(lab, page, place).ray
    hit = ray.origin + ray.direction * (place[2] - ray.origin[2]) / ray.direction[2]
    assert np.abs(hit - place).max() < 0.01 * np.linalg.norm(CORNER)


def test_w_walks_towards_the_body_however_small_it_is_and_an_edit_leaves_the_eye_there(lab, page):
    reach = read_scene(str(lab.folder / "grain.toml")).body.reach
    go_back(page)
    before = np.linalg.norm(with_impulse(lab, page, CENTRE).ray.origin - CENTRE) / reach
    reset(page)
    go_back(page)
    page.mouse.click(*BESIDE)
    page.keyboard.down("w")
    page.evaluate(THREE_PICTURES)
    page.keyboard.up("w")
    page.get_by_text("Scene", exact=True).first.click()
    numbers = page.locator("input[inputmode=decimal], input[inputmode=numeric]")
    magnitude, mass = numbers.nth(0), numbers.nth(5)
    chosen = magnitude.input_value()
    assert float(chosen) > 0
    mass.fill("0.0000002")
    mass.press("Enter")
    page.get_by_text("Scene", exact=True).first.click()
    impulse = with_impulse(lab, page, CENTRE)
    walked = np.linalg.norm(impulse.ray.origin - CENTRE) / reach
    assert before == pytest.approx(12.3, abs=0.2)
    assert walked < before - WALKED
    assert np.linalg.norm(impulse.value) == pytest.approx(float(chosen))
    newest = max(lab.folder.glob("grain-*.toml"), key=lambda file: file.stat().st_mtime_ns)
    assert read_scene(str(newest)).body.mass == 2e-7


def test_the_coursework_is_replayed_with_its_five_times_and_its_printed_positions(lab, opened_here):
    page = opened_here(lab)
    page.get_by_role("button", name="Table 4.1").click()
    for time in ("0.06", "0.28", "0.42", "0.5", "0.36"):
        page.get_by_role("button", name=time, exact=True).click()
    expect(page.locator("[data-lab=time]")).to_have_text("0.36", timeout=PATIENCE_MS)
    expect(page.locator("[data-lab=message]")).to_contain_text("the application (black) 9.17 mm", timeout=PATIENCE_MS)
    expect(page.locator("[data-lab=errors]")).to_contain_text("vertex 5", timeout=PATIENCE_MS)
    pixels = picture_of(lab, page)
    red, green, blue = np.moveaxis(pixels.astype(int), -1, 0)
    assert ((red - green > 90) & (red - blue > 90)).sum() > SPOT


def test_after_a_pull_of_the_slider_it_stands_where_the_time_does(lab, page):
    # A later time may be on its way to the browser as it is pulled: which of the two it is is nobody's promise.
    with_impulse(lab, page, CENTRE)
    number = page.locator("input[inputmode=decimal], input[inputmode=numeric]").nth(1)
    track = page.locator(".mantine-Slider-root").nth(1)
    play, pause = (page.get_by_role("button", name=name) for name in ("Play", "Pause"))
    for share in (0.2, 0.5, 0.2):
        if play.is_visible():
            play.click()
        expect(pause).to_be_visible(timeout=PATIENCE_MS)
        box = track.bounding_box()
        track.click(position={"x": share * box["width"], "y": box["height"] / 2})
        expect(play).to_be_visible(timeout=PATIENCE_MS)
        page.wait_for_timeout(SETTLED_MS)
        shown = float(page.locator("[data-lab=time]").inner_text())
        assert float(number.input_value()) == pytest.approx(shown, abs=1e-9)


def test_an_engine_is_ticked_in_the_panel(page, lab):
    page.get_by_text("Engines", exact=True).click()
    scipy = page.get_by_label("scipy", exact=True)
    press(scipy, lambda patience_ms: expect(scipy).to_be_checked(timeout=patience_ms))
    page.get_by_text("Engines", exact=True).click()
    with_impulse(lab, page, CENTRE)
    ran = page.locator("[data-contestant='scipy:dop853'] [data-lab=off]")
    expect(ran).to_have_text(re.compile(r"\d"), timeout=PATIENCE_MS)


def test_in_a_narrow_window_all_of_the_body_is_above_the_controls(lab, opened_here):
    page = opened_here(lab, width=400, height=800)
    top = page.get_by_text("Tumble lab").bounding_box()["y"]
    camera = Camera(page, str(lab.folder / "grain.toml"), is_narrow=True)
    signs = np.array(list(np.ndindex(2, 2, 2))) * 2 - 1
    corners = np.array([camera.pixel(CENTRE + sign * CORNER) for sign in signs])
    assert (corners > 0).all()
    assert corners[:, 0].max() < 400
    assert corners[:, 1].max() < top
    ray = with_impulse(lab, page, CENTRE, is_narrow=True).ray
    assert np.linalg.norm(np.cross(CENTRE - ray.origin, ray.direction)) < 0.02 * np.linalg.norm(CORNER)


def picture_of(lab: Lab, page: Page) -> np.ndarray:
    """Keep a picture and return its pixels, (h, w, 3)."""
    return np.asarray(Image.open(saved(lab, page, "Screenshot")).convert("RGB"))


def test_the_picture_shows_the_body_and_tells_who_is_how_far_off(lab, page):
    with_impulse(lab, page, CENTRE)
    pixels = picture_of(lab, page)
    seen = pixels[: int(0.75 * len(pixels))]
    assert pixels.shape[1] >= 960
    assert seen[len(seen) // 2, pixels.shape[1] // 2].min() < 250
    for colour in (rgb(place) for place in places(["tumble", "mujoco"]).values()):
        assert (pixels == colour).all(axis=-1).any()
