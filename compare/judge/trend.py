"""What becomes of the energy of the spin: the part of a flight in which integrators differ in kind."""

import numpy as np

from tumble.compare.judge import mechanics
from tumble.compare.judge.errors import Run, quietly
from tumble.scenarios.frames import Array

# What may become of it, from good to bad.
TRENDS = {"conserved": 0, "oscillates": 1, "grows": 2, "decays": 2}
# Rounding leaves up to 1e-11 in 1e5 steps; what a method loses by its kind is far above.
KEPT = 1e-9
# A drift that ends below this share of its largest has come back.
CAME_BACK = 0.5


def spin_energy(run: Run) -> str:
    """Return one of TRENDS: the drift of w.I w / 2 from the truth, over its largest true value.

    Empty where nothing turns, where a force feeds the spin, or there is nothing to hold it against.  The translation's
    part is left out: falling has an energy error of its own, which would hide what becomes of the spin.
    """
    if not run.has_errors or run.truth is None or not run.scene.is_free:
        return ""
    true = mechanics.spin_energy(run.truth.states, run.scene.body)
    if not true.max() > 0:
        return ""
    with quietly():
        return trend((mechanics.spin_energy(run.flight.states, run.scene.body) - true) / true.max())


def trend(drift: Array) -> str:
    """Return the word for a drift over the rows, (R, N), by the throw where it is largest."""
    if not np.isfinite(drift).all():
        return "grows"
    own = drift[:, np.argmax(abs(drift).max(axis=0))]
    largest, final = abs(own).max(), own[-1]
    if largest <= KEPT:
        return "conserved"
    if abs(final) < CAME_BACK * largest:
        return "oscillates"
    return "grows" if final > 0 else "decays"
