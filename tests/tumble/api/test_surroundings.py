"""`import tumble` in other people's programs: scripts, pipes, their own compare.py, and pytest with xdist."""

import subprocess
import sys
from pathlib import Path

import pytest
from patience import PATIENCE_S

SCRIPT = """\
import tumble
print(tumble.compare(["two-hits", "brick-tumble"], ["mujoco:rk4", "tumble:rk4"]).runs.status.tolist())
"""
PROJECT = {
    "compare.py": "raise SystemExit('my compare.py was imported')\n",
    "scenarios.py": "raise SystemExit('my scenarios.py was imported')\n",
    "solver.py": "def advance(state, dt, body):\n    state[0:3] += dt * state[7:10]\n",
    "reports/__init__.py": "raise SystemExit('my reports was imported')\n",
    "tests/test_mine.py": """\
import pytest
import tumble
import solver

@pytest.mark.parametrize("scene", ["two-hits", "die-straight"])
def test_it(scene):
    runs = tumble.compare(scene, ["mujoco:rk4", solver.advance]).runs
    assert set(runs["status"]) <= {"ok", "flagged", "skipped"}
    assert len(runs) == 2
""",
}


@pytest.fixture
def project(tmp_path) -> Path:
    for name, text in PROJECT.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text, encoding="utf-8")
    return tmp_path


def python(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, *words], cwd=folder, capture_output=True, text=True, timeout=PATIENCE_S, check=False
    )


def test_a_script_without_a_guard_beside_files_of_our_names_writes_nothing_else(project):
    (project / "script.py").write_text(SCRIPT, encoding="utf-8")
    done = python(project, "script.py")
    assert (done.stdout, done.stderr, done.returncode) == ("['ok', 'ok', 'ok', 'ok']\n", "", 0)


def test_code_on_standard_input(project):
    done = subprocess.run(
        [sys.executable], input=SCRIPT, cwd=project, capture_output=True, text=True, timeout=PATIENCE_S, check=False
    )
    assert (done.stdout, done.stderr) == ("['ok', 'ok', 'ok', 'ok']\n", "")


def test_in_jupyter_the_bar_is_removed_and_the_result_is_its_answer_and_its_page(tmp_path):
    """In a real kernel: nothing is printed, each bar is replaced by nothing, and the last output is the result."""
    nbformat, nbclient = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    lines = "import tumble, tumble.api.progress as own; own.PERIOD_S = 0.02", 'tumble.compare("two-hits", "mujoco:rk4")'
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell("\n".join(lines))])
    nbclient.NotebookClient(notebook, timeout=PATIENCE_S, resources={"metadata": {"path": tmp_path}}).execute()
    *bars, result = notebook.cells[0].outputs
    assert bars
    assert {bar.output_type for bar in bars} == {"display_data"}
    assert {bar.data["text/html"] for bar in bars} == {""}
    assert result.data["text/plain"].startswith("two-hits: ")
    assert "\x1b" not in result.data["text/plain"]
    assert "<p>two-hits: " in result.data["text/html"]
    assert "srcdoc=" in result.data["text/html"]


@pytest.mark.parametrize("workers", ["0", "2"])
def test_pytest_in_a_project_of_its_own(project, workers):
    done = python(project, "-m", "pytest", "-q", "-n", workers, "-p", "no:cacheprovider", "tests")
    assert done.returncode == 0, done.stdout + done.stderr
    assert "2 passed" in done.stdout
