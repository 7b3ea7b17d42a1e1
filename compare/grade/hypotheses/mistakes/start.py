"""Mistakes with the start: what was not set, or was set in other axes, or is not what the scene says."""

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from tumble.compare.grade.hypotheses.hypothesis import Hypothesis, Question, choice
from tumble.compare.grade.hypotheses.mistakes.axes import axis_names, signed_permutations
from tumble.compare.grade.model.program_model import Account
from tumble.scenarios.frames import Array, rotation_matrix

POSITION, ATTITUDE, VELOCITY, SPIN = slice(0, 3), slice(3, 7), slice(7, 10), slice(10, 13)
UNTURNED = np.array([1.0, 0.0, 0.0, 0.0])
INVERSE = np.array([1.0, -1.0, -1.0, -1.0])


def start(question: Question) -> Iterator[Hypothesis]:
    """Yield what is wrong with the state that the program began with, where it would make a difference."""
    account, first = question.account, question.first
    turn = rotation_matrix(account.start[ATTITUDE])
    changes: list[tuple[str, str, str, slice, Array]] = [
        ("start velocity missing", "start velocity", "velocity of the start not set", VELOCITY, np.zeros(3)),
        ("start spin missing", "spin", "angular velocity of the start not set", SPIN, np.zeros(3)),
        ("start attitude missing", "start attitude", "attitude of the start not set", ATTITUDE, UNTURNED),
        ("start position missing", "start position", "position of the start not set", POSITION, np.zeros(3)),
    ]
    for name, part, what, place in (
        ("start velocity", "start velocity", "velocity", VELOCITY),
        ("start spin", "spin", "angular velocity", SPIN),
    ):
        value = account.start[place]
        changes += [
            (f"{name} reversed", part, f"{what} of the start of the wrong sign", place, -value),
            (f"{name} turned back", part, f"{what} of the start turned from world to body axes", place, turn.T @ value),
        ]
    velocity = account.start[VELOCITY]
    says = "velocity of the start taken in body axes"
    changes.append(("start velocity in body axes", "start velocity", says, VELOCITY, turn @ velocity))
    inverse = INVERSE * account.start[ATTITUDE]
    changes.append(("start attitude inverted", "start attitude", "attitude of the start inverted", ATTITUDE, inverse))
    if first is not None:
        x, q = first[:3], first[3:]
        says = f"it starts from x = {_numbers(x)} m, not from where the scene says"
        changes.append(("another start position", "start position", says, POSITION, x))
        says = f"it starts with the attitude {_numbers(q)}, not with the scene's"
        changes.append(("another start attitude", "start attitude", says, ATTITUDE, q))
    if question.drift is not None and question.drift[0].any():
        velocity = account.start[VELOCITY] + question.drift[0]
        says = f"it starts with a velocity of {_numbers(velocity)} m/s, not with the scene's"
        changes.append(("another start velocity", "start velocity", says, VELOCITY, velocity))
    for name, part, says, place, value in changes:
        if _differs(account.start[place], value, place):
            is_taken = name.startswith("another")
            taken = 3 if is_taken else 0
            yield Hypothesis(name, part, says, _set(place, value), rare=True, of_scene=is_taken, taken=taken)
    yield from _in_other_axes(account)


def _in_other_axes(account: Account) -> Iterator[Hypothesis]:
    """Yield that only a part of the start was turned into other axes, as y up into z up."""
    renamings = [*signed_permutations(1), *signed_permutations(-1)]
    q = account.start[ATTITUDE]
    for name, part, what, place, values in (
        ("start velocity", "start velocity", "velocity", VELOCITY, [a @ account.start[VELOCITY] for a in renamings]),
        ("start spin", "spin", "angular velocity", SPIN, [a @ account.start[SPIN] for a in renamings]),
        # An attitude in mirrored axes is one in others that are not: its axis turns round as well.
        ("start attitude", "start attitude", "attitude", ATTITUDE, [_renamed(a, q) for a in signed_permutations(1)]),
    ):
        others = [number for number, value in enumerate(values) if _differs(account.start[place], value, place)]
        if others:
            yield Hypothesis(
                f"{name} in other axes",
                part,
                f"{what} of the start in other axes: for x y z stand {{}}",
                lambda account, number, place=place, values=values, others=others: _set(
                    place, values[others[int(number)]]
                )(account, 0.0),
                choice(len(others)),
                tuple(axis_names(renamings[number]) for number in others),
                rare=True,
            )


def _renamed(axes: Array, q: Array) -> Array:
    return np.array([q[0], *(axes @ q[1:])])


def _set(place: slice, value: Array) -> Callable[[Account, float], Account]:
    def change(account: Account, _: float) -> Account:
        state = account.start.copy()
        state[place] = value
        return replace(account, start=state)

    return change


def _differs(one: Array, other: Array, place: slice) -> bool:
    if place == ATTITUDE:
        return bool(abs(abs(one @ other) / np.linalg.norm(one) / np.linalg.norm(other) - 1) > 1e-12)
    return bool((one != other).any())


def _numbers(values: Array) -> str:
    return "(" + ", ".join(f"{value:.4g}" for value in values) + ")"
