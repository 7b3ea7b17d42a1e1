"""The central impact by a soft law against closed forms, which share nothing with its integration."""

import math

import pytest

from tumble.compare.contact.impacts import DEEPEST, REBOUND
from tumble.compare.contact.own_law import central_impact
from tumble.compare.engines.parts.soft_law import APPROACH, HUNT_CROSSLEY, IMPEDANCE, SPRING, SoftLaw

MASS, STIFFNESS, SPEED = 0.7, 3e4, 2.0
RATE = math.sqrt(STIFFNESS / MASS)


def rebound(ratio: float) -> float:
    """Restitution of a spring and damper that only push: Schwager & Poschel, Granular Matter 9 (2007) 465."""
    root = math.sqrt(abs(1 - ratio * ratio))
    return math.exp(-2 * ratio * (math.acos(ratio) if ratio < 1 else math.acosh(ratio)) / root)


@pytest.mark.parametrize("ratio", [0.05, 0.4, 2.5])
def test_a_spring_and_a_damper_give_their_restitution(ratio):
    plain = SoftLaw(SPRING, STIFFNESS, 2 * ratio * RATE * MASS)
    assert central_impact(plain, MASS, SPEED, 0.0)[REBOUND] == pytest.approx(SPEED * rebound(ratio), rel=1e-9)
    # Of a constant impedance z the stiffness is z^2 k, the damping z c.
    z = 0.8
    own = SoftLaw(IMPEDANCE, (RATE / z) ** 2, 2 * ratio * RATE / z, (z, z, 1e-3, 0.5, 2.0))
    assert central_impact(own, MASS, SPEED, 0.0)[REBOUND] == pytest.approx(SPEED * rebound(ratio), rel=1e-9)


def test_a_damper_on_the_approach_alone_leaves_the_way_back_to_the_spring():
    """With a damping ratio z it turns at v/w e^(-z arccos(z) / sqrt(1 - z^2)), from where the spring gives all back."""
    z = 0.3
    found = central_impact(SoftLaw(APPROACH, STIFFNESS, 2 * z * RATE * MASS), MASS, SPEED, 0.0)
    left = SPEED * math.exp(-z * math.acos(z) / math.sqrt(1 - z * z))
    assert found[REBOUND] == pytest.approx(left, rel=1e-9)
    assert found[DEEPEST] == pytest.approx(left / RATE, rel=1e-9)


def test_gravity_presses_a_spring_further():
    """Energy: k x^2 / 2 = m v^2 / 2 + m g x; and with an impedance z only 1 - z of gravity is left."""
    g = 9.81
    sag = g / RATE**2
    found = central_impact(SoftLaw(SPRING, STIFFNESS, 0.0), MASS, SPEED, -g)
    assert found[DEEPEST] == pytest.approx(sag + math.hypot(sag, SPEED / RATE), rel=1e-9)
    # Read off as of a rigid impact in the middle of the contact, from y + sag = sag cos(wt) - v/w sin(wt).
    lasts = 2 * (math.pi - math.atan(SPEED * RATE / g)) / RATE
    assert found[REBOUND] == pytest.approx(SPEED + g * lasts / 2, rel=1e-9)
    z, sag = 0.6, 0.4 * sag
    found = central_impact(SoftLaw(IMPEDANCE, (RATE / z) ** 2, 0.0, (z, z, 1e-3, 0.5, 2.0)), MASS, SPEED, -g)
    assert found[DEEPEST] == pytest.approx(sag + math.hypot(sag, SPEED / RATE), rel=1e-9)


def test_hunt_and_crossley_give_their_restitution():
    """d v (1 + e) = log((1 + d v) / (1 - d v e)): their equation, integrated over the depth."""
    d = 0.2
    e = central_impact(SoftLaw(HUNT_CROSSLEY, STIFFNESS, d), MASS, SPEED, 0.0)[REBOUND] / SPEED
    assert d * SPEED * (1 + e) == pytest.approx(math.log((1 + d * SPEED) / (1 - d * SPEED * e)), rel=1e-9)
    assert e < 0.9


def test_what_does_not_come_out_has_no_rebound():
    """MuJoCo's default lets go of a ball that falls fast far below the plane, to which it does not return."""
    impedance = (0.9, 0.95, 0.001, 0.5, 2.0)
    law = SoftLaw(IMPEDANCE, 1 / (0.95 * 0.02) ** 2, 2 / (0.95 * 0.02), impedance)
    assert REBOUND not in central_impact(law, MASS, 4.4, -9.81)
