"""docs/many-machines.md: its table of efficiency is what tools.efficiency measured."""

from tools import efficiency


def test_the_table_is_that_of_the_recorded_measurements():
    text = efficiency.PAGE.read_text(encoding="utf-8")
    assert efficiency.page(text) == text
    assert {row["workload"] for row in efficiency.recorded()} == {*efficiency.THROWS}


def test_the_model_has_the_measured_time_with_one_worker_and_what_is_serial_without_end():
    figures = {"workload": "ledger", "workers": "1", "processor_s": "10", "serial_s": "1"}
    assert efficiency.model([figures]) == ["release ledger", "1", "9", "100%", "91%", "77%", "40%", "9%"]
