"""Which contestants are the same integrator, found from the numbers: agreement is no evidence of being right."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Annotated

import numpy as np

from tumble.compare.judge.errors import Run

# Two that lie this much closer to each other than either does to the truth share their mistake.
SHARED = 1e-3


@dataclass(frozen=True, kw_only=True)
class AgreementRow:
    """Two contestants that agree with each other far better than with the truth."""

    scene: Annotated[str, "name of the scene"]
    engine_a: Annotated[str, "engine of the one contestant"]
    method_a: Annotated[str, "METHOD[@TOLERANCE] of the one contestant"]
    engine_b: Annotated[str, "engine of the other contestant"]
    method_b: Annotated[str, "METHOD[@TOLERANCE] of the other contestant"]
    apart_m: Annotated[float, "largest distance between their vertices"]
    error_a_m: Annotated[float, "largest vertex error of the one"]
    error_b_m: Annotated[float, "largest vertex error of the other"]

    @property
    def contestant_a(self) -> str:
        """ENGINE:METHOD of the one."""
        return f"{self.engine_a}:{self.method_a}"

    @property
    def contestant_b(self) -> str:
        """ENGINE:METHOD of the other."""
        return f"{self.engine_b}:{self.method_b}"


def agreements(runs: Sequence[Run]) -> Iterator[AgreementRow]:
    """Yield the pairs of one scene whose largest distance apart is below SHARED of the smaller of their errors."""
    flown = [run for run in runs if run.has_errors and np.isfinite(run.distances).all()]
    for a, b in combinations(flown, 2):
        errors = float(a.distances.max()), float(b.distances.max())
        apart = float(np.linalg.norm(a.errors - b.errors, axis=-1).max())
        # Below the truth's limit a distance tells nothing, so errors must stand that much above it.
        if SHARED * min(errors) > a.limits.max() and apart < SHARED * min(errors):
            yield AgreementRow(
                scene=a.scene.name,
                engine_a=a.engine,
                method_a=a.method,
                engine_b=b.engine,
                method_b=b.method,
                apart_m=apart,
                error_a_m=errors[0],
                error_b_m=errors[1],
            )
