"""The guides: every command that they print is one that there is, and their Python runs as printed."""

import re
import subprocess
import sys
from pathlib import Path

import pytest
from patience import PATIENCE_S

from tumble.parser import parser

DOCS = Path(__file__).parents[2] / "docs"
PAGES = [DOCS / "index.md", *sorted((DOCS / "guides").glob("*.md"))]
COMMAND = re.compile(r"^tumble .+$|`(tumble [^`]+)`|^\| .*?`(tumble [^`]+)`", re.MULTILINE)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_every_command_is_one_that_there_is(page):
    for found in COMMAND.finditer(page.read_text(encoding="utf-8")):
        words = next(text for text in (*found.groups(), found[0]) if text).split()[1:]
        if len(words) > 1 or page.stem == "teacher":
            parser().parse_args(words)


def test_the_function_of_the_engine_authors_guide_runs_as_printed(tmp_path):
    code, _ = re.findall(r"^```python\n(.*?)^```", (DOCS / "guides/engine-author.md").read_text(), re.M | re.S)
    done = subprocess.run(
        [sys.executable, "-P", "-"], input=code, cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE_S
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert "FAILED turns (step)" in done.stdout
    assert re.search(r"^mine:step .* flagged", done.stdout, re.MULTILINE)
