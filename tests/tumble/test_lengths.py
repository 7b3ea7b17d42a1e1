"""Lengths on the command line: with a unit, or in metres."""

from argparse import ArgumentTypeError

import pytest

from tumble.parser import metres


@pytest.mark.parametrize(
    ("text", "value"),
    [("1mm", 1e-3), ("0.001", 1e-3), ("1e-3", 1e-3), ("50um", 5e-5), ("50 µm", 5e-5), ("1e2nm", 1e-7), ("2in", 0.0508),
     (".5cm", 5e-3), ("1.m", 1.0)],
)  # fmt: skip
def test_a_length_is_read_in_metres(text, value):
    assert metres(text) == pytest.approx(value, rel=1e-12)


@pytest.mark.parametrize(
    "text", ["mm", "1 parsec", "0mm", "-1mm", "nan", "inf", "1mm2", "", "1e", "1,5mm", "1MM", "1M"]
)
def test_what_is_no_length_is_refused(text):
    with pytest.raises(ArgumentTypeError, match=r"is not a positive length, such as 0\.001, 1mm or 50um"):
        metres(text)
