"""The page in a real browser, offline: what it draws is what the tables say, and every view is an address."""

import csv
import io
import math
import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from axe_playwright_python.sync_playwright import Axe
from conftest import SCENES, data_in, until
from playwright.sync_api import expect

from tumble.compare.comparison.findings import error_findings
from tumble.compare.tables.frames import frame, rows
from tumble.compare.tables.shared import FINDINGS, RUNS
from tumble.reports.page import page
from tumble.scenarios.frames import rotation_matrix
from tumble.scenarios.read import catalogue

EVIL = "</script><script>alert(1)</script><img src=x onerror=alert(2)>"
TOWARDS_EYE = np.array((0.55, 0.5, 1.0)) / np.linalg.norm((0.55, 0.5, 1.0))
RIGHT = np.cross((0.0, 1.0, 0.0), TOWARDS_EYE)
RIGHT /= np.linalg.norm(RIGHT)
UP = np.cross(TOWARDS_EYE, RIGHT)
SECTIONS = ("scenes", "cost", "stability", "extremes", "same", "matrix", "class-report", "how")


def name(row) -> str:
    return f"{row['engine']}:{row['method'].partition('@')[0]}"


def everything_drawn(tab) -> None:
    """Go down the page, so that every section draws itself."""
    for section in SECTIONS:
        tab.locator(f"#{section}").scroll_into_view_if_needed()
        until(tab, f"document.querySelector('#{section} .host').children.length > 0")


def test_every_section_draws_and_every_chart_has_marks(html, opened):
    tab = opened(html, "#show=all")
    everything_drawn(tab)
    tab.locator("#scene-two-hits > summary").click()
    expect(tab.locator("#polhode-two-hits path").nth(4)).to_be_attached()
    charts = tab.locator("svg.chart")
    assert charts.count() >= 6
    for chart in charts.all():
        expect(chart.locator(".point").first).to_be_attached()


def test_every_row_and_every_figure_has_an_address_of_its_own(html, opened):
    tab = opened(html, "#show=all&open=die-vertex,table-4-1&at=first")
    everything_drawn(tab)
    for fold in tab.locator("details.fold > summary").all():
        if fold.is_visible():
            fold.click()
    expect(tab.locator("#fold-runs-die-vertex table.data tbody tr").first).to_be_attached()
    without = tab.evaluate("""() => {
        const parts = "table.data tbody tr, #board tbody tr, figure svg:not(.mark), canvas.stage";
        const linked = (each) => (each.closest("figure, tr") ?? each.parentElement).querySelector("button.link");
        return [...document.querySelectorAll(parts)]
          .filter((each) => !each.id || !linked(each))
          .map((each) => each.outerHTML.slice(0, 200));
    }""")
    assert without == []
    ids = tab.evaluate("() => [...document.querySelectorAll('[id]')].map((each) => each.id)")
    assert len(ids) == len(set(ids))
    assert len([each for each in ids if each.startswith(("runs-", "vertices-", "agreement-", "table-4-1-"))]) > 30


def test_the_page_is_small_and_runs_no_script_but_its_own(html, browser, tmp_path):
    assert len(html.encode()) < 3_000_000
    file = tmp_path / "report.html"
    file.write_text(html, encoding="utf-8")
    tab = browser.new_page()
    refused = []
    tab.on("console", lambda message: refused.append(message.text))
    tab.goto(file.as_uri())
    tab.evaluate("""() => {
        const script = document.createElement('script');
        script.textContent = 'window.ran = true';
        document.body.append(script);
    }""")
    assert tab.evaluate("window.ran") is None
    assert "Content Security Policy" in refused[0]
    assert "unsafe" not in html.partition("<style>")[0]
    tab.close()


def test_the_board_has_every_error_and_every_verdict(real, html, opened):
    tab = opened(html, "#show=all&tol=0.01")
    titles = [each.inner_text() for each in tab.locator("#board thead tr").nth(1).locator("th.upright").all()]
    seen, tints = set(), {}
    for line in tab.locator("#board tbody tr").all():
        contestant = line.get_attribute("data-name")
        unit = line.locator("td.of-row").inner_text()
        for scene, cell in zip(titles, line.locator("td.cell").all(), strict=True):
            kind, tint = cell.get_attribute("class").split("v-")[1].split(" ")
            seen.add(kind)
            (run,) = (
                row for row in real["runs.csv"].to_dict("records") if (name(row), row["scene"]) == (contestant, scene)
            )
            error, limit = run["max_error_m"], run["resolution_m"]
            if run["status"].startswith("skipped"):
                assert kind == "skipped"
            elif run["status"] == "ok":
                assert kind == ("exact" if error <= limit else "within" if error <= 0.01 else "beyond")
                told = max(error, limit)
                number = cell.locator(".figure").inner_text()
                # Two digits, or one where a power of ten stands.
                assert metres(number, unit) == pytest.approx(told, rel=0.51 if "e" in number else 0.051)
                decades = min(12, max(1, math.ceil(abs(math.log10(told / 0.01)))))
                assert tint == f"{'above' if kind == 'beyond' else 'below'}-{decades}"
                tints[tint] = cell.evaluate("(it) => getComputedStyle(it).backgroundColor")
    assert {"skipped", "within", "beyond", "flagged"} <= seen
    assert len(set(tints.values())) == len(tints) > 4, "each decade has a colour of its own"


def metres(text: str, unit: str) -> float:
    """Return a length as the board has it, in the unit of its row: 410, ≤11, or with a power of ten."""
    found = re.fullmatch(r"≤?([0-9.]+(?:e-?[0-9]+)?)", text.replace("\N{MINUS SIGN}", "-"))
    assert found, text
    assert len(text) <= 7
    size = {"m": 1.0, "mm": 1e-3, "µm": 1e-6, "nm": 1e-9, "pm": 1e-12, "fm": 1e-15}[unit]
    return float(found[1]) * size


def test_another_tolerance_changes_the_answer_and_the_address(html, opened):
    tab = opened(html)
    before = tab.locator("#answer").inner_text()
    assert "1\u202fmm" in before
    tab.locator("#tolerance").fill("5")
    tab.locator("#tolerance").press("Enter")
    until(tab, "location.hash.includes('tol=0.005')")
    assert "5\u202fmm" in tab.locator("#answer").inner_text()


def test_the_unit_stays_as_the_reader_chose_it(html, opened):
    tab = opened(html)
    unit = tab.get_by_label("Unit of the acceptable error")
    tab.locator("#tolerance").fill("0.01")
    tab.locator("#tolerance").press("Enter")
    until(tab, "location.hash.includes('tol=0.00001')")
    assert (tab.locator("#tolerance").input_value(), unit.input_value()) == ("0.01", "mm")
    unit.select_option("m")
    until(tab, "location.hash.includes('tol=0.01')")
    assert (tab.locator("#tolerance").input_value(), unit.input_value()) == ("0.01", "m")
    tab.evaluate("location.hash = '#tol=2e-6'")
    until(tab, "document.getElementById('tolerance').value === '2'")
    assert unit.input_value() == "µm"


def test_there_is_one_answer_and_it_has_a_row(real, opened):
    """Who is cheapest in the sentence has a row on the board, and is the first of the section on costs.

    Here it is a method that is neither its engine's default nor its best.
    """
    costs = real["sweep-work-precision.csv"].copy()
    cheap = (costs["engine"] == "tumble") & (costs["method"] == "quaternion-euler")
    costs.loc[cheap, ["status", "error_m", "run_us"]] = "ok", 1e-6, 1e-4
    html = page(real | {"sweep-work-precision.csv": costs})
    for tolerance in ("0.001", "0.05"):
        tab = opened(html, f"#tol={tolerance}&at=cost")
        named = tab.locator("#answer b").all_inner_texts()
        assert named[0] == "tumble:quaternion-euler"
        rows = [row.get_attribute("data-name") for row in tab.locator("#board tbody tr").all()]
        assert set(named) <= set(rows)
        assert "cheapest" in tab.locator(f'#board tr[data-name="{named[0]}"] .note').inner_text()
        assert tab.locator("#cost .headline b").first.inner_text() == named[0]
        tab.evaluate("location.hash = `#tol=${" + tolerance + "}&show=pybullet:multibody`")
        expect(tab.locator("#board tbody tr")).to_have_count(1)
        assert tab.locator("#cost .headline b").first.inner_text() == named[0], "another choice, another winner"


def test_the_first_screen_has_a_clause_on_stiff_scenes(real, opened):
    changed = dict(real)
    found = real["findings.csv"].copy()
    for finding, value in (("limits with theory", 31), ("limits matching theory", 29), ("extreme cases", 17)):
        found.loc[found["finding"] == finding, "value"] = value
    silent = (found["finding"] == "silent failures") & (found["method"] == "multibody+defaults")
    assert silent.sum() == 1
    found.loc[silent, "value"] = 13
    changed["findings.csv"] = found
    tab = opened(page(changed))
    said = tab.locator("#answer").inner_text()
    assert re.search(r"stiff scenes, 29 of 31 .* 17 extreme cases, pybullet .* 13\b", said)
    tab.locator("#answer a", has_text="extreme cases").click()
    until(tab, "Math.abs(document.getElementById('extremes').getBoundingClientRect().top) < 100")
    assert (
        "On stiff scenes"
        not in opened(page(changed | {"findings.csv": found.iloc[:0]})).locator("#answer").inner_text()
    )


def test_links_keep_what_the_reader_has_chosen(html, opened):
    tab = opened(html, "#tol=0.02")
    tab.locator('nav a[href="#cost"]').click()
    until(tab, "Math.abs(document.getElementById('cost').getBoundingClientRect().top) < 100")
    assert tab.locator("#tolerance").input_value() == "20"


def test_every_scene_has_a_sentence_of_its_own_kind(html, opened):
    """Without numbers and names no two of them are one sentence."""
    tab = opened(html)
    said = tab.locator("#scenes summary .headline").all_inner_texts()
    assert len(said) == len(SCENES)
    bare = {re.sub(r"[\w.+-]+:[\w.+-]+|[\d.·⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+\s?\S*", "", one) for one in said}
    assert len(bare) == len(said), said


@pytest.mark.parametrize(
    ("scene", "time"), [("die-vertex", 0.6), ("two-hits", 1.3), ("two-hits", 0.33), ("table-4-1", 0.28)]
)
def test_the_slider_puts_every_vertex_where_the_trajectory_says(real, html, opened, scene, time):
    """To a pixel, also between frames; the truth there is that of the nearest frames, turned on by its own velocity."""
    tab = opened(html, f"#open={scene}&t={scene}~{time}&at=scene-{scene}&show=mujoco:euler")
    canvas = tab.locator(f"#scene-{scene} canvas.stage")
    canvas.scroll_into_view_if_needed()
    until(tab, f"document.querySelector('#scene-{scene} canvas.stage').seen")
    seen = canvas.evaluate("canvas => canvas.seen")
    width, height = canvas.evaluate("canvas => [canvas.clientWidth, canvas.clientHeight]")
    points = real["points.csv"].query("scene == @scene")[["x_m", "y_m", "z_m"]].to_numpy()
    motion = real["motion.csv"].query("scene == @scene")
    centre, truth = placed(motion[motion["engine"] == "truth"], points, time)
    _, own = placed(motion[(motion["engine"] == "mujoco") & (motion["method"] == "euler")], points, time)
    pixels_a_metre = min(width, height) / (2.9 * np.linalg.norm(points, axis=1).max())
    for told, where in (("truth", truth), ("mujoco:euler", own)):
        drawn = np.array(seen[told])[:, :2]
        away = where - centre
        expected = np.stack(
            (width / 2 + pixels_a_metre * away @ RIGHT, height / 2 - pixels_a_metre * away @ UP), axis=1
        )
        assert np.abs(drawn - expected).max() < 1.0


def placed(rows: pd.DataFrame, points: np.ndarray, time: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the centre and the vertices at a time, from the nearest earlier frame: turned and moved at its velocity.

    Exact for a spin about a fixed axis; for a tumbling body the axis moves by |w| dt over a frame of some 20 ms.
    """
    row = rows[rows["t_s"] <= time + 1e-12].iloc[-1]
    ahead = time - row["t_s"]
    nearest = rows.iloc[(rows["t_s"] - time).abs().argmin()]
    row, ahead = (nearest, time - nearest["t_s"]) if abs(time - nearest["t_s"]) < ahead else (row, ahead)
    x = np.array([row["x_m"], row["y_m"], row["z_m"]]) + ahead * np.array([row["vx_m_s"], row["vy_m_s"], row["vz_m_s"]])
    w = np.array([row["wx_rad_s"], row["wy_rad_s"], row["wz_rad_s"]])
    angle = np.linalg.norm(w) * ahead
    half = np.concatenate(([math.cos(angle / 2)], math.sin(angle / 2) * w / (np.linalg.norm(w) or 1.0)))
    turned = rotation_matrix(half) @ rotation_matrix(row[["qw", "qx", "qy", "qz"]].to_numpy(dtype=float))
    return x, x + points @ turned.T


def test_the_tooltip_of_a_point_is_what_the_table_has(real, html, opened):
    tab = opened(html, "#open=die-vertex&at=error-die-vertex&show=mujoco:euler")
    chart = tab.locator("#error-die-vertex")
    chart.locator(".point").first.wait_for()
    box = chart.locator(".touch").bounding_box()
    tooltip = tab.locator("#tooltip")
    motion = real["motion.csv"].query("scene == 'die-vertex' and engine == 'mujoco' and method == 'euler'")
    found = 0
    for mark in chart.locator(".curve .point").all():
        at = mark.bounding_box()
        x, y = at["x"] + at["width"] / 2, at["y"] + at["height"] / 2
        if not (box["x"] < x < box["x"] + box["width"] and box["y"] < y < box["y"] + box["height"]):
            continue
        tab.mouse.move(x, y)
        who, when, error = tooltip.inner_text().split("\n")
        assert who == "mujoco:euler"
        row = motion.iloc[(motion["t_s"] - float(when.split()[2])).abs().argmin()]
        if "≤" not in error:
            assert figure(error) == pytest.approx(row["error_m"], rel=0.005)
            found += 1
    assert found > 3


def figure(text: str) -> float:
    """Return a number as the page sets it: 2.31·10⁻⁴ m."""
    digits = {small: sign for sign, small in zip("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹", strict=True)}
    mantissa, _, power = text.removesuffix(" m").partition("·10")
    return float(mantissa.replace("\N{MINUS SIGN}", "-")) * 10.0 ** int("".join(digits[sign] for sign in power) or "0")


def test_a_click_hides_a_double_click_isolates_and_all_figures_follow(html, opened):
    tab = opened(html, "#show=all&open=die-vertex&at=error-die-vertex")
    chart = tab.locator("#error-die-vertex")
    chart.locator(".label").first.wait_for()
    names = [each.get_attribute("data-name") for each in chart.locator(".label").all()]
    chart.locator(f'.label[data-name="{names[0]}"]').click()
    until(tab, f"document.querySelectorAll('#error-die-vertex .label').length === {len(names) - 1}")
    assert tab.locator(f'#board tbody tr[data-name="{names[0]}"]').count() == 0
    chart.locator(f'.label[data-name="{names[1]}"]').dblclick()
    until(tab, "document.querySelectorAll('#error-die-vertex .label').length === 1")
    assert [row.get_attribute("data-name") for row in tab.locator("#board tbody tr").all()] == [names[1]]
    tab.locator('.chip[data-show="best"]').click()
    until(tab, "document.querySelectorAll('#board tbody tr').length > 2")


def test_every_figure_stands_with_nobody_shown(html, opened):
    tab = opened(html, "#show=all&open=die-vertex&at=first")
    everything_drawn(tab)
    tab.locator('.chip[data-show="none"]').click()
    until(tab, "document.querySelectorAll('#board tbody tr').length === 0")
    expect(tab.locator("#error-die-vertex")).to_contain_text("No contestant is shown")
    tab.locator('.chip[data-show="all"]').click()
    expect(tab.locator("#error-die-vertex .label").first).to_be_attached()


def test_a_hover_marks_the_same_contestant_everywhere(html, opened):
    tab = opened(html, "#show=all&open=die-vertex&at=error-die-vertex", height=2000)
    label = tab.locator("#error-die-vertex .label").first
    label.hover()
    picked = label.get_attribute("data-name")
    for chart in ("error-die-vertex", "energy-die-vertex"):
        for curve in tab.locator(f"#{chart} .curve").all():
            assert (curve.get_attribute("opacity") == "1") == (curve.get_attribute("data-name") == picked)


def test_an_address_restores_the_view(html, opened):
    tab = opened(html, "#tol=0.02&show=mujoco:euler,tumble:rk4&open=two-hits&mag=100&t=two-hits~1.25&scene=die-vertex")
    assert tab.locator("#tolerance").input_value() == "20"
    assert {row.get_attribute("data-name") for row in tab.locator("#board tbody tr").all()} == {
        "mujoco:euler",
        "tumble:rk4",
    }
    assert tab.locator("#scene-two-hits").evaluate("fold => fold.open")
    assert tab.locator("#scene-two-hits .clock").inner_text() == "1.25 s"
    assert tab.locator("#scene-two-hits select").input_value() == "100"
    assert "tumbles" in tab.locator("#hero .hero-title").inner_text()
    slider = tab.locator("#scene-two-hits .time")
    slider.focus()
    slider.press("ArrowRight")
    until(tab, "/t=two-hits/.test(location.hash) && !/1\\.25/.test(location.hash)")
    again = opened(html, tab.evaluate("location.hash"))
    assert again.locator("#scene-two-hits .clock").inner_text() == tab.locator("#scene-two-hits .clock").inner_text()


@pytest.mark.parametrize(
    "address", ["#t=two-hits~nan&tol=-1&show=nobody&open=nowhere&mag=7", "#at=nowhere", "#%", "#=&=", "#tol=1e999"]
)
def test_an_address_that_means_nothing_does_no_harm(html, opened, address):
    tab = opened(html, address)
    assert tab.locator("#answer").inner_text()


def test_a_saved_table_is_the_table(real, html, opened):
    tab = opened(html, "#open=die-vertex")
    tab.locator("#fold-runs-die-vertex > summary").click()
    with tab.expect_download() as saved:
        tab.locator("#fold-runs-die-vertex .table-tools button", has_text="CSV").click()
    text = Path(saved.value.path()).read_text(encoding="utf-8")
    told = list(csv.DictReader(io.StringIO(text)))
    rows = real["runs.csv"].query("scene == 'die-vertex'")
    assert list(told[0]) == list(rows.columns)
    assert len(told) == len(rows)
    for line, (_, row) in zip(told, rows.iterrows(), strict=True):
        for column, cell in line.items():
            assert (cell == "" and (pd.isna(row[column]) or row[column] == "")) or (
                cell == row[column] if isinstance(row[column], str) else float(cell) == row[column]
            )


def test_a_table_sorts_and_filters(html, opened):
    tab = opened(html, "#open=die-vertex")
    tab.locator("#fold-runs-die-vertex > summary").click()
    table = tab.locator("#runs-die-vertex")
    table.locator("button.sort", has_text="largest error").click()
    errors = [
        figure(cell.removeprefix("≤ ") + " m")
        for cell in table.locator("tbody tr td:nth-child(3)").all_inner_texts()
        if cell
    ]
    assert errors == sorted(errors)
    assert len(errors) > 3
    tab.locator("#fold-runs-die-vertex .find").fill("mujoco")
    assert all("mujoco" in line for line in table.locator("tbody tr").all_inner_texts())


@pytest.mark.parametrize("kind", ["SVG", "PNG"])
def test_a_figure_is_saved(html, opened, kind):
    tab = opened(html, "#open=die-vertex&at=error-die-vertex")
    tab.locator("#error-die-vertex .point").first.wait_for()
    with tab.expect_download() as saved:
        tab.locator("#error-die-vertex + .tools button", has_text=kind).click()
    content = Path(saved.value.path()).read_bytes()
    assert saved.value.suggested_filename == f"error-die-vertex.{kind.lower()}"
    assert content.startswith(b"<svg") if kind == "SVG" else content.startswith(b"\x89PNG")
    assert b"var(--" not in content
    assert len(content) > 5000


def test_a_moment_of_a_flight_is_saved_as_the_lines_that_the_stage_draws(html, opened):
    tab = opened(html, "#open=die-vertex&show=mujoco:euler&t=die-vertex~0.6&at=scene-die-vertex")
    stage = tab.locator("#scene-die-vertex canvas.stage")
    until(tab, "document.querySelector('#scene-die-vertex canvas.stage').seen")
    seen = stage.evaluate("canvas => canvas.seen['mujoco:euler']")
    with tab.expect_download() as saved:
        tab.locator("#scene-die-vertex .controls .tools button", has_text="SVG").click()
    text = Path(saved.value.path()).read_text(encoding="utf-8")
    assert text.startswith("<svg")
    ends = np.array([[float(x), float(y)] for x, y in re.findall(r"[ML](-?[\d.]+),(-?[\d.]+)", text)])
    # Each of the ghost's corners is the end of an edge.
    assert all(np.abs(ends - (x, y)).max(axis=1).min() < 0.02 for x, y, _ in seen)


def test_the_class_reports_figure_shows_who_is_shown(real, html, opened):
    tab = opened(html, "#at=class-report&show=mujoco:euler")
    bars = tab.locator("#corrections-figure .point")
    budget = real["table-4-1-budget.csv"].query("scene == 'table-4-1'")
    by_hand, engines = budget[budget["engine"] == "handcalc"], budget[budget["engine"].isin(["mujoco", "tumble"])]
    assert bars.count() == len(by_hand)
    # Whoever is as near as the calculation with all its mistakes mended shares its bar.
    last = bars.last.get_attribute("data-name")
    assert last == "handcalc:all-mended mujoco:euler"
    tab.evaluate("location.hash = '#show=none'")
    until(tab, "![...document.querySelectorAll('#corrections-figure .point')].at(-1).dataset.name.includes('mujoco')")
    expect(bars).to_have_count(len(by_hand))
    tab.evaluate("location.hash = '#show=all'")
    until(tab, "document.querySelector('#corrections-figure').textContent.includes(' contestants')")
    told = [f"{distance:.3f}" for distance in pd.concat([by_hand, engines])["max_to_application_m"]]
    assert bars.count() < len(told)
    drawn = re.findall(r"([0-9.]+) m", tab.locator("#corrections-figure").text_content() or "")
    assert set(told) <= set(drawn)
    assert len(drawn) == len(set(drawn)) == bars.count()


def test_it_moves_and_stands_still_where_that_is_preferred(html, opened):
    still = opened(html)
    still.locator("#hero canvas").scroll_into_view_if_needed()
    assert still.locator("#hero .play").get_attribute("aria-label") == "Play"
    moving = opened(html, reduced_motion="no-preference")
    until(moving, "document.querySelector('#hero .play').getAttribute('aria-label') === 'Pause'")
    before = moving.locator("#hero .clock").inner_text()
    until(moving, f"document.querySelector('#hero .clock').textContent !== '{before}'")


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_nothing_serious_for_who_cannot_see_it(html, opened, scheme):
    tab = opened(html, "#open=die-vertex", color_scheme=scheme)
    everything_drawn(tab)
    tab.locator("#fold-runs-die-vertex > summary").click()
    found = Axe().run(tab).response["violations"]
    serious = {
        each["id"]: [node["html"][:120] for node in each["nodes"][:3]]
        for each in found
        if each["impact"] in ("serious", "critical")
    }
    assert serious == {}


@pytest.mark.parametrize("width", [400, 1280, 2560])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_it_fits_every_width(html, opened, width, scheme, request):
    tab = opened(html, "#open=die-vertex", width=width, color_scheme=scheme)
    everything_drawn(tab)
    assert tab.evaluate("document.documentElement.scrollWidth") <= width
    kept = request.config.rootpath / "report" / "screenshots"
    kept.mkdir(parents=True, exist_ok=True)
    tab.screenshot(path=kept / f"page-{width}-{scheme}.png", full_page=True)


def test_it_is_printed_on_few_pages(html, opened):
    tab = opened(html)
    everything_drawn(tab)
    pages = re.findall(rb"/Type\s*/Page[^s]", tab.pdf(format="A4"))
    assert 2 <= len(pages) < 16


def test_bodies_are_printed_in_their_own_proportions(html, opened):
    """A canvas that keeps the pixels of a wide window in a narrow column would press a die into a brick."""
    tab = opened(html, "#at=matrix", width=1700)
    pictures = tab.locator("#matrix canvas")
    pictures.first.wait_for()
    tab.emulate_media(media="print")
    tab.evaluate("window.dispatchEvent(new Event('beforeprint'))")
    for picture in pictures.all():
        drawn, shown = picture.evaluate("(it) => [it.width / it.height, it.clientWidth / it.clientHeight]")
        assert drawn == pytest.approx(shown, rel=0.02)
        assert picture.evaluate("(it) => it.clientWidth") < 400, "it is drawn as wide as the paper has it"


def test_the_matrix_is_shown_where_it_has_lost_its_shape(real, html, opened):
    tab = opened(html, "#at=matrix")
    pictures = tab.locator("#matrix canvas")
    pictures.first.wait_for()
    bent, rigid = (picture.evaluate("(it) => it.toDataURL()") for picture in pictures.all())
    assert bent != rigid, "it starts where both are still one"
    clock = tab.locator("#matrix .clock").inner_text()
    scene = re.search(r"in (\S+) tumble:matrix", tab.locator("#matrix .headline").inner_text())
    assert scene
    assert float(clock.removesuffix(" s")) == pytest.approx(
        real["scenes.csv"].set_index("scene")["duration_s"][scene[1]], abs=0.005
    )


def test_names_are_below_a_figure_too_narrow_for_them(html, opened):
    tab = opened(html, "#at=cost&show=all", width=400)
    chart = tab.locator("#cost svg.chart")
    chart.locator(".label").first.wait_for()
    named = {label.get_attribute("data-name") for label in chart.locator(".label").all()}
    assert named == {curve.get_attribute("data-name") for curve in chart.locator(".curve").all()}
    box = chart.bounding_box()
    for label in chart.locator(".label text").all():
        at = label.bounding_box()
        assert box["x"] <= at["x"]
        assert at["x"] + at["width"] <= box["x"] + box["width"] + 1
    label = chart.locator(".label").first
    hidden = label.get_attribute("data-name")
    label.click()
    until(tab, f"!document.querySelector('#cost .label[data-name=\"{hidden}\"]')")


def test_an_axis_of_errors_ends_where_they_mean_nothing_any_more(real, opened):
    """At ten times the body's size; what is further off stands there, however far."""
    changed = dict(real)
    costs = real["sweep-work-precision.csv"].copy()
    worst = costs["error_m"].idxmax()
    costs.loc[worst, "error_m"] = 1e9
    changed["sweep-work-precision.csv"] = costs
    changed["motion.csv"] = real["motion.csv"].assign(
        scene=real["motion.csv"]["scene"].replace("die-vertex", "yardstick")
    )
    for file in ("points.csv", "bodies.csv", "faces.csv", "loads.csv", "deformed.csv"):
        changed[file] = real[file].assign(scene=real[file]["scene"].replace("die-vertex", "yardstick"))
    changed["scenes.csv"] = real["scenes.csv"].assign(
        scene=real["scenes.csv"]["scene"].replace("die-vertex", "yardstick")
    )
    tab = opened(page(changed), "#at=cost&show=all")
    chart = tab.locator("#cost svg.chart")
    chart.locator(".point").first.wait_for()
    ticks = [text for text in chart.locator("text").all_text_contents() if re.fullmatch(r"1.*\u202f.?m", text)]
    assert ticks
    assert not any("·10" in tick or (tick.endswith("0\u202fm") and float(tick.split()[0]) > 1) for tick in ticks), ticks
    top = chart.locator(".touch").bounding_box()["y"]
    owner = f"{costs.loc[worst, 'engine']}:{str(costs.loc[worst, 'method']).partition('@')[0]}"
    highest = min(mark.bounding_box()["y"] for mark in chart.locator(f'.curve[data-name="{owner}"] .point').all())
    assert abs(highest - top) < 8


def test_what_nobody_has_seen_yet_is_drawn_when_it_is_printed(html, opened):
    tab = opened(html)
    assert tab.locator("#matrix canvas").count() == 0, "it is drawn before it comes into view"
    tab.evaluate("window.dispatchEvent(new Event('beforeprint'))")
    pictures = tab.locator("#matrix canvas")
    assert pictures.count() == 2
    pixels = "it.getContext('2d').getImageData(0, 0, it.width, it.height).data.buffer"
    colours = f"(it) => new Set(new Uint32Array({pixels})).size"
    assert [picture.evaluate(colours) > 10 for picture in pictures.all()] == [True, True]
    # At the end, when the one has become longer than the other.
    first, second = (picture.evaluate("(it) => it.toDataURL()") for picture in pictures.all())
    assert first != second


def test_each_swept_scene_has_its_own_headline(real, opened):
    both = dict(real)
    for file, table in real.items():
        if file.startswith("sweep-") and "scene" in table.columns:
            both[file] = pd.concat([table, table.assign(scene="die-vertex")], ignore_index=True)
    tab = opened(page(both), "#cost")
    everything_drawn(tab)
    first, second = (tab.locator("#cost .headline").nth(place).inner_text() for place in (0, 1))
    assert "fastest" in first
    assert second == first, "the same runs have another headline"


def test_names_beside_limits_have_room(html, opened):
    tab = opened(html, "#stability", width=400)
    everything_drawn(tab)
    left = "(it) => it.getBoundingClientRect().left"
    for chart in tab.locator("#stability svg[id^=limits-]").all():
        assert min(name.evaluate(left) for name in chart.locator("text").all()) >= chart.evaluate(left) - 0.5


def test_whatever_a_table_says_stays_text(real, opened):
    evil = dict(real)
    evil["scenes.csv"] = real["scenes.csv"].assign(title=EVIL, source=EVIL)
    evil["conditions.csv"] = real["conditions.csv"].assign(value=EVIL)
    evil["engines.csv"] = real["engines.csv"].assign(version=EVIL, switched_off=EVIL)
    evil["runs.csv"] = real["runs.csv"].assign(status="flagged", why=EVIL)
    tab = opened(page(evil), "#open=die-vertex")
    everything_drawn(tab)
    tab.locator("#fold-runs-die-vertex > summary").click()
    expect(tab.locator("#scene-die-vertex h3")).to_contain_text(EVIL)
    expect(tab.locator("#runs-die-vertex td", has_text=EVIL).first).to_be_attached()
    assert tab.locator("img").count() == 0


def test_a_section_with_nothing_to_show_is_not_there(real, opened):
    one = {
        file: (table[table["scene"] == "tether-critical"] if "scene" in table.columns else table)
        for file, table in real.items()
    }
    one = {file: table.iloc[:0] if file.startswith("sweep-") else table for file, table in one.items()}
    tab = opened(page(one))
    for section in ("cost", "matrix", "class-report"):
        assert tab.locator(f"#{section}").count() == 0
        assert tab.locator(f'nav a[href="#{section}"]').count() == 0
    nothing = opened(page({file: table.iloc[:0] for file, table in real.items()}))
    assert nothing.locator("section h2").count() == 0


def test_the_sentence_on_the_class_report_has_the_tables_figures(real, html, opened):
    exact = real["table-4-1-budget.csv"].query("engine == 'exact'").iloc[0]
    tab = opened(html, "#class-report")
    said = tab.locator("#class-report .headline").inner_text()
    assert f"within {exact['max_to_application_m']:.3f} m" in said
    assert f"up to {exact['max_to_calculated_m']:.3f} m" in said
    assert "Unity application was right" in said


def test_the_sentence_on_agreement_is_of_a_pair_of_two_engines(real, html, opened):
    said = opened(html, "#same").locator("#same .headline").inner_text()
    found = re.match(r"No: in (\S+) (\S+) and (\S+) agree", said)
    assert found
    assert found[2].partition(":")[0] != found[3].partition(":")[0]
    assert found[1] in SCENES


def test_sentences_say_what_findings_say(real, opened):
    """Another number in findings.csv, and nothing else changed, is another number in the sentence."""
    changed = dict(real)
    found = real["findings.csv"].copy()
    found.loc[(found["finding"] == "most accurate engine") & (found["scene"] == "two-hits"), "value"] = 0.25
    found.loc[found["finding"] == "largest stable step", "value"] = 7.77
    changed["findings.csv"] = found
    tab = opened(page(changed), "#at=stability")
    assert "250\u202fmm" in tab.locator("#scene-two-hits .headline").inner_text(), (
        "the hardest of these few for engines"
    )
    assert "ω·dt = 7.77" in tab.locator("#stability .headline").inner_text()


def test_only_what_an_engine_does_where_nobody_sets_anything_is_called_its_default(real, opened):
    """Of MuJoCo only what somebody named, and PyBullet as it ships."""
    changed = {name: table for name, table in real.items() if not name.startswith("sweep-")}
    runs = real["runs.csv"]
    changed["runs.csv"] = runs[(runs["engine"] != "mujoco") | (runs["method"] == "rk4")]
    told = error_findings(
        rows(RUNS, changed["runs.csv"]), {"pybullet:multibody+defaults", "mujoco:euler"}, {"mujoco:rk4"}
    )
    changed["findings.csv"] = frame(FINDINGS, told)
    tab = opened(page(changed), "#tol=1e-12&show=all&open=two-hits")
    said = tab.locator("#answer").inner_text()
    assert re.search(r"[Dd]efault.* pybullet .* \d of \d throws\. As requested, mujoco:rk4 ", said)
    roles = {
        row.get_attribute("data-name"): row.locator("th").first.inner_text()
        for row in tab.locator("#board tbody tr").all()
    }
    assert "requested, best of its engine" in roles["mujoco:rk4"]
    assert "default settings" in roles["pybullet:multibody+defaults"]
    assert not any("default method" in role for role in roles.values())
    assert [name for name, role in roles.items() if "requested" in role] == ["mujoco:rk4"]


def test_a_horizon_is_drawn_where_a_scene_has_one(real, opened):
    changed = dict(real)
    changed["scenes.csv"] = real["scenes.csv"].assign(
        horizon_s=real["scenes.csv"]["duration_s"].where(real["scenes.csv"]["scene"] == "two-hits") / 2
    )
    tab = opened(page(changed), "#open=two-hits,die-vertex&at=scene-two-hits")
    band = tab.locator("#error-two-hits .horizon")
    expect(band).to_have_count(1)
    expect(tab.locator("#error-die-vertex .point").first).to_be_attached()
    assert tab.locator("#error-die-vertex .horizon").count() == 0
    touch = tab.locator("#error-two-hits .touch")
    # Half the flight: the band begins in the middle of the time axis.
    middle = float(touch.get_attribute("x") or 0) + float(touch.get_attribute("width") or 0) / 2
    assert abs(float(band.get_attribute("x") or 0) - middle) < 0.5


def test_a_whole_page_opens_small_and_soon(whole_page, opened):
    """The page that `make report` makes."""
    html = whole_page.read_text(encoding="utf-8")
    assert len(html.encode()) < 3_000_000
    tab = opened(html, "#show=all")
    everything_drawn(tab)
    for chart in tab.locator("svg.chart").all():
        expect(chart.locator(".point").first).to_be_attached()
    scenes = set(data_in(html)["tables"]["scenes.csv"]["values"]["scene"]["words"])
    assert set(catalogue()) <= scenes


def test_the_step_taken_stands_beside_the_one_asked_for(real, opened):
    changed = dict(real)
    runs = real["runs.csv"].copy()
    runs.loc[runs["scene"] == "two-hits", "dt_taken_s"] = 0.0019231
    changed["runs.csv"] = runs
    tab = opened(page(changed), "#open=two-hits,die-vertex&at=scene-two-hits")
    assert "s (0.001923 s taken, because samples cut the run)" in tab.locator("#scene-two-hits .facts").inner_text()
    assert "taken" not in tab.locator("#scene-die-vertex .facts").inner_text()
