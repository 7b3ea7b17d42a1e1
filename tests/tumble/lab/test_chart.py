"""The chart of errors: lengths on its axis, curves where the errors are, and the instant that is shown."""

import re
from xml.etree import ElementTree

import numpy as np
import pytest

from tumble.lab.chart import BOTTOM, LEFT, RIGHT, TOP, Curve, chart, ticks_x, ticks_y

TIMES = np.linspace(0.0, 2.0, 21)
LIMIT = np.full(21, 1e-15)
EVIL = '"><script>alert(1)</script>'


def curve(errors, name="a") -> Curve:
    return Curve(name, TIMES, errors, "rgb(1, 2, 3)", "")


def drawn(svg: str, colour: str = "rgb(1, 2, 3)") -> np.ndarray:
    """Return the points of the curve of a colour, (n, 2)."""
    (path,) = (one for one in ElementTree.fromstring(svg).iter() if one.get("stroke") == colour)
    return np.array(re.findall(r"([\d.]+) ([\d.]+)", path.get("d")), dtype=float)  # pyright: ignore[reportCallIssue]


def test_a_decade_is_as_high_everywhere():
    errors = np.logspace(-9, -3, 21)
    points = drawn(chart(TIMES, [curve(errors)], LIMIT, 0))
    # From the second row on, the first is t = 0; the axis goes from the limit to the largest error.
    height = (BOTTOM - TOP) / 12
    assert np.diff(points[:, 1]) == pytest.approx(np.full(19, -0.3 * height), abs=0.11)
    assert points[-1] == pytest.approx((RIGHT, TOP), abs=0.1)


def test_the_axis_says_lengths_and_seconds():
    texts = [one.text for one in ElementTree.fromstring(chart(TIMES, [curve(np.full(21, 1e-3))], LIMIT, 0)).iter()]
    assert {"1 mm", "1 µm", "1 nm", "1 pm", "1 fm"} <= set(texts)
    assert "2 s" in texts
    assert not any("log" in text or text == "10" for text in texts if text)


def test_the_instant_shown_is_a_line_with_a_dot_on_each_curve_that_is_known_there():
    known, unknown = np.full(21, 1e-3), np.full(21, np.nan)
    unknown[:5] = 1e-6
    root = ElementTree.fromstring(chart(TIMES, [curve(known), curve(unknown, "b")], LIMIT, 10))
    (now,) = (one for one in root.iter() if one.tag == "line" and one.get("x1") == one.get("x2"))
    assert float(now.get("x1")) == pytest.approx((LEFT + RIGHT) / 2)
    (dot,) = (one for one in root.iter() if one.tag == "circle")
    assert float(dot.get("cx")) == pytest.approx((LEFT + RIGHT) / 2)


def test_there_is_no_chart_of_nothing():
    assert chart(TIMES, [curve(np.full(21, np.nan))], np.full(21, np.nan), 0) == ""


def test_names_are_text():
    svg = chart(TIMES, [curve(np.full(21, 1e-3), EVIL)], LIMIT, 0)
    assert "<script" not in svg
    ElementTree.fromstring(svg)


@pytest.mark.parametrize(("low", "high"), [(-18, 1), (-15, -3), (-5, -3), (-2, 0), (-300, 200)])
def test_few_decades_have_a_line_and_they_are_units_where_there_are_many(low, high):
    ticks = ticks_y(low, high)
    assert 1 <= len(ticks) <= 8
    assert high - low <= 6 or all(tick % 3 == 0 for tick in ticks)


@pytest.mark.parametrize("end", [0.1, 0.4, 0.5, 1.0, 1.2, 2.0, 10.0, 30.0, 7e-5])
def test_times_on_the_axis_are_round_and_few(end):
    ticks = ticks_x(end)
    assert 3 <= len(ticks) <= 7
    assert ticks[-1] <= end * (1 + 1e-9)
