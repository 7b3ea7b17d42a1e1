"""Mistakes of a step: integration methods, identified by the size, sign and shape of their drift."""

from collections.abc import Callable, Iterator
from itertools import product

import numpy as np

from tumble.compare.grade.hypotheses.hypothesis import Context, Hypothesis, choice, grid
from tumble.compare.grade.hypotheses.names import RARELY_NORMALISED, SPIN_RECOVERED, VELOCITY_IN_BODY_AXES
from tumble.compare.grade.model.kernel.dynamics import (
    ALONG_SCREW,
    EXPLICIT,
    EXPONENTIAL,
    HEUN,
    IN_BODY,
    IN_BODY_AXES,
    IN_WORLD,
    MATRIX,
    MOMENTUM,
    OF_UNIT,
    ORDER_2,
    ORDER_3,
    ORDER_4,
    QUATERNION,
    RALSTON,
    RAW,
    RAW_INVERSE,
    RUNGE_KUTTA,
    SHU_OSHER,
    SMOOTH,
    THREE_EIGHTHS,
    VERLET,
    Scheme,
)
from tumble.compare.grade.model.program_model import ProgramModel

# A run of more steps takes longer than it is worth; of more than the second number if its step has a name.
MOST_STEPS, MOST_KNOWN_STEPS = 5_000, 10_000
# Number of first values, and the ratio of the longest to the shortest.
TRIED, RANGE = 7, 200
# Weight that a velocity in body axes costs that is never corrected: with other mistakes it explains any few rows.
UNLIKELY = 15.0
# Weight that it costs to take w from attitudes, as position-based programs do: noise hides how other mistakes differ.
POSITION_BASED = 6.0
RARELY = (2, 3, 4, 5, 8, 10, 16, 20, 25, 30, 32, 50, 60, 64, 100, 120, 128, 240, 500, 1000)
METHODS = {
    "runge-kutta-4": ("Runge-Kutta of order 4", ORDER_4, 0.0), "midpoint": ("midpoint method", ORDER_2, 1.0),
    "heun": ("Heun's method", HEUN, 1.0),
    "runge-kutta-3": ("Runge-Kutta of order 3", ORDER_3, 2.0), "ralston": ("Ralston's method", RALSTON, 3.0),
    "runge-kutta-3-shu-osher": ("Shu and Osher's Runge-Kutta of order 3", SHU_OSHER, 3.0),
    "runge-kutta-4-three-eighths": ("Runge-Kutta of order 4 by the three-eighths rule", THREE_EIGHTHS, 3.0),
}  # fmt: skip
# Those that students' programs and games have with other quaternions in the stages, and the weight of these.
STAGED, OTHER = frozenset({"runge-kutta-4", "midpoint", "heun"}), 1.0
STAGES = {
    OF_UNIT: ("normalised", ", q normalised in each stage"),
    RAW: ("not normalised", ", R from the q of each stage, which is not normalised"),
    RAW_INVERSE: ("not normalised, R I^-1 R^T", ", R I^-1 R^T from the q of each stage, which is not normalised"),
}
WORLD_AXES = ", w in world axes"
VELOCITY_AXES = {
    ALONG_SCREW: ("screw", "and the body moved along a screw"),
    IN_BODY_AXES: ("straight", "and the centre moved straight"),
}
CONSERVED, MIDWAY = ", angular momentum stored", ", angular momentum stored, attitude rotated by the w of mid-step"
UPDATES = {EXPONENTIAL: ("", ""), QUATERNION: ("first order", ", quaternion updated to first order")}


def steps(context: Context) -> Iterator[Hypothesis]:
    """Yield explicit and symplectic Euler as in engines and students' programs, and other methods.

    A program that stores the angular momentum conserves it between impulses.  Others step w by Euler's equations, as
    PyBullet's default body and MuJoCo's Euler do, or with an implicit gyroscopic term.  In a symplectic step, w in body
    axes and w in world axes are the same, since the body rotates about it.
    """
    is_dense = _longest(context) * MOST_KNOWN_STEPS < context.duration  # to simulate a step between rows takes too long
    if context.kind != "pose" and not is_dense and context.speeds[1].any():  # else it is any explicit Euler
        shears = "explicit Euler on the rotation matrix with a step of {} s: the shape is not rigid"
        yield _euler(context, "matrix-euler", shears, MATRIX, EXPLICIT, MOMENTUM)
    if not is_dense:
        yield from _methods(context)
    yield from _details(context)
    if not is_dense:
        yield from _position_updates(context)
        yield from velocity_axes(context)


def _details(context: Context) -> Iterator[Hypothesis]:
    """Yield details that a step of any method may have."""
    for is_unit_used, where in ((False, ""), (True, ", and where an impulse acts"))[
        : 1 + bool(context.program.impulses)
    ]:
        yield Hypothesis(
            RARELY_NORMALISED,
            "normalisation",
            f"quaternion normalised only every {{}} steps{where}",
            lambda program, number, is_unit_used=is_unit_used: program.but(
                scheme=program.scheme._replace(normalise_every=RARELY[int(number)], is_unit_used=is_unit_used)
            ),
            choice(len(RARELY)),
            tuple(map(str, RARELY)),
            needs_steps=True,
        )
    yield Hypothesis(
        SPIN_RECOVERED,
        "stored spin",
        "angular velocity taken from the attitudes before and after a step, 2 Im(q' q*)/dt",
        lambda program, _: program.but(scheme=program.scheme._replace(recovers=True)),
        unlikely=POSITION_BASED,
        needs_steps=True,
    )


def _methods(context: Context) -> Iterator[Hypothesis]:
    """Yield methods of higher order: what they store of the rotation, and what quaternions their stages have.

    Their error is so small that any step would fit, so only usual steps are tried.
    """
    if not (named := _named_steps(context)):
        return
    places = ((IN_BODY, ""), (IN_WORLD, WORLD_AXES), (MOMENTUM, CONSERVED))
    equal = np.ptp(context.program.moments) == 0
    for (stored, axes), (name, (title, method, unlikely)) in product(places[: 2 if equal else 3], METHODS.items()):
        scheme = Scheme(0.0, RUNGE_KUTTA, method, False, 0.0, stored=stored)
        yield _method(named, name, title, axes, scheme, unlikely)
        for stages, (word, text) in STAGES.items() if name in STAGED else ():
            if stages == OF_UNIT or stored != IN_BODY:
                other = scheme._replace(stages=stages)
                yield _method(named, name, title, axes + text, other, unlikely + OTHER, (("stages", word),))
    name, title, verlet = "velocity-verlet", "velocity Verlet", Scheme(0.0, RUNGE_KUTTA, VERLET, False, 0.0)
    yield _method(named, name, title, "", verlet, 1.0)
    # With w stored, the quaternion to first order makes it symplectic Euler wherever nothing acts.
    for rotation, (word, update) in UPDATES.items() if not equal else ():
        other = verlet._replace(stored=MOMENTUM, rotation=rotation)
        details = ("rotation", word), ("stored", "angular momentum")
        yield _method(named, name, title, MIDWAY + update, other, 1.0, details)


def _method(
    named: dict[float, str],
    name: str,
    title: str,
    more: str,
    scheme: Scheme,
    unlikely: float,
    details: tuple[tuple[str, str], ...] = (),
) -> Hypothesis:
    """Return a method; named: its steps [s]."""
    return Hypothesis(
        name,
        "steps",
        f"{title} with a step of {{}} s{more}",
        lambda program, step: program.but(scheme=scheme._replace(step=step)),
        tuple(sorted(named)),
        named_values=named,
        only_named=True,
        unit="s",
        details=details,
        unlikely=unlikely,
    )


def _named_steps(context: Context) -> dict[float, str]:
    """Return steps with a name that a program may take [s]."""
    shortest, longest = context.duration / MOST_KNOWN_STEPS, context.spacing_s * 1.01
    return {step: name for step, name in context.steps.items() if shortest <= step < longest}


def _euler(
    context: Context,
    name: str,
    text: str,
    attitude: int,
    spin: int,
    stored: int,
    symplectic: bool = False,
    normalise_every: int = 1,
) -> Hypothesis:
    longest = _longest(context)
    shortest = max(longest / RANGE, context.duration / MOST_STEPS)
    return Hypothesis(
        name,
        "steps",
        text,
        lambda program, step: program.but(
            scheme=Scheme(step, attitude, spin, symplectic, 1.0 if symplectic else 0.0, normalise_every, stored=stored),
        ),
        grid(min(shortest, longest / 2), longest, TRIED),
        named_values=_named_steps(context),
        unit="s",
    )


def _longest(context: Context) -> float:
    """Return the longest step that is tried [s], at most the row interval."""
    return min(0.1 * context.duration, 0.5 * context.turn_s, context.spacing_s)


def velocity_axes(context: Context) -> Iterator[Hypothesis]:
    """Yield velocities of the centre that are stored in body axes, if it moves."""
    still = not context.program.start[7:10].any() and not context.program.gravity.any() and context.scene.is_free
    if still and not context.program.impulses:
        return
    yield from map(velocity_in_body_axes, (ALONG_SCREW, IN_BODY_AXES))
    yield Hypothesis(
        "velocity-in-body-axes-without-correction",
        "velocity axes",
        "velocity of the centre stored in body axes without -w x v: it rotates with the body",
        lambda program, _: program.but(swirl=1.0, scheme=program.scheme._replace(velocity_axes=IN_BODY_AXES)),
        unlikely=UNLIKELY,
    )


def velocity_in_body_axes(axes: int) -> Hypothesis:
    """Return that the velocity of the centre is stored in body axes, in steps of Euler's methods."""
    moves, text = VELOCITY_AXES[axes]
    return Hypothesis(
        VELOCITY_IN_BODY_AXES,
        "velocity axes",
        f"velocity of the centre stored in body axes, with -w x v by a step, {text}",
        lambda program, _: program.but(scheme=program.scheme._replace(velocity_axes=axes)),
        details=(("moves", moves),),
        needs_steps=True,
    )


def _position_updates(context: Context) -> Iterator[Hypothesis]:
    """Yield other updates of the position, if a force acts."""
    if not context.program.gravity.any() and context.scene.is_free:
        return

    def updated(program: ProgramModel, change: Callable[[float], float]) -> ProgramModel:
        if program.scheme.attitude == SMOOTH:
            return program
        return program.but(scheme=program.scheme._replace(position_weight=change(program.scheme.position_weight)))

    for text, change in (
        ("by x += v dt + a dt^2/2", lambda _: 0.5),
        (
            "by the other velocity: the new instead of the old, or the old instead of the new",
            lambda weight: 1.0 - weight,
        ),
        ("by x += v dt + a dt^2/2 with the new velocity", lambda _: 1.5),
        ("by x += v dt + a dt^2 with the new velocity", lambda _: 2.0),
    ):
        yield Hypothesis(
            "wrong-position-update",
            "position step",
            f"position updated {text}",
            lambda program, _, change=change: updated(program, change),
            needs_steps=True,
        )
