"""Table 4.1 of the CE1051A report as printed: one vertex of a cube, by hand and in Unity, at five times."""

import csv
import math
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from tumble.scenarios.frames import Array

# Eq. 4.2 prints p0 = (-2.5, 0, -2.5); the printed results (4.10 and the calculated column) come out only with the
# opposite sign, (2.5, 0, 2.5), which is the vertex (+, -, +) of a cube centred at (0, 2.5, 0).
VERTEX = 5

PHYSICS_STEP_S = 0.02


@dataclass(frozen=True, eq=False)
class Table41:
    """The printed columns: clock on the screen [s], (5,); calculated and application positions [m], (5, 3)."""

    clock: Array
    calculated: Array
    application: Array

    @property
    def physics_times(self) -> Array:
        """The instants the application's positions belong to [s], (5,): whole physics steps, behind the clock."""
        steps = [math.floor((t - PHYSICS_STEP_S / 2) / PHYSICS_STEP_S) for t in self.clock]
        return np.array([round(n * PHYSICS_STEP_S, 2) for n in steps])


@cache
def table_4_1() -> Table41:
    """Return Table 4.1 as published.

    Returns
    -------
    table
    """
    text = Path(__file__).with_name("table_4_1.csv").read_text(encoding="utf-8")
    rows = list(csv.DictReader(text.splitlines()))

    def columns(name: str) -> Array:
        return np.array([[float(row[f"{name}_{axis}_m"]) for axis in "xyz"] for row in rows])

    return Table41(np.array([float(row["t_clock_s"]) for row in rows]), columns("calculated"), columns("application"))
