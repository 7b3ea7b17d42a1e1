"""Every contestant on every scene, compared with the reference solution."""

from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, field, replace
from functools import partial

from tumble.compare.comparison.in_parts import EnsembleRun, ensemble_runs
from tumble.compare.comparison.sensors import first_throw, sensor_runs
from tumble.compare.judge.errors import Run, RunAnswer
from tumble.compare.judge.sensors import SensorRun
from tumble.compare.run.execution import Parts
from tumble.compare.run.flight import Trajectory
from tumble.compare.run.progress import ProgressCallback, no_progress
from tumble.compare.run.running_engines import AS_ASKED, DEFAULT, RunningEngine, truth_limit
from tumble.compare.run.status import Failure
from tumble.compare.run.tasks import Task, run
from tumble.compare.run.truths import Truths
from tumble.scenarios.scene import Scene
from tumble.scenarios.truth import Truth
from tumble.scenarios.truth.rounded_inputs import input_rounding_error


@dataclass(frozen=True, eq=False)
class Comparison:
    """The runs of all contestants in one scene, compared with its reference solution.

    Parameters
    ----------
    scene : the scene
    truth : its reference solution; None: there is none
    why_no_truth : why there is no reference solution; empty if there is one
    runs : the run of each contestant
    lost_m : how far a vertex moves if the inputs are rounded to double precision, at most [m]; 0 if unknown
    roles : role of each contestant for its engine, as `RunningEngine.role` returns it, by ENGINE:METHOD
    sensors : the readings of the scene's sensors by each contestant; empty if it has no sensors
    ensemble : of a scene that ran in parts, all throws of each contestant; scene and runs are then those of throw 0
    watched : the run of the scene with more samples by engine and method, where it was asked for and there is one
    """

    scene: Scene
    truth: Truth | None
    why_no_truth: str
    runs: tuple[Run, ...]
    lost_m: float
    roles: Mapping[str, str]
    sensors: tuple[SensorRun, ...] = ()
    ensemble: tuple[EnsembleRun, ...] = ()
    watched: Mapping[tuple[str, str], Trajectory] = field(default_factory=dict)

    @property
    def defaults(self) -> frozenset[str]:
        """The contestants that are their engine's default."""
        return frozenset(name for name, role in self.roles.items() if role == DEFAULT)

    @property
    def named(self) -> frozenset[str]:
        """The contestants that the user named."""
        return frozenset(name for name, role in self.roles.items() if role == AS_ASKED)


def compare(
    running_engines: Sequence[RunningEngine],
    scenes: Sequence[Scene],
    dt: float | None = None,
    on_progress: ProgressCallback = no_progress,
    truths: Truths | None = None,
    watched: Sequence[Scene] | None = None,
) -> list[Comparison]:
    """Run every scene with every contestant and compare the trajectories with the reference.

    Parameters
    ----------
    running_engines : with their methods
    scenes : the scenes
    dt : step [s]; None: each scene's own
    on_progress : called for every run and reference solution
    truths : has the scenes' reference solutions already; None: they are computed
    watched : of each scene the first throw with more samples, in which the contestants run as well

    Returns
    -------
    the comparisons, in the order of the scenes

    Raises
    ------
    RayMissed : the ray of a later impulse misses the true body
    """
    given, scenes = scenes, [replace(scene, ensemble=None) if scene.ensemble else scene for scene in scenes]

    def task(
        scene: Scene, film: Scene | None, running_engine: RunningEngine, method: str
    ) -> Task[tuple[Trajectory | Failure, Trajectory | Failure | None]]:
        key = scene.name, running_engine.title, method
        film = film if film and method in running_engine.methods_for(film) else None
        ask = partial(RunningEngine.simulate_watched, scene=scene, method=method, dt=dt or scene.step, watched=film)
        return Task(key, running_engine, ask)

    tasks = [
        [
            task(scene, film, running_engine, method)
            for running_engine in running_engines
            for method in running_engine.methods_for(scene)
        ]
        for scene, film in zip(scenes, watched or [None] * len(scenes), strict=True)
    ]
    with (
        nullcontext(truths)
        if truths
        else Truths(scenes, on_progress, limit_s=truth_limit(running_engines)) as references
    ):
        sensing = [scene for scene in scenes if scene.sensors]
        readings = references.each(first_throw, sensing, [truth_limit(running_engines)] * len(sensing))
        with Parts() as part:
            found = part(lambda: run([one for own in tasks for one in own], references, on_progress=on_progress))
            sensed = part(lambda: sensor_runs(running_engines, scenes, readings, dt, on_progress, references))
            ensembles = [
                part(lambda scene=scene: ensemble_runs(running_engines, scene, dt, on_progress))
                if scene.ensemble
                else []
                for scene in given
            ]
        true = [references.answer(scene) for scene in scenes]
        moved = references.each(lost_m, scenes, [answer.truth for answer in true])
        lost = [future.result() for future in moved]
    answers = iter(found)
    seen = [[next(answers) for _ in own] for own in tasks]
    return [
        Comparison(
            scene=scene,
            truth=answer.truth,
            why_no_truth=answer.why,
            runs=tuple(
                RunAnswer.of(one.running_engine, one.key[-1], dt or scene.step, flight).run(
                    scene, one.running_engine.title, answer.truth
                )
                for one, (flight, _) in zip(own, flights, strict=True)
            ),
            lost_m=lost,
            sensors=sensors,
            roles={
                f"{engine.title}:{method}": engine.role(method)
                for engine, method in [
                    *((one.running_engine, one.key[-1]) for one in own),
                    *((one.running_engine, one.method) for one in ensemble),
                ]
            },
            ensemble=tuple(ensemble),
            watched={
                (one.running_engine.title, one.key[-1]): film
                for one, (_, film) in zip(own, flights, strict=True)
                if isinstance(film, Trajectory)
            },
        )
        for scene, answer, own, flights, lost, sensors, ensemble in zip(
            scenes, true, tasks, seen, lost, sensed, ensembles, strict=True
        )
    ]


def lost_m(scene: Scene, truth: Truth | None) -> float:
    """Return the largest error from rounding the inputs to double precision.

    Parameters
    ----------
    scene : the scene
    truth : its reference solution

    Returns
    -------
    the error [m], 0 without a reference solution
    """
    return 0.0 if truth is None else input_rounding_error(scene, truth)
