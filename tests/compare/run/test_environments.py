"""Environments: what is refused or fails is one line and leaves nothing; what is there is found.

The real ones are in tests/compare/engines, one for each engine that needs it.
"""

import json
import os
import shutil
import signal
import subprocess
import sys
import zipfile
from pathlib import Path
from time import sleep

import psutil
import pytest

from tumble.compare.run.engines import environments, registry
from tumble.compare.run.engines.environments import HERE, BadEngine, located, split_release
from tumble.compare.run.engines.installing import install, remove, run, site, sweep
from tumble.compare.run.progress import no_progress
from tumble.compare.run.status import Failure, Status
from tumble.compare.run.worker import Worker

APART = next(name for name in registry.names() if registry.package(name).apart)


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch) -> Path:
    monkeypatch.setenv("TUMBLE_ENVIRONMENTS", str(tmp_path / "environments"))
    return tmp_path / "environments"


def test_a_release_is_split_off_and_its_form_is_asked_for():
    assert split_release("mujoco@3.10.0") == ("mujoco", "3.10.0")
    assert split_release("mujoco") == ("mujoco", "")
    for wrong in ("mujoco@", "mujoco@../up", "mujoco@-r x", "mujoco@>3", "handcalc@1"):
        with pytest.raises(BadEngine):
            split_release(wrong)


@pytest.fixture
def pip_alone(monkeypatch):
    """Let pip install, also where uv is: their words differ."""
    which = shutil.which
    monkeypatch.setattr(shutil, "which", lambda name, path=None: None if name == "uv" else which(name, path=path))


def test_what_is_beside_tumble_needs_no_environment():
    assert located("tumble") == ("tumble", HERE, "")
    assert located("handcalc") == ("handcalc", HERE, "")
    here = environments.beside("mujoco")
    assert located(f"mujoco@{here}") == ("mujoco", HERE, "")


def test_what_is_nowhere_says_how_to_install_it(tumble):
    assert located("mujoco@0.1") == ("mujoco", None, "not installed; tumble engines --install mujoco@0.1")
    with Worker("mujoco@0.1", 5.0) as worker:
        said = worker.describe()
    assert said == Failure(Status.MISSING, "not installed; tumble engines --install mujoco@0.1")
    done = tumble("compare", "die-straight", "-e", "mujoco@0.1:rk4", "-e", APART)
    assert done.returncode == 1
    assert "mujoco@0.1:rk4: missing: not installed; tumble engines --install mujoco@0.1" in done.stdout
    assert f"{APART}: missing: not installed; tumble engines --install {APART}" in done.stdout


def test_no_other_command_than_install_makes_anything(tumble, folder):
    tumble("compare", "die-straight", "-e", f"{APART}@1.0")
    tumble("engines")
    assert not folder.exists()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--install", "nope"), "unknown engine 'nope'"),
        (("--install", "mujoco@"), "mujoco@: a release is written as in mujoco@1.2.3"),
        (("--install", "mujoco:rk4"), "mujoco:rk4: give ENGINE or ENGINE@RELEASE, without a method"),
        (("--install", "handcalc"), "handcalc comes with Tumble: there is nothing to install"),
        (("--remove", "mujoco"), "mujoco is not installed in an environment of its own; there is none"),
    ],
)
def test_wrong_words_are_one_line(tumble, folder, words, said):
    done = tumble("engines", *words)
    assert done.returncode == 2
    assert said in done.stderr.splitlines()[-1]
    assert not folder.exists()


@pytest.mark.usefixtures("pip_alone")
def test_a_release_that_there_is_not_leaves_nothing(monkeypatch, folder):
    monkeypatch.setenv("PIP_NO_INDEX", "1")  # as without a network: no release is found anywhere
    with pytest.raises(BadEngine, match=r"mujoco@9\.9: No matching .* for mujoco==9\.9.*nothing was kept"):
        install("mujoco@9.9")
    assert list(folder.iterdir()) == []


def empty_wheel(folder: Path) -> None:
    with zipfile.ZipFile(folder / "mujoco-9.9-py3-none-any.whl", "w") as archive:
        archive.writestr("mujoco-9.9.dist-info/METADATA", "Metadata-Version: 2.1\nName: mujoco\nVersion: 9.9\n")
        archive.writestr("mujoco-9.9.dist-info/WHEEL", "Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: py3-none-any\n")
        archive.writestr("mujoco-9.9.dist-info/RECORD", "")


@pytest.mark.usefixtures("pip_alone")
def test_a_package_that_does_not_bring_the_engine_leaves_nothing(monkeypatch, tmp_path, folder):
    empty_wheel(tmp_path)
    monkeypatch.setenv("PIP_NO_INDEX", "1")
    monkeypatch.setenv("PIP_FIND_LINKS", str(tmp_path))
    with pytest.raises(BadEngine, match=r"mujoco@9\.9: installed, but it cannot be used: .*; nothing was kept"):
        install("mujoco@9.9")
    assert list(folder.iterdir()) == []


@pytest.mark.usefixtures("pip_alone")
def test_what_is_installed_is_reported_as_it_comes(monkeypatch, tmp_path):
    empty_wheel(tmp_path)
    monkeypatch.setenv("PIP_NO_INDEX", "1")
    monkeypatch.setenv("PIP_FIND_LINKS", str(tmp_path))
    told: list[str] = []
    with pytest.raises(BadEngine):
        install("mujoco@9.9", lambda what, share=1.0: told.append(what))
    assert "Installing collected packages: mujoco" in told
    assert told[-1] == "loading mujoco"
    assert max(map(len, told)) <= 60


def test_what_a_killed_installation_leaves_is_swept_when_nothing_works_in_it_any_more(monkeypatch, tmp_path, folder):
    """npm outlives the process that is killed, and goes on writing: `tumble engines` has one that takes it along."""
    npm = tmp_path / "bin" / "npm"
    npm.parent.mkdir()
    npm.write_text(f"#!/bin/sh\necho $$ > {tmp_path}/begun\nexec sleep 600\n")
    npm.chmod(0o755)
    monkeypatch.setenv("PATH", f"{npm.parent}:{os.environ['PATH']}")
    command = [sys.executable, "-P", "-c", f"from {install.__module__} import install; install('cannon')"]
    with subprocess.Popen(command, stderr=subprocess.DEVNULL) as killed:
        while not (begun := tmp_path / "begun").exists() or not begun.read_text():
            assert killed.poll() is None
            sleep(0.02)
        killed.kill()
    sleeper = int(begun.read_text())
    try:
        sweep()
        assert [path.name.startswith("making-cannon-") for path in folder.iterdir()] == [True]
    finally:
        os.kill(sleeper, signal.SIGKILL)
    for _ in range(1000):  # the kernel closes what it had open when it likes
        sweep()
        if not any(folder.iterdir()):
            return
        sleep(0.05)
    pytest.fail("it was not swept")


def test_several_are_made_at_once_and_an_interrupt_leaves_nothing(monkeypatch, tmp_path, folder):
    npm = tmp_path / "bin" / "npm"
    npm.parent.mkdir()
    npm.write_text(f"#!/bin/sh\ncd {tmp_path}\necho $$ > $$.part\nmv $$.part begun-$$\nexec sleep 600\n")
    npm.chmod(0o755)
    monkeypatch.setenv("PATH", f"{npm.parent}:{os.environ['PATH']}")
    command = [sys.executable, "-P", "-m", "tumble", "engines", "--install", "cannon", "jolt", "cannon"]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as interrupted:
        while len(begun := [*tmp_path.glob("begun-*[0-9]")]) < 2:
            assert interrupted.poll() is None
            sleep(0.02)
        interrupted.send_signal(signal.SIGINT)
        said = interrupted.communicate()[1]
    assert interrupted.returncode == 130
    assert said.splitlines() == [
        "tumble: making environments for cannon@0.20.0, jolt@1.1.0",
        "tumble: interrupted; nothing was written",
    ]
    assert list(folder.iterdir()) == []
    for each in begun:
        assert not psutil.pid_exists(pid := int(each.read_text())) or psutil.Process(pid).status() == "zombie"


def test_one_that_fails_does_not_keep_the_others_from_being_tried(tumble, monkeypatch, folder):
    place = folder / "mujoco@1.0"
    (place / "bin").mkdir(parents=True)
    (place / "bin" / "python").symlink_to(sys.executable)
    mark = {"engine": "mujoco", "release": "1.0", "python": "3.11", "packages": ["mujoco==1.0"], "size": 1}
    (place / environments.MARK).write_text(json.dumps(mark))
    monkeypatch.setenv("PIP_NO_INDEX", "1")
    monkeypatch.setenv("UV_OFFLINE", "1")
    done = tumble("engines", "--install", "mujoco@9.9", "mujoco@1.0", "mujoco@9.8")
    assert done.returncode == 2
    assert [line.partition(":")[0] for line in done.stdout.splitlines()] == ["mujoco@1.0"]
    there, making, *_, one, other = done.stderr.splitlines()
    assert there == "tumble: mujoco@1.0 is installed already"
    assert making == "tumble: making environments for mujoco@9.9, mujoco@9.8"
    assert sorted(line.split()[1] for line in (one, other)) == ["mujoco@9.8:", "mujoco@9.9:"]
    assert one.endswith("nothing was kept")
    assert other.endswith("nothing was kept")
    assert [path.name for path in folder.iterdir()] == ["mujoco@1.0"]


def test_what_is_being_made_is_not_swept(folder):
    with site("cannon", no_progress) as made:
        (made.folder / "file").touch()
        sweep()
        assert (made.folder / "file").exists()
    assert list(folder.iterdir()) == []
    (folder / "making-something-of-the-users").mkdir()
    (folder / "making-cannon-left").mkdir()
    sweep()
    assert [path.name for path in folder.iterdir()] == ["making-something-of-the-users"]


def test_a_full_disk_is_one_line():
    with pytest.raises(BadEngine, match="no space left on the disk; nothing was kept"):
        run([sys.executable, "-c", "print(1, file=open('/dev/full', 'w', buffering=1))"])


def test_what_npm_says_is_what_went_wrong_and_not_where_its_log_lies():
    said = """npm error code ETARGET
npm error notarget No matching version found for jolt-physics@99.0.0.
npm error notarget In most cases you or one of your dependencies are requesting
npm error A complete log of this run can be found in: /somewhere/debug-0.log"""
    with pytest.raises(BadEngine, match=r"^No matching version found for jolt-physics@99\.0\.0\.; nothing was kept$"):
        run([sys.executable, "-c", f"import sys; sys.exit({said!r})"])


def test_a_folder_that_cannot_be_made_is_one_line(monkeypatch, tmp_path):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("TUMBLE_ENVIRONMENTS", str(tmp_path / "file" / "below"))
    with pytest.raises(BadEngine, match="Not a directory"):
        install("mujoco@3.10.0")


def test_a_broken_environment_is_none(folder):
    place = folder / "mujoco@1.0"
    place.mkdir(parents=True)
    mark = {"engine": "mujoco", "release": "1.0", "python": "3.11", "packages": ["mujoco==1.0"], "size": 1}
    (place / environments.MARK).write_text(json.dumps(mark))  # and no interpreter
    (folder / "mujoco@2.0" / "bin").mkdir(parents=True)
    (folder / "mujoco@2.0" / environments.MARK).write_text("{")
    assert environments.environments() == []
    (place / "bin").mkdir()
    (place / "bin" / "python").symlink_to(sys.executable)
    (there,) = environments.environments()
    assert located("mujoco@1.0") == ("mujoco", there.place, "")
    assert remove("mujoco") == [there]
    assert not place.exists()
