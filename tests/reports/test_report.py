"""The page: made from the tables of a real, small comparison, read as text and opened in a real browser, offline."""

import csv
import io
import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from markupsafe import escape
from playwright.sync_api import Browser, Page, sync_playwright

from compare.comparison.against_truth import compare
from compare.comparison.results import comparison_tables
from compare.run.participants import launched
from compare.tables.frames import csv_texts
from compare.tables.rows import RunRow, table_text
from reports import die
from reports.families import joined
from reports.numerals import MINUS, SUPERSCRIPTS, TIMES_TEN, figure
from reports.page import page
from reports.rows import cells, typed
from scenarios.frames import rotation_matrix
from scenarios.mass import box_corners
from scenarios.read import read_scene

Tables = dict[str, str]
Change = Callable[[dict[str, str]], object]

SCENES = ("table-4-1", "die-vertex")
ENGINES = ("tumble:matrix-euler", "tumble:quaternion-euler", "handcalc", "mujoco:euler", "pybullet:multibody")
EVIL = "</script><script>alert(1)</script><img src=x onerror=alert(2)>"
CHROMIUM = ("chromium", "chromium-browser", "google-chrome")
QUIET = ("--no-sandbox", "--disable-background-networking", "--disable-component-update", "--disable-sync")

deterministic = settings(derandomize=True, deadline=None)


@pytest.fixture(scope="session")
def real() -> Tables:
    with launched(ENGINES) as participants:
        comparisons = compare(participants, [read_scene(name) for name in SCENES])
        return csv_texts(comparison_tables(comparisons, participants, "tumble report"))


@pytest.fixture(scope="session")
def html(real) -> str:
    return page(real)


def read(text: str) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(text)))


def written(rows: list[dict[str, str]], names: list[str]) -> str:
    out = io.StringIO()
    writer = csv.DictWriter(out, names, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return out.getvalue()


def changed(real: Tables, name: str, change: Change) -> Tables:
    """Return the tables with every row of one of them changed; a row for which change returns False is left out."""
    rows = read(real[name])
    kept = [row for row in rows if change(row) is not False]
    return {**real, name: written(kept, list(rows[0]))}


def only(real: Tables, scene: str) -> Tables:
    """Return the tables of one scene."""
    for name, text in real.items():
        if text.startswith("scene,"):
            real = changed(real, name, lambda row: row["scene"] == scene)
    return real


def plain(html: str) -> str:
    """Return a page's words without scripts, styles and tags."""
    bare = re.sub(r"<(script|style).*?</\1>", "", html, flags=re.DOTALL)
    return " ".join(re.sub(r"<[^>]+>", " ", bare).replace("&#39;", "'").split())


def test_the_sentences_on_table_4_1_carry_the_tables_figures(real, html):
    budget = {(row["engine"], row["method"]): row for row in read(real["table-4-1-budget.csv"])}
    exact, printed = budget["exact", ""], budget["handcalc", "as-printed"]
    words = plain(html)
    assert f"within {float(exact['max_to_application_m']):.3f} m of the application's positions" in words
    assert f"as far as {float(exact['max_to_calculated_m']):.3f} m from the calculated ones" in words
    assert f"calculated column to {float(printed['max_to_calculated_m']):.3f} m" in words
    for method in ("as-printed", "impulse-mended", "impulse+vertex-mended", "all-mended"):
        assert f"{float(budget['handcalc', method]['max_to_application_m']):.3f}" in words
    assert "The report's Unity application was right and its hand calculation was not" in words


def test_the_verdict_on_table_4_1_turns_with_the_numbers(real):
    def swap(row: dict[str, str]) -> None:
        row["max_to_calculated_m"], row["max_to_application_m"] = (
            row["max_to_application_m"],
            row["max_to_calculated_m"],
        )

    def level(row: dict[str, str]) -> None:
        row["max_to_calculated_m"] = row["max_to_application_m"]

    swapped = plain(page(changed(real, "table-4-1-budget.csv", swap)))
    assert "The report's hand calculation was right and its Unity application was not" in swapped
    assert "bears out neither column" in plain(page(changed(real, "table-4-1-budget.csv", level)))


def test_agreement_is_said_with_the_numbers_of_its_pair(real, html):
    (pair,) = (
        row
        for row in read(real["agreement.csv"])
        if {f"{row['engine_a']}:{row['method_a']}", f"{row['engine_b']}:{row['method_b']}"}
        == {"mujoco:euler", "pybullet:multibody"}
        and row["scene"] == "die-vertex"
    )
    # Both forget half a step of gravity, g t dt / 2; the rest is how each turns the die.
    apart, error = float(pair["apart_m"]), max(float(pair["error_a_m"]), float(pair["error_b_m"]))
    words = plain(html)
    assert f"agree to {figure(apart)} m in die-vertex, and both are {figure(error)} m from the truth" in words


def test_every_run_is_in_the_page_and_an_error_below_the_limit_is_shown_as_the_limit(real, html):
    below = 0
    words = plain(html)
    for row in read(real["runs.csv"]):
        if row["max_error_m"]:
            assert f"{row['engine']}:{row['method']}" in words
            error, limit = float(row["max_error_m"]), float(row["limit_m"])
            below += error <= limit
            name = re.escape(f"{row['engine']}:{row['method']} ")
            cell = f"≤ {figure(limit)} " if error <= limit else f"{figure(error)} "
            assert re.search(name + re.escape(cell), words)
    assert below, "no run is within the limit, so that form was never seen"


def test_who_could_not_fly_is_one_row_with_its_reason(html):
    folded = re.findall(r"<tr class=\"skipped\">.*?</tr>", html, flags=re.DOTALL)
    assert len(folded) == 1
    words = plain(folded[0])
    assert words.startswith("handcalc: 8 methods skipped: handcalc has no gravity")
    assert "as-printed" in words


def test_a_section_with_nothing_to_show_is_not_there(real, html):
    sections = ('id="table-4-1"', 'id="thrown-die"', 'id="agreement"', 'id="scene-2"', 'class="chart"')
    assert all(section in html for section in sections)
    cube = page(only(real, "table-4-1"))
    assert 'id="table-4-1"' in cube
    assert 'id="thrown-die"' not in cube
    assert 'id="scene-2"' not in cube
    thrown = page(only(real, "die-vertex"))
    assert 'id="table-4-1"' not in thrown
    assert 'id="thrown-die"' in thrown
    nothing = page({name: text.partition("\n")[0] + "\n" for name, text in real.items()})
    assert not any(section in nothing for section in sections)
    assert "vegaEmbed" not in nothing


def test_a_scene_without_a_truth_says_why_and_shows_no_errors(real):
    bare = only(real, "die-vertex")
    bare = changed(bare, "scenes.csv", lambda row: row.update(truth="tethers are not yet true", bound_m="", floor_m=""))
    errors = ("max_error_m", "rms_error_m", "final_error_m", "limit_m")
    drifts = ("energy_drift", "momentum_drift", "angular_momentum_drift")
    bare = changed(bare, "runs.csv", lambda row: row.update(dict.fromkeys((*errors, *drifts), "")))
    for name in ("vertex-errors.csv", "error-over-time.csv", "agreement.csv"):
        bare = changed(bare, name, lambda row: False)
    html = page(bare)
    assert "none: tethers are not yet true" in plain(html)
    assert "time per step" in html
    assert "max error" not in html
    assert 'class="chart"' not in html


def test_a_run_that_diverged_keeps_its_reason_and_its_curve_as_far_as_it_goes(real):
    def lose(row: dict[str, str]) -> None:
        if (row["scene"], row["engine"]) == ("die-vertex", "mujoco"):
            row.update({name: "inf" for name in row if name.endswith("_error_m")}, status="diverged at 0.7 s")

    def cut(row: dict[str, str]) -> None:
        if (row["scene"], row["engine"]) == ("die-vertex", "mujoco") and float(row["t_s"]) >= 0.7:
            row["error_m"] = "inf" if float(row["t_s"]) < 1.0 else "nan"

    html = page(changed(changed(real, "runs.csv", lose), "error-over-time.csv", cut))
    assert re.search(r'<tr class="diverged">.*?∞.*?diverged at 0\.7 s', html, flags=re.DOTALL)
    assert not re.search(
        r"[\[,:] ?(NaN|Infinity)", "".join(re.findall(r"application/json[^>]*>(.*?)</script>", html, re.DOTALL))
    )


def test_the_same_tables_make_the_same_page_in_another_process(real, html):
    """In which sets and hashes have another order."""
    program = (
        "import json, sys; from reports.page import page; sys.stdout.buffer.write(page(json.load(sys.stdin)).encode())"
    )
    other = subprocess.run(
        [sys.executable, "-c", program],
        input=json.dumps(real).encode(),
        capture_output=True,
        check=True,
        env={**os.environ, "PYTHONHASHSEED": "1"},
    )
    assert other.stdout.decode() == html


@deterministic
@given(st.floats(-1e300, 1e300))
def test_a_figure_reads_back_to_its_three_digits(value):
    digits = {small: sign for sign, small in SUPERSCRIPTS.items()}
    mantissa, _, power = figure(value).replace(MINUS, "-").partition(TIMES_TEN)
    back = float(mantissa + ("e" + "".join(digits[small] for small in power) if power else ""))
    # Half a unit of the third digit is at most 1/200 of the number; below the normal numbers they are fewer.
    assert abs(back - value) <= 0.00501 * abs(value) + 5e-324


@deterministic
@given(st.lists(st.tuples(st.integers(0, 12), st.integers(0, 12)).map(lambda pair: tuple(map(str, pair)))))
def test_families_are_disjoint_and_hold_every_pair(pairs):
    groups = joined(pairs)
    members = [member for group in groups for member in group]
    assert len(members) == len(set(members))
    assert all(any(set(pair) <= set(group) for group in groups) for pair in pairs)
    assert set(members) == {member for pair in pairs for member in pair}


def test_a_table_reads_back_as_the_rows_it_was_written_from():
    rows = [
        RunRow("a,b", 'say "x"', "m", 0.1, None, None, "skipped", "two\nlines"),
        RunRow("s", "e", "", 1e-3, None, 7, "ok", "", 0.1 + 0.2),
    ]
    said = [replace(rows[0], status="skipped: two\nlines"), rows[1]]
    assert list(typed(RunRow, cells(table_text(RunRow, rows)))) == said


@deterministic
@given(st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda q: np.linalg.norm(q) > 0.1))
def test_a_drawn_box_hides_exactly_the_faces_that_look_away(q):
    turn = rotation_matrix(np.array(q) / np.linalg.norm(q))
    vertices = box_corners(np.array((0.4, 0.15, 0.1))) @ turn.T + (0.3, -1.2, 0.7)
    towards_eye = turn.T @ die.TOWARDS_EYE
    # A face seen edge-on to rounding may go either way.
    sure = np.abs(towards_eye) > 1e-12
    drawn = die.box(vertices).count('class="face"')
    assert np.count_nonzero(sure) <= drawn <= 3
    assert np.allclose(sorted(die.edge_lengths(vertices)), [0.1] * 4 + [0.15] * 4 + [0.4] * 4)
    assert die.volume(vertices) == pytest.approx(0.4 * 0.15 * 0.1)


def test_opposite_faces_of_the_die_add_up_to_seven():
    pairs = list(zip(die.EYES[::2], die.EYES[1::2], strict=True))
    assert [sum(pair) for pair in pairs] == [7, 7, 7]
    for first, second in zip(die.FACES[::2], die.FACES[1::2], strict=True):
        assert not set(first) & set(second)


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    found = next(filter(None, map(shutil.which, CHROMIUM)), None)
    if found is None:
        pytest.skip(f"none of {', '.join(CHROMIUM)} is installed, and the page must be seen in a real browser")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=found, args=[*QUIET, "--no-first-run"])
        yield browser
        browser.close()


@pytest.fixture
def opened(browser, tmp_path) -> Iterator[Callable[..., Page]]:
    """Open a page from its file, offline; afterwards no request but for that file, and no word in the console."""
    contexts, heard, asked = [], [], []

    def open_page(html: str, width: int = 1300) -> Page:
        file = tmp_path / "report.html"
        file.write_text(html, encoding="utf-8")
        context = browser.new_context(viewport={"width": width, "height": 900}, offline=True)
        contexts.append(context)
        tab = context.new_page()
        tab.on("console", lambda message: heard.append(message.text))
        tab.on("pageerror", lambda error: heard.append(str(error)))
        tab.on("dialog", lambda dialog: (heard.append(dialog.message), dialog.dismiss()))
        tab.on("request", lambda request: asked.append(request.url))
        tab.goto(file.as_uri())
        drawn = "[...document.querySelectorAll('.canvas')].every(canvas => canvas.querySelector('.mark-line path'))"
        tab.wait_for_function(drawn, timeout=10_000)
        return tab

    yield open_page
    for context in contexts:
        context.close()
    assert heard == []
    assert {url.rpartition("/")[2] for url in asked} == {"report.html"}
    assert all(url.startswith("file:///") for url in asked)


def lines_drawn(tab: Page, scene: int) -> int:
    return tab.locator(f"#scene-{scene} .layer_2_marks path").count()


def test_every_contestant_with_errors_has_a_curve_that_can_be_hidden_and_read(real, html, opened):
    tab = opened(html)
    for number, scene in enumerate(SCENES, start=1):
        flown = {(row["engine"], row["method"]) for row in read(real["error-over-time.csv"]) if row["scene"] == scene}
        assert lines_drawn(tab, number) == len(flown) > 0
        assert tab.locator(f"#scene-{number} .legend input").count() == len(flown)
    before = lines_drawn(tab, 2)
    tab.locator("#scene-2 .legend input").first.uncheck()
    tab.wait_for_function(f"document.querySelectorAll('#scene-2 .layer_2_marks path').length === {before - 1}")
    tab.locator("#scene-2 .layer_4_marks path").last.hover(force=True)
    told = tab.locator("#vg-tooltip-element")
    told.wait_for(state="visible")
    assert re.fullmatch(r"\S+:\S+ at [0-9.]+ s: .+ m(, the limit)?", told.inner_text().strip())


def test_the_dice_are_drawn(html, opened):
    tab = opened(html)
    assert tab.locator("#table-4-1 .pictures svg").count() == 5
    assert tab.locator("#table-4-1 .pictures .by-hand").count() == 5
    assert tab.locator("#thrown-die .pictures svg").count() == 12
    boxes = tab.locator("#thrown-die .pictures svg").all()
    assert all(1 <= box.locator(".face").count() <= 3 for box in boxes)
    # The matrix has stretched the die of Figure 2, so at the last time it is drawn larger than that of Figure 3.
    area = "svg => { const box = svg.getBBox(); return box.width * box.height; }"
    assert boxes[5].evaluate(area) > 1.05 * boxes[11].evaluate(area)


@pytest.mark.parametrize("width", [400, 1300])
def test_the_page_never_scrolls_sideways(html, opened, width):
    tab = opened(html, width)
    assert tab.evaluate("document.documentElement.scrollWidth") <= width


def test_whatever_a_table_says_stays_text(real, opened):
    evil = real
    evil = changed(evil, "scenes.csv", lambda row: row.update(title=EVIL, source=EVIL))
    evil = changed(evil, "engines.csv", lambda row: row.update(version=EVIL, switched_off=EVIL))
    evil = changed(evil, "conditions.csv", lambda row: row.update(value=EVIL))
    for name in ("runs.csv", "error-over-time.csv", "vertex-errors.csv"):
        evil = changed(evil, name, partial(rename, engine="pybullet", to=EVIL))
    evil = changed(evil, "runs.csv", lambda row: row["engine"] != EVIL or row.update(status=f"flagged: {EVIL}"))
    evil = changed(evil, "agreement.csv", lambda row: False)
    html = page(evil)
    assert EVIL not in html
    assert str(escape(EVIL)) in html
    tab = opened(html)
    assert tab.locator("#scene-1 h2").inner_text() == EVIL
    assert tab.locator("#scene-1 tbody th", has_text=EVIL).count() > 0
    assert tab.locator("img").count() == 0


def rename(row: dict[str, str], engine: str, to: str) -> None:
    if row["engine"] == engine:
        row["engine"] = to
