"""Contestants in extreme cases: scenes with extreme numbers (`tumble.scenarios.extremes`).

Each is free motion with an exact reference solution.
"""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tumble.compare.engines import OWN
from tumble.compare.judge.errors import RunAnswer
from tumble.compare.judge.verdict import verdict
from tumble.compare.run.flight import legs
from tumble.compare.run.running_engines import RunningEngine
from tumble.compare.run.status import Failure, Status
from tumble.compare.stability.modes import stiffest_mode
from tumble.compare.stability.schemas import ExtremeRow
from tumble.compare.tables.runs import boundless
from tumble.scenarios.scene import Scene
from tumble.scenarios.truth import Truth

BEST, FLOORS = f"{OWN}:exact", 10.0
BUDGET_S = 6.0  # run time of one run
# Of an adaptive method this share of the run is tried, to see whether all of it fits into the budget: first the share
# in which the body turns by a radian, then so many times more.  The first try may include compilation.
SHARE, LONGER, LOOKS = 1 / 256, 4.0, 2

# The cases on the page: short runs, each of which shows something that no other does.
OF_A_PAGE = (
    "spin-1e2",
    "spin-1e3",
    "spin-1e4",
    "spin-1e6",
    "step-1",
    "middle-axis",
    "separatrix",
    "ten-impulses",
    "inertia-1e6",
    "needle",
    "plate",
    "micrometre",
    "thousand-km",
    "mass-1e-9",
    "far-1e7",
    "denormal",
)
PAGE_BUDGET_S = 0.25


def extreme(
    running_engine: RunningEngine, method: str, scene: Scene, true: Truth, budget_s: float = BUDGET_S
) -> ExtremeRow:
    """Return the result of one contestant in one case, in a run time of at most budget_s [s]."""
    answer = too_long(running_engine, method, scene, budget_s) or running_engine.simulate(scene, method, scene.step)
    run = RunAnswer.of(running_engine, method, scene.step, answer).run(scene, running_engine.title, true)
    found = verdict(run)
    row = ExtremeRow(
        scene=scene.name,
        title=scene.title,
        engine=running_engine.title,
        method=method,
        dt_s=scene.step,
        status=run.status.value,
        verdict=found.word,
        why=found.why,
        size_m=scene.body.reach,
    )
    if isinstance(answer, Failure):
        return row
    worst = run.distances.max(axis=(1, 2))
    ratio = float(np.max(worst / run.limits.max(axis=1))) if np.isfinite(worst).all() else math.inf
    return replace(
        row,
        steps=answer.steps,
        max_error_m=boundless(worst.max()),
        resolution_m=float(run.limits.max()),
        error_over_resolution=ratio,
        energy_ratio=found.energy_ratio,
        why="; ".join(dict.fromkeys(filter(None, (found.why, *run.notes)))),
    )


def too_long(running_engine: RunningEngine, method: str, scene: Scene, budget_s: float) -> Failure | None:
    """Return that a run would not fit into the budget, or None.

    By its steps and the engine's stated cost of one; for an adaptive method, whose steps are unknown, by the CPU time
    of a share of the run: no wall clock is read, so that a busy machine has the same rows.
    """
    info = running_engine.info
    if isinstance(info, Failure) or method in info.whole:
        return None
    if running_engine.takes_own_steps(method):
        found = needed_for_all(running_engine, method, scene, budget_s)
        if isinstance(found, Failure):
            return found
        work, needed = f"{scene.duration:g} s of motion", found
    else:
        steps = sum(leg.n for leg in legs(scene, scene.step))
        work, needed = f"{steps:.0e} steps", steps * info.step_of(method) / 1e9
    if needed <= budget_s:
        return None
    return Failure(Status.TIMEOUT, f"{work} would take {needed:.2g} s, the limit is {budget_s:g} s")


def needed_for_all(running_engine: RunningEngine, method: str, scene: Scene, budget_s: float) -> float | Failure:
    """Return the CPU time that an adaptive method needs for a run [s], as far as a share of it shows, or its failure.

    It is 0 for a share that fits.  A shorter one that takes LONGER times as much as SHARE may, and so more than what
    any run costs before its first step, is the last.
    """
    share = 1 / max(1 / SHARE, scene.duration * stiffest_mode(scene).rate)
    while True:
        seconds, took = share * scene.duration, math.inf
        most = SHARE * budget_s * (1.0 if share == SHARE else LONGER)
        impulses = tuple(each for each in scene.impulses if each.time < seconds)
        begun = replace(scene, duration=seconds, times=np.array([seconds]), impulses=impulses)
        for _ in range(LOOKS):
            answer = running_engine.simulate(begun, method, scene.step)
            if isinstance(answer, Failure):
                return answer
            if answer.diverged_at is not None:
                return 0.0  # all of the run diverges as soon
            took = min(took, answer.cpu_s)
            if took <= most:
                break
        else:
            return took / share
        if share == SHARE:
            return 0.0
        share = min(SHARE, LONGER * share)


def missed(rows: Sequence[ExtremeRow]) -> list[ExtremeRow]:
    """Return the extreme cases in which our best method is not accurate enough.

    Parameters
    ----------
    rows : rows of extremes.csv

    Returns
    -------
    its rows with errors above FLOORS times the resolution
    """
    best = [row for row in rows if f"{row.engine}:{row.method}" == BEST]
    return [row for row in best if row.error_over_resolution is None or not row.error_over_resolution <= FLOORS]
