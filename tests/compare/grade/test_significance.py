"""What a residual weighs: nothing, noise, or a mistake."""

import numpy as np
import pytest

from tumble.compare.grade.measure.significance import (
    FITTED_VALUES,
    ResidualScale,
    autocorrelation,
    choice_cost,
    independent,
    is_even,
    root_mean_square,
    spares_rows,
)

SCALE = ResidualScale(numbers=600, floor_m=1e-6, size_m=0.3, floors_m=np.full((100, 3), 1e-6 / np.sqrt(3.0)))


def test_the_root_mean_square_is_of_lengths():
    assert root_mean_square(np.full((7, 2, 3), 2.0)) == pytest.approx(2.0 * np.sqrt(3.0))


def test_rows_of_noise_are_unrelated_and_those_of_a_drift_are_not():
    noise, drift = np.random.default_rng(2).normal(size=(400, 6)), np.linspace(0, 1, 400)[:, None] * np.ones(6)
    assert abs(autocorrelation(noise)) < 0.1
    assert autocorrelation(drift) > 0.98
    assert autocorrelation(np.tile([[1.0], [-1.0]], (200, 6))) == pytest.approx(-1.0)


def test_what_repeats_itself_every_few_rows_is_related():
    waves = np.tile(np.random.default_rng(3).normal(size=(3, 6)), (100, 1))
    assert abs(autocorrelation(waves)) == pytest.approx(1.0, abs=0.02)


def test_nothing_noise_and_a_mistake_are_told_apart():
    assert SCALE.is_within_floor(1.9e-6)
    assert not SCALE.is_within_floor(2.1e-6)
    assert SCALE.is_noise(1e-3, 4e-3, 0.05, 99)
    assert not SCALE.is_noise(1e-3, 4e-3, 0.5, 99), "its rows are related"
    assert not SCALE.is_noise(1e-3, 6e-3, 0.05, 99), "it has a spike"
    assert not SCALE.is_noise(0.05, 0.1, 0.05, 99), "it is too loud"
    assert not SCALE.is_noise(1e-3, 4e-3, 0.05, 9), "nine pairs say nothing"


def test_a_number_that_was_fitted_must_take_away_more_than_one_that_has_a_name():
    halved = SCALE.weight(500.0, SCALE.parameter_cost()), SCALE.weight(1000.0, 0.0)
    assert halved[0] < halved[1]
    hardly = SCALE.weight(990.0, SCALE.parameter_cost()), SCALE.weight(1000.0, 0.0)
    assert hardly[0] > hardly[1]
    assert SCALE.parameter_cost() > choice_cost(FITTED_VALUES) > choice_cost(2) > choice_cost(1) == 0.0


def test_below_the_floor_less_is_not_better():
    assert SCALE.weight(1e-6, 0.0) == pytest.approx(SCALE.weight(0.0, 0.0), abs=1e-6)


def test_a_row_that_is_known_well_counts_for_more():
    floors = np.full((2, 3), 1e-6 / np.sqrt(3.0))
    floors[1] *= 100.0
    weighted = ResidualScale(12, 1e-6, 0.3, floors).weighted(np.ones((2, 1, 3)))
    assert weighted[0, 0, 0] == pytest.approx(100.0 * weighted[1, 0, 0])


def test_a_pose_is_six_numbers_however_many_vertices_show_it():
    assert (independent(10, 1), independent(10, 8)) == (30, 60)


def test_noise_is_as_large_in_every_part_of_a_file_and_what_begins_later_is_not():
    noise = np.random.default_rng(4).normal(size=(40, 8, 3))
    assert is_even(noise)
    assert not is_even(np.where(np.arange(40)[:, None, None] < 12, 1e-3, 1.0) * noise)


def test_noise_spares_no_row_but_perhaps_the_first():
    floors = np.full((40, 3), 1e-5)
    noise = np.random.default_rng(5).normal(size=(40, 8, 3))
    assert not spares_rows(noise, floors)
    assert not spares_rows(np.where(np.arange(40)[:, None, None] == 0, 0.0, noise), floors)
    assert spares_rows(np.where(np.arange(40)[:, None, None] % 4 == 0, 1e-5, noise), floors)
    # Where an error is as small as the digits, some rows are right by chance.
    assert not spares_rows(1e-5 * np.round(noise), floors)
