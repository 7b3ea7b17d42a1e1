"""Throws that run in parts: the same errors as all at once, shards merged, the worst throws again as scene files."""

from contextlib import suppress
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tumble.compare.comparison.against_truth import Comparison, compare
from tumble.compare.comparison.results import comparison_tables
from tumble.compare.comparison.worst import worst_scenes
from tumble.compare.judge.spread import BIN_ERROR, WORST
from tumble.compare.run.execution import Execution, Incomplete, Shard, executing
from tumble.compare.run.running_engines import launched
from tumble.compare.run.task_cache import TaskCache
from tumble.reports.comparison_text import comparison_text
from tumble.scenarios import ensemble
from tumble.scenarios.ensemble import parts_in
from tumble.scenarios.read import CATALOGUE, read_document, read_scene, scene_of_document
from tumble.scenarios.scene import Scene

NAME = "many-throws"
THROWS = 300
# Times of runs.
NOT_COMPARED = ["wall_s", "wall_ns_per_step", "wall_per_sim_s"]


@pytest.fixture(scope="module")
def engines():
    with launched(["tumble:rk4", "tumble:exact-lanes"]) as found:
        yield found


@pytest.fixture
def document(monkeypatch) -> dict:
    """Return the catalogue's ensemble with more throws than are held at once."""
    monkeypatch.setattr(ensemble, "TOGETHER", 100)
    monkeypatch.setattr(ensemble, "BLOCK", 128)
    found = read_document(CATALOGUE / f"{NAME}.toml", NAME)
    found["ensemble"]["throws"] = THROWS
    return found


def scene(document: dict, in_parts: bool = True) -> Scene:
    return scene_of_document(document, Path(f"{NAME}.toml"), NAME, in_parts=in_parts)


def tables(comparison: Comparison) -> dict[str, pd.DataFrame]:
    return comparison_tables([comparison], [], "")


def plain(found: dict[str, pd.DataFrame]) -> dict[str, str]:
    return {name: table.drop(columns=NOT_COMPARED, errors="ignore").to_csv() for name, table in found.items()}


def test_parts_and_shards_have_the_errors_of_all_throws_at_once(document, engines, tmp_path):
    large, whole = scene(document), scene(document, in_parts=False)
    assert (parts_in(large), len(whole.start), parts_in(whole)) == (2, THROWS, 0)
    (parts,), (together,) = compare(engines, [large]), compare(engines, [whole])
    ours, theirs = tables(parts), tables(together)
    by_member = theirs["members.csv"].sort_values(["method", "max_error_m", "member"], ascending=[True, False, True])
    assert set(ours["members.csv"].method) == {"rk4", "exact-lanes"}
    for method, worst in ours["members.csv"].groupby("method"):
        known = by_member[by_member.method == method]
        assert worst.max_error_m.tolist() == known.max_error_m.tolist()[:WORST]
        assert set(worst.member[: WORST // 2]) <= set(known.member[:WORST])
        (row,) = ours["ensemble-errors.csv"].query("method == @method").itertuples()
        errors = np.maximum(known.max_error_m, known.resolution_m)
        assert (row.members, row.unknown, row.lost, row.quantile_error) == (THROWS, 0, 0, BIN_ERROR)
        assert row.mean_error_m == pytest.approx(errors.mean(), rel=1e-12)
        for column, share in (("p1_error_m", 0.01), ("median_error_m", 0.5), ("p99_error_m", 0.99)):
            exact = np.quantile(errors, share, method="inverted_cdf")
            assert getattr(row, column) == pytest.approx(exact, rel=BIN_ERROR)
    runs, known = (found["runs.csv"].set_index("method") for found in (ours, theirs))
    for column in ("steps", "status", "max_error_m", "final_error_m", "resolution_m"):
        assert runs[column].equals(known[column]), column
    assert runs.rms_error_m.tolist() == pytest.approx(known.rms_error_m.tolist(), rel=1e-12)
    assert ours["error-over-time.csv"].equals(theirs["error-over-time.csv"])
    assert ours["scenes.csv"].needs[0] == theirs["scenes.csv"].needs[0]
    text = "\n".join(str(getattr(piece, "renderable", piece)) for piece in comparison_text(parts, None))
    assert f"throw 0 of {THROWS}" in text
    assert f"Quantiles over {THROWS} throws" in text

    cache = TaskCache(tmp_path)
    for number in (2, 1):
        with executing(Execution((cache,), Shard(number, 2))), suppress(Incomplete):
            compare(engines, [large])
    with executing(Execution((cache,), is_merge=True)):
        (merged,) = compare(engines, [large])
    assert plain(tables(merged)) == plain(ours)


def test_a_number_of_throws_may_be_written_with_an_exponent(document):
    many = {**document, "ensemble": {**document["ensemble"], "throws": 1e9}}
    large = scene(many)
    assert (large.ensemble.throws, parts_in(large)) == (10**9, 10**9 // 128)  # type: ignore[union-attr]


def test_the_worst_throws_are_scenes_with_the_same_error(document, engines):
    (parts,) = compare(engines[:1], [scene(document)])
    files = worst_scenes(parts, document, Path())
    spread = parts.ensemble[0].spread
    assert {f"worst/{NAME}-throw-{member}.toml" for member in spread.worst} <= set(files)
    (alone,) = compare(
        engines[:1], [scene({**document, "ensemble": {**document["ensemble"], "member": int(spread.worst[0])}})]
    )
    assert len(alone.scene.start) == 1
    run = next(run for run in alone.runs if run.method == "rk4")
    assert float(run.distances.max()) == pytest.approx(spread.worst_m[0], rel=0, abs=2 * float(run.limits.max()))
    assert spread.worst_m[0] > 1e3 * float(run.limits.max()), "an error that says something"


def test_a_member_is_that_throw_alone_and_more_throws_leave_the_first_as_they_were(document):
    whole = scene(document, in_parts=False)
    for member in (0, 5, 127, 128, THROWS - 1):
        alone = scene({**document, "ensemble": {**document["ensemble"], "member": member}})
        assert alone.ensemble is None
        assert np.array_equal(alone.start, whole.start[member : member + 1])
    more = scene({**document, "ensemble": {**document["ensemble"], "throws": 999}}, in_parts=False)
    assert np.array_equal(more.start[:THROWS], whole.start)
    assert len(np.unique(whole.start, axis=0)) == THROWS
    few = {**document, "ensemble": {**document["ensemble"], "throws": 24}}
    assert np.array_equal(scene(few).start, read_scene(NAME).start), "few throws are drawn as ever"
    third = scene({**few, "ensemble": {**few["ensemble"], "member": 3}})
    assert np.array_equal(third.start, read_scene(NAME).start[3:4])
