"""Mistakes with one impulse of several, and with the time of any."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from tumble.compare.grade.hypotheses.hypothesis import STEPS, Hypothesis, Question, choice, grid
from tumble.compare.grade.model.program_model import FINE, Account
from tumble.scenarios.frames import Array, rotation_matrix
from tumble.scenarios.scene import Impulse

# Bodies of more vertices than this are meshes, whose vertices nobody takes for one another.
MOST_VERTICES = 27


def one_impulse(question: Question) -> Iterator[Hypothesis]:
    """Yield what may be wrong with each impulse by itself."""
    impulses = question.account.impulses
    for number, impulse in enumerate(impulses):
        which = f"impulse {number + 1}" if len(impulses) > 1 else "the impulse"
        yield _at_another_time(question, number, which)
        if len(impulses) > 1:
            yield from _of_another_size(number, which)
            yield from _elsewhere(question, number, impulse, which)


def _at_another_time(question: Question, number: int, which: str) -> Hypothesis:
    time = question.account.impulses[number].time
    times = np.linspace(-time, question.duration - time, 25)
    return Hypothesis(
        "impulse at another time",
        "impulse time",
        f"{which} acts {{}} s after its time",
        lambda account, late: _changed(account, number, late=late),
        tuple(times.tolist()),
        known={step: name for step, name in STEPS.items() if step < times[-1]},
        rare=True,
        unit="s",
    )


def _of_another_size(number: int, which: str) -> Iterator[Hypothesis]:
    for name, says, factor in (
        ("one impulse missing", "missing", 0.0),
        ("one impulse doubled", "applied twice", 2.0),
        ("one impulse reversed", "of the wrong sign", -1.0),
    ):
        yield Hypothesis(
            name,
            "one impulse",
            f"{which} {says}",
            lambda account, _, factor=factor: _changed(account, number, factor=factor),
            rare=True,
        )
    yield Hypothesis(
        "one impulse of another size",
        "one impulse",
        f"{which} {{}} times what it is",
        lambda account, factor: _changed(account, number, factor=factor),
        grid(1e-3, 1e3, 25),
        rare=True,
    )


def _elsewhere(question: Question, number: int, impulse: Impulse, which: str) -> Iterator[Hypothesis]:
    """Yield that one impulse acts at another point of the body, or along other axes."""
    account, points = question.account, question.scene.body.points
    row = account.flown(np.array([impulse.time]), FINE)[0]  # after the impulse: pose and place are as before
    x, axes = row[0:3], row[3:12].reshape(3, 3)
    at = axes.T @ (impulse.point_world - x) if impulse.point_body is None else impulse.point_body
    first = rotation_matrix(account.start[3:7])
    for name, says, point in (
        ("one impulse at the centre", f"{which} applied at the centre of mass", np.zeros(3)),
        ("one impulse lever reversed", f"torque of {which} of the wrong sign", -at),
        ("one impulse lever not turned", f"lever of {which} in body axes, not turned to the world", axes.T @ at),
        ("one impulse lever as at the start", f"lever of {which} turned as it was at the start", axes.T @ first @ at),
        ("one impulse point from the origin", f"point of {which} not taken from the centre of mass", at + axes.T @ x),
    ):
        if not np.allclose(point, at):
            yield Hypothesis(
                name,
                "one impulse",
                says,
                lambda account, _, point=point: _changed(account, number, point=point),
                rare=True,
            )
    value = axes @ impulse.value
    if not np.allclose(value, impulse.value):
        yield Hypothesis(
            "one impulse in body axes",
            "one impulse",
            f"{which} taken in body axes",
            lambda account, _: _changed(account, number, value=value),
            rare=True,
        )
    others = [k for k, point in enumerate(points) if not np.allclose(point, at)]
    if len(points) <= MOST_VERTICES:
        yield Hypothesis(
            "one impulse at another vertex",
            "one impulse",
            f"{which} applied at {{}}",
            lambda account, k: _changed(account, number, point=points[others[int(k)]]),
            choice(len(others)),
            tuple(f"vertex {k}" for k in others),
            rare=True,
            of_scene=True,
        )


def _changed(
    account: Account,
    number: int,
    late: float = 0.0,
    factor: float = 1.0,
    point: Array | None = None,
    value: Array | None = None,
) -> Account:
    """Return the account with one impulse later, of another size or value, or at another point of the body."""
    impulses = list(account.impulses)
    old = impulses[number]
    new = replace(old, time=old.time + late, value=factor * (old.value if value is None else value))
    impulses[number] = new if point is None else replace(new, point_world=None, point_body=point)
    return replace(account, impulses=tuple(sorted(impulses, key=lambda impulse: impulse.time)))
