"""Writing never destroys what is no plain file, nor what a file was besides its text."""

import os
import signal
import stat
import subprocess
import sys
import tempfile
import threading
from contextlib import contextmanager
from pathlib import Path

import pytest
from patience import PATIENCE_S

from tumble.compare.tables.files import DRAFTS, READY, place, settle, write_folder, write_together, write_whole

RUN = [sys.executable, "-P", "-m", "tumble", "run", "table-4-1", "-o"]


def test_a_link_is_followed_and_stays_a_link(tmp_path):
    (tmp_path / "there").mkdir()
    target, link, chain = tmp_path / "there" / "table.csv", tmp_path / "link.csv", tmp_path / "chain.csv"
    link.symlink_to("there/table.csv")
    chain.symlink_to(link)
    for text in ("new where the link leads", "replaced"):
        write_whole(chain, text)
        assert link.is_symlink()
        assert chain.is_symlink()
        assert target.read_text() == text
    assert sorted(os.listdir(tmp_path)) == ["chain.csv", "link.csv", "there"]
    assert os.listdir(tmp_path / "there") == ["table.csv"]


def test_a_link_that_leads_to_itself_is_refused(tmp_path):
    (tmp_path / "loop").symlink_to("loop")
    with pytest.raises(OSError, match="symbolic links"):
        write_whole(tmp_path / "loop", "text")
    assert os.readlink(tmp_path / "loop") == "loop"


def test_a_device_is_written_through(tmp_path):
    # A link, so that code that replaces what it is given would replace the link and not the machine's device.
    link = tmp_path / "null"
    link.symlink_to(os.devnull)
    subprocess.run([*RUN, str(link)], check=True, cwd=tmp_path, timeout=PATIENCE_S)
    assert link.is_symlink()
    assert stat.S_ISCHR(link.stat().st_mode)
    full = tmp_path / "full"
    full.symlink_to("/dev/full")
    done = subprocess.run([*RUN, str(full)], cwd=tmp_path, timeout=PATIENCE_S, capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.endswith("No space left on device\n")
    assert done.stderr.count("\n") == 1


def test_a_pipe_is_written_through(tmp_path):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    heard: list[str] = []
    reader = threading.Thread(target=lambda: heard.append(pipe.read_text()), daemon=True)
    reader.start()
    subprocess.run([*RUN, str(pipe)], check=True, cwd=tmp_path, timeout=PATIENCE_S)
    reader.join(timeout=PATIENCE_S)
    assert heard[0].startswith("t_s,x_m")
    assert stat.S_ISFIFO(pipe.stat().st_mode)
    assert os.listdir(tmp_path) == ["pipe"]


@pytest.mark.parametrize("where", ["| cat > table.csv", "> table.csv"])
def test_standard_output_by_its_name_is_standard_output(tmp_path, where):
    words = " ".join([*RUN, "/dev/stdout"])
    subprocess.run(["bash", "-c", f"{{ echo before; {words}; echo after; }} {where}"], cwd=tmp_path, timeout=PATIENCE_S)
    lines = (tmp_path / "table.csv").read_text().splitlines()
    assert (lines[0], lines[1][:7], lines[-1]) == ("before", "t_s,x_m", "after")


def test_a_file_keeps_its_mode_and_its_owner(tmp_path):
    private = tmp_path / "private.csv"
    private.write_text("old")
    private.chmod(0o600)
    if os.geteuid() == 0:
        os.chown(private, 1234, 2345)
    before = private.stat()
    write_whole(private, "new")
    after = private.stat()
    assert private.read_text() == "new"
    assert (after.st_mode, after.st_uid, after.st_gid) == (before.st_mode, before.st_uid, before.st_gid)


def test_a_file_that_may_not_be_written_is_not_replaced():
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "mine.csv")
        path.write_text("old")
        path.chmod(0o444)
        Path(folder).chmod(0o777)
        with nobody(), pytest.raises(PermissionError):
            write_whole(path, "new")
        assert path.read_text() == "old"
        assert os.listdir(folder) == ["mine.csv"]


@contextmanager
def nobody():
    """Be somebody who may not do everything."""
    before = os.geteuid()
    if before == 0:
        os.seteuid(65534)
    try:
        yield
    finally:
        os.seteuid(before)


def test_files_written_together_are_written_all_or_none(tmp_path):
    old, folder = tmp_path / "old.csv", tmp_path / "folder.csv"
    old.write_text("old")
    folder.mkdir()
    with pytest.raises(IsADirectoryError):
        write_together({old: "new", folder: "no file", tmp_path / "more" / "third.csv": "new"})
    assert old.read_text() == "old"
    assert [path.name for path in tmp_path.rglob("*") if path.is_file()] == ["old.csv"]


def test_a_full_stream_leaves_the_files_as_they_were(tmp_path):
    old = tmp_path / "old.csv"
    old.write_text("old")
    with pytest.raises(OSError, match="No space left"):
        write_together({old: "new", Path("/dev/full"): "more"})
    assert old.read_text() == "old"
    assert os.listdir(tmp_path) == ["old.csv"]


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


def files(folder: Path) -> dict[str, str]:
    return {path.name: path.read_text(encoding="utf-8") for path in folder.iterdir()}


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
