"""Shards of a command, merged: equal to the whole, in any order; what is mixed, different or missing is refused."""

import json
import math
import os
import re
import shutil
import stat
from functools import partial
from pathlib import Path

import pandas as pd
import pytest

import tumble as package
from tumble.compare.run.digest import NoValue, digest
from tumble.compare.run.execution import Incomplete, Parts, Shard
from tumble.compare.run.task_cache import TaskCache
from tumble.compare.run.timing import readings, timing
from tumble.scenarios.read import read_scene

ENGINE = """
METHODS = ("{method}",)
FEATURES = {{"gravity", "plane"}}
ABOUT = {{"version": "1", "precision": "double", "switched_off": []}}
LOG = __file__ + ".log"
def build(scene, method):
    open(LOG, "a").write(scene.name + "\\n")
    return {{}}
def write(world, states): world["states"] = states
def advance(world, n, dt): world["states"][:, 0:3] += {factor} * n * dt * world["states"][:, 7:10]
def read(world): return world["states"]
"""
# A spinning box without forces, with a sensor, and a ball that meets a plane.
SCENE = """
title = "Spinning box"
duration = 0.2
times = [0.1, 0.2]
step = 0.01
[body]
shape = "box"
size = [0.4, 0.2, 0.1]
mass = 1.0
angular_velocity = [1.0, 2.0, 3.0]
[[sensor]]
name = "imu"
kind = "imu"
rate = 10.0
"""
# The words of each command, without its engines and -o; a release of mujoco is installed beside its own.
COMMANDS = {
    "compare": ("./box.toml", "ball-drop-dead"),
    "sweep": ("./box.toml",),
    "stability": ("./box.toml",),
    "check": ("./box.toml", "ball-drop-dead", "--no-times", "--accept"),
    "releases": ("mujoco", "./box.toml", "ball-drop-dead"),
    "report": ("./box.toml",),
}
# What is measured with a clock, and what follows from it.
NOT_COMPARED = re.compile(
    r"wall_|ns$|^(ns|run_us|steps_per_s|ratio|rounds)|_(ns|us)$|per_step|time_ratio|build_s|compile_s|peak_bytes"
)
NOT_COMPARED_ROWS = {
    "conditions.csv": ("command", "other work"),
    "findings.csv": ("feature overhead",),
    "release-changes.csv": ("time",),
}
# Which clock is right, and where a method's work is done, is found in the readings.
NOT_COMPARED_COLUMNS = {"timing.csv": ("clock", "finding"), "sweep-timing.csv": ("clock", "finding")}
TIMED = ("sweep", "releases", "report")


def engines(folder: Path, factor: float = 1.0) -> list[str]:
    (folder / "one.py").write_text(ENGINE.format(method="still", factor=factor))
    (folder / "other.py").write_text(ENGINE.format(method="slow", factor=factor / 2))
    return ["-e", "./one.py", "-e", "./other.py"]


def tables(folder: Path) -> dict[str, str]:
    """Return the text of every table but for what depends on a clock, and the command line."""
    return {path.name: without_times(path) for path in sorted(folder.glob("*.csv"))}


def without_times(path: Path) -> str:
    found = pd.read_csv(path, dtype=str, keep_default_na=False)
    found = found[~found.isin(NOT_COMPARED_ROWS.get(path.name, ())).any(axis=1)]
    by_clock = [name for name in found.columns if NOT_COMPARED.search(name)]
    return found.drop(columns=[*by_clock, *NOT_COMPARED_COLUMNS.get(path.name, ())]).to_csv(index=False)


@pytest.mark.parametrize("length", [0, 1, 3, 10, 97])
@pytest.mark.parametrize("count", [1, 2, 4, 7])
def test_shards_share_a_list_out_evenly(length, count):
    blocks = [Shard(number, count).block(length) for number in range(1, count + 1)]
    assert [place for block in blocks for place in block] == [*range(length)]
    assert max(map(len, blocks)) - min(map(len, blocks)) <= 1


@pytest.mark.parametrize("command", COMMANDS)
def test_merged_shards_are_the_whole_whatever_their_order(command, tmp_path, tumble, monkeypatch):
    briefly = partial(readings.round_robin, span_s=0.0, rounds=2, budget_s=0.0)
    monkeypatch.setattr(timing, "round_robin", lambda samplers, *usual: briefly(samplers))
    monkeypatch.setattr(readings, "other_work", lambda *_: "other processes used 9.0 of 2 cores")
    (tmp_path / "box.toml").write_text(SCENE)
    # Steps of those of a file are too short to be timed.
    contestants = engines(tmp_path) if command not in TIMED else ["-e", "tumble:rk4", "-e", "mujoco:rk4"]
    words = [command, *COMMANDS[command], *([] if command == "releases" else contestants)]

    def written(*words: str, to: str) -> tuple[str, dict[str, str]]:
        """Return what a command printed, and the tables that it wrote."""
        output = f"{to}.html" if command == "report" else to
        done = tumble(*words, "-o", output)
        assert done.returncode == 0, done.stderr
        folder = tmp_path / (f"{to}-tables" if command == "report" else to)
        assert f"-o {output}" in (folder / "conditions.csv").read_text()
        return done.stdout, tables(folder)

    said, whole = written(*words, to="whole")
    logs = [tmp_path / "one.py.log", tmp_path / "other.py.log"]
    for log in logs:
        log.unlink(missing_ok=True)
    for number in (1, 2):
        done = tumble(*words, "--shard", f"{number}/2", "-o", f"s{number}")
        assert (done.returncode, done.stdout) == (0, ""), done.stderr
    runs = [log.read_text().count("\n") for log in logs if log.exists()]
    again, merged = written("merge", "s2", "s1", to="merged")
    assert merged == whole
    is_timed = command in TIMED
    if not is_timed:
        assert again.replace("merged", "whole") == said
        assert [log.read_text().count("\n") for log in logs if log.exists()] == runs, "merging runs nothing"
    for folder in ("whole", "merged"):
        folder += "-tables" * (command == "report")
        assert ("other work" in (tmp_path / folder / "conditions.csv").read_text()) == is_timed, "times have their load"


def test_what_cannot_be_merged_is_refused_in_one_line(tmp_path, tumble):
    words = ["compare", "two-hits", *engines(tmp_path)]
    for number in (1, 2):
        assert tumble(*words, "--shard", f"{number}/2").returncode == 0
    one, two = tmp_path / "shard-1-of-2", tmp_path / "shard-2-of-2"

    def refusal(*folders: Path) -> str:
        done = tumble("merge", *(folder.name for folder in folders), "-o", "merged")
        assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1), done.stderr
        assert not (tmp_path / "merged").exists() or not [*(tmp_path / "merged").iterdir()]
        return done.stderr

    def altered(change) -> Path:
        """Return a copy of the second shard whose manifest is another one."""
        copy = tmp_path / "altered"
        shutil.rmtree(copy, ignore_errors=True)
        shutil.copytree(two, copy)
        manifest = json.loads((copy / "shard.json").read_text())
        change(manifest)
        (copy / "shard.json").write_text(json.dumps(manifest))
        return copy

    assert "give shard 2/2 too" in refusal(one)
    assert "no such folder" in refusal(one, tmp_path / "nowhere")
    (tmp_path / "empty").mkdir()
    assert "no shard.json" in refusal(one, tmp_path / "empty")

    def older(manifest) -> None:
        row = next(row for row in manifest["machine"]["versions"] if row["what"] == "numpy")
        row["value"] = "0.1"

    other = altered(older)
    assert "altered ran numpy 0.1, but shard-1-of-2 " in refusal(one, other)
    assert "shard-1-of-2 ran numpy" in refusal(other, one)
    assert "different engines under the name ./one.py" in refusal(
        one, altered(lambda found: found["engines"]["./one.py"].update(source="other"))
    )
    assert "but shard-1-of-2 ran `tumble compare two-hits" in refusal(
        one, altered(lambda found: found.update(words=["tumble", "compare", "top"]))
    )
    assert "shard 2/3" in refusal(one, altered(lambda found: found.update(count=3)))
    assert "cannot be read" in refusal(one, altered(lambda found: found.pop("code")))
    # The same shard again, with times of its own, is no contradiction; another result is.
    assert tumble(*words, "--shard", "1/2", "-o", "repeated").returncode == 0
    repeated = tmp_path / "repeated"
    assert tumble("merge", one.name, repeated.name, two.name).returncode == 0
    engines(tmp_path, factor=1.5)
    assert tumble(*words, "--shard", "1/2", "-o", "changed").returncode == 0
    for file in (repeated / "tasks").iterdir():
        file.unlink()
    ours = {file.name for file in (one / "tasks").iterdir()}
    theirs = [file for file in (tmp_path / "changed" / "tasks").iterdir() if file.name not in ours]
    assert theirs, "another engine file makes other tasks"
    theirs[0].rename(repeated / "tasks" / next(name for name in ours if not (repeated / "tasks" / name).exists()))
    assert "have different results of the same task" in refusal(one, repeated, two)


def test_a_cache_serves_other_commands_and_shards_and_notices_what_changed(tmp_path, tumble):
    words = ["compare", "two-hits", *engines(tmp_path), "--cache", "cache"]
    log = tmp_path / "one.py.log"

    def ran(*words: str) -> tuple[list[str], str]:
        """Return the scenes that an engine was built for, and what the command printed."""
        log.write_text("")
        done = tumble(*words)
        assert done.returncode == 0, done.stderr
        return sorted(set(log.read_text().split())), done.stdout

    again, none = ["two-hits"], []
    found, said = ran(*words)
    assert found == again
    assert ran(*words, "--shard", "1/1", "-o", "whole")[0] == none
    assert ran("merge", "whole") == (none, said), "a shard has what it found in the cache"
    other = ["compare", "two-hits", "-e", str(tmp_path / "one.py"), "--cache", str(tmp_path / "cache")]
    assert ran(*other)[0] == none
    assert ran(*other, "--time-limit", "59")[0] == again, "another time limit may have another result"
    engines(tmp_path, factor=1.5)
    assert ran(*other)[0] == again, "another engine file has other results"
    for file in (tmp_path / "cache").iterdir():
        file.write_bytes(file.read_bytes()[:-1])
    assert ran(*other)[0] == again, "a damaged file is no result"


def test_who_shares_a_folder_can_read_what_another_saved_in_it(tmp_path):
    before = os.umask(0o027)
    try:
        TaskCache(tmp_path / "cache").save("task", ["scene"], 1.5)
    finally:
        os.umask(before)
    (file,) = (tmp_path / "cache").iterdir()
    assert stat.S_IMODE(file.stat().st_mode) == 0o640
    assert TaskCache(tmp_path / "cache").find("task", float) == 1.5


def test_the_digest_of_a_task_is_that_of_its_values(tmp_path):
    scene = read_scene("two-hits")
    assert digest(scene) == digest(read_scene("two-hits"))
    values = [
        scene,
        read_scene("die-straight"),
        1,
        1.0,
        True,
        "1",
        b"1",
        None,
        [1],
        [[1]],
        (1,),
        {1},
        {1: None},
        -0.0,
        0.0,
    ]
    assert len({digest(value) for value in values}) == len(values)
    assert digest({"a": 1, "b": 2.5}) == digest({"b": 2.5, "a": 1})
    assert digest(math.nan) == digest(math.nan)
    for odd in (lambda: 1, object(), iter([])):
        with pytest.raises(NoValue):
            digest(odd)


def test_parts_of_a_study_go_on_after_one_that_is_incomplete():
    done = []

    def incomplete():
        raise Incomplete(["a b:c"])

    def study():
        with Parts() as part:
            part(incomplete)
            done.append(part(lambda: 1))
            part(incomplete)

    with pytest.raises(Incomplete, match="2 results"):
        study()
    assert done == [1]
    with Parts() as part:
        assert part(lambda: 2) == 2


def test_python_merges_what_the_command_left(tmp_path, tumble, monkeypatch):
    words = ["compare", "die-straight", "-e", "tumble:rk4", "-e", "tumble:exact"]
    for number in (1, 2):
        assert tumble(*words, "--shard", f"{number}/2").returncode == 0
    monkeypatch.chdir(tmp_path)
    found = package.merge(["shard-2-of-2", tmp_path / "shard-1-of-2"], progress=False)
    assert sorted(found.runs.method) == ["exact", "rk4"]
    with pytest.raises(package.UserError, match="give shard 1/2 too"):
        package.merge(["shard-2-of-2"], progress=False)


def test_a_call_in_python_is_shared_out_and_merged(tmp_path, tumble, monkeypatch):
    monkeypatch.chdir(tmp_path)
    scene = package.Scene.read("die-straight").replace(name="mine", duration=0.5, times=[0.25, 0.5])
    call = partial(package.compare, scene, ["tumble:rk4", "tumble:exact"], progress=False)
    for number in (1, 2):
        with package.session(shard=(number, 2)):
            call()
            pytest.fail("a part has no result")
    folders = ["shard-2-of-2", "shard-1-of-2"]
    with package.session(merge=folders):
        merged = call()
    whole = call()
    for name, table in whole.tables.items():
        timed = [column for column in table.columns if NOT_COMPARED.search(column)]
        assert table.drop(columns=timed).equals(merged.tables[name].drop(columns=timed)), name
    with pytest.raises(package.UserError, match="give shard 1/2 too"), package.session(merge=folders[:1]):
        call()
    with pytest.raises(package.UserError, match="was run in Python"):
        package.merge(folders)
    with pytest.raises(package.UserError, match=r"shard = \(3, 2\): must be"), package.session(shard=(3, 2)):
        pass
