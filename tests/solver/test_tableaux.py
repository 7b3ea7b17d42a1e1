"""The numbers of Dormand & Prince's pair: against another transcription of them, and against what they are for."""

import numpy as np
import pytest
from scipy.integrate._ivp import dop853_coefficients as published

from tumble.solver.dop853 import ERROR_3, ERROR_5, STAGES, WEIGHTS

NODES = STAGES.sum(axis=1)
EPS = np.finfo(float).eps


def test_every_coefficient_is_the_published_one():
    np.testing.assert_array_equal(STAGES, published.A[:12, :12])
    np.testing.assert_array_equal(WEIGHTS, published.B)
    np.testing.assert_array_equal(ERROR_5, published.E5[:12])
    np.testing.assert_array_equal(ERROR_3, published.E3[:12])


def test_the_rows_sum_to_the_nodes():
    np.testing.assert_allclose(NODES, published.C[:12], rtol=0, atol=200 * EPS)


@pytest.mark.parametrize("power", range(8))
def test_the_weights_integrate_powers_up_to_the_seventh(power):
    # Order 8 on y' = f(t): sum b_i c_i^k = 1/(k + 1).  Source: Hairer, Norsett & Wanner (1993), eq. II.1.11.
    assert WEIGHTS @ NODES**power == pytest.approx(1.0 / (power + 1), abs=200 * EPS)


def test_they_do_not_integrate_the_eighth():
    assert abs(WEIGHTS @ NODES**8 - 1.0 / 9.0) > 1e-6


@pytest.mark.parametrize(("error", "order"), [(ERROR_5, 5), (ERROR_3, 3)])
def test_an_error_estimate_sees_nothing_below_its_order(error, order):
    for power in range(order):
        assert abs(error @ NODES**power) < 200 * EPS
    assert abs(error @ NODES**order) > 1e-4
