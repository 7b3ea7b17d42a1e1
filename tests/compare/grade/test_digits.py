"""What printed figures tell: the place of the last digit, single precision, clocks rounded to a place."""

import numpy as np
import pytest

from tumble.compare.grade.read.digits import digits, rounded_times, with_exact_numbers, with_shared_format


def test_figures_of_a_fixed_format_leave_half_of_their_last_place_open():
    found = digits([f"{value:.4f}" for value in np.linspace(-3.0, 7.0, 40)])
    assert found.fixed
    assert found.place == pytest.approx(1e-4)
    np.testing.assert_allclose(found.half(np.array([0.01, 7.0])), 0.5e-4)


def test_figures_of_six_digits_leave_more_open_where_a_number_is_large():
    found = digits([f"{value:.6g}" for value in np.geomspace(1e-3, 7e3, 40)])
    assert found.figures == 6
    np.testing.assert_allclose(found.half(np.array([1234.56, 0.001234567])), [0.5e-2, 0.5e-8])


def test_numbers_of_single_precision_are_told_from_doubles():
    values = np.random.default_rng(1).normal(size=30)
    single, double = (digits(map(repr, kind.tolist())) for kind in (values.astype(np.float32).astype(float), values))
    assert (single.single, single.is_decisive) == (True, True)
    assert not double.single
    # Nine digits of a double are a number of single precision one time in a hundred.
    assert digits([f"{value:.9g}" for value in values.astype(np.float32).astype(float)]).single
    assert not digits([f"{value:.9g}" for value in values]).single


def test_fewer_than_nine_digits_refute_single_precision_but_do_not_show_it():
    values = np.random.default_rng(1).normal(size=30)
    six, eight = (digits([f"{value:.{figures}g}" for value in values]) for figures in (6, 8))
    assert (six.single, six.is_decisive) == (True, False)
    assert not eight.single
    singles = digits([f"{value:.8g}" for value in values.astype(np.float32).astype(float)])
    assert (singles.single, singles.is_decisive) == (True, False)


def test_zeros_at_the_end_do_not_tell_single_precision():
    short = digits([f"{value:.7f}" for value in 100 * (8 * np.linspace(0, 10, 41) - 4.9 * np.linspace(0, 10, 41) ** 2)])
    assert not short.is_decisive


def test_a_short_column_is_taken_for_one_of_its_neighbours():
    short, long = digits(["0.05", "0.1", "0.15"]), digits(["0.05123", "0.1", "0.15777"])
    assert [each.place for each in with_shared_format([short, long])] == pytest.approx([1e-5, 1e-5])
    assert with_shared_format([short]) == [short]


def test_a_constant_column_says_nothing_of_rounding():
    assert digits(["1.5"] * 5).half(np.array([1.5]))[0] < 1e-15


def test_lengths_in_centimetres_show_that_metres_were_of_single_precision():
    metres = np.random.default_rng(1).normal(size=30).astype(np.float32).astype(float)
    centimetres = [f"{100 * value:.9g}" for value in metres]
    assert not digits(centimetres).single
    assert digits(centimetres, 0.01).single
    assert not digits([f"{value:.9g}" for value in np.random.default_rng(1).normal(size=30)], 0.01).single


def columns_of(x):
    """Return the formats of a column and of one of nine digits, and their numbers."""
    cells = {
        "x": [f"{value:.9g}" for value in x],
        "q": [f"{value:.9g}" for value in np.sin(np.arange(1.0, len(x) + 1))],
    }
    return {name: digits(each) for name, each in cells.items()}, {
        name: [*map(float, each)] for name, each in cells.items()
    }


def test_numbers_that_are_exact_in_few_decimals_are_as_precise_as_the_others():
    """0.12 m/s over 0.02 s: no zeros are written at the end."""
    formats, numbers = columns_of(0.5 + 0.0024 * np.arange(60.0))
    assert formats["x"].half(np.array([0.5]))[0] == pytest.approx(5e-5)
    found = with_exact_numbers(formats, [["x"], ["q"]], numbers)
    assert found["x"].half(np.array([0.5]))[0] == pytest.approx(5e-10)
    assert formats["x"].single
    assert not found["x"].single, "of single precision, they would have nine digits"
    assert found["q"] == formats["q"]


@pytest.mark.parametrize(
    "x",
    [
        pytest.param((0.5 + 0.001234 * np.arange(60.0)).round(4), id="rounded"),
        pytest.param((0.5 + 0.0024 * np.minimum(np.arange(60.0), 40.0)).round(4), id="at rest at the end"),
        pytest.param(0.5 + 0.0024 * np.arange(12.0), id="few rows"),
    ],
)
def test_numbers_that_may_be_rounded_are_as_precise_as_they_look(x):
    formats, numbers = columns_of(x)
    assert with_exact_numbers(formats, [["x"], ["q"]], numbers) == formats


def test_numbers_of_a_throw_are_exact_though_two_are_equal_at_its_top():
    formats, numbers = columns_of(0.0049 * (30.5**2 - (np.arange(60.0) - 30.5) ** 2))
    assert len(set(numbers["x"])) < 60
    assert with_exact_numbers(formats, [["x"], ["q"]], numbers)["x"].figures == 9


def test_numbers_that_do_not_change_at_first_show_no_exactness():
    formats, numbers = columns_of(0.5 + 0.0024 * np.arange(60.0))
    assert with_exact_numbers(formats, [["x"], ["q"]], numbers | {"x": [0.5] * 60}) == formats


def test_one_rounded_column_shows_that_its_neighbours_are_rounded_as_well():
    formats, numbers = columns_of(0.5 + 0.0024 * np.arange(60.0))
    y = (0.5 + 0.001234 * np.arange(60.0)).round(4)
    formats["y"], numbers["y"] = digits([f"{value:.9g}" for value in y]), y.tolist()
    assert with_exact_numbers(formats, [["x", "y"], ["q"]], numbers) == formats


def test_an_even_clock_that_is_rounded_is_told_from_an_uneven_one():
    even = np.arange(1, 30) / 60
    assert rounded_times(even.round(3), 1e-3)
    assert not rounded_times(even, 1e-3)
    assert not rounded_times(even + 5e-3 * np.sin(np.arange(29.0)), 1e-3)


def test_many_uneven_instants_are_rounded_unless_they_are_whole_intervals():
    frames = np.cumsum(np.random.default_rng(2).uniform(0.012, 0.021, 60))
    assert rounded_times(frames.round(3), 1e-3)
    assert not rounded_times(frames.round(3)[:20], 1e-3), "too few: they may be meant as they are"
    lost = np.delete(np.arange(80) * 0.02, [7, 8, 30])
    assert not rounded_times(lost, 1e-2), "rows are missing"
