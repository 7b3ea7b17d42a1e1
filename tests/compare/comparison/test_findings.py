"""What a comparison found, from planted rows."""

from tumble.compare.comparison.findings import agreement_findings, error_findings
from tumble.compare.judge.agreement import AgreementRow
from tumble.compare.tables.shared import RunRow


def run(
    engine: str, method: str, error_m: float | None, resolution_m: float | None = 1e-12, status: str = "ok"
) -> RunRow:
    return RunRow(
        scene="s",
        engine=engine,
        method=method,
        dt_s=0.01,
        tolerance=None,
        steps=10,
        status=status,
        why="",
        max_error_m=error_m,
        rms_error_m=error_m,
        final_error_m=error_m,
        resolution_m=resolution_m,
    )


def found(rows) -> dict:
    return {row.finding: (row.contestant, row.value, row.resolution) for row in rows}


def test_each_scene_has_its_nearest_its_engines_and_its_lost():
    rows = [
        run("tumble", "exact", 1e-15),
        run("handcalc", "as-printed", 3.0),
        run("one", "euler", 0.2),
        run("one", "euler+defaults", 0.3),
        run("one", "rk4", 1e-6),
        run("two", "only", float("inf"), status="diverged"),
        run("three", "", None, None, status="missing"),
    ]
    told = list(error_findings(rows, {"tumble:exact", "one:euler", "one:euler+defaults", "two:only"}))
    assert found(told)["most accurate"] == ("tumble:exact", 1e-15, 1e-12)
    assert found(told)["most accurate engine"] == ("one:rk4", 1e-6, 1e-12)
    assert found(told)["least accurate"] == ("handcalc:as-printed", 3.0, 1e-12)
    assert found(told)["unfinished"][1] == 1
    assert found(told)["unsupported"][1] == 1
    assert [row.contestant for row in told if row.finding == "first method"] == ["one:euler", "handcalc:as-printed"]
    shipped = {row.engine: (row.method, row.value) for row in told if row.finding == "engine default"}
    assert shipped == {
        "tumble": ("exact", 1e-15),
        "one": ("euler+defaults", 0.3),
        "two": ("only", float("inf")),
    }


def test_what_somebody_named_is_not_what_an_engine_does_as_it_ships():
    told = list(error_findings([run("one", "rk4", 1e-6), run("two", "euler", 1e-3)], {"one:euler", "two:euler"}))
    assert [row.contestant for row in told if row.finding == "engine default"] == ["two:euler"]
    named = error_findings([run("one", "rk4", 1e-6), run("two", "euler", 1e-3)], {"two:euler"}, {"one:rk4"})
    assert [row.contestant for row in named if row.finding == "named method"] == ["one:rk4"]


def test_an_error_below_what_the_truth_tells_ranks_as_that():
    """1e-15 and 2e-15 m are both at a limit of 1e-12: neither is nearer, and the first stays first."""
    rows = [run("one", "a", 2e-15), run("two", "b", 1e-15)]
    assert found(error_findings(rows))["most accurate"][0] == "one:a"


def test_who_was_flagged_is_nearest_only_where_nobody_else_flew():
    rows = [run("one", "a", 1e-9, status="flagged"), run("two", "b", 1e-3)]
    assert found(error_findings(rows))["most accurate"][0] == "two:b"
    assert found(error_findings(rows[:1]))["most accurate"][0] == "one:a"


def test_of_agreeing_engines_the_most_misleading_pair_is_told():
    pairs = [
        AgreementRow(
            scene="s",
            engine_a="one",
            method_a="a",
            engine_b="one",
            method_b="b",
            apart_m=1e-18,
            error_a_m=1.0,
            error_b_m=1.0,
        ),  # one engine: no surprise
        AgreementRow(
            scene="s",
            engine_a="one",
            method_a="a",
            engine_b="two",
            method_b="c",
            apart_m=1e-6,
            error_a_m=0.5,
            error_b_m=0.6,
        ),
        AgreementRow(
            scene="s",
            engine_a="one",
            method_a="a",
            engine_b="three",
            method_b="d",
            apart_m=1e-9,
            error_a_m=0.5,
            error_b_m=0.7,
        ),
    ]
    told = found(agreement_findings(pairs))
    assert told == {"agreement distance": ("one:a", 1e-9, None), "agreement error": ("one:a", 0.7, None)}
