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

from compare.comparison.findings import error_findings
from compare.tables.frames import frame, rows
from compare.tables.known import schema
from compare.tables.shared import FINDINGS, RUNS
from reports.page import TEMPLATES, page, whole_script
from scenarios.frames import rotation_matrix
from scenarios.read import catalogue

EVIL = "</script><script>alert(1)</script><img src=x onerror=alert(2)>"
TOWARDS_EYE = np.array((0.55, 0.5, 1.0)) / np.linalg.norm((0.55, 0.5, 1.0))
RIGHT = np.cross((0.0, 1.0, 0.0), TOWARDS_EYE)
RIGHT /= np.linalg.norm(RIGHT)
UP = np.cross(TOWARDS_EYE, RIGHT)
SECTIONS = ("scenes", "cost", "stability", "same", "matrix", "class-report", "how")


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
    seen = set()
    for line in tab.locator("#board tbody tr").all():
        contestant = line.get_attribute("data-name")
        for scene, cell in zip(titles, line.locator("td.cell").all(), strict=True):
            kind = cell.get_attribute("class").split("v-")[1]
            seen.add(kind)
            (run,) = (
                row for row in real["runs.csv"].to_dict("records") if (name(row), row["scene"]) == (contestant, scene)
            )
            error, limit = run["max_error_m"], run["limit_m"]
            if run["status"].startswith("skipped"):
                assert kind == "skipped"
            elif run["status"] == "ok":
                assert kind == ("exact" if error <= limit else "within" if error <= 0.01 else "beyond")
                assert metres(cell.locator(".figure").inner_text()) == pytest.approx(max(error, limit), rel=0.051)
    assert {"skipped", "within", "beyond", "flagged"} <= seen


def metres(text: str) -> float:
    """Return a length as the board has it: 410mm, ≤11fm."""
    found = re.fullmatch(r"≤?([0-9.]+)([afpnµm]?)m", text)
    assert found, text
    return float(found[1]) * {"": 1.0, "m": 1e-3, "µ": 1e-6, "n": 1e-9, "p": 1e-12, "f": 1e-15, "a": 1e-18}[found[2]]


def test_another_tolerance_changes_the_answer_and_the_address(html, opened):
    tab = opened(html)
    before = tab.locator("#answer").inner_text()
    assert "1\u202fmm" in before
    tab.locator("#tolerance").fill("5")
    tab.locator("#tolerance").press("Enter")
    until(tab, "location.hash.includes('tol=0.005')")
    assert "5\u202fmm" in tab.locator("#answer").inner_text()


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


def test_what_is_told_of_a_point_is_what_the_table_has(real, html, opened):
    tab = opened(html, "#open=die-vertex&at=error-die-vertex&show=mujoco:euler")
    chart = tab.locator("#error-die-vertex")
    chart.locator(".point").first.wait_for()
    box = chart.locator(".touch").bounding_box()
    told = tab.locator("#told")
    motion = real["motion.csv"].query("scene == 'die-vertex' and engine == 'mujoco' and method == 'euler'")
    found = 0
    for mark in chart.locator(".curve .point").all():
        at = mark.bounding_box()
        x, y = at["x"] + at["width"] / 2, at["y"] + at["height"] / 2
        if not (box["x"] < x < box["x"] + box["width"] and box["y"] < y < box["y"] + box["height"]):
            continue
        tab.mouse.move(x, y)
        who, when, error = told.inner_text().split("\n")
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
    expect(tab.locator("#error-die-vertex")).to_contain_text("Nobody is shown")
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
    bars = tab.locator("#mending-figure .point")
    by_hand = real["table-4-1-budget.csv"].query("scene == 'table-4-1' and engine == 'handcalc'")
    expect(bars).to_have_count(len(by_hand) + 1)
    assert bars.last.get_attribute("data-name") == "mujoco:euler"
    tab.evaluate("location.hash = '#show=none'")
    expect(bars).to_have_count(len(by_hand))


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
    assert "does it soonest" in first
    assert second == first, "the same runs are told as others"


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
    assert f"as far as {exact['max_to_calculated_m']:.3f} m" in said
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
    found.loc[(found["finding"] == "nearest engine") & (found["scene"] == "two-hits"), "value"] = 0.25
    found.loc[found["finding"] == "longest step", "value"] = 7.77
    changed["findings.csv"] = found
    tab = opened(page(changed), "#at=stability")
    assert "250\u202fmm" in tab.locator("#scene-two-hits .headline").inner_text()
    assert "ω·dt = 7.77" in tab.locator("#stability .headline").inner_text()


def test_only_what_an_engine_does_where_nobody_sets_anything_is_called_its_default(real, opened):
    """Of MuJoCo only what somebody named, and PyBullet as it ships."""
    changed = {name: table for name, table in real.items() if not name.startswith("sweep-")}
    runs = real["runs.csv"]
    changed["runs.csv"] = runs[(runs["engine"] != "mujoco") | (runs["method"] == "rk4")]
    told = error_findings(rows(RUNS, changed["runs.csv"]), {"pybullet:multibody+defaults", "mujoco:euler"})
    changed["findings.csv"] = frame(FINDINGS, told)
    tab = opened(page(changed), "#tol=1e-12&show=all&open=two-hits")
    said = tab.locator("#answer").inner_text()
    assert re.search(r"left at its default, pybullet manages \d of \d throws; as asked, mujoco:rk4 manages", said)
    roles = {
        row.get_attribute("data-name"): row.locator("th").first.inner_text()
        for row in tab.locator("#board tbody tr").all()
    }
    assert "as asked, its best" in roles["mujoco:rk4"]
    assert "as it ships" in roles["pybullet:multibody+defaults"]
    assert not any("its default" in role for role in roles.values())


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


@pytest.mark.parametrize("which", ["committed", "made now"])
def test_a_whole_page_opens_small_and_soon(which, opened, request):
    """The page that is committed, and the one that `make report` makes."""
    committed = request.config.rootpath / "docs/example.html"
    file = committed if which == "committed" else request.getfixturevalue("whole_page")
    html = file.read_text(encoding="utf-8")
    assert len(html.encode()) < 3_000_000
    tab = opened(html, "#show=all")
    everything_drawn(tab)
    for chart in tab.locator("svg.chart").all():
        expect(chart.locator(".point").first).to_be_attached()
    scenes = set(data_in(html)["tables"]["scenes.csv"]["values"]["scene"]["words"])
    assert set(catalogue()) <= scenes


def test_the_committed_page_is_drawn_as_pages_are_now(request):
    """After a change of the page's script or style: `make docs`."""
    html = (request.config.rootpath / "docs/example.html").read_text(encoding="utf-8")
    assert whole_script() in html
    assert (TEMPLATES / "page.css").read_text(encoding="utf-8") in html
    carried = data_in(html)["tables"]
    assert all(list(carried[name]["columns"]) == schema(name).names for name in ("runs.csv", "findings.csv"))


def test_the_step_taken_stands_beside_the_one_asked_for(real, opened):
    changed = dict(real)
    runs = real["runs.csv"].copy()
    runs.loc[runs["scene"] == "two-hits", "dt_taken_s"] = 0.0019231
    changed["runs.csv"] = runs
    tab = opened(page(changed), "#open=two-hits,die-vertex&at=scene-two-hits")
    assert "s (0.001923 s taken, because samples cut the run)" in tab.locator("#scene-two-hits .facts").inner_text()
    assert "taken" not in tab.locator("#scene-die-vertex .facts").inner_text()
