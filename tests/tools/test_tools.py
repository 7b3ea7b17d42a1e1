"""The tools that make docs/ start as their pages say: `python -m tools.NAME`, from the repository's top."""

import subprocess
import sys
from pathlib import Path

import pytest
from patience import PATIENCE_S

ROOT = Path(__file__).parents[2]
# What others import has no main part.
TOOLS = sorted(path.stem for path in (ROOT / "tools").glob("*.py") if "__main__" in path.read_text(encoding="utf-8"))


def test_there_are_tools():
    assert {"confusion", "foreign", "scene_guide"} <= set(TOOLS)


@pytest.mark.parametrize("name", TOOLS)
def test_a_tool_starts(name):
    words = [sys.executable, "-m", f"tools.{name}", "--help"]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, timeout=PATIENCE_S)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("usage: ")


def test_no_program_is_left_in_docs():
    """But for the file that docs/check.md shows to its reader."""
    assert [path.name for path in (ROOT / "docs").rglob("*.py")] == ["test_mine.py"]


def test_no_page_or_picture_in_docs_is_large():
    """`make report` makes pages; `tools.palette` makes pictures small."""
    large = {path.name: path.stat().st_size for path in (ROOT / "docs").rglob("*") if path.stat().st_size > 200_000}
    assert large == {}
