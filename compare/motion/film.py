"""Films of a scene: the reference and every contestant at about sixty instants, the scene's own among them.

The instants lie on steps that a run takes anyway, so that filming does not change it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

from tumble.compare.run.flight import Trajectory, legs
from tumble.compare.run.progress import ProgressCallback, no_progress
from tumble.compare.run.running_engines import RunningEngine, truth_limit
from tumble.compare.run.status import Failure
from tumble.compare.run.tasks import Task, run
from tumble.compare.run.truths import Truths
from tumble.scenarios.scene import Scene, frozen_array
from tumble.scenarios.truth import Truth

FRAMES = 64


@dataclass(frozen=True, eq=False)
class Film:
    """The runs of one scene, sampled finely enough to be watched.

    Parameters
    ----------
    scene : the scene, with the instants of the film
    dt : step [s]
    truth : reference solution, up to its horizon
    trajectories : run by engine and method
    """

    scene: Scene
    dt: float
    truth: Truth
    trajectories: dict[tuple[str, str], Trajectory]


def film(
    running_engines: Sequence[RunningEngine],
    scenes: Sequence[Scene],
    dt: float | None = None,
    on_progress: ProgressCallback = no_progress,
) -> list[Film]:
    """Return the films of all scenes with a reference solution.

    Parameters
    ----------
    running_engines : with their methods
    scenes : the scenes
    dt : step [s]; None: each scene's own
    on_progress : called for every run and reference solution

    Returns
    -------
    the films, in the order of the scenes
    """

    def task(scene: Scene, running_engine: RunningEngine, method: str) -> Task[Trajectory | Failure]:
        key = scene.name, running_engine.title, method
        ask = partial(RunningEngine.simulate, scene=scene, method=method, dt=dt or scene.step)
        return Task(key, running_engine, ask)

    watched = [filmed(scene, dt or scene.step) for scene in scenes]
    tasks = [
        task(scene, running_engine, method)
        for scene in watched
        for running_engine in running_engines
        for method in running_engine.methods_for(scene)
    ]
    with Truths(watched, on_progress, limit_s=truth_limit(running_engines)) as references:
        answers = dict(zip((one.key for one in tasks), run(tasks, references, on_progress=on_progress), strict=True))
        true = [references.answer(scene).truth for scene in watched]
    flown = [
        {
            (engine, method): trajectory
            for (name, engine, method), trajectory in answers.items()
            if name == scene.name and isinstance(trajectory, Trajectory)
        }
        for scene in watched
    ]
    return films(watched, true, flown, dt)


def films(
    watched: Sequence[Scene],
    true: Sequence[Truth | None],
    flown: Sequence[Mapping[tuple[str, str], Trajectory]],
    dt: float | None = None,
) -> list[Film]:
    """Return the films of scenes that were run.

    Parameters
    ----------
    watched : the scenes, with the instants of a film (`filmed`)
    true : their reference solutions; None: there is none, and so no film
    flown : their runs by engine and method
    dt : step [s]; None: each scene's own

    Returns
    -------
    the films, in the order of the scenes
    """
    return [
        Film(scene, dt or scene.step, truth.until_horizon(), dict(trajectories))
        for scene, truth, trajectories in zip(watched, true, flown, strict=True)
        if truth is not None
    ]


def filmed(scene: Scene, dt: float) -> Scene:
    """Return a scene's first throw, sampled about FRAMES times where steps end.

    Parameters
    ----------
    scene : the scene
    dt : step [s]

    Returns
    -------
    the scene; its samples include the original ones
    """
    return replace(scene, start=frozen_array(scene.start[:1]), times=frozen_array(instants(scene, dt)))


def instants(scene: Scene, dt: float) -> list[float]:
    """Return about FRAMES instants [s] where steps of dt [s] end, the scene's own among them."""
    found: list[float] = [0.0] if scene.times[0] == 0.0 else []
    begin = 0.0
    for leg in legs(scene, dt):
        pieces = min(leg.n, max(1, round(FRAMES * (leg.end - begin) / scene.duration)))
        found += [begin + round(leg.n * piece / pieces) * leg.dt for piece in range(1, pieces)]
        found.append(leg.end)
        begin = leg.end
    return found
