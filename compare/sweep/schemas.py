"""The tables of a sweep, beside its runs: one line a column."""

from dataclasses import dataclass
from typing import Annotated

from tumble.compare.tables.schema import EMPTY, Table
from tumble.compare.tables.shared import (
    CONTESTANT,
    Engine,
    Limit,
    Method,
    SceneName,
    Status,
    Step,
    StepTaken,
    Tolerance,
    Why,
)

WORSE = 2.0


@dataclass(frozen=True, kw_only=True)
class WorkPrecisionRow:
    """Error and time of one run: the time is that of its native loop, by the clock that is right for it."""

    scene: SceneName
    engine: Engine
    method: Method
    dt_s: Step
    tolerance: Tolerance
    steps: Annotated[int | None, "steps of the whole flight; empty where a flight is what was timed"]
    status: Status
    why: Why
    error_m: Annotated[
        float,
        "largest error of any vertex and sample, the median over the throws where there are many; empty of one that "
        "diverged",
        EMPTY,
    ]
    resolution_m: Limit
    run_us: Annotated[float, "time of one throw's flight: lower decile of the rounds"]
    p90_run_us: Annotated[float, "time of one throw's flight: upper decile of the rounds"]
    step_ns: Annotated[float | None, "time of one step of one throw; empty where a flight is what was timed"]
    clock: Annotated[str, "thread CPU, process CPU or wall: the one that is right for it"]
    pareto_front: Annotated[bool, "on the Pareto front: no run is both faster and as accurate"]
    dt_taken_s: StepTaken = None


@dataclass(frozen=True, kw_only=True)
class AccuracyCostRow:
    """What it takes one contestant to reach one error.

    The time is interpolated between two measured runs of its own frontier, never beyond them; the step and what follows
    are those of the nearest finer run.
    """

    scene: SceneName
    engine: Engine
    method: Annotated[str, "method; the tolerances of an adaptive one together"]
    target_m: Annotated[float, "largest vertex error to reach"]
    verdict: Annotated[str, "reached, not reached, at most (the coarsest run is as good already), or untimed"]
    run_us: Annotated[float | None, "time of the native loop of one throw's flight"] = None
    dt_s: Annotated[float | None, "step; empty where the method chose its own, or nothing was reached"] = None
    tolerance: Tolerance = None
    steps_per_s: Annotated[float | None, "steps in one second of CPU time; empty where a flight is the unit"] = None
    reference: Annotated[str, "ENGINE:METHOD that the ratio is over"]
    ratio: Annotated[float | None, "time over the reference's; empty where either did not reach the error, or why"] = (
        None
    )
    ratio_low: Annotated[float | None, "lower end of the 95 % confidence interval of the ratio"] = None
    ratio_high: Annotated[float | None, "upper end of the 95 % confidence interval of the ratio"] = None
    no_ratio: Annotated[str, "why the contestant has no time, and so no ratio"] = ""
    dt_taken_s: StepTaken = None


@dataclass(frozen=True, kw_only=True)
class OrderRow:
    """One fixed-step contestant: the order its errors show by the steps taken, its floor and the step it bends at.

    The parts of the error are read at the run nearest to one thousandth of the body.
    """

    scene: SceneName
    engine: Engine
    method: Method
    order: Annotated[float | None, "median of the orders between neighbouring steps; empty where none can be read"]
    order_low: Annotated[float | None, "the least of them"]
    order_high: Annotated[float | None, "the largest of them"]
    best_error_m: Annotated[float, "least error of all runs"]
    best_dt_s: Annotated[float, "its step"]
    bends: Annotated[bool, "whether smaller steps were worse"]
    finest_dt_s: Annotated[float, "the smallest step of all runs"]
    finest_error_m: Annotated[float, "its error"]
    precision: Annotated[str, "single or double"]
    rounding_m: Annotated[float, "half an ulp, in that precision, of the furthest coordinate of a corner"]
    dt_s: Annotated[float, "step at which the parts are read"]
    attitude_m: Annotated[float, "largest vertex error from the attitude alone"]
    translation_m: Annotated[float, "largest error of the centre of mass"]

    @property
    def worsens(self) -> bool:
        """Whether steps below the best one are so much worse that it is no accident."""
        return self.finest_error_m > WORSE * self.best_error_m


@dataclass(frozen=True, kw_only=True)
class TimingRow:
    """What the clock said of one contestant: time of its native loop, its spread, which clock, and what it took before.

    None of build_s, compile_s and call_ns is in any other figure.
    """

    scene: SceneName
    engine: Engine
    method: Method
    tolerance: Tolerance
    unit: Annotated[str, "what the times are of: a step, or a flight of a method that takes its own steps"]
    ns: Annotated[float, "lower decile of the rounds"]
    median_ns: Annotated[float, "median of the rounds"]
    p90_ns: Annotated[float, "upper decile of the rounds"]
    clock: Annotated[str, "thread CPU, process CPU or wall: the one that is right for it"]
    finding: Annotated[str, "how the clocks disagree, or work was left to be done when it is read"]
    call_ns: Annotated[float, "what a call from Python costs beyond that"]
    build_s: Annotated[float, "building the world"]
    compile_s: Annotated[float, "what the first steps took beyond those after them"]
    peak_bytes: Annotated[int, "the most memory that its engine's process had held by then [B]"]
    rounds: Annotated[int, "number of rounds"]


@dataclass(frozen=True, kw_only=True)
class EquivalentRow:
    """Two contestants that are one integrator: at every step, far closer to each other than to the truth."""

    scene: SceneName
    engine_a: Annotated[str, "engine of the one contestant"]
    method_a: Annotated[str, "method of the one contestant"]
    engine_b: Annotated[str, "engine of the other contestant"]
    method_b: Annotated[str, "method of the other contestant"]
    steps_compared: Annotated[int, "number of steps at which both errors stand clear of the truth's limit"]
    max_distance_m: Annotated[float, "largest distance between their vertices at any step"]

    @property
    def contestant_a(self) -> str:
        """ENGINE:METHOD of the one."""
        return f"{self.engine_a}:{self.method_a}"

    @property
    def contestant_b(self) -> str:
        """ENGINE:METHOD of the other."""
        return f"{self.engine_b}:{self.method_b}"


@dataclass(frozen=True, kw_only=True)
class EnsembleRow:
    """One run of many throws: quantiles over the throws of the largest vertex error."""

    scene: SceneName
    engine: Engine
    method: Method
    dt_s: Step
    tolerance: Tolerance
    members: Annotated[int, "number of throws"]
    p5_error_m: Annotated[float, "5 % quantile"]
    median_error_m: Annotated[float, "median"]
    p95_error_m: Annotated[float, "95 % quantile"]


WORK_PRECISION = Table("work-precision.csv", WorkPrecisionRow, (*CONTESTANT, "dt_s"))
DIGITS = Table("accuracy-cost.csv", AccuracyCostRow, (*CONTESTANT, "target_m"))
ORDERS = Table("orders.csv", OrderRow, CONTESTANT)
ENSEMBLES = Table("ensembles.csv", EnsembleRow, (*CONTESTANT, "dt_s", "tolerance"))
SAME = Table("equivalent.csv", EquivalentRow, ("scene", "engine_a", "method_a", "engine_b", "method_b"))
CLOCK = Table("timing.csv", TimingRow, CONTESTANT)
TABLES = (WORK_PRECISION, DIGITS, ORDERS, ENSEMBLES, SAME, CLOCK)
