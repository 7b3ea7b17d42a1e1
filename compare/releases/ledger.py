"""The same scenes with every release of an engine, each in its own environment.

All run times are of one scene, sampled in the same rounds, so that they can be compared.
"""

from collections.abc import Iterator, Sequence
from concurrent.futures import Future
from dataclasses import dataclass, field, replace
from functools import partial

from tumble.compare.contact.rows import contact_rows
from tumble.compare.contact.schemas import ContactRow
from tumble.compare.contact.study import Contact, contacts
from tumble.compare.judge import ladder, trend
from tumble.compare.judge.errors import Run, RunAnswer
from tumble.compare.releases.schemas import ReleaseRow
from tumble.compare.run.engines.environments import split_release
from tumble.compare.run.execution import Parts
from tumble.compare.run.progress import ProgressCallback, no_progress
from tumble.compare.run.running_engines import RunningEngine, truth_limit
from tumble.compare.run.status import Failure
from tumble.compare.run.tasks import Task, run
from tumble.compare.run.timing.readings import USUAL, Reading, Sampling, ratio
from tumble.compare.run.timing.timing import Cost, Load, costs
from tumble.compare.run.truths import Answer, Truths, answered
from tumble.compare.tables.runs import run_row
from tumble.scenarios.scene import Scene
from tumble.scenarios.truth import Truth

# A brick that tumbles and falls, two impulses, and a force other than gravity.
SCENES = ("brick-tumble", "two-hits", "tether-undamped")

Named = tuple[str, str]  # release and method


@dataclass(frozen=True)
class Runs:
    """The runs of one method of one release: at the scene's own step, and the step-size sequence around it."""

    own: RunAnswer
    ladder: list[RunAnswer]


@dataclass(frozen=True, eq=False)
class Ledger:
    """The runs of an engine's releases.

    Parameters
    ----------
    engine : name of the engine
    releases : the releases, the oldest first
    rows : one for each scene, release and method; times are of the first scene only
    speeds : time per step [ns] in the first scene, by release and method
    contact : observables of contact, by release, scene and method; only of scenes with a plane
    """

    engine: str
    releases: tuple[str, ...]
    rows: tuple[ReleaseRow, ...]
    speeds: dict[Named, Reading]
    contact: dict[tuple[str, str, str], list[ContactRow]] = field(default_factory=dict)


def release_of(running_engine: RunningEngine) -> str:
    """Return the release of a running engine."""
    _, release = split_release(running_engine.engine)
    return release or ("" if isinstance(running_engine.info, Failure) else running_engine.info.version)


def ledger(
    running_engines: Sequence[RunningEngine],
    scenes: Sequence[Scene],
    on_progress: ProgressCallback = no_progress,
    sampling: Sampling = USUAL,
) -> Ledger:
    """Return the ledger of one engine's releases, the oldest first.

    Times are always measured anew, on this machine.
    Raises RayMissed as compare does.
    """

    def task(scene: Scene, answer: Future[Answer], running_engine: RunningEngine, method: str) -> Task[Runs]:
        key = scene.name, running_engine.title, method
        return Task(key, running_engine, partial(runs_of, scene=scene, method=method, answer=answer))

    landing, limit_s = [scene for scene in scenes if scene.plane], truth_limit(running_engines)
    with Parts() as part:
        with Truths(scenes, on_progress, limit_s=limit_s) as truths:
            tasks = [
                (scene, future, task(scene, future, each, method))
                for scene, future in zip(scenes, truths.futures, strict=True)
                for each in running_engines
                for method in each.methods_for(scene)
            ]

            def flown() -> list[ReleaseRow]:
                answers = run([one for _, _, one in tasks], truths, on_progress=on_progress)
                # Where tasks are found, only this asks for the reference solutions that cannot be saved.
                return [
                    row(scene, one.running_engine, answer, future.result().truth)
                    for (scene, future, one), answer in zip(tasks, answers, strict=True)
                ]

            rows = part(flown)
        landed = part(lambda: contacts(running_engines, answered(landing, limit_s), on_progress=on_progress))
    observed = observables(running_engines, landed)
    speeds = speeds_on(scenes[0], running_engines, sampling)
    on_progress("timed")
    newest = release_of(running_engines[-1])
    return Ledger(
        engine=split_release(running_engines[0].engine)[0],
        releases=tuple(map(release_of, running_engines)),
        rows=tuple(with_speed(each, speeds, newest) if each.scene == scenes[0].name else each for each in rows),
        speeds=speeds,
        contact=observed,
    )


def observables(
    running_engines: Sequence[RunningEngine], landed: Sequence[Contact]
) -> dict[tuple[str, str, str], list[ContactRow]]:
    """Return the observables of contact by release, scene and method."""
    released = {each.title: release_of(each) for each in running_engines}
    return {
        (released[one.engine], one.scene.name, one.method): list(contact_rows(one))
        for one in landed
        if one.observations
    }


def runs_of(running_engine: RunningEngine, scene: Scene, method: str, answer: Future[Answer]) -> Runs:
    """Return one method's run, and a step-size sequence around it if it has an order to determine."""
    true = answer.result().truth

    def at(dt: float) -> Run:
        return RunAnswer.of(running_engine, method, dt, running_engine.simulate(scene, method, dt)).run(
            scene, running_engine.title, true
        )

    own = at(scene.step)
    around = ladder.ladder(own, at) if ladder.readable(own) and not running_engine.takes_own_steps(method) else []
    plain = [
        RunAnswer(method=each.method, dt=each.dt, answer=each.answer, tolerance=each.tolerance, rounding=each.rounding)
        for each in (own, *around)
    ]
    return Runs(plain[0], plain[1:])


def row(scene: Scene, running_engine: RunningEngine, answer: Runs, true: Truth | None) -> ReleaseRow:
    """Return the row of one answer."""
    own = answer.own.run(scene, running_engine.title, true)
    found = run_row(own)
    attitude_order, translation_order = ladder.orders(
        [each.run(scene, running_engine.title, true) for each in answer.ladder]
    )
    return ReleaseRow(
        engine=split_release(running_engine.engine)[0],
        release=release_of(running_engine),
        scene=scene.name,
        method=answer.own.method,
        dt_s=found.dt_s,
        status=found.status,
        why=found.why,
        max_error_m=found.max_error_m,
        resolution_m=found.resolution_m,
        energy_drift=found.energy_drift,
        angular_momentum_drift=found.angular_momentum_drift,
        attitude_order=attitude_order,
        translation_order=translation_order,
        spin_energy=trend.spin_energy(own),
    )


def speeds_on(scene: Scene, running_engines: Sequence[RunningEngine], sampling: Sampling) -> dict[Named, Reading]:
    """Return the time per step of every method of every release on one scene, sampled in the same rounds."""
    loads = {
        (release_of(each), method): Load(each, scene, method)
        for each in running_engines
        if not isinstance(each.info, Failure) and not each.unsupported(scene)
        for method in each.methods_for(scene)
    }
    found = costs({f"{release} {method}": load for (release, method), load in loads.items()}, sampling)
    by_name = {name: found[" ".join(name)] for name in loads}
    return {name: cost.reading for name, cost in by_name.items() if isinstance(cost, Cost)}


def with_speed(row: ReleaseRow, speeds: dict[Named, Reading], newest: str) -> ReleaseRow:
    """Return the row with its time per step, and its ratio to the newest release's if that has the method."""
    own, last = (speeds.get((release, row.method)) for release in (row.release, newest))
    if own is None:
        return row
    timed = replace(row, step_ns=own.ns)
    found = ratio(own, last) if last else None
    if found is None or found.refusal:
        return timed
    return replace(timed, time_ratio=found.value, time_ratio_low=found.low, time_ratio_high=found.high)


def neighbours(ledger: Ledger) -> Iterator[tuple[str, str]]:
    """Yield each release after the first with the one before it."""
    yield from zip(ledger.releases[1:], ledger.releases, strict=False)
