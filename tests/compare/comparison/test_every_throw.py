"""A comparison of many throws writes every one of them."""

import pytest

from tumble.compare.comparison.against_truth import compare
from tumble.compare.comparison.results import comparison_tables
from tumble.compare.run.running_engines import launched
from tumble.compare.tables.engines import engine_row
from tumble.reports.comparison_text import comparison_text
from tumble.scenarios.read import read_scene


def test_every_throw_is_written_and_told_of():
    scenes = [read_scene(name) for name in ("many-throws", "die-straight")]
    with launched(["tumble:rk4"]) as running_engines:
        comparisons = compare(running_engines, scenes)
        tables = comparison_tables(comparisons, list(map(engine_row, running_engines)), "")
    every, runs = tables["members.csv"], tables["runs.csv"].set_index("scene")
    assert every["scene"].unique().tolist() == ["many-throws"]
    assert every["member"].tolist() == list(range(24))
    assert every["max_error_m"].max() == runs.loc["many-throws", "max_error_m"]
    assert every["resolution_m"].to_numpy() == pytest.approx(comparisons[0].runs[0].limits.max(axis=0), rel=0)
    many, one = ([str(piece) for piece in comparison_text(each, None)] for each in comparisons)
    assert any("throw 0 of 24" in piece for piece in many)
    assert any("members.csv" in piece for piece in many)
    assert not any("throw" in piece for piece in one)
