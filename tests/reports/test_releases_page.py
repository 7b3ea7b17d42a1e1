"""The ledger of releases on the page, and who gets worse below a step."""

from pathlib import Path

import numpy as np
import pandas as pd

from tumble.compare.releases.schemas import TABLES
from tumble.compare.tables.frames import frame, kept_tables
from tumble.compare.tables.shared import FINDINGS, FindingRow
from tumble.reports.folders import gathered
from tumble.reports.page import page

LEDGER = Path(__file__).parents[2] / "docs" / "releases" / "mujoco"


def test_a_folder_of_releases_is_a_page(opened):
    tab = opened(page(gathered(LEDGER)), "#at=releases")
    said = tab.locator("#releases .headline").inner_text()
    assert "mujoco, 14 releases from 3.6.0 to 4.0.0: 3.7.0," in said
    assert "3.13.0 and 4.0.0 behave differently" in said
    tab.locator("#fold-release-changes-mujoco > summary").click()
    row = tab.locator('[id="release-changes-mujoco-4.0.0-rk4-attitude_order"]')
    assert "fourth-order" in row.inner_text(), "the notes' own words"
    assert "14 releases of mujoco, " in tab.locator("#how .headline").inner_text()
    assert tab.locator("section h2").count() == 2, "of the others there is nothing, but how it was measured"


def test_order_and_error_are_drawn_against_the_release(opened):
    found = gathered(LEDGER)
    tab = opened(page(found), "#at=releases&show=mujoco:rk4")
    runs = found["releases.csv"].query("method == 'rk4' and scene == 'brick-tumble'")
    for chart in ("orders-mujoco", "errors-mujoco-brick-tumble"):
        marks = tab.locator(f"#release-{chart} .curve .point")
        marks.first.wait_for()
        box = tab.locator(f"#release-{chart} .touch").bounding_box()
        seen = set()
        for mark in marks.all():
            at = mark.bounding_box()
            x, y = at["x"] + at["width"] / 2, at["y"] + at["height"] / 2
            tab.mouse.move(min(max(x, box["x"] + 1), box["x"] + box["width"] - 1), min(y, box["y"] + box["height"] - 1))
            who, where, *rest = tab.locator("#tooltip").inner_text().split("\n")
            assert who == "mujoco:rk4"
            release = where.partition(",")[0]
            row = runs[runs["release"] == release].iloc[0]
            assert f"order {row['attitude_order']:.1f}" in rest
            seen.add(release)
            share = (x - box["x"]) / box["width"] * 14
            assert int(share) == list(runs["release"]).index(release), "it stands at another release"
        assert len(seen) > 5
        assert "4.0.0" in seen, "where it changed"
    # The last chart is of errors: they are smaller from 4.0.0 on.
    ends = [marks.nth(at).bounding_box()["y"] for at in (0, -1)]
    assert runs["max_error_m"].iloc[-1] < runs["max_error_m"].iloc[0]
    assert ends[1] > ends[0], "a smaller error is drawn higher"
    ticks = tab.locator("#release-orders-mujoco text").all_text_contents()
    assert {"2", "3", "4", "4.0.0"} <= set(ticks)


def test_a_ledger_that_is_there_is_taken_onto_the_page_and_none_is_none(tmp_path, opened, real):
    assert kept_tables(tmp_path, TABLES) == {}
    tab = opened(page(real | kept_tables(LEDGER, TABLES)), "#at=releases")
    assert tab.locator("#releases .fold").count() == 2
    assert tab.locator("#releases svg.chart").count() == 4
    assert opened(page(real)).locator("#releases").count() == 0


def test_releases_that_all_behave_alike_have_a_headline(opened):
    found = kept_tables(LEDGER, TABLES)
    calm = {name: table.iloc[:0] if "changes" in name else table for name, table in found.items()}
    headline = opened(page(calm), "#at=releases").locator("#releases .headline").inner_text()
    assert headline == "mujoco, 14 releases from 3.6.0 to 4.0.0: each behaves like the previous one."


def test_errors_that_grow_below_a_step_are_reported_where_the_contestant_is_shown(real, opened):
    changed = dict(real)
    orders = real["sweep-orders.csv"].copy()
    at = int(np.flatnonzero(((orders["engine"] == "mujoco") & (orders["method"] == "euler")).to_numpy())[0])
    orders.loc[at, ["precision", "best_error_m", "finest_error_m", "finest_dt_s"]] = ["single", 0.025, 0.19, 1.5e-4]
    found = frame(
        FINDINGS,
        [
            FindingRow(
                finding="optimal step",
                scene="yardstick",
                engine="mujoco",
                method="euler",
                other="",
                value=2e-4,
                unit="s",
            )
        ],
    )
    changed["sweep-orders.csv"] = orders
    changed["findings.csv"] = pd.concat([real["findings.csv"], found], ignore_index=True)
    html = page(changed)
    note = opened(html, "#show=mujoco:euler&at=cost").locator("#worse-below-yardstick").inner_text()
    assert note == (
        "Smaller steps increase the error of mujoco:euler, in single precision, below 200\u202fµs, "
        "from 25\u202fmm to 190\u202fmm at 150\u202fµs."
    )
    alone = opened(html, "#show=mujoco:rk4&at=cost")
    assert "mujoco:euler" not in alone.locator("#worse-below-yardstick").inner_text()
