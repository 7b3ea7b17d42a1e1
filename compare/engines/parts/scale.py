"""A factor for engines that take small masses and moments for nothing."""

import math


def scale_to_one(*masses_and_moments: float) -> float:
    """Return the power of two that takes the smallest to about one.

    Motion depends on ratios only, of masses, moments and forces, and a power of two changes no bit of it.
    """
    return math.ldexp(1.0, -math.frexp(min(masses_and_moments))[1])
