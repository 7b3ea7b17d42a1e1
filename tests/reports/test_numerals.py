"""Numbers for people read back to what they were."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from tumble.reports.numerals import MINUS, SUPERSCRIPTS, TIMES_TEN, figure, fixed
from tumble.reports.terminal import vector


@settings(derandomize=True, deadline=None)
@given(st.floats(-1e300, 1e300))
def test_a_figure_reads_back_to_its_three_digits(value):
    digits = {small: sign for sign, small in SUPERSCRIPTS.items()}
    mantissa, _, power = figure(value).replace(MINUS, "-").partition(TIMES_TEN)
    back = float(mantissa + ("e" + "".join(digits[small] for small in power) if power else ""))
    # Half a unit of the third digit is at most 1/200 of the number; below the normal numbers they are fewer.
    assert abs(back - value) <= 0.00501 * abs(value) + 5e-324


def test_what_decimals_leave_nothing_of_has_no_sign():
    assert (fixed(-0.004, 2), fixed(-0.006, 2)) == ("0.00", f"{MINUS}0.01")
    assert vector(np.array((-0.0, -0.004, -0.006)), 2) == "(0.00, 0.00, -0.01)"
