"""Each function gives the tables of its command: byte for byte but for measured times and the record of the call."""

import json
import re
from pathlib import Path

import pandas as pd
import pyarrow
import pytest

import tumble as api
from tumble.compare.run.engines import registry
from tumble.compare.tables.frames import read_tables

ROOT = Path(__file__).parents[3]
# Columns of run times and memory; every other cell is equal.
MEASURED = re.compile(r"_ns$|^ns$|_us$|^wall_|_per_s$|^ratio|_ratio|build_s|compile_s|peak_bytes|^rounds$")
# Rows of conditions.csv: the call, digests of tables with times in them, and what else ran.
OF_THE_CALL = re.compile(r"command|table .*|other work")


def assert_same_tables(of_command: Path, result: api.Result, folder: Path, unlike: re.Pattern[str] = MEASURED) -> None:
    result.save(folder)
    assert sorted(path.name for path in folder.iterdir()) == sorted(path.name for path in of_command.iterdir())
    for path in of_command.glob("*.csv"):
        one, other = (pd.read_csv(each, dtype=str, keep_default_na=False) for each in (path, folder / path.name))
        if path.name == "conditions.csv":
            one, other = (
                each[~each["what"].str.fullmatch(OF_THE_CALL)].reset_index(drop=True) for each in (one, other)
            )
        timed = [name for name in one.columns if unlike.search(name)]
        pd.testing.assert_frame_equal(one.drop(columns=timed), other.drop(columns=timed))
        if not timed and path.name != "conditions.csv":
            assert path.read_bytes() == (folder / path.name).read_bytes()


def test_compare(tumble, tmp_path):
    said = tumble(
        "compare", "two-hits", "brick-tumble", "-e", "tumble:rk4", "-e", "mujoco:rk4", "--dt", "0.002", "-o", "c"
    )
    result = api.compare(["two-hits", "brick-tumble"], ["tumble:rk4", "mujoco:rk4"], dt=0.002)
    assert_same_tables(tmp_path / "c", result, tmp_path / "a")
    assert said.stdout.startswith(str(result)[:60])
    with_rows = {name for name, table in result.tables.items() if len(table)}
    assert with_rows <= {path.name for path in (tmp_path / "c").iterdir()}


def test_a_difference_would_be_found(tumble, tmp_path):
    tumble("compare", "two-hits", "-e", "tumble:rk4", "--dt", "0.002", "-o", "c")
    with pytest.raises(AssertionError):
        assert_same_tables(tmp_path / "c", api.compare("two-hits", "tumble:rk4", dt=0.004), tmp_path / "a")


def test_run(tumble, tmp_path):
    tumble("run", "two-hits", "-e", "mujoco:rk4", "--dt", "0.004", "-o", "motion.csv")
    motion = api.run("two-hits", "mujoco:rk4", dt=0.004)
    written = pd.read_csv(tmp_path / "motion.csv")
    pd.testing.assert_frame_equal(written, motion, check_exact=True)
    assert (motion.attrs["units"]["v0x_m"], motion.attrs["findings"]) == ("m", ())


def test_reference_is_what_every_comparison_uses():
    true = api.reference("two-hits")
    exact = api.compare("two-hits", "tumble:exact").vertex_errors
    for vertex in (0, 7):
        own = exact[exact["vertex"] == vertex]
        assert own["true_x_m"].tolist() == true[f"v{vertex}x_m"].tolist()[1:]
        assert own["t_s"].tolist() == true["t_s"].tolist()[1:]
    assert float(true["bound_m"].max()) < 1e-14
    assert true.attrs["units"]["bound_m"] == "m"
    elsewhere = api.reference("two-hits", [0.25, 3.5])
    assert elsewhere["t_s"].drop_duplicates().tolist() == [0.0, 0.25, 3.5]


def test_stability(tumble, tmp_path):
    tumble("stability", "spin-1e2", "-e", "tumble:exact", "-o", "c")
    assert_same_tables(tmp_path / "c", api.stability("spin-1e2", "tumble:exact"), tmp_path / "a")


def test_grade(tumble, tmp_path):
    tumble("run", "brick-tumble", "-e", "mujoco:euler", "-o", "mine.csv")
    tumble("grade", "mine.csv", "--scene", "brick-tumble", "-o", "c")
    said = json.loads(tumble("grade", "mine.csv", "--scene", "brick-tumble", "--json").stdout)
    result = api.grade(tmp_path / "mine.csv", "brick-tumble")
    assert_same_tables(tmp_path / "c", result, tmp_path / "a", re.compile(r"^file$"))
    assert result.verdict == said["verdict"] == "explained"
    assert result.mistakes


@pytest.mark.parametrize("form", ["frame", "arrays", "arrow"])
def test_grade_takes_what_is_not_a_file(form):
    motion = api.run("two-hits", "mujoco:euler")
    given = {
        "frame": motion,
        "arrays": {name: motion[name].to_numpy() for name in motion.columns},
        "arrow": pyarrow.Table.from_pandas(motion),
    }[form]
    found = api.grade(given, "two-hits")
    written = api.compare("two-hits", "mujoco:euler").runs["max_error_m"].iloc[0]
    assert found.max_error_m == pytest.approx(written, rel=1e-12)
    assert found.verdict == "explained"


def test_check(tumble, tmp_path):
    tumble("check", "two-hits", "-e", "tumble:rk4", "--baseline", "c", "--no-times", "--accept")
    first = api.check("two-hits", "tumble:rk4", baseline=tmp_path / "a", accept=True, times=False)
    assert first
    for path in (tmp_path / "c").glob("*.csv"):
        if path.name != "conditions.csv":
            assert path.read_bytes() == (tmp_path / "a" / path.name).read_bytes()
    again = api.check(baseline=tmp_path / "c", times=False)
    assert again
    assert len(again.changes) == 0
    worse = api.check("two-hits", "tumble:symplectic-euler", baseline=tmp_path / "c", times=False)
    command = tumble("check", "two-hits", "-e", "tumble:symplectic-euler", "--baseline", "c", "--no-times")
    assert bool(worse) is (command.returncode == 0)
    with pytest.raises(api.UserError, match="nowhere"):
        api.check("two-hits", "tumble:rk4", baseline=tmp_path / "nowhere")


def test_scenes_and_engines(tumble):
    listed = tumble("scenes").stdout
    assert all(name in listed for name in api.scenes()["scene"])
    engines = api.engines()
    assert engines["engine"].tolist() == [name for name in registry.names() if name in set(engines["engine"])]
    assert engines.attrs["meanings"]["version"]
    assert dict(zip(engines["engine"], engines["status"], strict=True))["mujoco"] == "ok"


def test_check_engine(tumble):
    mine = str(ROOT / "tests/plugins/mine.py")
    found = api.check_engine(mine)
    said = tumble("engines", "--check", mine)
    assert found
    assert said.returncode == 0
    assert set(found.table["outcome"]) <= {"passed", "skipped"}
    assert all(check in said.stdout for check in found.table["check"])


def test_sweep(tumble, tmp_path):
    tumble("sweep", "two-hits", "-e", "tumble:rk4", "-o", "c")
    result = api.sweep("two-hits", "tumble:rk4")
    assert_same_tables(tmp_path / "c", result, tmp_path / "a")
    assert result.conditions["what"].iloc[0] == "format"


def test_advise(tumble):
    # At 1 pm rk4 needs thirty times as many steps as at 1 um: which engine is faster does not depend on the machine.
    result = api.advise("two-hits", ["tumble:rk4", "tumble:exact"], tolerance="1pm")
    said = tumble("advise", "two-hits", "--tolerance", "1pm", "-e", "tumble:rk4", "-e", "tumble:exact").stdout
    assert "tumble:exact" in result.answer
    assert "tumble:exact" in said
    assert set(read_tables({})) == set()
    assert len(result.orders) == 1
    assert "tolerance='1pm'" in result.conditions.set_index("what").loc["command", "value"]
    with pytest.raises(api.UserError, match="tolerance = '-1' is not a positive length"):
        api.advise("two-hits", tolerance=-1)


def test_ablate(tumble, tmp_path):
    tumble("ablate", "die-straight", "-e", "tumble:rk4", "-o", "c")
    result = api.ablate("die-straight", "tumble:rk4")
    assert_same_tables(tmp_path / "c", result, tmp_path / "a", re.compile(rf"{MEASURED.pattern}|^why$"))


def test_releases_of_an_engine_that_has_none_are_refused_in_one_line():
    with pytest.raises(api.UserError) as refused:
        api.releases("tumble")
    assert "\n" not in str(refused.value)
    assert "tumble" in str(refused.value)


def test_report(tumble, tmp_path):
    tumble("report", "two-hits", "-e", "tumble:rk4", "-o", "c.html")
    result = api.report("two-hits", "tumble:rk4", file=tmp_path / "a.html")
    one, other = ((tmp_path / name).read_text(encoding="utf-8") for name in ("c.html", "a.html"))
    headings = [re.findall(r"<h[123][^>]*>(.*?)</h[123]>", text) for text in (one, other)]
    assert headings[0] == headings[1] != []
    assert result.runs["status"].tolist() == ["ok"] * len(result.runs)
    assert abs(len(one) - len(other)) < 0.02 * len(one)
