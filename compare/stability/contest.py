"""All of `tumble stability`: every scene and every extreme case to every contestant, engines side by side.

What one contestant makes of one scene is a piece, done whole or not at all, and handed over as soon as it is done.
"""

import os
import threading
from collections.abc import Callable, Collection, Sequence
from concurrent.futures import Future, ThreadPoolExecutor

from compare.comparison.comparison import give_up
from compare.run.participants import Participant
from compare.stability.extremes import Case, ExtremeRow, extreme, true_case
from compare.stability.stability import FACTORS, Piece, Question, Stopped, Trials, column_truth, columns, contestants
from scenarios.scene import Scene

# Mapped where no scene is named.
STIFF = (
    "tether-undamped",
    "tether-critical",
    "tether-overdamped",
    "rod-stiff",
    "drag-stiff",
    "floor-stiff",
    "spin-fast",
)
Key = tuple[str, str, str]
Done = Piece | ExtremeRow


def keys(participants: Sequence[Participant], scenes: Sequence[Scene], cases: Sequence[Case]) -> list[Key]:
    """Return scene, engine and method of every piece there will be, in the order of the tables."""
    asked = (*scenes, *(case.scene for case in cases))
    return [
        (scene.name, participant.title, method)
        for scene in asked
        for participant in participants
        for method in contestants(participant, scene)
    ]


def stability(
    participants: Sequence[Participant],
    scenes: Sequence[Scene],
    cases: Sequence[Case],
    keep: Callable[[Done], object],
    tick: Callable[[str], object] = lambda what: None,
    done: Collection[Key] = (),
    factors: Sequence[float] = FACTORS,
) -> None:
    """Hand over every piece as it is done, but for those that are done already.

    keep: called from several threads, one at a time; tick is told what was done; factors: of the scenes' own values.
    Raises BadScene for a scene in which nothing can be stiff, RayMissed as truth does.
    """
    stop, one_at_a_time = threading.Event(), threading.Lock()
    told = [columns(scene, factors) for scene in scenes]
    tasks: list[Future] = []
    truths = ThreadPoolExecutor(1)
    pool = ThreadPoolExecutor(max(1, min(len(participants), os.cpu_count() or 1)))
    try:
        questions = [
            Question(scene, own, [truths.submit(column_truth, column) for column in own])
            for scene, own in zip(scenes, told, strict=True)
        ]
        answers = [truths.submit(true_case, case) for case in cases]

        def hand_over(piece: Done) -> None:
            with one_at_a_time:
                keep(piece)
                tick(" ".join((piece.key[0], ":".join(piece.key[1:]))))

        def ask(participant: Participant) -> None:
            for question in questions:
                for method in contestants(participant, question.scene):
                    if (question.scene.name, participant.title, method) not in done:
                        hand_over(Trials(participant, method, question, stop).piece())
            for case, answer in zip(cases, answers, strict=True):
                for method in contestants(participant, case.scene):
                    if (case.scene.name, participant.title, method) not in done:
                        if stop.is_set():
                            raise Stopped
                        hand_over(extreme(participant, method, case, answer.result()))

        # The engine with most methods is what the others are waited for with at the end, so it begins.
        tasks += [
            pool.submit(ask, participant) for participant in sorted(participants, key=lambda each: -len(each.methods))
        ]
        for task in tasks:
            task.result()
    except BaseException:
        truths.shutdown(wait=False, cancel_futures=True)
        give_up(participants, stop, tasks)
        raise
    finally:
        pool.shutdown()
        truths.shutdown(cancel_futures=True)
