"""Films a scene: the truth and every contestant at some sixty instants between and at the scene's own.

The instants lie on the steps that a flight takes anyway, so that who is watched flies as it does unwatched.
"""

from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import dataclass, replace

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
    """One scene with its instants, its step [s], its truth up to the horizon, and the flights by engine and method."""

    scene: Scene
    dt: float
    truth: Truth
    flights: dict[tuple[str, str], Trajectory]


def film(
    running_engines: Sequence[RunningEngine],
    scenes: Sequence[Scene],
    dt: float | None = None,
    on_progress: ProgressCallback = no_progress,
    truths: Truths | None = None,
) -> list[Film]:
    """Return the films of all scenes that have a truth; dt [s], by default each scene's own step.

    truths: where those of the films' scenes (`filmed`) are asked for already.
    """

    def task(scene: Scene, running_engine: RunningEngine, method: str) -> Task[Trajectory | Failure]:
        key = scene.name, running_engine.title, method
        return Task(key, running_engine, lambda able: able.fly(scene, method, dt or scene.step))

    watched = [filmed(scene, dt or scene.step) for scene in scenes]
    tasks = [
        task(scene, running_engine, method)
        for scene in watched
        for running_engine in running_engines
        for method in running_engine.methods_for(scene)
    ]
    with nullcontext(truths) if truths else Truths(watched, on_progress, limit_s=truth_limit(running_engines)) as asked:
        answers = dict(zip((one.key for one in tasks), run(tasks, asked, on_progress=on_progress), strict=True))
        true = [asked.answer(scene).truth for scene in watched]
    return [
        Film(
            scene=scene,
            dt=dt or scene.step,
            truth=answer.until_horizon(),
            flights={
                (engine, method): flight
                for (name, engine, method), flight in answers.items()
                if name == scene.name and isinstance(flight, Trajectory)
            },
        )
        for scene, answer in zip(watched, true, strict=True)
        if answer is not None
    ]


def filmed(scene: Scene, dt: float) -> Scene:
    """Return the scene's first throw, looked at some FRAMES times, where steps of dt [s] end."""
    return replace(scene, start=frozen_array(scene.start[:1]), times=frozen_array(instants(scene, dt)))


def instants(scene: Scene, dt: float) -> list[float]:
    """Return some FRAMES instants [s] where steps of dt [s] end, the scene's own among them."""
    found: list[float] = [0.0] if scene.times[0] == 0.0 else []
    begin = 0.0
    for leg in legs(scene, dt):
        pieces = min(leg.n, max(1, round(FRAMES * (leg.end - begin) / scene.duration)))
        found += [begin + round(leg.n * piece / pieces) * leg.dt for piece in range(1, pieces)]
        found.append(leg.end)
        begin = leg.end
    return found
