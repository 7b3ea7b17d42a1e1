"""What a sweep says in numbers: what each digit costs, at which step, of which order, and where steps stop paying."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
import pandas as pd

from tumble.compare.judge.agreement import SHARED
from tumble.compare.judge.cost import Timed
from tumble.compare.judge.errors import Run
from tumble.compare.judge.orders import ASYMPTOTIC, LAST, Rung, local_orders, parts
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
from tumble.compare.sweep.work_precision import Sweep
from tumble.compare.tables.runs import contestant_columns, status_columns, step_columns

UNTIMED = "untimed"
TARGETS_M = (1e-3, 1e-6, 1e-9, 1e-12)


def ensemble_rows(sweep: Sweep) -> Iterator[EnsembleRow]:
    """Yield the spread over the throws of every plain run, where there are many."""
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
    """Return the runs whose error is a plain result."""
    return [each for each in timed if each.run.status is Status.OK and np.isfinite(each.error_m)]


def clocked(timed: Sequence[Timed]) -> list[Timed]:
    """Return the runs that have a time, so that they have a ratio to others."""
    return [each for each in timed if not each.reading.doubt]


def by_contestant(timed: Sequence[Timed]) -> dict[tuple[str, str], list[Timed]]:
    """Return the runs of each contestant, the tolerances of an adaptive method together, the cheapest run first."""
    found: dict[tuple[str, str], list[Timed]] = {}
    for each in timed:
        found.setdefault((each.run.engine, together(each.run.method)), []).append(each)
    return {name: sorted(own, key=lambda each: each.run_ns) for name, own in found.items()}


def together(method: str) -> str:
    """Return the method that all tolerances of an adaptive one are reported under."""
    return str(MethodName.parse(method).without_tolerance)


def pareto_front(timed: Sequence[Timed]) -> list[Timed]:
    """Return the runs that no cheaper run equals, the cheapest first: where error falls as time rises."""
    kept: list[Timed] = []
    for each in sorted(usable(clocked(timed)), key=lambda each: (each.run_ns, each.error_m)):
        if not kept or each.error_m < kept[-1].error_m:
            kept.append(each)
    return kept


def reach(timed: Sequence[Timed], target_m: float) -> tuple[str, float | None, Timed | None]:
    """Return the verdict, the flight's time [ns] at which the error is reached, and the first run that reaches it."""
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
    """Yield what each digit costs each contestant over the reference contestant ENGINE:METHOD, or why it is untimed."""
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
                    # Both times are their readings' times what lies between two runs.
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
    """Yield the reason, once for each digit, of every contestant that ran and has no time at all."""
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
    """Return step and tolerance of a run: it has the one or the other, or takes a flight of any length at once."""
    if timed is None:
        return None, None
    return timed.run.dt if timed.per_step else None, timed.run.tolerance


def order_rows(sweep: Sweep) -> Iterator[OrderRow]:
    """Yield order, floor and the parts of the error of each fixed-step contestant."""
    size = sweep.scene.body.reach
    for (engine, method), timed in by_contestant(sweep.timed).items():
        ladder = sorted((each for each in usable(timed) if each.per_step), key=lambda each: -each.run.dt)
        if not ladder:
            continue
        best = min(ladder, key=lambda each: each.error_m)
        rungs = [Rung(each.run.dt_taken or each.run.dt, each.error_m, float(each.run.limits.max())) for each in ladder]
        slopes = local_orders(rungs, ASYMPTOTIC * size) or local_orders(rungs, size)[-LAST:]
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
    """Yield what the clock said, once a contestant."""
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
    """Yield the pairs of fixed-step contestants that are one integrator, found from the numbers."""
    ladders = {
        (engine, method): {each.run.dt: each.run for each in usable(timed) if each.per_step}
        for (engine, method), timed in by_contestant(sweep.timed).items()
    }
    names = list(ladders)
    for a, b in ((a, b) for place, a in enumerate(names) for b in names[place + 1 :]):
        shared = sorted(ladders[a].keys() & ladders[b].keys())
        apart = [float(np.linalg.norm(ladders[a][dt].errors - ladders[b][dt].errors, axis=-1).max()) for dt in shared]
        least = [min(float(ladders[name][dt].distances.max()) for name in (a, b)) for dt in shared]
        telling = [
            resolution_m < SHARED * worst for resolution_m, worst in zip(limits(ladders[a], shared), least, strict=True)
        ]
        if any(telling) and all(
            gap < SHARED * worst for gap, worst, tells in zip(apart, least, telling, strict=True) if tells
        ):
            (engine_a, method_a), (engine_b, method_b) = a, b
            yield EquivalentRow(
                scene=sweep.scene.name,
                engine_a=engine_a,
                method_a=method_a,
                engine_b=engine_b,
                method_b=method_b,
                steps_compared=sum(telling),
                max_distance_m=max(apart),
            )


def limits(ladder: dict[float, Run], steps: Sequence[float]) -> list[float]:
    """Return what the truth can tell at each of the steps [m]."""
    return [float(ladder[dt].limits.max()) for dt in steps]


def work_precision_rows(sweep: Sweep) -> Iterator[WorkPrecisionRow]:
    """Yield error and time of every run that has a time."""
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
