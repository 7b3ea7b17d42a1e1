"""Titles, sources, names and an engine's own words are data wherever they appear: nothing in them acts."""

import csv
import io
import json
import os
import re
import shutil
import subprocess
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from xml.etree import ElementTree

import in_process
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from markdown_it import MarkdownIt

from tumble.compare.check.changes import compare_records
from tumble.compare.check.junit import junit
from tumble.compare.check.markdown import code, summary
from tumble.compare.check.record import Record
from tumble.compare.check.schemas import CELLS, QUESTIONS, CellRow, QuestionRow
from tumble.compare.check.tolerances import Tolerances
from tumble.compare.tables.cells import CONTROL as OBEYED
from tumble.compare.tables.cells import float_cells, lines_text, text_cell, text_of_cell
from tumble.compare.tables.frames import frame
from tumble.compare.tables.shared import ENGINES, EngineRow

MINE = (Path(__file__).parents[1] / "plugins/mine.py").read_text(encoding="utf-8")
HTML = "<script>alert(1)</script><img src=x onerror=alert(2)>"
MARKUP = "[red]x[/red] [link=http://x]y[/link] | `a` ``b`` *c* _d_ @everyone http://x www.x.de"
CONTROL = "\x1b[31m\x07\x00\u202e\nx\r\u2028"
FORMULAS = ("=1+1", "+1+1", "-1+1", "@SUM(A1)", "\t=1", "\r=1", " =1", "'=1", "''=1")
# A name that a file can have and that acts nowhere else.
NAME = "=a[red]`|*b"


@pytest.fixture(scope="module")
def hostile(tmp_path_factory) -> Path:
    """A folder with a scene and an engine whose every word wants to act, compared, checked and put on a page."""
    folder = tmp_path_factory.mktemp("hostile")
    scene = f"""title = {json.dumps(f"={HTML}{MARKUP}")}
source = {json.dumps(f"@{HTML}{CONTROL}")}
duration = 0.1
samples = 2
step = 0.01
[body]
shape = "box"
size = [0.4, 0.15, 0.1]
mass = 2.4
velocity = [1.0, 0.0, 0.0]
angular_velocity = [0.3, 9.0, 0.4]
"""
    (folder / f"{NAME}.toml").write_text(scene, encoding="utf-8")
    words = repr(f"={HTML}{MARKUP}{CONTROL}")
    (folder / f"{NAME}.py").write_text(
        MINE.replace('METHODS = ("semi-implicit-euler",)', f"METHODS = ({words},)").replace(
            '"version": "1", "precision": "double", "switched_off": []',
            f'"version": {words}, "precision": {words}, "switched_off": [{words}]',
        )
        + f"\n\ndef audit(world):\n    return [{words}]\n",
        encoding="utf-8",
    )
    return folder


def tumble(folder: Path, *words: str, code: int = 0) -> subprocess.CompletedProcess[str]:
    done = in_process.tumble(folder, *words)
    assert done.returncode == code, done.stderr
    assert not set(done.stdout + done.stderr) & set("\x1b\x07\x00\u202e\r\u2028"), "a terminal would obey"
    return done


def test_a_terminal_shows_it_as_it_is(hostile):
    for command in ("compare", "check"):
        extra = ("--accept", "-o", "terminal") if command == "check" else ()
        tumble(hostile, command, f"./{NAME}.toml", "-e", f"./{NAME}.py", *extra)
    shown = tumble(hostile, "compare", f"./{NAME}.toml", "-e", f"./{NAME}.py").stdout
    assert NAME in shown
    assert "[red]x[/red]" in shown, "taken for the terminal's own markup"
    listed = tumble(hostile, "engines", "-e", f"./{NAME}.py").stdout
    assert r"\x1b[31m" in listed


def test_tables_hold_nothing_that_a_spreadsheet_runs(hostile):
    tumble(hostile, "compare", f"./{NAME}.toml", "-e", f"./{NAME}.py", "-o", "out")
    negative = []
    for path in (hostile / "out").glob("*.csv"):
        header, *rows = csv.reader(io.StringIO(path.read_text(encoding="utf-8"), newline=""))
        for row in rows:
            assert len(row) == len(header), path.name
            for value in row:
                assert not re.match(r"\s*[=+@]", value) or is_number(value), f"{path.name}: {value!r}"
                assert not re.match(r"\s*-", value) or is_number(value), f"{path.name}: {value!r}"
        negative += [value for row in rows for value in row if is_number(value) and value.startswith("-")]
    assert negative, "a number is no formula, and stays as it is"


def is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


@pytest.mark.parametrize("text", FORMULAS)
def test_a_formula_is_text_and_comes_back(text):
    (written,) = list(csv.reader(io.StringIO(lines_text(["a"], [[text_cell(text)]]), newline="")))[1]
    assert written == f"'{text}"
    assert text_of_cell(written) == text


@settings(derandomize=True, deadline=None)
@given(st.text() | st.text(alphabet="'=+-@ \t\ra1"))
def test_any_text_comes_back(text):
    rows = list(csv.reader(io.StringIO(lines_text(["a", "b"], [[text_cell(text)], ["1"]]), newline="")))
    assert text_of_cell(rows[1][0]) == OBEYED.sub(lambda found: repr(found[0])[1:-1], text)


@pytest.mark.parametrize("number", [-1.0, -0.0, -1e-300, -5, 1e300])
def test_numbers_stay_numbers(number):
    assert float_cells(np.array([number], dtype=float)) == [repr(float(number))]


class Elements(HTMLParser):
    """What a browser would make of a page: its elements and what their attributes would load."""

    def __init__(self) -> None:
        super().__init__()
        self.found: list[tuple[str, dict[str, str | None]]] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found.append((tag, dict(attrs)))


def elements(html: str) -> list[tuple[str, dict[str, str | None]]]:
    parser = Elements()
    parser.feed(html)
    return parser.found


def test_a_page_shows_it_as_it_is(hostile):
    tumble(hostile, "report", f"./{NAME}.toml", "-e", f"./{NAME}.py", "-o", "page.html")
    html = (hostile / "page.html").read_text(encoding="utf-8")
    assert "alert(1)" in html, "it was not shown at all"
    assert "<script>alert" not in html
    assert "<img src=x" not in html
    assert not [attributes for tag, attributes in elements(html) if any(name.startswith("on") for name in attributes)]


def record(words: str, cells: list[CellRow], version: str) -> Record:
    """Return a record in which these words stand wherever text may."""
    question = QuestionRow(
        scene=words, step_s=0.5, samples=5, truth="exact", resolution_m=1e-15, size_m=0.3, x_m=1.0, y_m=2.0, z_m=3.0
    )
    engine = EngineRow(
        engine=words, status="ok", why="", version=version, precision="", methods="", features="", switched_off=""
    )
    return Record(
        (words,), (words,), words, frame(QUESTIONS, [question]), frame(ENGINES, [engine]), frame(CELLS, cells)
    )


def said(words: str) -> tuple[str, str]:
    """Return the summary and the XML of a check in which everything that can be said is said of these words."""
    cell = CellRow(
        scene=words,
        engine=words,
        method=words,
        steps=9,
        status="flagged",
        why=words,
        max_error_m=1e-3,
        rms_error_m=1e-3,
        final_error_m=1e-3,
        resolution_m=1e-15,
        rounding_m=1e-13,
        energy_drift=0.0,
        momentum_drift=0.0,
        angular_momentum_drift=0.0,
        spin_energy="conserved",
    )
    changed = replace(cell, status=f"crashed: {words}", max_error_m=None)
    worse = replace(cell, method=f"{words}2", max_error_m=1.0, spin_energy="grows")
    before = replace(worse, max_error_m=1e-3, spin_energy="conserved")
    old = record(words, [cell, before, replace(cell, method="gone")], words)
    new = record(words, [changed, worse, replace(cell, method="new")], f"{words}2")
    outcome = compare_records(old, new, Tolerances())
    assert {change.verdict for change in outcome.changes} >= {"worse", "gone", "new"}
    against = ("--baseline", words)
    return summary(outcome, against), junit(outcome, against)


@settings(derandomize=True, deadline=None, max_examples=60)
@given(st.sampled_from([HTML, MARKUP, CONTROL, *FORMULAS, "a`", "``", " ", "\\"]) | st.text(min_size=1, max_size=20))
def test_markdown_and_xml_show_it_as_it_is(words):
    text, xml = said(words)
    assert all(char.isprintable() or char == "\n" for char in text)
    # What a renderer makes of it is headings, lists, paragraphs and code: nothing that loads, links, hides or mentions.
    tokens = MarkdownIt("gfm-like", {"linkify": False}).parse(text)
    kinds = {inner.type for token in tokens for inner in (token, *(token.children or ()))}
    assert kinds <= {
        "inline", "text", "softbreak", "code_inline", "heading_open", "heading_close", "paragraph_open",
        "paragraph_close", "bullet_list_open", "bullet_list_close", "list_item_open", "list_item_close",
    }, text  # fmt: skip
    root = ElementTree.fromstring(xml)
    assert len(list(root.iter("testcase"))) == 4


@settings(derandomize=True, deadline=None)
@given(st.text(alphabet="`a |\\\n\x1b") | st.text())
def test_a_code_span_holds_its_text(text):
    shown = "".join(char if char.isprintable() else repr(char)[1:-1] for char in text)
    (token,) = [token for token in MarkdownIt().parse(f"x {code(text)} y") if token.type == "inline"]
    if not shown.strip():
        return
    (span,) = [child for child in token.children or () if child.type == "code_inline"]
    assert span.content == shown


def test_a_summary_of_a_real_check_is_harmless(hostile, tmp_path):
    folder = Path(shutil.copytree(hostile, tmp_path / "own"))
    base = ("check", f"./{NAME}.toml", "-e", f"./{NAME}.py", "--no-times")
    tumble(folder, *base, "--accept", "-o", "base")
    engine = folder / f"{NAME}.py"
    torque, spoiled = "np.cross(moments * w_body, w_body)", "np.cross(w_body, moments * w_body)"
    engine.write_text(engine.read_text().replace(torque, spoiled))
    done = tumble(folder, "check", "--trust", "--baseline", "base", "-o", "out", code=1)
    assert f"`` {NAME}" in done.stdout or NAME in done.stdout
    assert "<script>" not in MarkdownIt("commonmark").render(done.stdout)
    assert ElementTree.parse(folder / "out/junit.xml").getroot().get("failures") == "1"


def test_a_name_that_is_no_text_is_written_out(tmp_path):
    """A file's name is bytes, and these are no UTF-8: they must neither be refused nor break a table."""
    name = os.fsdecode(b"a\xff.toml")
    scene = 'title="a"\nduration=0.1\nsamples=1\nstep=0.1\n[body]\nshape="box"\nsize=[1,1,1]\nmass=1\n'
    (tmp_path / name).write_text(scene)
    tumble(tmp_path, "compare", f"./{name}", "-e", "tumble:rk4", "-o", "out")
    assert r"a\udcff" in (tmp_path / "out/runs.csv").read_text(encoding="utf-8")
