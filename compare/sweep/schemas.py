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
    """Error and run time of one run, the time of its native loop by the clock that suits it."""

    scene: SceneName
    engine: Engine
    method: Method
    dt_s: Step
    tolerance: Tolerance
    steps: Annotated[int | None, "steps of the whole run; empty if whole runs were timed"]
    status: Status
    why: Why
    error_m: Annotated[
        float,
        "largest error over vertices and samples, of many throws the median; empty if the run diverged",
        EMPTY,
    ]
    resolution_m: Limit
    run_us: Annotated[float, "run time of one throw, 10th percentile over the rounds"]
    p90_run_us: Annotated[float, "run time of one throw, 90th percentile over the rounds"]
    step_ns: Annotated[float | None, "time per step of one throw; empty if whole runs were timed"]
    clock: Annotated[str, "clock that was read: thread CPU, process CPU or wall"]
    pareto_front: Annotated[bool, "on the Pareto front: no run is both faster and as accurate"]
    dt_taken_s: StepTaken = None


@dataclass(frozen=True, kw_only=True)
class AccuracyCostRow:
    """The run time one contestant needs to reach one error.

    The time is interpolated between two measured runs of its own Pareto front, never extrapolated; the step and the
    columns after it are those of the next more accurate run.
    """

    scene: SceneName
    engine: Engine
    method: Annotated[str, "method; all tolerances of an adaptive one together"]
    target_m: Annotated[float, "largest vertex error to reach"]
    verdict: Annotated[str, "reached, not reached, at most (the fastest run is already more accurate), or untimed"]
    run_us: Annotated[float | None, "run time of one throw: its native loop"] = None
    dt_s: Annotated[float | None, "step; empty if the method chose its own, or the error was not reached"] = None
    tolerance: Tolerance = None
    steps_per_s: Annotated[float | None, "steps per second of CPU time; empty if whole runs were timed"] = None
    reference: Annotated[str, "ENGINE:METHOD that run times are divided by"]
    ratio: Annotated[
        float | None, "run time over the reference's; empty if either did not reach the error, or as no_ratio says"
    ] = None
    ratio_low: Annotated[float | None, "lower end of the 95 % confidence interval of the ratio"] = None
    ratio_high: Annotated[float | None, "upper end of the 95 % confidence interval of the ratio"] = None
    no_ratio: Annotated[str, "why there is no time or no ratio; empty if there is one"] = ""
    dt_taken_s: StepTaken = None


@dataclass(frozen=True, kw_only=True)
class OrderRow:
    """One fixed-step contestant: its measured order of convergence, its smallest error, and the parts of the error.

    The parts are those of the run whose error is nearest to one thousandth of the body.
    """

    scene: SceneName
    engine: Engine
    method: Method
    order: Annotated[
        float | None, "order of convergence: median over pairs of neighbouring steps; empty if it cannot be determined"
    ]
    order_low: Annotated[float | None, "smallest order over these pairs"]
    order_high: Annotated[float | None, "largest order over these pairs"]
    best_error_m: Annotated[float, "smallest error of all runs"]
    best_dt_s: Annotated[float, "step of the run with the smallest error"]
    bends: Annotated[bool, "True if smaller steps have larger errors"]
    finest_dt_s: Annotated[float, "smallest step of all runs"]
    finest_error_m: Annotated[float, "error of the run with the smallest step"]
    precision: Annotated[str, "precision of the engine: single or double"]
    rounding_m: Annotated[
        float, "half a unit in the last place, in that precision, of the largest coordinate of a vertex"
    ]
    dt_s: Annotated[float, "step of the run whose error is split"]
    attitude_m: Annotated[float, "largest vertex error from the attitude alone"]
    translation_m: Annotated[float, "largest error of the centre of mass"]

    @property
    def worsens(self) -> bool:
        """Whether the smallest step is significantly worse than the best one."""
        return self.finest_error_m > WORSE * self.best_error_m


@dataclass(frozen=True, kw_only=True)
class TimingRow:
    """The run time of one contestant's native loop, its spread, and the cost of building, compiling and calling.

    build_s, compile_s and call_ns are not part of any other column.
    """

    scene: SceneName
    engine: Engine
    method: Method
    tolerance: Tolerance
    unit: Annotated[str, "unit that was timed: step, or flight (a whole run) of a method that takes its own steps"]
    ns: Annotated[float, "time per unit, 10th percentile over the rounds"]
    median_ns: Annotated[float, "time per unit, median over the rounds"]
    p90_ns: Annotated[float, "time per unit, 90th percentile over the rounds"]
    clock: Annotated[str, "clock that was read: thread CPU, process CPU or wall"]
    finding: Annotated[
        str, "why the time may be wrong: clocks disagree, or work continues after the call; empty if neither"
    ]
    call_ns: Annotated[float, "cost of a call from Python"]
    build_s: Annotated[float, "time to build the world"]
    compile_s: Annotated[float, "extra time of the first steps, for compiling"]
    peak_bytes: Annotated[int, "peak memory of the engine process so far [B]"]
    rounds: Annotated[int, "number of sampling rounds"]


@dataclass(frozen=True, kw_only=True)
class EquivalentRow:
    """Two contestants with the same integrator: at every step far closer to each other than to the reference."""

    scene: SceneName
    engine_a: Annotated[str, "engine of the one contestant"]
    method_a: Annotated[str, "method of the one contestant"]
    engine_b: Annotated[str, "engine of the other contestant"]
    method_b: Annotated[str, "method of the other contestant"]
    steps_compared: Annotated[
        int, "number of step sizes at which both errors are well above the resolution of the reference"
    ]
    max_distance_m: Annotated[float, "largest distance between their vertices over these step sizes"]

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
    p5_error_m: Annotated[float, "5 % quantile over the throws of the largest vertex error"]
    median_error_m: Annotated[float, "median over the throws of the largest vertex error"]
    p95_error_m: Annotated[float, "95 % quantile over the throws of the largest vertex error"]


@dataclass(frozen=True, kw_only=True)
class ObservableCostRow:
    """Error of one observable of contact, and the run time of the whole scene, at one step of one contestant."""

    scene: SceneName
    engine: Engine
    method: Method
    dt_s: Step
    tolerance: Tolerance
    observable: Annotated[str, "observable, as in contact.csv; of a vector without its component"]
    blow: Annotated[int | None, "number of the impact; empty if it is of the whole run"]
    unit: Annotated[str, "unit of the error"]
    error: Annotated[float, "error, of a vector its length, at the worse of two positions of the plane in a step"]
    error_share: Annotated[
        float, "error over the size of the observable: its true value, or the scale of one that is 0"
    ]
    run_us: Annotated[float, "run time of the scene at this step, 10th percentile over the rounds"]
    p90_run_us: Annotated[float, "run time of the scene at this step, 90th percentile over the rounds"]
    pareto_front: Annotated[bool, "on the Pareto front: no run is both faster and as accurate"]


WORK_PRECISION = Table("work-precision.csv", WorkPrecisionRow, (*CONTESTANT, "dt_s"))
DIGITS = Table("accuracy-cost.csv", AccuracyCostRow, (*CONTESTANT, "target_m"))
ORDERS = Table("orders.csv", OrderRow, CONTESTANT)
ENSEMBLES = Table("ensembles.csv", EnsembleRow, (*CONTESTANT, "dt_s", "tolerance"))
SAME = Table("equivalent.csv", EquivalentRow, ("scene", "engine_a", "method_a", "engine_b", "method_b"))
CLOCK = Table("timing.csv", TimingRow, CONTESTANT)
OBSERVABLES = Table("observable-cost.csv", ObservableCostRow, (*CONTESTANT, "dt_s", "observable", "blow"))
TABLES = (WORK_PRECISION, DIGITS, ORDERS, ENSEMBLES, SAME, CLOCK, OBSERVABLES)
