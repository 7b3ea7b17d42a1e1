"""Free rotation to many instants at once, by the closed form."""

from pathlib import Path

from tumble.compare.grade.model.kernel.dynamics import Array
from tumble.solver.compilation import kernel_with
from tumble.solver.integrators.exact import exact
from tumble.solver.vectors import Vector


@kernel_with(Path(__file__).parent)
def coast(spins: Array, times_s: Array, inverse_moments: Vector, gyroscopic: Vector | None) -> None:
    """Turn each row for a time of its own [s], (T,); spins: as `tumble.solver.integrators.exact` has them, (T, 14)."""
    for row in range(len(times_s)):
        exact(spins[row : row + 1], 1, times_s[row], inverse_moments, gyroscopic)
