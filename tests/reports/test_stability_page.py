"""What is said of stability, on the page and in the terminal: from planted tables, and in a real browser."""

import io
import math
import re
import shutil

import pytest
from playwright.sync_api import sync_playwright
from rich.console import Console

from compare.comparison.results import EngineRow, ErrorOverTimeRow, SceneRow
from compare.comparison.table_4_1 import BudgetRow, PublishedRow
from compare.judge.agreement import AgreementRow
from compare.judge.verdict import WORDS
from compare.run.provenance import ConditionRow
from compare.stability.extremes import ExtremeRow
from compare.stability.schemas import LimitRow, StabilityRow
from compare.stability.trials import Piece
from compare.tables.rows import RunRow, VertexErrorRow, table_text
from reports.page import page
from reports.stability import MEANING, SIGNS
from reports.stability_text import stability_text
from reports.terminal import console, reasons_text

W = 1000.0
EMPTY = {
    "scenes.csv": SceneRow,
    "engines.csv": EngineRow,
    "runs.csv": RunRow,
    "vertex-errors.csv": VertexErrorRow,
    "error-over-time.csv": ErrorOverTimeRow,
    "agreement.csv": AgreementRow,
    "table-4-1.csv": PublishedRow,
    "table-4-1-budget.csv": BudgetRow,
    "conditions.csv": ConditionRow,
}


def piece(engine: str, method: str, limit: float | None, then: str, note: str = "") -> Piece:
    """Return a map of two values and four steps that is stable up to a limit."""
    key = "springy", engine, method
    row = LimitRow(*key, "stiffness [N/m]", 1e6, W, limit, then, 2.0, "semi-implicit Euler", 2e-3, 1e-4, None, note)
    if note:
        return Piece(
            (StabilityRow(*key, 1e-3, "stiffness [N/m]", 1e6, "skipped", note, "refused", None, None, None),), row
        )
    cells = []
    for value in (1e6, 1e8):
        rate = W * math.sqrt(value / 1e6)
        for w_dt in (8.0, 4.0, 2.0, 1.0):
            word = "stable" if limit is None or w_dt < limit else then
            cells.append(StabilityRow(*key, w_dt / rate, "stiffness [N/m]", value, "ok", "", word, 1e-3, 1.0, 1e-15))
    return Piece(tuple(cells), row)


PIECES = [
    piece("mine", "a", 3.0, "diverged"),
    piece("mine", "b", 3.0, "diverged"),
    piece("mine", "c", 3.0, "clamped"),
    piece("mine", "d", math.inf, ""),
    piece("mine", "own", None, ""),
    piece("other", "x", None, "", "x carries no forces"),
    piece("other", "y", None, "", "y carries no forces"),
]


def extreme(method: str, scene: str, word: str, times_limit: float | None) -> ExtremeRow:
    error = None if times_limit is None else 1e-15 * times_limit
    return ExtremeRow(
        scene, scene.upper(), "tumble", method, 0.1, 1, "ok", word, error, 1e-15, times_limit, 1.0, "<b>why</b>"
    )


EXTREMES = [extreme(method, scene, "stable", 2.0) for scene in ("hot", "cold") for method in ("exact", "rk4")]


def tables(pieces=PIECES, extremes=EXTREMES) -> dict[str, str]:
    return {
        **{name: table_text(row_type, []) for name, row_type in EMPTY.items()},
        "stability.csv": table_text(StabilityRow, (row for each in pieces for row in each.rows)),
        "limits.csv": table_text(LimitRow, (each.limit for each in pieces)),
        "extremes.csv": table_text(ExtremeRow, extremes),
    }


def words(html: str) -> str:
    bare = re.sub(r"<(script|style).*?</\1>", "", html, flags=re.DOTALL)
    return " ".join(re.sub(r"<[^>]+>", " ", bare).split())


@pytest.fixture(scope="module")
def html() -> str:
    return page(tables())


def test_every_verdict_has_a_sign_of_its_own_and_a_meaning():
    assert set(SIGNS) == set(MEANING) == set(WORDS)
    assert len(set(SIGNS.values())) == len(SIGNS), "colour alone must not tell them apart"


def test_contestants_with_one_map_share_it_and_others_do_not(html):
    captions = re.findall(r'<figure class="map">.*?<figcaption>(.*?)</figcaption>', html, flags=re.DOTALL)
    assert captions == ["mine:d", "mine:a, mine:b", "mine:c"], "who bears most comes first"
    assert html.count('class="theory"') == 3
    assert len(re.findall(r'<rect class="v-clamped"', html)) == 4 + 1  # the cells and the legend


def test_a_cell_stands_where_its_step_is(html):
    """The steps of a map are factors of two apart, and as many radians at every value."""
    first = re.search(r'<figure class="map">(.*?)</figure>', html, flags=re.DOTALL)[1]
    squares = re.findall(r'<rect class="v-\S+" x="(\S+)" y="(\S+)" width="(\S+)"', first)
    places = {(float(x), float(y)) for x, y, _ in squares}
    assert {width for *_, width in squares} == {"12.0"}
    assert places == {(4.0 + 12 * step, 4.0 + 12 * row) for step in range(4) for row in range(2)}


def test_limits_stand_beside_theory(html):
    said = words(html)
    assert "mine:a 3.00 2.00 diverged 0.00200 1.00·10⁻⁴" in said
    assert "mine:d no limit 2.00" in said
    assert "mine:own steps of its own" in said
    assert "other:x and other:y: carries no forces." in said
    assert "Theory: semi-implicit Euler." in said


def test_how_our_best_method_did_is_said_as_the_rows_have_it(html):
    assert "tumble:exact is within 10 times what the truth can tell in all 2 cases." in words(html)
    missed = [*EXTREMES[1:], extreme("exact", "hot", "stable", 11.0)]
    assert "tumble:exact is further off than 10 times what the truth can tell in hot" in words(page(tables([], missed)))


def test_what_an_engine_says_stays_text(html):
    assert "<b>why</b>" not in html


def test_without_such_tables_there_is_no_such_section():
    texts = {name: text for name, text in tables().items() if name in EMPTY}
    assert 'id="stability"' not in page(texts)
    assert 'id="extremes"' not in page(tables(extremes=[]))


@pytest.mark.parametrize("width", [400, 1300])
def test_it_fits_a_telephone_and_a_desk(html, tmp_path, width):
    found = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    if found is None:
        pytest.skip("no browser is installed, and the page must be seen in a real one")
    many = [extreme("exact", f"a-long-case-{number}", "stable", 1.0) for number in range(30)]
    file = tmp_path / "page.html"
    file.write_text(page(tables(extremes=many)), encoding="utf-8")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=found, args=["--no-sandbox"])
        tab = browser.new_page(viewport={"width": width, "height": 900})
        tab.goto(file.as_uri())
        assert tab.evaluate("document.documentElement.scrollWidth") <= width
        assert tab.locator(".map svg").count() == 3
        browser.close()


def printed(pieces, extremes, width=80) -> str:
    console = Console(width=width, highlight=False, markup=False)
    with console.capture() as captured:
        for part in stability_text(pieces, extremes):
            console.print(part)
    return captured.get()


def test_the_terminal_says_the_same_in_eighty_columns():
    text = printed(PIECES, EXTREMES)
    assert max(map(len, text.splitlines())) <= 80
    lines = {line.split()[0]: " ".join(line.split()) for line in text.splitlines() if line.strip()}
    assert lines["mine:a"] == "mine:a 3 2 diverged 2.0e-03 1.0e-04"
    assert lines["mine:c"].startswith("mine:c 3 2 clamped")
    assert "other:x, other:y: carries no forces" in text
    assert "no limit: at no step that was tried, up to w dt = 8" in text
    assert "tumble:exact is within 10 limits of the truth in all 2 cases" in text


def test_many_contestants_of_a_case_are_counted():
    rows = [extreme(f"m{number}", "hot", "stable" if number else "diverged", 1.0) for number in range(9)]
    assert "8 stable, 1 diverged" in printed([], rows)


def test_every_reason_is_told_once_and_no_wider_than_a_terminal():
    told = [("ours:x", "skipped: x carries no forces"), ("ours:y", "skipped: y carries no forces")]
    told += [(f"theirs:{number}", "skipped: theirs has no tether") for number in (*range(20), *range(20))]
    out = console(file=io.StringIO())
    for reason in reasons_text(told):
        out.print(reason)
    lines = out.file.getvalue().splitlines()
    assert lines[0].rstrip() == "ours:x, ours:y: skipped: carries no forces"
    assert max(map(len, lines)) <= 80
    rest = " ".join(line.strip() for line in lines[1:])
    assert rest == f"{', '.join(f'theirs:{number}' for number in range(20))}: skipped: theirs has no tether"
