"""What a comparison found, from planted rows."""

from tumble.compare.comparison.findings import agreement_findings, error_findings
from tumble.compare.judge.agreement import AgreementRow
from tumble.compare.tables.shared import RunRow


def run(
    engine: str, method: str, error_m: float | None, resolution_m: float | None = 1e-12, status: str = "ok"
) -> RunRow:
    return RunRow("s", engine, method, 0.01, None, 10, status, "", error_m, error_m, error_m, resolution_m)


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
    assert found(told)["nearest"] == ("tumble:exact", 1e-15, 1e-12)
    assert found(told)["nearest engine"] == ("one:rk4", 1e-6, 1e-12)
    assert found(told)["furthest"] == ("handcalc:as-printed", 3.0, 1e-12)
    assert found(told)["unfinished"][1] == 1
    assert found(told)["unable"][1] == 1
    assert [row.contestant for row in told if row.finding == "asked for"] == ["one:euler", "handcalc:as-printed"]
    shipped = {row.engine: (row.method, row.value) for row in told if row.finding == "as shipped"}
    assert shipped == {
        "tumble": ("exact", 1e-15),
        "one": ("euler+defaults", 0.3),
        "two": ("only", float("inf")),
    }


def test_what_somebody_named_is_not_what_an_engine_does_as_it_ships():
    told = list(error_findings([run("one", "rk4", 1e-6), run("two", "euler", 1e-3)], {"one:euler", "two:euler"}))
    assert [row.contestant for row in told if row.finding == "as shipped"] == ["two:euler"]
    named = error_findings([run("one", "rk4", 1e-6), run("two", "euler", 1e-3)], {"two:euler"}, {"one:rk4"})
    assert [row.contestant for row in named if row.finding == "as asked"] == ["one:rk4"]


def test_an_error_below_what_the_truth_tells_ranks_as_that():
    """1e-15 and 2e-15 m are both at a limit of 1e-12: neither is nearer, and the first stays first."""
    rows = [run("one", "a", 2e-15), run("two", "b", 1e-15)]
    assert found(error_findings(rows))["nearest"][0] == "one:a"


def test_who_was_flagged_is_nearest_only_where_nobody_else_flew():
    rows = [run("one", "a", 1e-9, status="flagged"), run("two", "b", 1e-3)]
    assert found(error_findings(rows))["nearest"][0] == "two:b"
    assert found(error_findings(rows[:1]))["nearest"][0] == "one:a"


def test_of_agreeing_engines_the_most_misleading_pair_is_told():
    pairs = [
        AgreementRow("s", "one", "a", "one", "b", 1e-18, 1.0, 1.0),  # one engine: no surprise
        AgreementRow("s", "one", "a", "two", "c", 1e-6, 0.5, 0.6),
        AgreementRow("s", "one", "a", "three", "d", 1e-9, 0.5, 0.7),
    ]
    told = found(agreement_findings(pairs))
    assert told == {"apart": ("one:a", 1e-9, None), "both off": ("one:a", 0.7, None)}
