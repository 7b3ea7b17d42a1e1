"""The kinds of mistakes, by their labels: what students, games and simulators get wrong.

Whether `tumble grade` has a name for one is not known here but in `names.py`.
"""

from tools.random_programs.mistakes import clock, forces, impulse, log, rotation, start
from tools.random_programs.mistakes.kind import KINDS, Kind, Params

# Mistakes whose size depends on how many steps are taken.
PER_STEP = frozenset(
    {
        "gravity accumulates", "inertia turned every n-th step only", "every n-th step turned on the wrong side",
        "uneven steps", "attitude in few bits", "velocity in half precision", "angular velocity in eighths",
        "far from the origin in single precision", "impulse times dt", "gravity times dt",
    }
)  # fmt: skip

__all__ = ["KINDS", "PER_STEP", "Kind", "Params", "clock", "forces", "impulse", "log", "rotation", "start"]
