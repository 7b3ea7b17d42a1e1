"""An interrupted command goes on task by task, keeps nothing unfinished, and believes no damage."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from patience import PATIENCE_S

from tumble.compare.run.provenance import ConditionRow
from tumble.compare.sweep.schemas import CLOCK, TimingRow
from tumble.compare.tables import store as room
from tumble.compare.tables.files import DRAFTS, READY, place, settle, write_folder, write_whole
from tumble.compare.tables.frames import frame
from tumble.compare.tables.shared import RUNS, RunRow
from tumble.compare.tables.store import Store

UNDER = [ConditionRow("command", "tumble sweep a b"), ConditionRow("numpy", "2.0"), ConditionRow("scene a", "0123")]


def made(scene: str) -> dict:
    return {
        "runs.csv": frame(
            RUNS,
            [
                RunRow(
                    scene=scene,
                    engine="mine",
                    method="m",
                    dt_s=0.1,
                    tolerance=None,
                    steps=10,
                    status="ok",
                    why="",
                    max_error_m=1e-3,
                    wall_s=1 / 3,
                )
            ],
        ),
        "timing.csv": frame(
            CLOCK,
            [
                TimingRow(
                    scene=scene,
                    engine="mine",
                    method="m",
                    tolerance=None,
                    unit="step",
                    ns=1.0,
                    median_ns=2.0,
                    p90_ns=3.0,
                    clock="wall",
                    finding="it waits",
                    call_ns=4.0,
                    build_s=5.0,
                    compile_s=6.0,
                    peak_bytes=7,
                    rounds=8,
                )
            ],
        ),
    }


def files(folder: Path) -> dict[str, str]:
    return {path.name: path.read_text(encoding="utf-8") for path in folder.iterdir()}


def store(folder: Path, under=UNDER) -> tuple[Store, str]:
    found = Store(folder, (RUNS, CLOCK), ["scene"], [("a",), ("b",)], under)
    return found, found.resume()


def kept(folder: Path, *scenes: str) -> Store:
    found, _ = store(folder)
    for scene in scenes:
        found.keep((scene,), made(scene))
    found.write()
    return found


def test_it_goes_on_where_it_stopped(tmp_path):
    _, said = store(tmp_path / "whole")
    assert said == ""
    kept(tmp_path / "whole", "a", "b")
    kept(tmp_path / "parts", "b")
    second, said = store(tmp_path / "parts")
    assert second.done == {("b",)}
    assert "has 1 of 2 already" in said
    kept(tmp_path / "parts", "a")
    assert files(tmp_path / "parts") == files(tmp_path / "whole")


def test_another_run_begins_anew_and_says_so(tmp_path):
    kept(tmp_path, "a")
    again, said = store(tmp_path, [*UNDER[:1], ConditionRow("numpy", "3.0"), *UNDER[2:]])
    assert again.done == set()
    assert "begun anew: numpy was 2.0, is 3.0" in said
    same, _ = store(tmp_path, [ConditionRow("command", "tumble sweep b a"), *UNDER[1:]])
    assert same.done == {("a",)}, "how it was asked is of no account"


DAMAGE = {
    "a header and nothing else": lambda text: "scene,engine\n",
    "nothing": lambda text: "",
    "half a row": lambda text: text[:-9],
    "a row less": lambda text: "".join(text.splitlines(keepends=True)[:-1]),
    "a digit": lambda text: text[::-1].replace("1", "2", 1)[::-1],
    "bytes": lambda text: "\udcff",
}


@pytest.mark.parametrize("name", ["runs.csv", "timing.csv", "conditions.csv"])
@pytest.mark.parametrize("damage", DAMAGE)
def test_damage_is_seen_taken_for_nothing_and_mended(tmp_path, name, damage):
    kept(tmp_path, "a", "b")
    whole = files(tmp_path)
    text = DAMAGE[damage](whole[name])
    (tmp_path / name).write_text(text, encoding="utf-8", errors="surrogateescape")
    again, said = store(tmp_path)
    assert again.done == set()
    assert "begun anew" in said
    assert "\n" not in said
    kept(tmp_path, "a", "b")
    assert files(tmp_path) == whole


def test_a_pipe_in_place_of_a_table_is_refused_and_not_waited_for(tmp_path):
    kept(tmp_path, "a")
    (tmp_path / "conditions.csv").unlink()
    os.mkfifo(tmp_path / "conditions.csv")
    code = f"from tumble.compare.tables.store import *; print(Store(Path({str(tmp_path)!r}), (), [], []).resume())"
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=PATIENCE_S)
    assert "not a plain file" in said.stdout


def test_nothing_is_written_where_nothing_was_done(tmp_path):
    kept(tmp_path, "a")
    whole = files(tmp_path)
    other, said = store(tmp_path, [ConditionRow("numpy", "3.0")])
    assert "begun anew" in said
    other.write()
    assert files(tmp_path) == whole, "what another run left is lost only when there is something in its place"


def test_files_are_written_now_and_then(tmp_path, monkeypatch):
    monkeypatch.setattr(room, "OFTEN_S", 0.0)
    found, _ = store(tmp_path)
    found.keep(("a",), made("a"))
    assert store(tmp_path)[0].done == {("a",)}


# A folder as a whole.

STOPPED = """
import os, signal, sys
from pathlib import Path
from tumble.compare.tables import files
count, put, fill = int(sys.argv[1]), files.put, files.fill
def stop(do):
    def wrapped(*arguments):
        global count
        if not count:
            os.kill(os.getpid(), signal.SIGKILL)
        count -= 1
        do(*arguments)
    return wrapped
files.put, files.fill = stop(put), stop(fill)
files.write_folder(Path("."), {name: "new" for name in ("a.csv", "b.csv", "c.csv")})
"""


@pytest.mark.parametrize("at", range(7))
def test_a_folder_is_old_or_new_wherever_a_kill_comes(tmp_path, at):
    names = ("a.csv", "b.csv", "c.csv")
    write_folder(tmp_path, dict.fromkeys(names, "old"))
    path = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run([sys.executable, "-P", "-c", STOPPED, str(at)], cwd=tmp_path, env=path, timeout=PATIENCE_S)
    assert done.returncode == (-signal.SIGKILL if at < 6 else 0)
    (seen,) = {place(tmp_path, name).read_text() for name in names}
    assert seen == ("old" if at < 3 else "new")
    settle(tmp_path)
    assert files(tmp_path) == dict.fromkeys(names, seen), "no draft of the dead run is left"


def test_drafts_of_the_dead_are_swept_and_of_the_living_left(tmp_path):
    dead = subprocess.run([sys.executable, "-c", "import os; print(os.getpid())"], capture_output=True, text=True)
    for pid in (dead.stdout.strip(), str(os.getppid())):
        (tmp_path / f"{DRAFTS}{pid}-x").mkdir()
        (tmp_path / f".t.csv.{pid}-x").write_text("half")
    write_whole(tmp_path / "t.csv", "whole")
    write_folder(tmp_path, {"u.csv": "whole"})
    assert {path.name for path in tmp_path.iterdir()} == {
        "t.csv", "u.csv", f"{DRAFTS}{os.getppid()}-x", f".t.csv.{os.getppid()}-x"
    }  # fmt: skip
    assert not (tmp_path / READY).exists()
