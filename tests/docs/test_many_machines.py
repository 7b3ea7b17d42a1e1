"""docs/many-machines.md: its table of efficiency is what tools.efficiency measured."""

import pytest

from tools import efficiency


def test_the_table_is_that_of_the_recorded_measurements():
    text = efficiency.PAGE.read_text(encoding="utf-8")
    assert efficiency.page(text) == text


def test_the_model_has_the_measured_time_with_one_worker_and_what_is_serial_without_end():
    figures = {"workload": "ledger", "workers": "1", "processor_s": "10", "serial_s": "1"}
    assert efficiency.model([figures], 1) == ["release ledger", "1", "1", "8", "100%", "83%", "62%", "25%", "5%"]


def test_what_each_worker_takes_is_fitted_to_all_numbers_of_workers():
    rows = [{"workers": str(n), "processor_s": str(10 + 3 * n)} for n in (1, 2, 4, 1)]
    assert efficiency.of_each_worker(rows) == pytest.approx(3)
