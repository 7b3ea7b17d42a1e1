"""MuJoCo above a plane, as tables, in words and on the page: its pyramid is named, its round cone is none."""

from pathlib import Path

import tumble
from tumble.compare.tables.frames import read_tables
from tumble.reports.page import page

SLIDE = {
    "title": "slide",
    "duration": 0.6,
    "samples": 6,
    "step": 0.004,
    "gravity": [0.0, -9.81, 0.0],
    "body": {
        "shape": "box",
        "size": [0.5, 0.1, 0.5],
        "mass": 5.0,
        "position": [0.0, 0.05, 0.0],
        "velocity": [0.8, 0.0, 0.8],
    },
    "plane": {"restitution": 0.0, "friction": 0.4},
}


def test_the_pyramid_of_mujoco_is_named_and_its_round_cone_is_not(tmp_path: Path, opened):
    result = tumble.compare(SLIDE, ["mujoco:euler", "mujoco:euler+elliptic"], film=False, progress=False)
    stops = result.contact[result.contact.observable == "distance until it stops"].set_index("method")
    assert stops.verdict["euler"] == "another law: pyramid along x and z, 1.41 times as far"
    assert abs(stops.law_error["euler"] / stops.true["euler"] - (2**0.5 - 1)) < 0.01
    assert stops.verdict["euler+elliptic"] == "Coulomb and Newton"
    assert "mujoco:euler: distance until it stops +41" in result.answer
    assert len(result.contact_scans[result.contact_scans.method == "euler"]) == 2 * 16
    result.save(tmp_path)
    assert tumble.read(tmp_path).contact.equals(result.contact)
    tab = opened(result.page(), "#contact", width=400)
    assert "distance until it stops" in tab.locator("section#contact .headline").inner_text()
    outline = tab.locator("svg.rose [data-name='mujoco:euler'] path").first.get_attribute("d")
    assert outline.count(",") == 16
    assert tab.evaluate("document.documentElement.scrollWidth") <= 400
    # Of contact alone, as on the page of the catalogue: figures begin with all contestants, and a note has the command.
    tables = read_tables(tmp_path)
    alone = {name: tables[name] for name in ("contact.csv", "contact-scans.csv")}
    alone |= {"runs.csv": tables["runs.csv"].query("method == 'euler'").assign(scene="another")}
    tab = opened(page(alone), "#contact")
    assert tab.locator("svg.rose .curve").count() == 2
    assert f"tumble report {result.contact.scene[0]} makes" in tab.locator("section#contact").inner_text()
    tab.locator("svg.rose .label[data-name='mujoco:euler']").press("Enter")
    assert tab.locator("svg.rose .curve").get_attribute("data-name") == "mujoco:euler+elliptic"
