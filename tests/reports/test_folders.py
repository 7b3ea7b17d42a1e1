"""`tumble report --from`: the same page without flying, and what changed between two folders."""

import re

import numpy as np
import pytest
from conftest import data_in

from tumble.compare.comparison.ensemble_rows import QUANTILES
from tumble.compare.comparison.schemas import ENSEMBLE_ERRORS
from tumble.compare.tables.files import write_folder
from tumble.compare.tables.frames import csv_texts, frame
from tumble.reports.folders import changes, gathered
from tumble.reports.page import page


@pytest.fixture
def folder(real, tmp_path):
    write_folder(tmp_path / "one", csv_texts(real))
    return tmp_path / "one"


def test_the_page_of_a_folder_is_the_page_of_its_tables(html, folder, tmp_path, tumble):
    done = tumble("report", "--from", str(folder), "-o", "page.html")
    assert done.returncode == 0, done.stderr
    drawn = data_in((tmp_path / "page.html").read_text(encoding="utf-8"))
    run = data_in(html)
    assert drawn["tables"] == run["tables"]
    assert drawn["films"] == run["films"]


def test_a_sweeps_folder_draws_its_costs(real, tmp_path):
    swept = {name.removeprefix("sweep-"): table for name, table in real.items() if name.startswith("sweep-")}
    write_folder(tmp_path / "swept", csv_texts(swept | {"conditions.csv": real["conditions.csv"]}))
    assert {"sweep-runs.csv", "sweep-accuracy-cost.csv", "conditions.csv"} <= set(gathered(tmp_path / "swept"))
    assert "runs.csv" not in gathered(tmp_path / "swept")


def test_a_run_that_blew_up_is_read_back_and_drawn_by_nobody(real, tmp_path, opened):
    lost = real["sweep-work-precision.csv"].copy()
    lost.loc[0, ["error_m", "status"]] = [np.nan, "diverged"]
    write_folder(tmp_path / "lost", csv_texts(real | {"sweep-work-precision.csv": lost}))
    found = gathered(tmp_path / "lost")
    assert np.isnan(found["sweep-work-precision.csv"]["error_m"][0])
    tab = opened(page(found), "#show=all&at=cost")
    assert tab.locator("#cost svg.chart .curve").count() > 3


def test_very_many_throws_are_drawn_up_to_the_rarest_that_there_is(real, tmp_path, opened):
    run = real["runs.csv"].query("status == 'ok'").iloc[0]
    errors = {column: 1e-9 * share / (1 - share) for column, share in QUANTILES.items()}
    named = {column: run[column] for column in ("scene", "engine", "method", "dt_s", "tolerance", "status")}
    counts = {"members": 200_000, "unknown": 10, "lost": 0, "max_error_m": 1e-3, "quantile_error": 2.0**-7}
    table = frame(ENSEMBLE_ERRORS, []).reindex([0]).assign(**named, **counts, **errors)
    write_folder(tmp_path / "throws", csv_texts(real | {"ensemble-errors.csv": table}))
    tab = opened(page(gathered(tmp_path / "throws")), f"#show=all&at=scene-{run.scene}")
    tab.locator(f"#throws-{run.scene} .curve").wait_for()
    assert tab.locator(f"#throws-{run.scene} .point").count() == len(QUANTILES), "not 1 in 1e6 throws, but the largest"
    assert "200000 throws" in tab.locator(f"#scene-{run.scene} h4").first.inner_text()


def test_a_record_of_check_is_drawn(tumble, tmp_path):
    made = tumble(
        "check", "die-vertex", "-e", "tumble:rk4", "-e", "mujoco:euler", "--accept", "--no-times", "-o", "kept"
    )
    assert made.returncode == 0, made.stderr
    done = tumble("report", "--from", "kept", "-o", "page.html")
    assert done.returncode == 0, done.stderr
    carried = data_in((tmp_path / "page.html").read_text(encoding="utf-8"))["tables"]
    assert set(carried["runs.csv"]["values"]["method"]["words"]) == {"rk4", "euler"}


def test_what_changed_is_what_was_changed(real):
    later = dict(real)
    runs = real["runs.csv"].copy()
    hit = (runs["scene"] == "die-vertex") & (runs["engine"] == "mujoco") & (runs["method"] == "euler")
    runs.loc[hit, "max_error_m"] *= 3
    lost = (runs["scene"] == "two-hits") & (runs["method"] == "rk4") & (runs["engine"] == "mujoco")
    later["runs.csv"] = runs.loc[~lost]
    found = changes(real, later)["changed-runs.csv"]
    assert len(found) == 2
    one = found[found["scene"] == "die-vertex"].iloc[0]
    assert one["ratio"] == pytest.approx(3)
    gone = found[found["scene"] == "two-hits"].iloc[0]
    assert gone["status_after"] == "not there"
    assert np.isnan(gone["ratio"])
    assert changes(real, real)["changed-runs.csv"].empty


def test_the_page_reports_it(real, opened):
    later = dict(real)
    later["runs.csv"] = real["runs.csv"].assign(max_error_m=real["runs.csv"]["max_error_m"] * 10)
    tab = opened(page(later | changes(real, later)), "#at=changed")
    assert "less accurate" in tab.locator("#changed .headline").inner_text()


def test_runs_that_one_folder_has_alone_are_neither_more_nor_less_accurate(real, opened):
    earlier, later = dict(real), dict(real)
    runs = real["runs.csv"]
    earlier["runs.csv"], later["runs.csv"] = runs[runs["scene"] != "two-hits"], runs[runs["scene"] != "die-vertex"]
    tab = opened(page(later | changes(earlier, later)), "#at=changed")
    added, removed = ((runs["scene"] == scene).sum() for scene in ("two-hits", "die-vertex"))
    headline = tab.locator("#changed .headline").inner_text()
    assert re.findall(r"\d+", headline) == [f"{added}", f"{removed}"]


def test_runs_that_finish_in_one_folder_only_are_counted(real, opened):
    runs = real["runs.csv"]
    hit = (runs["scene"] == "die-vertex") & (runs["status"] == "ok")
    crashed = real | {
        "runs.csv": runs.assign(
            status=runs["status"].mask(hit, "crashed: signal 11"), max_error_m=runs["max_error_m"].mask(hit)
        )
    }
    for earlier, later, words in (real, crashed, "no longer finish"), (crashed, real, "now finish"):
        tab = opened(page(later | changes(earlier, later)), "#at=changed")
        headline = tab.locator("#changed .headline").inner_text()
        assert re.findall(r"\d+", headline) == [f"{hit.sum()}", "0", "0", f"{hit.sum()}"]
        assert headline.endswith(f" {words}.")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--from", "nowhere"), "nowhere: no such folder"),
        (("--from", "."), "has no tables"),
        (("die-vertex", "--from", "."), "--from draws"),
        (("--from", ".", "--from", ".", "--from", "."), "at most two folders"),
    ],
)
def test_the_users_mistakes_are_one_line(tumble, words, said):
    done = tumble("report", *words)
    assert done.returncode == 2
    assert said in done.stderr
    assert len(done.stderr.splitlines()) == 1
