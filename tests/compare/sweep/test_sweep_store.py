"""An interrupted sweep goes on scene by scene, and keeps nothing of a scene that was not finished."""

from pathlib import Path

from compare.run.provenance import ConditionRow
from compare.sweep.frontier import ClockRow
from compare.sweep.store import ROW_TYPES, SweepStore
from compare.tables.rows import RunRow, table_text

UNDER = [ConditionRow("command", "tumble sweep a b"), ConditionRow("numpy", "2.0"), ConditionRow("scene a", "0123")]


def tables(scene: str) -> dict[str, str]:
    rows = {
        "runs.csv": [RunRow(scene, "mine", "m", 0.1, 10, "ok", 1e-3, wall_s=1 / 3)],
        "clock.csv": [ClockRow(scene, "mine", "m", "step", 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7)],
    }
    return {name: table_text(row_type, rows.get(name, [])) for name, row_type in ROW_TYPES.items()}


def files(folder: Path) -> dict[str, str]:
    return {path.name: path.read_text(encoding="utf-8") for path in folder.iterdir()}


def store(folder: Path, under=UNDER) -> tuple[SweepStore, str]:
    made = SweepStore(folder, ["a", "b"], under)
    return made, made.resume()


def test_it_goes_on_where_it_stopped(tmp_path):
    whole, said = store(tmp_path / "whole")
    assert said == ""
    whole.keep(tables("a"))
    whole.keep(tables("b"))
    first, _ = store(tmp_path / "parts")
    first.keep(tables("a"))
    second, said = store(tmp_path / "parts")
    assert second.done == ["a"]
    assert "has a already, with the times of then" in said
    second.keep(tables("b"))
    assert files(tmp_path / "parts") == files(tmp_path / "whole")


def test_a_scene_without_runs_is_not_done(tmp_path):
    first, _ = store(tmp_path)
    first.keep(tables("a"))
    half = files(tmp_path)["clock.csv"] + tables("b")["clock.csv"].splitlines()[1] + "\n"
    (tmp_path / "clock.csv").write_text(half)
    second, _ = store(tmp_path)
    assert second.done == ["a"]
    second.keep(tables("b"))
    assert files(tmp_path)["clock.csv"].count("\nb,") == 1


def test_another_run_begins_anew_and_says_so(tmp_path):
    first, _ = store(tmp_path)
    first.keep(tables("a"))
    again, said = store(tmp_path, [*UNDER[:1], ConditionRow("numpy", "3.0"), *UNDER[2:]])
    assert again.done == []
    assert "begun anew: numpy was 2.0, is 3.0" in said
    same, _ = store(tmp_path, [ConditionRow("command", "tumble sweep b a"), *UNDER[1:]])
    assert same.done == ["a"], "how it was asked is of no account"


def test_damaged_tables_are_not_taken_up(tmp_path):
    first, _ = store(tmp_path)
    first.keep(tables("a"))
    (tmp_path / "runs.csv").write_text("scene,engine\nhalf a row\n")
    again, said = store(tmp_path)
    assert again.done == []
    assert "cannot be read" in said
