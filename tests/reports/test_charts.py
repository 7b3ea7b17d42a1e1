"""Charts and colours in a terminal, none in a pipe, and the figure of a command as SVG and PNG."""

import math
import os
import re
from itertools import pairwise

import pytest
from rich.console import Console

from tumble.compare.stability.schemas import LimitRow
from tumble.compare.sweep.schemas import AccuracyCostRow
from tumble.compare.tables.shared import RunRow
from tumble.reports import figures
from tumble.reports.charts import Ruler, cost_chart, error_chart, limit_chart

ANSI = re.compile(r"\x1b\[[0-9;?]*[A-Za-z]")
ASK = ("compare", "die-straight", "-e", "tumble:rk4", "-e", "mujoco:euler", "-e", "pybullet:multibody")


def printed(pieces) -> list[str]:
    out = Console(width=80, highlight=False, markup=False)
    with out.capture() as captured:
        for piece in pieces:
            out.print(piece)
    lines = captured.get().splitlines()
    assert max(map(len, lines)) <= 80
    return lines


def bars(lines: list[str], sign: str = "━") -> dict[str, int]:
    return {line.split()[0]: line.count(sign) for line in lines if sign in line}


def test_a_bar_is_as_long_as_the_error_has_digits():
    """Each bar is a decade longer than the one above it: equal steps, to the rounding of both ends to a column."""
    rows = [
        RunRow(
            scene="s",
            engine=f"e{k}",
            method="m",
            dt_s=0.1,
            tolerance=None,
            steps=1,
            status="ok",
            why="",
            max_error_m=10.0**-k,
            rms_error_m=0,
            final_error_m=0,
            resolution_m=1e-9,
        )
        for k in range(1, 6)
    ]
    lengths = list(bars(printed(error_chart(rows))).values())
    steps = [after - before for before, after in pairwise(lengths)]
    assert len(lengths) == 5
    assert max(steps) - min(steps) <= 1
    assert min(steps) > 4


def test_an_error_at_its_limit_is_said_to_be_no_more():
    rows = [
        RunRow(
            scene="s",
            engine=f"e{k}",
            method="m",
            dt_s=0.1,
            tolerance=None,
            steps=1,
            status="ok",
            why="",
            max_error_m=error,
            rms_error_m=0,
            final_error_m=0,
            resolution_m=1e-6,
        )
        for k, error in enumerate((0.1, 1e-9))
    ]
    assert any(line.startswith("e1:m") and line.endswith("≤1 µm") for line in printed(error_chart(rows)))


def test_marks_stand_in_the_order_of_their_times():
    rows = [
        AccuracyCostRow(
            scene="s",
            engine="one",
            method="a",
            target_m=target,
            verdict="reached",
            run_us=time,
            dt_s=0.1,
            tolerance=None,
            steps_per_s=None,
            reference="one:a",
            ratio=1.0,
        )
        for target, time in ((1e-3, 1.0), (1e-6, 10.0), (1e-9, 100.0), (1e-12, 1000.0))
    ]
    line = next(line for line in printed(cost_chart(rows)) if line.startswith("one:a"))
    assert re.fullmatch(r"one:a\s+m +µ +n +p\s*", line)
    assert not list(cost_chart([]))


def test_theory_is_marked_on_the_bar_of_the_limit():
    limits = [
        LimitRow(
            scene="s",
            engine="one",
            method=method,
            parameter="k",
            value=1.0,
            w_rad_s=1.0,
            w_dt_limit=limit,
            beyond="diverged",
            theory_w_dt=2.0,
            theory="",
            dt_stable_s=1.0,
            dt_1pct_s=None,
            dt_1mm_s=None,
            note="",
        )
        for method, limit in (("longer", 4.0), ("shorter", 1.0), ("endless", math.inf))
    ]
    lines = {line.split()[0]: line for line in printed(limit_chart(limits)) if line.startswith("one:")}
    assert "━|━" in lines["one:longer"]
    assert re.search(r"━ +\|", lines["one:shorter"])
    assert lines["one:endless"].rstrip().endswith("no limit")


def test_a_ruler_keeps_what_lies_beyond_it_at_its_ends():
    ruler = Ruler(1.0, 100.0, 21)
    assert [ruler.column(value) for value in (0.0, 1.0, 10.0, 100.0, math.inf)] == [0, 0, 10, 20, 20]


def test_a_terminal_gets_chart_and_colour_and_a_pipe_neither(tumble):
    plain = tumble(*ASK).stdout
    env = {key: value for key, value in os.environ.items() if key != "NO_COLOR"}
    shown = tumble(*ASK, env={**env, "FORCE_COLOR": "1", "COLUMNS": "80", "TERM": "xterm-256color"}).stdout
    assert "━" not in plain
    assert not ANSI.search(plain)
    assert ANSI.search(shown)
    bare = ANSI.sub("", shown).splitlines()
    assert len(bars(bare)) == 3
    assert max(map(len, bare)) <= 80


def test_the_figure_is_saved_as_svg_and_png(tumble, tmp_path):
    done = tumble(*ASK, "--svg", "figure.svg", "--png", "figure.png")
    assert done.returncode == 0, done.stderr
    text = (tmp_path / "figure.svg").read_text(encoding="utf-8")
    assert all(name in text for name in ("tumble:rk4", "mujoco:euler", "pybullet:multibody", "largest vertex error"))
    assert (tmp_path / "figure.png").read_bytes().startswith(b"\x89PNG")


def test_where_nothing_draws_figures_that_is_one_line(monkeypatch):
    monkeypatch.setattr(figures, "LIBRARIES", ("no_such_library",))
    figures.check_figures(None, None)
    with pytest.raises(
        figures.NoFigures, match=r"need no-such-library: in Tumble's checkout, pip install '\.\[figures\]'$"
    ):
        figures.check_figures("a.svg", None)
