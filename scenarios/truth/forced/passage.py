"""The flight from one blow to the next: steps as long as they resolve the motion, each ending where a law switches."""

from typing import NamedTuple

import numpy as np

from scenarios.frames import Array
from scenarios.truth.forced.compilation import inlined, inner, kernel
from scenarios.truth.forced.laws import SIZE, Forces, Solid
from scenarios.truth.forced.radau import Step, Tableau, follow, iterate, new_step, newton, stand_still, unresolved
from scenarios.truth.forced.switches import ABOVE, NEVER, PRESSING, Switch, next_switch, off_switch, set_contacts

ARRIVED, TOO_LONG, LOST = 0, 1, 2
# Of what the tolerance would allow; and how much longer, or shorter, a step may be than the one before.
CAUTION, GROWTH, SHRINKAGE = 0.85, 2.0, 0.25
# Iteration is cheapest, per second flown, where each brings its factor of about e.
BRISK = 0.35
# A step that is this small a share of the passage gets nowhere: a motion without end, or without a direction.
SMALLEST = 1e-15
# The share of the body's size and distance that a step may be off by at any tolerance: it is rounding.
INVISIBLE = 1e-15
# After as many steps the pace is judged.
PATIENCE = 2000
CORRECTIONS = 4


class Manner(NamedTuple):
    """How to integrate: the collocation; what of the motion a step may leave unresolved, in its scales; and how many

    steps there may be.
    """

    rule: Tableau
    tolerance: float
    most_steps: int


@kernel
def passage(
    state: Array,
    spans: Array,
    rows: Array,
    solid: Solid,
    forces: Forces,
    manner: Manner,
    implicit: bool | None,
) -> tuple[int, int]:
    """Fly from a state through stops, one after each of the spans [s], and write the state at each into rows.

    state: a double and its rounding, (2, SIZE); rows: (stops, 2, SIZE); implicit: whether by Newton's iteration: None,
    not False, if not, so that a process that needs none does not compile it.
    Returns ARRIVED, TOO_LONG or LOST, and how many steps there were.
    """
    contacts, pressing = np.full(len(solid.points), ABOVE), np.zeros(len(solid.points), dtype=np.bool_)
    set_contacts(state[0], solid, forces, contacts)
    step, known, h = new_step(len(manner.rule.nodes)), 0.0, spans.max()
    whole, gone, steps = spans.sum(), 0.0, 0
    for stop in range(len(spans)):
        flown = np.zeros((2, 1))
        while flown[0, 0] < spans[stop]:
            steps += 1
            if h < SMALLEST * whole:
                return LOST, steps
            hopeless = (gone + flown[0, 0]) * manner.most_steps < whole * steps
            if steps > manner.most_steps or (steps == PATIENCE and hopeless):
                return TOO_LONG, steps
            rest = (spans[stop] - flown[0, 0]) - flown[1, 0]
            taken = rest / np.ceil(rest / h)
            for number in range(SIZE):
                step.y[number] = state[0, number]
            for vertex in range(len(contacts)):
                pressing[vertex] = contacts[vertex] == PRESSING
            if known > 0.0:
                follow(step, 1.0, taken / known, manner.rule)
            else:
                stand_still(step)
            known = 0.0
            solved, rate = solve(step, taken, solid, forces, pressing, manner, implicit)
            error = unresolved(step, manner.rule) if solved else np.inf
            factor = CAUTION * (manner.tolerance / error) ** (1.0 / len(manner.rule.powers)) if error > 0.0 else GROWTH
            h = taken * max(SHRINKAGE, min(factor, GROWTH, BRISK / rate if rate > 0.0 else GROWTH))
            if not error <= manner.tolerance:
                continue
            switch = next_switch(step, taken, manner.rule, solid, forces, contacts)
            if switch.at == NEVER:
                known = taken
            else:
                solved, taken = end_on(switch, step, taken, solid, forces, pressing, manner, implicit)
                if not solved:
                    h = taken * SHRINKAGE
                    continue
                contacts[switch.vertex] = switch.then
            for number in range(SIZE):
                advance(state, number, step.stages[-1, number])
            advance(flown, 0, taken)
        gone += spans[stop]
        for part in range(2):
            for number in range(SIZE):
                rows[stop, part, number] = state[part, number]
    return ARRIVED, steps


@inner
def solve(
    step: Step, h: float, solid: Solid, forces: Forces, pressing: np.ndarray, manner: Manner, implicit: bool | None
) -> tuple[bool, float]:
    """Find the stages of a step from those guessed; return whether they were, and the factor of plain iteration."""
    least = INVISIBLE / manner.tolerance
    if implicit is None:
        return iterate(step, h, manner.rule, solid, forces, pressing, least)
    return newton(step, h, manner.rule, solid, forces, pressing, least), 0.0


@inner
def end_on(
    switch: Switch,
    step: Step,
    h: float,
    solid: Solid,
    forces: Forces,
    pressing: np.ndarray,
    manner: Manner,
    implicit: bool | None,
) -> tuple[bool, float]:
    """Shorten a step until it ends on the switch; return whether that could be solved, and how long it is.

    The polynomial of the whole step is a little off inside, so the shorter one is tried again, by Newton's correction.
    """
    ratio, taken = switch.at, h
    for _ in range(CORRECTIONS):
        if ratio * taken <= SMALLEST * h:
            stand_still(step)
            return True, 0.0
        follow(step, 0.0, ratio, manner.rule)
        taken *= ratio
        solved, _ = solve(step, taken, solid, forces, pressing, manner, implicit)
        if not solved:
            return False, taken
        late = off_switch(step, manner.rule, solid, forces, switch)
        if not abs(late) * taken > SMALLEST * h:
            break
        ratio = min(max(1.0 - late, 0.0), 2.0)
    return True, taken


@inlined
def advance(state: Array, number: int, moved: float) -> None:
    """Add to a number that is a double and its rounding.  Source: Moller, "Quasi double-precision", BIT 5 (1965) 37."""
    small = state[1, number] + moved
    total = state[0, number] + small
    part = total - state[0, number]
    state[1, number] = (state[0, number] - (total - part)) + (small - part)
    state[0, number] = total
