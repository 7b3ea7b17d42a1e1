"""Nobody's modules are taken for another's: ours by us, the user's by his engine file, in a checkout and in a wheel."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from patience import PATIENCE_S

ROOT = Path(__file__).parents[2]
MINE = (ROOT / "tests/plugins/mine.py").read_text(encoding="utf-8")
# Names of ours, and what the file asks of them at once and while it flies.
TAKEN = ("compare", "solver", "scenarios", "reports", "tests")
ASKS = "\nimport compare, solver, scenarios, reports, tests.helper\nassert compare.WHOSE == 'mine'\n"
LATER = "\ndef remark(world):\n    import compare, solver\n    return compare.WHOSE + solver.WHOSE\n"


@pytest.fixture
def folder(tmp_path) -> Path:
    """A folder of somebody who has modules of our names beside an engine file that uses them."""
    for name in TAKEN[:-1]:
        (tmp_path / f"{name}.py").write_text("WHOSE = 'mine'\n")
    (tmp_path / "tests").mkdir()
    (tmp_path / "tests/__init__.py").touch()
    (tmp_path / "tests/helper.py").touch()
    (tmp_path / "mine.py").write_text(MINE + ASKS + LATER)
    return tmp_path


@pytest.fixture(scope="module")
def installed(tmp_path_factory) -> Path:
    """A folder with the wheel's files, as they would lie in somebody's environment."""
    home = tmp_path_factory.mktemp("wheel")
    words = [sys.executable, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-deps"]
    source = home / "source"
    subprocess.run(["git", "clone", "--quiet", ROOT, source], check=True, timeout=PATIENCE_S)
    for name in subprocess.run(
        ["git", "ls-files", "-m", "-o", "--exclude-standard"], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout.split():
        (source / name).parent.mkdir(parents=True, exist_ok=True)
        (source / name).write_bytes((ROOT / name).read_bytes()) if (ROOT / name).exists() else None
    subprocess.run([*words, "--no-build-isolation", "--target", home / "site", source], check=True, timeout=PATIENCE_S)
    return home / "site"


def flown(folder: Path, words: list[str], **more: str) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, **more}
    return subprocess.run(words, cwd=folder, env=environment, capture_output=True, text=True, timeout=PATIENCE_S)


def test_a_checkout_finds_its_own_and_the_user_his(folder):
    done = flown(folder, [sys.executable, "-m", "tumble", "run", "die-straight", "-e", "./mine.py"])
    assert done.returncode == 0, done.stderr
    assert "minemine" in done.stderr
    assert done.stdout.startswith("t_s,")


def test_what_the_user_has_not_got_is_not_ours_instead(folder):
    (folder / "solver.py").unlink()
    done = flown(folder, [sys.executable, "-m", "tumble", "run", "die-straight", "-e", "./mine.py"])
    assert done.returncode == 2
    assert "No module named 'solver'" in done.stderr


def test_a_wheel_takes_one_name(installed):
    named = {path.name for path in installed.iterdir() if path.suffix != ".dist-info" and path.name != "bin"}
    assert named == {"tumble"}


def test_a_wheel_works_beside_the_users_modules(folder, installed):
    program = (
        "import sys; from tumble.__main__ import main; code = main({words!r})\n"
        "assert not set({taken!r}) & set(sys.modules), 'a name was taken'\nsys.exit(code)"
    )
    for words in (
        ["run", "die-straight", "-e", "./mine.py"],
        ["compare", "die-straight", "-e", "tumble:rk4", "-e", "./mine.py"],
    ):
        text = program.format(words=words, taken=TAKEN)
        done = flown(folder, [sys.executable, "-P", "-c", text], PYTHONPATH=str(installed))
        assert done.returncode == 0, done.stderr
    assert (
        "minemine"
        in flown(
            folder,
            [sys.executable, "-P", "-m", "tumble", "run", "die-straight", "-e", "./mine.py"],
            PYTHONPATH=str(installed),
        ).stderr
    )


def test_a_wheel_has_every_file_of_the_rooms(installed):
    """A package that is forgotten is missed only by whoever installs it."""
    listed = subprocess.run(["git", "ls-files", "-co", "--exclude-standard"], cwd=ROOT, capture_output=True, text=True)
    rooms = ("solver", "scenarios", "compare", "reports")
    wanted = {
        name.removeprefix("tumble/")
        for name in listed.stdout.splitlines()
        if name.startswith(("tumble/", *(f"{room}/" for room in rooms))) and (ROOT / name).is_file()
    }
    here = {str(path.relative_to(installed / "tumble")) for path in (installed / "tumble").rglob("*") if path.is_file()}
    assert len(wanted) > 250
    assert wanted - here == set()
