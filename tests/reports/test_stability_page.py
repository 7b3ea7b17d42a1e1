"""What is said of stability, in the terminal and on the page, from planted tables."""

import io
import math
import re
from dataclasses import replace
from itertools import pairwise

from rich.console import Console

from tumble.compare.stability.findings import extreme_findings, limit_findings
from tumble.compare.stability.schemas import CELLS, LIMITS, ExtremeRow, LimitRow, StabilityRow
from tumble.compare.stability.schemas import EXTREMES as EXTREME
from tumble.compare.stability.trials import Piece
from tumble.compare.tables.frames import frame
from tumble.compare.tables.shared import FINDINGS
from tumble.reports.page import page
from tumble.reports.stability_text import stability_text
from tumble.reports.terminal import console, reasons_text

W = 1000.0


def piece(engine: str, method: str, limit: float | None, then: str, note: str = "") -> Piece:
    """Return a map of two values and four steps that is stable up to a limit."""
    key = {"scene": "springy", "engine": engine, "method": method}
    row = LimitRow(
        **key,
        parameter="stiffness [N/m]",
        value=1e6,
        w_rad_s=W,
        w_dt_limit=limit,
        beyond=then,
        theory_w_dt=2.0,
        theory="semi-implicit Euler",
        dt_stable_s=2e-3,
        dt_1pct_s=1e-4,
        dt_1mm_s=None,
        note=note,
    )
    if note:
        skipped = StabilityRow(
            **key,
            dt_s=1e-3,
            parameter="stiffness [N/m]",
            value=1e6,
            status="skipped",
            why=note,
            verdict="refused",
            max_error_m=None,
            energy_ratio=None,
            resolution_m=None,
        )
        return Piece((skipped,), row)
    cells = []
    for value in (1e6, 1e8):
        rate = W * math.sqrt(value / 1e6)
        for w_dt in (8.0, 4.0, 2.0, 1.0):
            word = "stable" if limit is None or w_dt < limit else then
            cells.append(
                StabilityRow(
                    **key,
                    dt_s=w_dt / rate,
                    parameter="stiffness [N/m]",
                    value=value,
                    status="ok",
                    why="",
                    verdict=word,
                    max_error_m=1e-3,
                    energy_ratio=1.0,
                    resolution_m=1e-15,
                )
            )
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


def extreme(method: str, scene: str, word: str, error_over_resolution: float | None) -> ExtremeRow:
    """Return what one of our methods makes of a case whose truth tells 1e-15 m of a body of 0.2 m."""
    error = None if error_over_resolution is None else 1e-15 * error_over_resolution
    return ExtremeRow(
        scene=scene,
        title=scene.upper(),
        engine="tumble",
        method=method,
        dt_s=0.1,
        steps=1,
        status="ok",
        verdict=word,
        max_error_m=error,
        resolution_m=1e-15,
        error_over_resolution=error_over_resolution,
        energy_ratio=1.0,
        why="<b>why</b>",
        size_m=0.2,
    )


EXTREMES = [extreme(method, scene, "stable", 2.0) for scene in ("hot", "cold") for method in ("exact", "rk4")]


def planted() -> str:
    """Return the page of these pieces and extremes, and of nothing else."""
    cells = (row for each in PIECES for row in each.rows)
    return page(
        {
            CELLS.file: frame(CELLS, cells),
            LIMITS.file: frame(LIMITS, (each.limit for each in PIECES)),
            EXTREME.file: frame(EXTREME, EXTREMES),
        }
    )


def test_contestants_with_one_map_share_it_and_others_do_not(opened):
    tab = opened(planted(), "#show=all&at=maps-springy")
    maps = tab.locator("#maps-springy figure.map")
    maps.first.wait_for()
    assert maps.locator("figcaption").all_inner_texts() == ["mine:a, mine:b", "mine:c", "mine:d, mine:own"]
    assert [each.locator("rect.s-stable").count() for each in maps.all()] == [4, 4, 8]
    assert [each.locator("rect.s-diverged").count() for each in maps.all()] == [4, 0, 0]
    assert maps.nth(1).locator("rect.s-clamped").count() == 4


def test_the_line_of_theory_stands_between_the_steps_it_parts(opened):
    """Steps of 8, 4, 2 and 1 radians stand a cell apart, the longest to the right; theory says 2."""
    tab = opened(planted(), "#show=all&at=maps-springy")
    first = tab.locator("#maps-springy figure.map").first
    first.wait_for()
    line = first.locator("svg > path").get_attribute("d")
    lefts = sorted({float(rect.get_attribute("x")) for rect in first.locator("rect").all()})
    assert lefts == [0.0, 14.0, 28.0, 42.0]
    assert line.startswith(f"M{lefts[1] + 7:g},")


def test_a_row_of_fewer_steps_leaves_no_gap(opened):
    """Of the upper value only the first and the last of four steps: each reaches half way to the other."""
    cells = [row for row in PIECES[3].rows if row.value == 1e6 or row.dt_s * W * 10 > 7.9 or row.dt_s * W * 10 < 1.1]
    tables = {CELLS.file: frame(CELLS, cells), LIMITS.file: frame(LIMITS, [PIECES[3].limit])}
    tab = opened(page(tables), "#show=all&at=maps-springy")
    rects = tab.locator("#maps-springy figure.map rect")
    rects.first.wait_for()
    spans: dict[float, list[tuple[float, float]]] = {}
    for rect in rects.all():
        x, y, width = (float(rect.get_attribute(name) or 0) for name in ("x", "y", "width"))
        spans.setdefault(y, []).append((x, x + width))
    rows = [sorted(own) for _, own in sorted(spans.items())]
    assert [len(own) for own in rows] == [2, 4]
    for own in rows:
        assert own[0][0] == 0.0
        assert own[-1][1] == 4 * 14 - 1
        assert all(after[0] - before[1] == 1.0 for before, after in pairwise(own))


def test_limits_stand_beside_theory(opened):
    tab = opened(planted(), "#show=all&at=limits-springy-mine:a")
    table = tab.locator("#limits")
    table.wait_for()
    lines = {
        line.split("\t")[0].split("\n")[0].rstrip("⚓︎"): line.split("\t")[2:]
        for line in table.locator("tbody tr").all_inner_texts()
    }
    assert lines["mine:a"][:3] == ["3.00", "2.00", "diverged"]
    assert lines["mine:d"][0] == "∞"
    assert lines["other:x"][-1] == "x carries no forces"
    assert [lines["mine:a"][4], lines["mine:a"][5]] == ["1.00·10⁻⁴", "< 0.00100"], "no step tried is within 1 mm"
    marks = tab.locator("#limits-figure g.limit")
    drawn = {mark.get_attribute("data-name"): mark.locator(".point").bounding_box() for mark in marks.all()}
    assert sorted(drawn) == ["mine:a", "mine:b", "mine:c", "mine:d"]
    middle = {name: (box["x"] + box["width"] / 2, box["y"] + box["height"] / 2) for name, box in drawn.items()}
    (bar,) = (bar.bounding_box() for bar in tab.locator("#limits-figure .theory").all())
    # One limit, 1.5 times theory's: at one place of the scale, one above the other; without a limit beyond them all.
    assert {round(middle[name][0]) for name in ("mine:a", "mine:b", "mine:c")} == {round(middle["mine:a"][0])}
    assert len({round(middle[name][1]) for name in ("mine:a", "mine:b", "mine:c")}) == 3
    assert bar["x"] < middle["mine:a"][0] < middle["mine:d"][0]
    assert [mark.get_attribute("data-name") for mark in marks.all() if mark.locator(".silent").count()] == ["mine:c"]


def test_a_scene_at_one_value_is_a_line_for_each_outcome(opened):
    """As `make report` has them: contestants with the same verdicts share a line, and theory's bar parts its steps."""
    cells = (row for each in PIECES for row in each.rows if row.value == 1e6)
    tables = {CELLS.file: frame(CELLS, cells), LIMITS.file: frame(LIMITS, (each.limit for each in PIECES))}
    tab = opened(page(tables), "#show=all&at=maps")
    strips = tab.locator("#map-springy")
    strips.wait_for()
    assert strips.locator("text.beside").all_text_contents() == ["mine:a, mine:b", "mine:c", "mine:d, mine:own"]
    assert strips.locator("rect").count() == 3 * 4
    lefts = sorted({float(rect.get_attribute("x") or 0) for rect in strips.locator("rect").all()})
    assert lefts == [0.0, 14.0, 28.0, 42.0]
    assert (strips.locator("path").first.get_attribute("d") or "").startswith(f"M{lefts[1] + 7:g},")


WORDS = ("stable", "damped", "drifting", "clamped", "reset", "diverged", "no-return")


def cases() -> list[ExtremeRow]:
    """Return each verdict once, and a flight that is right to the truth's limit, to 1 % of the body, and to less."""
    rows = [extreme("rk4", word, word, 1e14) for word in WORDS]
    rows[-2:] = [replace(rows[-2], max_error_m=math.inf), replace(rows[-1], max_error_m=None, why="it hung")]
    return [*rows, extreme("rk4", "exact", "stable", 0.5), extreme("rk4", "near", "stable", 1e11)]


def test_the_board_of_extreme_cases_has_the_verdicts_and_what_is_silent_stands_out(opened):
    table = {EXTREME.file: frame(EXTREME, cases()), FINDINGS.file: frame(FINDINGS, extreme_findings(cases()))}
    tab = opened(page(table), "#show=all&at=extremes")
    tab.locator("#extreme-board button.case").first.wait_for()
    titles = tab.locator("#extreme-board thead th.upright").all_inner_texts()
    cells = dict(zip(titles, tab.locator("#extreme-board tbody td.cell").all(), strict=True))
    kind = {name: (cell.get_attribute("class") or "").split("v-")[1].split()[0] for name, cell in cells.items()}
    silent = dict.fromkeys(("damped", "drifting", "clamped", "reset"), "flagged")
    assert kind == {
        "stable": "beyond", **silent, "diverged": "diverged", "no-return": "failed", "exact": "exact", "near": "within"
    }  # fmt: skip
    assert tab.locator("#extreme-board .score").inner_text() == "2/9"
    paint = "(it) => getComputedStyle(it).backgroundColor"
    loud, plain = cells["clamped"].evaluate(paint), cells["diverged"].evaluate(paint)
    assert loud != plain, "a silent failure looks as one that is seen"
    headline = tab.locator("section#extremes .headline").inner_text()
    assert re.search(r"tumble:rk4 is wrong .* in 4\b", headline)


def test_a_case_opens_its_sentence_and_a_command_that_runs_it_again(opened):
    tab = opened(page({EXTREME.file: frame(EXTREME, cases())}), "#show=all&at=extremes")
    first = tab.locator("#extreme-board button.case").first
    first.focus()
    for _ in range(3):
        tab.keyboard.press("ArrowRight")
    tab.keyboard.press("Enter")
    detail = tab.locator("#case-detail").inner_text()
    assert "tumble:rk4 in “CLAMPED”, step 0.1 s: a clamp hides" in detail
    assert "<b>why</b>" in detail
    assert tab.locator("#case-detail code").inner_text() == "tumble stability clamped -e tumble:rk4"
    assert tab.locator('#extreme-board button[aria-pressed="true"]').count() == 1


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
    assert "no limit: stable at every step tried, up to w dt = 8" in text
    assert "tumble:exact is within 10 times the resolution in all 2 cases" in text


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


def test_findings_count_the_limits_of_theory_and_the_silent_failures():
    """Theory has 2 rad for all: limits of 3 rad are none of its, 2.09 rad is within 5 %, and 2.11 rad is not."""
    near, far = piece("mine", "near", 2.09, "diverged").limit, piece("mine", "far", 2.11, "diverged").limit
    found = {row.finding: row.value for row in limit_findings([each.limit for each in PIECES[:4]])}
    assert (found["limits with theory"], found["limits matching theory"]) == (4, 0)
    found = {row.finding: row.value for row in limit_findings([near, far])}
    assert (found["limits with theory"], found["limits matching theory"]) == (2, 1)
    assert {row.finding: row.value for row in extreme_findings(cases())} == {"extreme cases": 9, "silent failures": 4}
    assert list(extreme_findings([])) == list(limit_findings([])) == []
