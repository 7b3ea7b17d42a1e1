"""Free rotation to many times at once, in closed form."""

from pathlib import Path

from tumble.compare.grade.model.kernel.dynamics import Array
from tumble.solver.compilation import kernel_with
from tumble.solver.integrators.exact import exact
from tumble.solver.vectors import Vector


@kernel_with(Path(__file__).parent)
def coast(spins: Array, times_s: Array, inverse_moments: Vector, gyroscopic: Vector | None) -> None:
    """Rotate each row for its own time [s], (T,); spins: rows of `tumble.solver.integrators.exact`, (T, 14)."""
    for row in range(len(times_s)):
        exact(spins[row : row + 1], 1, times_s[row], inverse_moments, gyroscopic)
