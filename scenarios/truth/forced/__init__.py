"""The true answer of a scene with forces, integrated in compiled doubles.

`laws` has the equations of motion, one function a force; `radau` makes one step, `switches` finds where the floor
begins and ceases to push, `passage` flies from one blow to the next, `flight` the whole throw, and `limit` says how
good the answer is.
"""

from scenarios.truth.forced.flight import Unending
from scenarios.truth.forced.limit import answer

__all__ = ["Unending", "answer"]
