"""The README stays true: its commands run as printed, its scene is read, its links exist."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from patience import PATIENCE_S

ROOT = Path(__file__).parents[2]
DOCS = sorted((ROOT / "docs").glob("*.md"))
README = (ROOT / "README.md").read_text(encoding="utf-8")


def blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```", README, re.MULTILINE | re.DOTALL)


COMMANDS = [line for block in blocks("sh") for line in block.splitlines()]


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """A user's folder: the engine file and the scene that the README shows."""
    folder = tmp_path_factory.mktemp("readme")
    shutil.copy(ROOT / "tests/plugins/mine.py", folder)
    (scene,) = blocks("toml")
    (folder / "brick.toml").write_text(scene, encoding="utf-8")
    return folder


@pytest.mark.parametrize("block", blocks("sh"))
def test_the_commands_of_a_block_run_as_printed_one_after_the_other(folder, block):
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    for command in block.splitlines():
        done = subprocess.run(
            command.split(),
            cwd=folder,
            env={**os.environ, "PATH": path},
            capture_output=True,
            text=True,
            timeout=PATIENCE_S,
        )
        assert done.returncode == 0, done.stderr
        written = re.findall(r"-o (\S+)", command)
        written += [f"shard-{number}-of-{count}" for number, count in re.findall(r"--shard (\d)/(\d)", command)]
        assert all((folder / name).exists() for name in written)
        assert written or done.stdout


@pytest.mark.parametrize("block", blocks("python"))
def test_the_python_runs_as_printed(folder, block):
    done = subprocess.run(
        [sys.executable, "-P", "-"], input=block, cwd=folder, capture_output=True, text=True, timeout=PATIENCE_S
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert re.search(r"mine +step", done.stdout)
    assert re.search(r"mujoco +rk4", done.stdout)


def test_there_are_commands_to_run():
    assert len(COMMANDS) >= 7


PAGES = ["README.md", "CONTRIBUTING.md", "SECURITY.md", "CHANGELOG.md", *(f"docs/{each.name}" for each in DOCS)]


@pytest.mark.parametrize("page", PAGES)
def test_files_named_are_there(page):
    text = (ROOT / page).read_text(encoding="utf-8")
    links = [(ROOT / page).parent / name for name in re.findall(r"\]\(([^)#:]+)\)", text)]
    names = re.findall(r"`((?:solver|scenarios|compare|reports|tumble|tests|tools|docs)/[\w./-]*)`", text)
    assert [str(path) for path in (*links, *(ROOT / name for name in names)) if not path.exists()] == []


def test_the_first_commands_are_targets_of_the_makefile():
    targets = re.findall(r"^    make (\w+)", README, re.MULTILINE)
    assert targets == ["report", "lab", "test"]
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    assert all(re.search(rf"^{target}:", makefile, re.MULTILINE) for target in targets)
