"""Every contestant's sensors in every scene that has any, compared with the true readings."""

from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import Future
from dataclasses import replace
from functools import partial

from tumble.compare.judge.sensors import SensorRun
from tumble.compare.run.progress import ProgressCallback, no_progress
from tumble.compare.run.running_engines import RunningEngine, truth_limit
from tumble.compare.run.sensing import SensorReadings
from tumble.compare.run.status import Failure
from tumble.compare.run.tasks import Task, run
from tumble.compare.run.truths import Truths
from tumble.scenarios.scene import Scene
from tumble.scenarios.truth.sensors import SensorTruth, sensor_truths


def sensor_runs(
    running_engines: Sequence[RunningEngine],
    scenes: Sequence[Scene],
    readings: Iterable["Future[tuple[SensorTruth, ...]]"],
    dt: float | None = None,
    on_progress: ProgressCallback = no_progress,
    truths: Truths | None = None,
) -> list[tuple[SensorRun, ...]]:
    """Read the sensors of every scene with every contestant; a scene without sensors costs nothing.

    Parameters
    ----------
    running_engines : with their methods
    scenes : the scenes
    readings : what will be the true readings of each scene with sensors (`first_throw`)
    dt : step [s]; None: each scene's own
    on_progress : called for every run
    truths : what runs wait for

    Returns
    -------
    the runs of each scene, none of one without sensors

    Raises
    ------
    RayMissed : the ray of a later impulse misses the true body
    """

    def task(scene: Scene, running_engine: RunningEngine, method: str) -> Task[SensorReadings | Failure]:
        key = scene.name, running_engine.title, method
        ask = partial(RunningEngine.read_sensors, scene=scene, method=method, dt=dt or scene.step)
        return Task(key, running_engine, ask)

    tasks = [
        [
            task(scene, running_engine, method)
            for running_engine in running_engines
            for method in running_engine.methods_for(scene)
        ]
        if scene.sensors
        else []
        for scene in scenes
    ]
    answers = iter(run([one for own in tasks for one in own], truths, on_progress=on_progress))
    true = (future.result() for future in readings)
    return [
        tuple(_runs(scene, own, answers, next(true), dt or scene.step)) if scene.sensors else ()
        for scene, own in zip(scenes, tasks, strict=True)
    ]


def _runs(
    scene: Scene,
    tasks: Sequence[Task[SensorReadings | Failure]],
    answers: Iterator[SensorReadings | Failure],
    true: tuple[SensorTruth, ...],
    dt: float,
) -> Iterator[SensorRun]:
    """Yield the runs of one scene, whose answers come next."""
    for one in tasks:
        engine, method = one.running_engine, one.key[-1]
        yield SensorRun(scene, engine.title, method, dt, next(answers), true, engine.tolerance(method))


def sensor_run(running_engine: RunningEngine, scene: Scene, method: str, dt: float) -> SensorRun:
    """Read the sensors of one scene with one contestant.

    Parameters
    ----------
    running_engine : the engine
    scene : has sensors
    method : of the engine
    dt : step [s]

    Returns
    -------
    the readings, with their true values

    Raises
    ------
    RayMissed : the ray of a later impulse misses the true body
    """
    answer = running_engine.read_sensors(scene, method, dt)
    true = first_throw(scene, truth_limit([running_engine]))
    return SensorRun(scene, running_engine.title, method, dt, answer, true, running_engine.tolerance(method))


def first_throw(scene: Scene, limit_s: float) -> tuple[SensorTruth, ...]:
    """Return the true readings of a scene's first throw; limit_s: wall time of each part [s]."""
    return sensor_truths(replace(scene, start=scene.start[:1]), limit_s)
