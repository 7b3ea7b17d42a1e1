"""`tumble.reference`: the reference solution of a scene, with its error bound."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from tumble.api.result import with_units
from tumble.api.scene import Scene, SceneLike
from tumble.compare.tables.trajectory import trajectory_frame
from tumble.scenarios.truth import truth


def reference(scene: SceneLike, times: Sequence[float] | None = None) -> pd.DataFrame:
    """Return the reference solution of a scene.

    Parameters
    ----------
    scene : a name, a path, a table as in TOML, or a `Scene`.
    times : sample instants [s], increasing, (S,); None: the scene's own.

    Returns
    -------
    pandas.DataFrame
        One row a sample, first t = 0, with the columns of a trajectory and `bound_m`, the error bound, and
        `input_error_m`, how far rounding the inputs moves a vertex.  With many members a first column `member`.
        `attrs` has `units`, `how` it was made, and `horizon_s`, after which no double-precision program can follow.

    Raises
    ------
    NoTruth
        Where the motion cannot be determined; the message says why.

    Examples
    --------
    >>> import tumble
    >>> float(tumble.reference("two-hits", [0.5]).bound_m.max()) < 1e-14
    True
    """
    given = Scene.of(scene)
    if times is not None:
        asked_for = np.ravel(times).tolist()
        last = float(max(asked_for, default=0.0))
        given = given.replace(times=asked_for, duration=max(given.document["duration"], last))
    asked = given.question
    true = truth(asked)
    errors = {"bound_m": true.bound.T.ravel(), "input_error_m": true.input_error.T.ravel()}
    found = with_units(trajectory_frame(true, asked.body).assign(**errors))
    found.attrs |= {"how": true.how, "horizon_s": true.horizon}
    return found
