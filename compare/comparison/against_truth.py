"""Every contestant on every scene, held against the truth."""

from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass

from tumble.compare.judge.errors import Flown, Run
from tumble.compare.run.flight import Trajectory
from tumble.compare.run.participants import AS_ASKED, DEFAULT, Participant, truth_limit
from tumble.compare.run.progress import Tick, untold
from tumble.compare.run.tasks import Task, run
from tumble.compare.run.truths import Truths
from tumble.compare.run.worker import Failure
from tumble.scenarios.scene import Scene
from tumble.scenarios.truth import Truth
from tumble.scenarios.truth.handed import cost_of_doubles


@dataclass(frozen=True, eq=False)
class Comparison:
    """A scene, its truth or why it has none, and what every contestant made of it.

    lost_m: how far what engines are handed, in doubles, is from the scene as it is written, at most [m]; 0 untold;
    roles: what contestants are to their engines (`Participant.role`), by ENGINE:METHOD.
    """

    scene: Scene
    truth: Truth | None
    why_no_truth: str
    runs: tuple[Run, ...]
    lost_m: float
    roles: Mapping[str, str]

    @property
    def defaults(self) -> frozenset[str]:
        """The contestants that do what their engines do where nobody sets anything."""
        return frozenset(name for name, role in self.roles.items() if role == DEFAULT)

    @property
    def asked(self) -> frozenset[str]:
        """The contestants that take part because the user named them."""
        return frozenset(name for name, role in self.roles.items() if role == AS_ASKED)


def compare(
    participants: Sequence[Participant],
    scenes: Sequence[Scene],
    dt: float | None = None,
    tick: Tick = untold,
    truths: Truths | None = None,
) -> list[Comparison]:
    """Put every scene to every participant and hold the answers against the truth.

    dt: step [s], by default each scene's own; tick is told of every flight and truth as it is done; truths: where those
    of the scenes are asked for already.
    Raises RayMissed where the true body is not in the way of a later ray.
    """

    def task(scene: Scene, participant: Participant, method: str) -> Task[Trajectory | Failure]:
        key = scene.name, participant.title, method
        return Task(key, participant, lambda able: able.fly(scene, method, dt or scene.step, untold=True))

    tasks = [
        [task(scene, participant, method) for participant in participants for method in participant.methods_for(scene)]
        for scene in scenes
    ]
    with nullcontext(truths) if truths else Truths(scenes, tick, limit_s=truth_limit(participants)) as asked:
        answers = iter(run([one for own in tasks for one in own], asked, tick=tick))
        true = [asked.answer(scene) for scene in scenes]
        lost = asked.each(lost_m, scenes, [answer.truth for answer in true])
    return [
        Comparison(
            scene,
            *answer,
            tuple(
                Flown.of(one.participant, one.key[-1], dt or scene.step, next(answers)).run(
                    scene, one.participant.title, answer.truth
                )
                for one in own
            ),
            lost,
            {f"{one.participant.title}:{one.key[-1]}": one.participant.role(one.key[-1]) for one in own},
        )
        for scene, answer, own, lost in zip(scenes, true, tasks, lost, strict=True)
    ]


def lost_m(scene: Scene, truth: Truth | None) -> float:
    """Return what being handed doubles costs at most [m], 0 where there is no truth to tell it by."""
    return 0.0 if truth is None else cost_of_doubles(scene, truth)
