"""One loop over scene x contestant: every engine in a process of its own, side by side."""

import os
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass

from compare.judge.errors import Run
from compare.run.flight import Trajectory
from compare.run.participants import Participant
from compare.run.worker import Failure
from scenarios.impulse import RayMissed
from scenarios.scene import Scene
from scenarios.truth import NoTruth, Truth, truth


@dataclass(frozen=True, eq=False)
class Comparison:
    """A scene, its truth or why it has none, and what every contestant made of it."""

    scene: Scene
    truth: Truth | None
    why_no_truth: str
    runs: tuple[Run, ...]


def compare(
    participants: Sequence[Participant],
    scenes: Sequence[Scene],
    dt: float | None = None,
    tick: Callable[[str], object] = lambda what: None,
) -> list[Comparison]:
    """Put every scene to every participant and hold the answers against the truth.

    dt: step [s], by default each scene's own; tick is told of every flight and truth as it is done.
    Raises RayMissed where the true body is not in the way of a later ray.
    """
    stop = threading.Event()
    flights: list[Future] = []
    with ThreadPoolExecutor(max(1, min(len(participants), os.cpu_count() or 1))) as pool:
        try:
            flights += [pool.submit(fly_all, participant, scenes, dt, tick, stop) for participant in participants]
            truths = [true_answer(scene, tick) for scene in scenes]
            answers = [flight.result() for flight in flights]
        except BaseException:
            give_up(participants, stop, flights)
            raise
    return [
        Comparison(
            scene,
            *true,
            tuple(
                Run(scene, participant.title, method, dt or scene.step, answer[number, method], true[0])
                for participant, answer in zip(participants, answers, strict=True)
                for method in participant.methods_for(scene)
            ),
        )
        for number, (scene, true) in enumerate(zip(scenes, truths, strict=True))
    ]


def fly_all(
    participant: Participant,
    scenes: Sequence[Scene],
    dt: float | None,
    tick: Callable[[str], object],
    stop: threading.Event,
) -> dict[tuple[int, str], Trajectory | Failure]:
    """Return one participant's answers by scene number and method; a dead worker is replaced for the next question."""
    answers: dict[tuple[int, str], Trajectory | Failure] = {}
    for number, scene in enumerate(scenes):
        for method in participant.methods_for(scene):
            if stop.is_set():
                return answers
            answers[number, method] = (
                participant.unsupported(scene)
                or participant.ensure_running()
                or participant.worker.fly(scene, method, dt or scene.step)
            )
            tick(f"{scene.name} {participant.title}:{method}")
    return answers


def true_answer(scene: Scene, tick: Callable[[str], object]) -> tuple[Truth | None, str]:
    """Return the truth, or None and the reason there is none."""
    try:
        return truth(scene), ""
    except NoTruth as reason:
        return None, str(reason)
    except RayMissed as missed:
        raise RayMissed(f"{scene.name}: {missed}") from missed
    finally:
        tick(f"{scene.name} truth")


def give_up(participants: Sequence[Participant], stop: threading.Event, flights: Sequence[Future]) -> None:
    """Let the threads that wait for engines end at once."""
    stop.set()
    for flight in flights:
        flight.cancel()
    for participant in participants:
        participant.worker.kill()
