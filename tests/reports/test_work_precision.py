"""What each digit costs, on the page: made from the tables of a real, small sweep."""

import json
import math
import re
from dataclasses import replace
from itertools import pairwise

import pytest
import test_report
from markupsafe import escape
from test_report import EVIL, Tables, changed, plain, read

from compare.comparison.against_truth import compare
from compare.comparison.results import comparison_tables
from compare.run.participants import launched
from compare.sweep.frontier import TARGETS_M, ThrowsRow
from compare.sweep.results import MEASURED, measured
from compare.sweep.sweep import sweep
from compare.tables.frames import csv_texts
from compare.tables.rows import table_text
from reports.numerals import figure, fixed
from reports.page import page
from reports.work_precision import TIMES
from scenarios.read import read_scene
from scenarios.scene import frozen_array

# The real browser serves here too: for one module at a time, as two in one process will not start.
browser, opened = test_report.browser, test_report.opened

ENGINES = (
    "tumble:rk4",
    "tumble:symplectic-euler",
    "tumble:adaptive@1e-4",
    "tumble:adaptive@1e-8",
    "mujoco:rk4",
    "mujoco:euler",
    "pybullet:multibody",
    "handcalc:all-mended",
)
SCENE = replace(read_scene("yardstick"), duration=1.0, times=frozen_array([1.0]))
BUDGET_S = 0.02
REFERENCE = "tumble:rk4"


@pytest.fixture(scope="session")
def real() -> Tables:
    with launched(ENGINES) as participants:
        whole = comparison_tables(compare(participants, [SCENE]), participants, "tumble report")
        costs = measured([sweep(participants, SCENE, budget_s=BUDGET_S)], REFERENCE)
        return csv_texts(whole | {f"sweep-{name}": table for name, table in costs.items()})


@pytest.fixture(scope="session")
def html(real) -> str:
    return page(real)


def name(row: dict[str, str]) -> str:
    return f"{row['engine']}:{row['method'].partition('@')[0]}"


def joined(real: Tables) -> list[dict[str, str]]:
    """Return the runs that are plain results with a time."""
    return [row for row in read(real["sweep-runs.csv"]) if row["status"] == "ok" and row["wall_s"]]


def error_m(row: dict[str, str]) -> float:
    return max(float(row["max_error_m"]), float(row["limit_m"]))


def costs(html: str) -> str:
    """Return the section of the page."""
    found = re.search(r'<section id="cost">.*?\n</section>\n</section>', html, re.DOTALL)
    assert found
    return found[0]


def line(html: str, contestant: str) -> list[str]:
    """Return the cells of a contestant's line in the table of costs, as words."""
    (found,) = re.findall(
        rf'<tr><th scope="row">{contestant}</th>\n<td>.*?</tr>', costs(html).split("<details>")[0], re.S
    )
    return [plain(cell.replace("<span", " <span")) for cell in re.split(r"</t[dh]>", found)[:-1]]


def test_without_a_sweep_there_is_no_section_and_no_way_to_it(real, html):
    assert 'id="cost"' in html
    assert 'href="#cost"' in html
    absent = {file: text for file, text in real.items() if not file.startswith("sweep-")}
    empty = real | {
        f"sweep-{file}": real[f"sweep-{file}"].partition("\n")[0] + "\n" for file in (table.file for table in MEASURED)
    }
    for texts in (absent, empty):
        bare = page(texts)
        assert "#cost" not in bare
        assert 'id="cost"' not in bare
        assert "error-against-run-time" not in bare


def test_every_cost_in_the_tables_is_in_its_cell(real, html):
    verdicts = set()
    for row in read(real["sweep-digits.csv"]):
        cell = line(html, name(row))[3 + TARGETS_M.index(float(row["target_m"]))]
        verdicts.add(row["verdict"])
        if row["verdict"] == "not reached":
            assert cell == "not reached"
            continue
        sign = "≤\N{NO-BREAK SPACE}" if row["verdict"] == "at most" else ""
        assert cell.startswith(" ".join(f"{sign}{figure(float(row['flight_us']))}".split()))
        assert not row["ratio"] or f"{TIMES} {figure(float(row['ratio']))}" in cell
        assert not row["dt_s"] or cell.endswith(f"{figure(float(row['dt_s']))} s")
    assert {"reached", "not reached"} <= verdicts


def test_a_ratio_that_may_not_be_quoted_says_why(real):
    def unsteady(row: dict[str, str]) -> None:
        if name(row) == "mujoco:rk4":
            row["ratio"] = ""

    assert "passes disagree" in line(page(changed(real, "sweep-digits.csv", unsteady)), "mujoco:rk4")[4]

    def reference_gone(row: dict[str, str]) -> bool:
        row["ratio"] = ""
        return name(row) != REFERENCE

    assert "passes disagree" not in costs(page(changed(real, "sweep-digits.csv", reference_gone)))


def test_order_floor_and_parts_are_the_tables(real, html):
    for row in read(real["sweep-orders.csv"]):
        _, order, _, *_, best, attitude, translation = line(html, name(row))
        assert order == "{} {} to {}".format(
            *(fixed(float(row[key]), 2) for key in ("order", "order_low", "order_high"))
        )
        assert figure(float(row["best_error_m"])) in best
        assert figure(float(row["best_dt_s"])) in best
        assert attitude == f"{figure(float(row['attitude_m']))} {figure(float(row['dt_s']))} s"
        assert translation == figure(float(row["translation_m"]))


@pytest.mark.parametrize(("bends", "said"), [("True", "bends at"), ("False", "still falling at")])
def test_where_smaller_steps_stop_paying_is_said(real, bends, said):
    turned = changed(real, "sweep-orders.csv", lambda row: row.update(bends=bends))
    assert said in line(page(turned), "mujoco:euler")[-3]


def test_nobody_on_the_frontier_is_beaten_and_everybody_off_it_is(real, html):
    runs = [(name(row), float(row["wall_s"]), error_m(row)) for row in joined(real)]
    (said,) = re.findall(r"At errors of 10⁻³ m and below nobody is cheaper than (.*?)\.<", html)
    unbeaten = {
        one
        for one, time, error in runs
        if error <= 1e-3 and not any((t, e) != (time, error) and t <= time and e <= error for _, t, e in runs)
    }
    assert set(re.split(", | and ", said)) == unbeaten


def test_who_does_not_step_stands_aside_once(real):
    """A contestant that takes the flight in one step leaves a frontier of those that step."""

    finest = min(float(row["dt_s"]) for row in joined(real) if name(row) == "tumble:rk4")

    def at_once(row: dict[str, str]) -> bool | None:
        if name(row) != "tumble:rk4":
            return None
        row.update(max_error_m="0", wall_s="1e-9")
        return float(row["dt_s"]) == finest

    def by_flight(row: dict[str, str]) -> None:
        if name(row) == "tumble:rk4":
            row["unit"] = "flight"

    texts = changed(changed(real, "sweep-runs.csv", at_once), "sweep-clock.csv", by_flight)
    texts = changed(texts, "sweep-orders.csv", lambda row: name(row) != "tumble:rk4")
    words = plain(page(texts))
    assert "nobody is cheaper than tumble:rk4." in words
    assert "among those that step, without tumble:rk4, nobody is cheaper than" in words


def test_contestants_that_are_one_integrator_are_said_with_their_distance_and_counted(real, html):
    (pair,) = read(real["sweep-same.csv"])
    assert {f"{pair['engine_a']}:{pair['method_a']}", f"{pair['engine_b']}:{pair['method_b']}"} == {
        "mujoco:euler",
        "pybullet:multibody",
    }
    words = plain(html)
    assert "mujoco:euler and pybullet:multibody are one integrator" in words
    assert f"to {figure(float(pair['furthest_apart_m']))} m at each of the {pair['steps_compared']} steps" in words
    modes = len({name(row) for row in joined(real)})
    assert f"the {modes} engine modes on the chart are {modes - 1} curves of error against step" in words


def test_the_translation_of_a_first_order_engine_is_said_only_where_the_numbers_say_so(real, html):
    (row,) = (row for row in read(real["sweep-orders.csv"]) if name(row) == "mujoco:euler")
    (run,) = (
        run for run in joined(real) if (name(run), run["dt_s"]) == ("mujoco:euler", row["dt_s"])
    )  # at 1 s the fall is g h / 2 = 4.905 m/s of step
    assert float(row["translation_m"]) == pytest.approx(4.905 * float(row["dt_s"]), rel=1e-6)
    share = round(100 * float(row["translation_m"]) / error_m(run))
    said = re.search(r"most of the corner error from translation, (\S+)( to \d+)? %(.*?): (.*?)\.(?: |$)", plain(html))
    assert said
    assert share >= int(said[1])
    assert "g h T/2 at the step h with g = 9.81 m/s²" in said[3]
    assert "mujoco:euler" in said[4]

    def twice(row: dict[str, str]) -> None:
        if name(row) == "mujoco:euler":
            row["translation_m"] = str(2 * float(row["translation_m"]))

    assert "g h T/2" not in page(changed(real, "sweep-orders.csv", twice))
    little = changed(real, "sweep-orders.csv", lambda row: row.update(translation_m="1e-9"))
    assert "most of the corner error from translation" not in page(little)


def test_how_it_was_measured_is_said_with_the_machine_and_the_clocks_figures(real, html):
    (machine,) = (row["value"] for row in read(real["conditions.csv"]) if row["what"] == "processor")
    clock = read(real["sweep-clock.csv"])
    words = plain(html)
    assert f"this machine, {machine}" in words
    assert f"{clock[0]['rounds']} rounds" in words
    for row in clock:
        figures = [figure(float(row[key])) for key in ("ns", "median_ns", "p90_ns", "call_ns")]
        said = f"{row['engine']}:{row['method']} {row['unit']} {' '.join(figures)} {row['clock']}"
        assert said in words


def test_who_could_not_fly_and_what_is_no_plain_result_keep_their_reasons(real, html):
    assert re.search(r"handcalc:all-mended\s*</th>\s*<td[^>]*>skipped: handcalc has no gravity", costs(html))
    odd = [row for row in read(real["sweep-runs.csv"]) if row["steps"] and row["status"] != "ok"]
    assert odd, "every run is plain, so the crosses are never seen"
    assert str(escape(odd[0]["status"])) in costs(html)


def test_of_many_throws_the_median_is_drawn_with_its_band_at_the_time_of_one(real):
    spread = [
        ThrowsRow(
            "yardstick",
            row["engine"],
            row["method"],
            float(row["dt_s"] or "nan"),
            float(row["tolerance"]) if row["tolerance"] else None,
            4,
            1e-3,
            2e-2,
            3e-1,
        )
        for row in joined(real)
    ]
    html = page(real | {"sweep-throws.csv": table_text(ThrowsRow, spread)})
    assert "of 4 throws the median" in plain(html)
    filling = filled(html)
    row = next(row for row in joined(real) if name(row) == "mujoco:euler")
    (curve,) = (curve for curve in filling["curves"] if curve["contestant"] == "mujoco:euler")
    place = curve["plain"].index(True)
    assert curve["error"][place] == 2e-2
    assert curve["time"][place] == pytest.approx(float(row["wall_s"]) * 1e6 / 4, rel=1e-3)
    assert {(part["low"], part["high"]) for part in filling["spread"]} == {(1e-3, 3e-1)}


def filled(html: str) -> dict:
    """Return the tables that the chart is made from."""
    found = re.search(r'<script type="application/json">(.*?)</script>', costs(html))
    assert found
    return json.loads(found[1])["datasets"]


def test_every_run_is_a_mark_and_only_plain_ones_are_joined(real, html, opened):
    tab = opened(html)
    flown = [row for row in read(real["sweep-runs.csv"]) if row["wall_s"] and math.isfinite(error_m(row))]
    lines, points = (tab.locator(f"#cost .layer_{layer}_marks path") for layer in (4, 5))
    assert points.count() == len(flown)
    assert lines.count() == len({name(row) for row in joined(real)})
    # A line goes once through every plain run, so it has as many corners.
    corners = sum(len(re.findall("[ML]", path.get_attribute("d") or "")) for path in lines.all())
    assert corners == len(joined(real)) < len(flown)
    assert tab.locator("#cost .legend input").count() == len({name(row) for row in flown})


def test_a_point_tells_its_step_or_tolerance_and_a_contestant_can_be_hidden(real, html, opened):
    tab = opened(html)
    told = [words for curve in filled(html)["curves"] for words in curve["told"]]
    assert any(re.fullmatch(r"step \S+ s: \S+ m in \S+ µs, \d+ steps of \S+ ns", words) for words in told)
    assert any(re.fullmatch(r"tolerance \S+: \S+ m in \S+ µs", words) for words in told)
    before = tab.locator("#cost .layer_5_marks path").count()
    own = sum(
        name(row) == "tumble:rk4" and math.isfinite(error_m(row))
        for row in read(real["sweep-runs.csv"])
        if row["wall_s"]
    )
    tab.locator("#cost .legend input[value='tumble:rk4']").uncheck()
    tab.wait_for_function(f"document.querySelectorAll('#cost .layer_5_marks path').length === {before - own}")


def test_the_section_never_scrolls_a_narrow_page_sideways(html, opened):
    assert opened(html, 400).evaluate("document.documentElement.scrollWidth") <= 400


def test_a_frontier_only_falls(html):
    corners = filled(html)["frontier"]
    assert all(a["time"] <= b["time"] and a["error"] >= b["error"] for a, b in pairwise(corners))


def test_whatever_a_sweeps_table_says_stays_text(real, opened):
    evil = real
    for file in ("sweep-runs.csv", "sweep-digits.csv", "sweep-orders.csv", "sweep-clock.csv"):
        evil = changed(evil, file, lambda row: row.update(method=EVIL) if row["engine"] == "mujoco" else None)
        evil = changed(evil, file, lambda row: row.update(scene=EVIL))
    evil = changed(evil, "sweep-runs.csv", lambda row: row["status"] == "ok" or row.update(status=f"flagged: {EVIL}"))
    evil = changed(evil, "sweep-same.csv", lambda row: row.update(scene=EVIL, engine_a=EVIL))
    html = page(evil)
    assert EVIL not in html
    tab = opened(html)
    assert tab.locator("#cost-1 h3").inner_text() == EVIL
    assert tab.locator("#cost-1 tbody th", has_text=EVIL).count() > 0
    assert tab.locator("img").count() == 0
