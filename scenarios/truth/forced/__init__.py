"""The true answer of a scene with forces, integrated in compiled numbers of 32 digits.

`laws` writes down the equations of motion, one function a force; `series` runs them as operations on power series,
`switches` finds where the floor begins and ceases to push, `passage` flies from one of these to the next, `flight` the
whole throw, `together` several throws at once, and `resolution` says how good the answer is.
"""

from tumble.scenarios.truth.forced.resolution import answer, simulate

__all__ = ["answer", "simulate"]
