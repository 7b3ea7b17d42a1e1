"""The rows of a sweep: Pareto front, cost of each error, orders of convergence, equal integrators, times."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
import pandas as pd

from tumble.compare.judge.agreement import SHARED
from tumble.compare.judge.cost import Timed
from tumble.compare.judge.errors import Run
from tumble.compare.judge.orders import ASYMPTOTIC, LAST, Level, local_orders, parts
from tumble.compare.run.contestant import Contestant, MethodName
from tumble.compare.run.precision import precision
from tumble.compare.run.status import Status
from tumble.compare.run.timing.readings import ratio
from tumble.compare.sweep.schemas import (
    AccuracyCostRow,
    EnsembleRow,
    EquivalentRow,
    OrderRow,
    TimingRow,
    WorkPrecisionRow,
)
from tumble.compare.sweep.work_precision import TARGETS_M, Sweep
from tumble.compare.tables.runs import contestant_columns, status_columns, step_columns

UNTIMED = "untimed"


def ensemble_rows(sweep: Sweep) -> Iterator[EnsembleRow]:
    """Yield the spread over the throws of every run with status ok, if there are many throws."""
    if len(sweep.scene.start) > 1:
        for each in usable(sweep.timed):
            low, median, high = pd.Series(each.run.throws_errors).quantile([0.05, 0.5, 0.95]).tolist()
            yield EnsembleRow(
                **contestant_columns(each.run),
                **step_columns(each.run),
                members=len(sweep.scene.start),
                p5_error_m=low,
                median_error_m=median,
                p95_error_m=high,
            )


def usable(timed: Sequence[Timed]) -> list[Timed]:
    """Return the runs with status ok and a finite error.

    Parameters
    ----------
    timed : runs with their times

    Returns
    -------
    those of them, in the same order
    """
    return [each for each in timed if each.run.status is Status.OK and np.isfinite(each.error_m)]


def clocked(timed: Sequence[Timed]) -> list[Timed]:
    """Return the runs with a valid time."""
    return [each for each in timed if not each.reading.doubt]


def by_contestant(timed: Sequence[Timed]) -> dict[tuple[str, str], list[Timed]]:
    """Return the runs of each contestant, the tolerances of an adaptive method together.

    Parameters
    ----------
    timed : runs with their times

    Returns
    -------
    runs by engine and method, the fastest first
    """
    found: dict[tuple[str, str], list[Timed]] = {}
    for each in timed:
        found.setdefault((each.run.engine, together(each.run.method)), []).append(each)
    return {name: sorted(own, key=lambda each: each.run_ns) for name, own in found.items()}


def together(method: str) -> str:
    """Return the method that all tolerances of an adaptive one are reported under."""
    return str(MethodName.parse(method).without_tolerance)


def pareto_front(timed: Sequence[Timed]) -> list[Timed]:
    """Return the runs more accurate than every faster one, the fastest first."""
    front: list[Timed] = []
    for each in sorted(usable(clocked(timed)), key=lambda each: (each.run_ns, each.error_m)):
        if not front or each.error_m < front[-1].error_m:
            front.append(each)
    return front


def reach(timed: Sequence[Timed], target_m: float) -> tuple[str, float | None, Timed | None]:
    """Return when a contestant reaches an error.

    Parameters
    ----------
    timed : runs of one contestant
    target_m : the error [m]

    Returns
    -------
    the verdict: reached, not reached or at most
    the run time at which the error is reached [ns], interpolated between two runs; None if it is not
    the first run that reaches it, None if there is none
    """
    edge = pareto_front(timed)
    fine = next((each for each in edge if each.error_m <= target_m), None)
    if fine is None:
        return "not reached", None, None
    place = edge.index(fine)
    if place == 0:
        return "at most", fine.run_ns, fine
    coarse = edge[place - 1]
    share = math.log(coarse.error_m / target_m) / math.log(coarse.error_m / fine.error_m)
    return "reached", coarse.run_ns * (fine.run_ns / coarse.run_ns) ** share, fine


def accuracy_cost_rows(sweep: Sweep, reference: str) -> Iterator[AccuracyCostRow]:
    """Yield the cost of each error for each contestant.

    Parameters
    ----------
    sweep : of one scene
    reference : ENGINE:METHOD that run times are divided by

    Returns
    -------
    rows of accuracy-cost.csv, also of untimed contestants, with the reason
    """
    contestants = by_contestant(clocked(sweep.timed))
    asked = Contestant.of_name(reference)
    own = contestants.get((asked.engine_release, str(asked.method)), [])
    for (engine, method), timed in contestants.items():
        for target in TARGETS_M:
            verdict, run_ns, run = reach(timed, target)
            _, own_ns, own_run = reach(own, target)
            found = None
            if run is not None and own_run is not None and run_ns is not None and own_ns is not None:
                found = ratio(run.reading, own_run.reading)
                if not found.refusal:
                    # From the times of the readings to the interpolated ones.
                    found *= run_ns / own_ns * own_run.reading.ns / run.reading.ns
            dt_s, tolerance = step_reached(run)
            row = AccuracyCostRow(
                scene=sweep.scene.name,
                engine=engine,
                method=method,
                target_m=target,
                verdict=verdict,
                run_us=None if run_ns is None else run_ns / 1e3,
                dt_s=dt_s,
                tolerance=tolerance,
                steps_per_s=1e9 / run.reading.ns if run is not None and run.per_step and run.reading.ns else None,
                reference=reference,
                no_ratio="" if found is None else found.refusal,
                dt_taken_s=run.run.dt_taken if run is not None and run.per_step else None,
            )
            if found is not None and not found.refusal:
                row = replace(row, ratio=found.value, ratio_low=found.low, ratio_high=found.high)
            yield row
    yield from untimed_rows(sweep, reference)


def untimed_rows(sweep: Sweep, reference: str) -> Iterator[AccuracyCostRow]:
    """Yield the reason, once for each error, of every contestant that ran and has no time."""
    contestants = by_contestant(clocked(sweep.timed))
    why = {
        (run.engine, together(run.method)): sweep.why_untimed[run.name]
        for run in sweep.untimed
        if run.name in sweep.why_untimed
    }
    for (engine, method), reason in why.items():
        if (engine, method) not in contestants:
            for target in TARGETS_M:
                yield AccuracyCostRow(
                    scene=sweep.scene.name,
                    engine=engine,
                    method=method,
                    target_m=target,
                    verdict=UNTIMED,
                    reference=reference,
                    no_ratio=reason,
                )


def step_reached(timed: Timed | None) -> tuple[float | None, float | None]:
    """Return step and tolerance of a run; a method that takes a run in one step has neither."""
    if timed is None:
        return None, None
    return timed.run.dt if timed.per_step else None, timed.run.tolerance


def order_rows(sweep: Sweep) -> Iterator[OrderRow]:
    """Yield order, smallest error and parts of the error of each fixed-step contestant.

    Parameters
    ----------
    sweep : of one scene

    Returns
    -------
    rows of orders.csv
    """
    size = sweep.scene.body.reach
    for (engine, method), timed in by_contestant(sweep.timed).items():
        ladder = sorted((each for each in usable(timed) if each.per_step), key=lambda each: -each.run.dt)
        if not ladder:
            continue
        best = min(ladder, key=lambda each: each.error_m)
        levels = [
            Level(each.run.dt_taken or each.run.dt, each.error_m, float(each.run.limits.max())) for each in ladder
        ]
        slopes = local_orders(levels, ASYMPTOTIC * size) or local_orders(levels, size)[-LAST:]
        # Errors as large as these may rise with shorter steps before they fall.
        slopes = slopes or local_orders(levels[-LAST - 1 :], size)
        shown = min(ladder, key=lambda each: abs(math.log(each.error_m / (ASYMPTOTIC * size))))
        attitude, translation = parts(shown.run)
        yield OrderRow(
            scene=sweep.scene.name,
            engine=engine,
            method=method,
            order=float(np.median(slopes)) if slopes else None,
            order_low=min(slopes, default=None),
            order_high=max(slopes, default=None),
            best_error_m=best.error_m,
            best_dt_s=best.run.dt,
            bends=best is not ladder[-1],
            finest_dt_s=ladder[-1].run.dt,
            finest_error_m=ladder[-1].error_m,
            precision=precision(best.run.rounding),
            rounding_m=best.run.rounding * float(abs(best.run.flight.vertices).max()),
            dt_s=shown.run.dt,
            attitude_m=attitude,
            translation_m=translation,
        )


def timing_rows(sweep: Sweep) -> Iterator[TimingRow]:
    """Yield the timing of each contestant."""
    for each in {each.run.name: each for each in sweep.timed}.values():
        reading = each.reading
        median_ns, p90_ns = reading.spread
        yield TimingRow(
            **contestant_columns(each.run),
            tolerance=each.run.tolerance,
            unit="step" if each.per_step else "flight",
            ns=reading.ns,
            median_ns=median_ns,
            p90_ns=p90_ns,
            clock=reading.clock,
            finding=reading.finding,
            call_ns=each.ready.call_ns,
            build_s=each.ready.build_s,
            compile_s=each.ready.compile_s,
            peak_bytes=each.ready.peak_bytes,
            rounds=len(reading.samples),
        )


def equivalent_rows(sweep: Sweep) -> Iterator[EquivalentRow]:
    """Yield the pairs of fixed-step contestants that are the same integrator, found from the numbers.

    Parameters
    ----------
    sweep : of one scene

    Returns
    -------
    rows of equivalent.csv
    """
    ladders = {
        (engine, method): {each.run.dt: each.run for each in usable(timed) if each.per_step}
        for (engine, method), timed in by_contestant(sweep.timed).items()
    }
    names = list(ladders)
    for a, b in ((a, b) for place, a in enumerate(names) for b in names[place + 1 :]):
        shared = sorted(ladders[a].keys() & ladders[b].keys())
        apart = [float(np.linalg.norm(ladders[a][dt].errors - ladders[b][dt].errors, axis=-1).max()) for dt in shared]
        least = [min(float(ladders[name][dt].distances.max()) for name in (a, b)) for dt in shared]
        significant = [
            resolution_m < SHARED * worst for resolution_m, worst in zip(limits(ladders[a], shared), least, strict=True)
        ]
        if any(significant) and all(
            gap < SHARED * worst for gap, worst, known in zip(apart, least, significant, strict=True) if known
        ):
            (engine_a, method_a), (engine_b, method_b) = a, b
            yield EquivalentRow(
                scene=sweep.scene.name,
                engine_a=engine_a,
                method_a=method_a,
                engine_b=engine_b,
                method_b=method_b,
                steps_compared=sum(significant),
                max_distance_m=max(apart),
            )


def limits(ladder: dict[float, Run], steps: Sequence[float]) -> list[float]:
    """Return the resolution of the reference at each step [m]."""
    return [float(ladder[dt].limits.max()) for dt in steps]


def work_precision_rows(sweep: Sweep) -> Iterator[WorkPrecisionRow]:
    """Yield error and run time of every run with a valid time."""
    edge = {id(each) for each in pareto_front(sweep.timed)}
    for each in clocked(sweep.timed):
        run, reading = each.run, each.reading
        run_us, steps = each.run_ns / 1e3, run.flight.steps if each.per_step else None
        yield WorkPrecisionRow(
            **contestant_columns(run),
            **step_columns(run),
            steps=steps,
            **status_columns(run),
            error_m=each.error_m,
            resolution_m=float(run.limits.max()),
            run_us=run_us,
            p90_run_us=run_us * reading.spread[1] / reading.ns,
            step_ns=None if steps is None else each.run_ns / steps,
            clock=reading.clock,
            pareto_front=id(each) in edge,
            dt_taken_s=run.dt_taken,
        )
