"""All tables of a comparison, by file name: what the page is made from, and what others script against."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from compare.ablation.ablation import Ablation, AblationRow
from compare.comparison.comparison import Comparison
from compare.comparison.table_4_1 import BudgetRow, PublishedRow, budget_rows, is_table_4_1, published_rows
from compare.judge.agreement import AgreementRow, agreements
from compare.judge.errors import Run
from compare.run.participants import Participant
from compare.run.provenance import ConditionRow, conditions
from compare.run.worker import Failure
from compare.sweep.frontier import (
    ClockRow,
    DigitRow,
    OrderRow,
    SameRow,
    ThrowsRow,
    clock_rows,
    digit_rows,
    order_rows,
    same_rows,
    sweep_run_rows,
    throws_rows,
)
from compare.sweep.sweep import Sweep
from compare.tables.files import write_together
from compare.tables.rows import RunRow, VertexErrorRow, run_row, table_text, vertex_error_rows
from scenarios.needs import needs


@dataclass(frozen=True)
class SceneRow:
    """One scene: what it needs, and how exact its truth is (largest over samples); truth says why there is none."""

    scene: str
    title: str
    source: str
    needs: str
    shape: str
    vertices: int
    duration_s: float
    step_s: float
    samples: int
    truth: str
    bound_m: float | None
    floor_m: float | None


@dataclass(frozen=True)
class EngineRow:
    """One engine: version, precision, methods, force laws, what was switched off to be fair; or why it is missing."""

    engine: str
    status: str
    version: str
    precision: str
    methods: str
    features: str
    switched_off: str


@dataclass(frozen=True)
class ErrorOverTimeRow:
    """The largest vertex error of one run at one sample, and the truth's limit there."""

    scene: str
    engine: str
    method: str
    dt_s: float
    t_s: float
    error_m: float
    limit_m: float


def scene_row(comparison: Comparison) -> SceneRow:
    """Return the row of one scene."""
    scene, truth = comparison.scene, comparison.truth
    return SceneRow(
        scene.name,
        scene.title,
        scene.source,
        ", ".join(needs(scene)),
        scene.body.shape,
        len(scene.body.points),
        scene.duration,
        scene.step,
        len(scene.times),
        comparison.why_no_truth or (truth.how if truth else ""),
        None if truth is None else float(truth.bound.max()),
        None if truth is None else float(truth.floor.max()),
    )


def engine_row(participant: Participant) -> EngineRow:
    """Return the row of one engine."""
    info = participant.info
    if isinstance(info, Failure):
        return EngineRow(participant.title, info.status, "", "", ", ".join(participant.methods), "", "")
    return EngineRow(
        participant.title,
        "ok",
        info.version,
        info.precision,
        ", ".join((*info.methods, *info.forced, *info.on_request)),
        ", ".join(sorted(info.features)),
        "; ".join(info.switched_off),
    )


def error_over_time_rows(run: Run) -> Iterator[ErrorOverTimeRow]:
    """Yield one row a sample."""
    if run.has_errors:
        worst = run.distances.max(axis=(1, 2))
        for time, error, limit in zip(run.scene.times, worst, run.limits.max(axis=1), strict=True):
            yield ErrorOverTimeRow(
                run.scene.name, run.engine, run.method, run.dt, float(time), float(error), float(limit)
            )


def tables(comparisons: Sequence[Comparison], participants: Sequence[Participant], command: str) -> dict[str, str]:
    """Return file name -> CSV text of every table; command reruns them."""
    runs = [run for comparison in comparisons for run in comparison.runs]
    published = [row for each in comparisons if is_table_4_1(each.scene) for row in published_rows(each)]
    return {
        "scenes.csv": table_text(SceneRow, map(scene_row, comparisons)),
        "engines.csv": table_text(EngineRow, map(engine_row, participants)),
        "runs.csv": table_text(RunRow, map(run_row, runs)),
        "vertex-errors.csv": table_text(VertexErrorRow, (row for run in runs for row in vertex_error_rows(run))),
        "error-over-time.csv": table_text(ErrorOverTimeRow, (row for run in runs for row in error_over_time_rows(run))),
        "agreement.csv": table_text(AgreementRow, (row for each in comparisons for row in agreements(each.runs))),
        "table-4-1.csv": table_text(PublishedRow, published),
        "table-4-1-budget.csv": table_text(BudgetRow, budget_rows(published)),
        "conditions.csv": table_text(ConditionRow, conditions(command)),
    }


SWEEP_TABLES = ("runs.csv", "digits.csv", "orders.csv", "throws.csv", "same.csv", "clock.csv")


def sweep_tables(
    sweeps: Sequence[Sweep], participants: Sequence[Participant], reference: str, command: str
) -> dict[str, str]:
    """Return file name -> CSV text of every table of a sweep; ratios are over the reference contestant's times."""
    return {
        "runs.csv": table_text(RunRow, (row for sweep in sweeps for row in sweep_run_rows(sweep))),
        "digits.csv": table_text(DigitRow, (row for sweep in sweeps for row in digit_rows(sweep, reference))),
        "orders.csv": table_text(OrderRow, (row for sweep in sweeps for row in order_rows(sweep))),
        "throws.csv": table_text(ThrowsRow, (row for sweep in sweeps for row in throws_rows(sweep))),
        "same.csv": table_text(SameRow, (row for sweep in sweeps for row in same_rows(sweep))),
        "clock.csv": table_text(ClockRow, (row for sweep in sweeps for row in clock_rows(sweep))),
        "engines.csv": table_text(EngineRow, map(engine_row, participants)),
        "conditions.csv": table_text(ConditionRow, conditions(command)),
    }


def ablation_tables(ablations: Sequence[Ablation], participants: Sequence[Participant], command: str) -> dict[str, str]:
    """Return file name -> CSV text of every table of an ablation."""
    return {
        "ablation.csv": table_text(AblationRow, (row for ablation in ablations for row in ablation.rows)),
        "engines.csv": table_text(EngineRow, map(engine_row, participants)),
        "conditions.csv": table_text(ConditionRow, conditions(command)),
    }


def write_tables(folder: Path, texts: dict[str, str]) -> None:
    """Write the tables into a folder, all of them or none.  Raises OSError."""
    write_together({folder / name: text for name, text in texts.items()})
