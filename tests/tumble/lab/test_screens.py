"""Every state of the lab as a person sees it, in a real browser; its picture is kept in report/screenshots."""

import re
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from lab_pages import PATIENCE_MS, Camera, Lab, click, reset, saved, serving, thrown
from PIL import Image
from playwright.sync_api import Page, expect

from tumble.lab.draft import Draft
from tumble.scenarios.read import read_scene

SCENE, MISSING = "die-ray", "drake"
WHO = ("tumble:exact", "mujoco:euler", "pybullet:multibody+defaults", MISSING)
CENTRE = read_scene(SCENE).start[0, 0:3]
SETTLED_MS = 1_500
DARK, PAPER = 70, (241, 243, 245)


@pytest.fixture(scope="module")
def lab(tmp_path_factory) -> Iterator[Lab]:
    words = [word for one in WHO for word in ("-e", one)]
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TUMBLE_ENVIRONMENTS", str(tmp_path_factory.mktemp("none")))  # where nothing is installed
        with serving(tmp_path_factory.mktemp("screens"), SCENE, *words) as lab:
            yield lab


@pytest.fixture(scope="module")
def wide(lab, opened) -> Page:
    return opened(lab)


@pytest.fixture(scope="module")
def narrow(lab, opened) -> Page:
    return opened(lab, width=400, height=800)


@pytest.fixture
def keep(request) -> Callable[[Page, str], Path]:
    """Keep a picture of what is seen."""

    def keep(page: Page, name: str) -> Path:
        folder = request.config.rootpath / "report" / "screenshots"
        folder.mkdir(parents=True, exist_ok=True)
        page.mouse.move(2, 2)
        page.wait_for_timeout(SETTLED_MS)
        page.screenshot(path=folder / f"lab-{name}.png")
        return folder / f"lab-{name}.png"

    return keep


def expect_message(page: Page, words: str) -> None:
    """Wait until the line above the controls says this."""
    expect(page.locator("[data-lab=message]")).to_contain_text(words, timeout=PATIENCE_MS)


def own_throw(page: Page) -> None:
    """Throw the scene's own throw and wait until it is over and all have answered."""
    page.get_by_role("button", name="Scene's own throw").click()
    thrown(page)
    expect(page.locator("[data-lab=errors]")).not_to_contain_text("running", timeout=PATIENCE_MS)
    expect(page.get_by_role("button", name="Play")).to_be_visible(timeout=PATIENCE_MS)
    expect(page.locator("[data-lab=time]")).to_have_text("1", timeout=PATIENCE_MS)


def chosen(page: Page, what: str, option: str) -> None:
    """Choose an option of a dropdown."""
    page.get_by_label(what).click()
    page.get_by_role("option", name=option, exact=True).click()


def seen(picture: Path, page: Page) -> np.ndarray:
    """Return the pixels of the canvas in a picture, (h, w, 3)."""
    box = page.locator("canvas").first.bounding_box()
    assert box is not None
    left, top, width, height = (round(box[key]) for key in ("x", "y", "width", "height"))
    return np.asarray(Image.open(picture).convert("RGB"))[top : top + height, left : left + width].astype(int)


def test_at_first_there_is_a_die_with_pips_before_a_ruled_wall(wide, keep):
    reset(wide)
    pixels = seen(keep(wide, "start"), wide)
    dark = (pixels.max(axis=-1) < DARK).mean()
    assert 0.01 < dark < 0.08, "no pips, or no die"
    assert (np.abs(pixels - PAPER).max(axis=-1) < 4).mean() > 0.4
    assert (np.abs(pixels[:, -20:] - PAPER).max(axis=-1) > 12).any(), "no lines behind the die"


def test_a_click_beside_it_says_so(wide, keep):
    reset(wide)
    click(wide, CENTRE + np.array([-1.0, 0.9, 0.0]), SCENE)
    expect_message(wide, "missed the body")
    keep(wide, "miss")


def test_errors_are_told_while_it_moves(wide, keep):
    reset(wide)
    chosen(wide, "Speed", "50 times slower")  # so that it still moves when a busy machine comes to look
    click(wide, CENTRE, SCENE)
    ran = wide.locator("[data-contestant='mujoco:euler'] [data-lab=off]")
    expect(ran).to_have_text(re.compile("[mµ]m$"), timeout=PATIENCE_MS)
    expect(wide.get_by_role("button", name="Pause")).to_be_visible()
    first = ran.inner_text()
    expect(ran).not_to_have_text(first, timeout=PATIENCE_MS)
    assert wide.locator("[data-lab=chart] path").count() >= 3
    wide.get_by_role("button", name="Pause").click()
    keep(wide, "flight")
    chosen(wide, "Speed", "5 times slower")


def test_errors_are_magnified_until_they_fit_and_what_is_outside_is_named(wide, keep):
    reset(wide)
    own_throw(wide)
    expect_message(wide, "Largest error now: pybullet:multibody+defaults")
    assert wide.locator("[data-lab=outside]").count() == 0
    keep(wide, "magnified-to-fit")
    chosen(wide, "Magnify errors", "1000")
    expect_message(wide, "Outside the view: mujoco:euler, pybullet:multibody+defaults")
    assert wide.locator("[data-lab=outside]").count() == 2
    keep(wide, "magnified-too-far")
    chosen(wide, "Magnify errors", "fit the view")
    expect(wide.locator("[data-lab=outside]")).to_have_count(0, timeout=PATIENCE_MS)


def test_contestants_are_ticked_and_missing_ones_marked(wide, keep):
    reset(wide)
    own_throw(wide)
    expect(wide.locator(f"[data-contestant='{MISSING}'] + tr [data-lab=status]")).to_contain_text("--install drake")
    wide.get_by_text("Engines", exact=True).click()
    wide.get_by_text(re.compile(r"^mujoco: 1 of \d+")).click()
    expect(wide.get_by_label(f"{MISSING} (missing)")).to_be_checked()
    expect(wide.get_by_label("euler", exact=True)).to_be_checked()
    wide.get_by_label("rk4", exact=True).locator("visible=true").click()
    ran = wide.locator("[data-contestant='mujoco:rk4'] [data-lab=off]")
    expect(ran).to_have_text(re.compile(r"\d"), timeout=PATIENCE_MS)
    wide.get_by_text("Save and load", exact=True).scroll_into_view_if_needed()
    keep(wide, "engines")
    wide.get_by_label("rk4", exact=True).locator("visible=true").click()
    expect(ran).to_have_count(0, timeout=PATIENCE_MS)
    wide.get_by_text(re.compile(r"^mujoco: 1 of \d+")).click()
    wide.get_by_text("Engines", exact=True).click()


def test_what_is_saved_is_downloaded_and_its_folder_is_named(lab, wide, keep):
    reset(wide)
    own_throw(wide)
    scene = saved(lab, wide, "Scene")
    expect(wide.locator("[data-lab=folder]")).to_contain_text(str(lab.folder))
    for button, name in (("Scene", scene.name), ("CSV", f"{scene.stem}.zip")):
        with wide.expect_download(timeout=PATIENCE_MS) as download:
            wide.get_by_role("button", name=button, exact=True).click()
        assert download.value.suggested_filename == name
        if button == "Scene":
            assert Path(download.value.path()).read_bytes() == scene.read_bytes()
    keep(wide, "saved")
    wide.get_by_text("Save and load", exact=True).click()


def test_a_loaded_trajectory_has_its_verdict_in_view(lab, wide, keep):
    reset(wide)
    own_throw(wide)
    folder = saved(lab, wide, "CSV")
    upload = wide.locator("input[type=file]")
    verdict = wide.locator("[data-lab=grade]")
    for name, contestant, words in (
        ("right", "tumble-exact", "is right"),
        ("wrong", "pybullet-multibody+defaults", "is wrong"),
    ):
        file = lab.folder / f"{name}.csv"
        file.write_bytes((folder / f"trajectory-{contestant}.csv").read_bytes())
        upload.set_input_files(file)
        expect(verdict).to_contain_text(f"{name}.csv {words}", timeout=PATIENCE_MS)
        expect(verdict).to_be_in_viewport()
        keep(wide, f"loaded-{name}")
    refused = lab.folder / "refused.csv"
    refused.write_text((lab.folder / "right.csv").read_text(encoding="utf-8").replace("t_s,", "Time,", 1))
    upload.set_input_files(refused)
    expect_message(wide, "refused.csv: the time, t_s, is missing")
    expect_message(wide, "command line")
    keep(wide, "loaded-refused")
    wide.get_by_text("Save and load", exact=True).click()


def test_printed_points_are_seen_through_the_body_and_joined(wide, keep):
    wide.get_by_role("button", name="Table 4.1").click()
    wide.get_by_role("button", name="0.36", exact=True).click()
    expect_message(wide, "the application (black) 9.17 mm from the truth, the calculation (red) 1.87 m")
    pixels = seen(keep(wide, "table-4-1"), wide)
    red = (pixels[..., 0] - pixels[..., 1:].max(axis=-1) > 90).sum()
    assert red > 300
    chosen_scene(wide, SCENE)


def chosen_scene(page: Page, name: str) -> None:
    """Open a scene again."""
    page.get_by_text("Scene", exact=True).first.click()
    chosen(page, "Scene", name)
    page.get_by_text("Scene", exact=True).first.click()
    expect_message(page, "Click the body")


def test_in_a_narrow_window_the_controls_fold(narrow, keep):
    reset(narrow)
    title = narrow.get_by_text("Tumble lab")
    sheet = title.bounding_box()
    assert sheet is not None
    assert 380 < sheet["y"] < 420, "the controls take more than half of the window, or less than they could"
    keep(narrow, "narrow-start")
    camera = Camera(narrow, SCENE, is_narrow=True)
    corners = np.array([camera.pixel(CENTRE + point) for point in Draft.opened(SCENE).scene.body.points])
    assert corners[:, 1].max() < sheet["y"]
    click(narrow, CENTRE, SCENE, is_narrow=True)
    thrown(narrow)
    expect(narrow.get_by_role("button", name="Play")).to_be_visible(timeout=PATIENCE_MS)
    keep(narrow, "narrow-thrown")
    for control in narrow.get_by_role("button").locator("visible=true").all():
        box = control.bounding_box()
        assert box is None or (box["x"] >= 0 and box["x"] + box["width"] <= 400), "a button is cut off"
    title.click()
    expect(narrow.get_by_role("button", name="Play")).to_be_hidden(timeout=PATIENCE_MS)
    keep(narrow, "narrow-folded")
    title.click()
    expect(narrow.get_by_role("button", name="Play")).to_be_visible(timeout=PATIENCE_MS)
