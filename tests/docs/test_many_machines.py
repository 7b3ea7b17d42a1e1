"""docs/many-machines.md: its table of efficiency is what tools.efficiency measured."""

from tools import efficiency


def test_the_table_is_that_of_the_recorded_file():
    text = efficiency.PAGE.read_text(encoding="utf-8")
    assert efficiency.page(text) == text


def test_the_model_is_that_of_amdahl():
    figures = {"workload": efficiency.LEDGER, "workers": "1", "processor_s": "10", "serial_s": "1", "adding_s": "0"}
    cells = efficiency.model(efficiency.LEDGER, [figures]).split("|")
    assert cells[2:4] == [" 1 ", " 9 "]
    # 10 s on one machine, 1 s + 9 s / 2 on two.
    assert cells[4:6] == [" 100% ", f" {10 / (2 * 5.5):.0%} "]
