"""The closed form in gmpy2's numbers is that in mpmath's, which remain where there is no gmpy2."""

from dataclasses import replace

import gmpy2
import numpy as np
import pytest
from mpmath import MPContext

from tumble.scenarios.read import read_scene
from tumble.scenarios.truth import mpfr, truth
from tumble.scenarios.truth.inertia import root_of
from tumble.scenarios.truth.rational import Fraction
from tumble.scenarios.truth.resolution import PRECISIONS, closed_form
from tumble.scenarios.truth.throw import read_throw

# Axes that are no fractions and a mesh, a ray at a box, equal moments, near the separatrix, many turns.
SCENES = ("mesh-die", "die-ray", "die-vertex", "separatrix", "middle-axis", "ten-impulses", "spin-1e6", "plate")
# On the separatrix itself, L1^2 (4/3 - 1) = L3^2 (1 - 4/6): hyperbolic functions.
SEPARATRIX = """\
title = "On the separatrix"
duration = 9.0
samples = 4
step = 0.01
[body]
shape = "rigid"
mass = 1.0
inertia = [[3.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 6.0]]
points = [[0.5, 0.0, 0.0], [0.0, 0.5, 0.0], [0.0, 0.0, 0.5]]
angular_velocity = [1.0, 0.25, 0.5]
"""


@pytest.fixture(params=[*SCENES, "separatrix.toml"])
def scene(request, tmp_path):
    (tmp_path / "separatrix.toml").write_text(SEPARATRIX, encoding="utf-8")
    return read_scene(str(tmp_path / request.param) if request.param.endswith(".toml") else request.param)


def test_poses_are_those_of_mpmath_to_the_last_digits(scene, monkeypatch):
    throw, mp, bits = read_throw(scene, 0), MPContext(), PRECISIONS[1]
    fast = closed_form(mp, throw, bits)
    monkeypatch.setattr(mpfr, "gmpy2", None)
    slow = closed_form(mp, throw, bits)
    turned = sum(abs(float(rate)) for rate in throw.w_world) * float(throw.times[-1])
    for one, other in zip(fast.poses, slow.poses, strict=True):
        assert all(
            hasattr(number, "_mpf_") or isinstance(number, int | gmpy2.mpq) for part in one for number in part.flat
        )
        # Of PRECISIONS[1] no more than the radians and an unstable axis cost.
        assert abs(one.axes - other.axes).max() < mp.mpf(2) ** (20 - bits) * (1 + turned) ** 2
        assert abs(one.x - other.x).max() <= abs(other.x).max() * mp.mpf(2) ** (8 - bits)


@pytest.mark.parametrize("name", ["mesh-die", "two-hits"])
def test_a_truth_is_the_same_without_gmpy2s_numbers(name, monkeypatch):
    scene = replace(read_scene(name), title="")
    fast = truth(scene)
    monkeypatch.setattr(mpfr, "gmpy2", None)
    slow = truth(scene)
    assert np.array_equal(fast.states, slow.states)
    assert np.array_equal(fast.vertices, slow.vertices)
    assert fast.bound == pytest.approx(slow.bound, rel=1e-12)
    assert np.array_equal(fast.input_error, slow.input_error)


def test_numbers_go_there_and_back_unchanged():
    mp = MPContext()
    mp.prec = 168
    numbers = [mp.sqrt(2), -mp.pi / 3, mp.mpf(0), mp.ldexp(mp.e, -5000), mp.mpf(-1) / 3, mp.mpf(2) ** 300]
    mp.prec = 112  # they have more digits
    with gmpy2.context(precision=112):
        fast = mpfr.Mpfr(mp)
        there = [fast.of(number) for number in numbers]
        assert all(isinstance(number, gmpy2.mpfr) for number in there)
        assert fast.of(3) == fast.back(3) == 3
        assert [fast.back(number) for number in there] == numbers


def test_a_root_has_the_digits_of_its_number():
    with gmpy2.context(precision=200):
        assert root_of(gmpy2.mpfr(2)) == gmpy2.sqrt(gmpy2.mpfr(2))
    assert root_of(2.0) == 2.0**0.5
    assert root_of(Fraction(9, 4)) == Fraction(3, 2)
