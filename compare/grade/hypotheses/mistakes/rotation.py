"""Mistakes with inertia, Euler's equations and the angular velocity."""

from collections.abc import Iterator
from itertools import permutations, product

import numpy as np

from tumble.compare.grade.hypotheses.hypothesis import Context, Hypothesis, choice, grid
from tumble.compare.grade.hypotheses.mistakes.scene_forces import turns_by_drag_only
from tumble.compare.grade.hypotheses.names import GYROSCOPIC_TERM_MISSING
from tumble.compare.grade.model.kernel.dynamics import (
    FROZEN,
    IN_BODY,
    IN_WORLD,
    MIXED_BODY,
    MIXED_WORLD,
    MOMENTUM,
    MULTIPLIED,
    NEVER_TURNED,
    RESPONSE_UNTURNED,
    TURNED,
    TURNED_BACK,
    UNDIVIDED,
)
from tumble.compare.grade.model.program_model import ProgramModel
from tumble.scenarios.frames import quaternion_product, rotation_matrix
from tumble.solver.forces import gives_torque

DEGREE = np.pi / 180
# An inertia larger or smaller than this factor is rare.
FAR = 31.6
# Factors on one moment that are tried.
MOMENTS = (0.5, 0.7, 0.85, 1.15, 1.4, 2.0)
# Weight that it costs to assume a sphere: without impulses it moves as without the gyroscopic term, which is left out
# by many.
UNUSUAL = 8.0


def rotation(context: Context) -> Iterator[Hypothesis]:
    """Yield mistakes with the rotation of the body."""
    program = context.program
    if program.impulses:
        yield from _inertia_size(program.mass, grid(1 / FAR, FAR, 31))
        # Large factors apart, as no fit leads to them.
        yield from _inertia_size(program.mass, (*grid(1e-3, 1 / FAR, 16), *grid(FAR, 1e3, 16)), is_far=True)
    elif gives_torque(program.forces, turning=True) and not turns_by_drag_only(context):
        yield from _inertia_size(program.mass, grid(0.1, 10.0, 9))
    if np.ptp(program.moments) > 0:
        yield from _unequal_moments(context)
    yield from _frames(context)
    yield from _attitude_rate()
    if program.start[10:13].any():
        yield from _start_spin(program)


def _inertia_size(mass: float, factors: tuple[float, ...], is_far: bool = False) -> Iterator[Hypothesis]:
    """Yield a scaled inertia, which shows only with impulses and torques: free rotation does not depend on it."""
    of_mass = {1 / mass: "mass left out", mass: "mass twice"} if mass != 1 else {}
    yield Hypothesis(
        "wrong-inertia",
        "inertia size",
        "inertia {} times its value",
        lambda program, factor: program.but(moments=factor * program.moments),
        factors,
        named_values={} if is_far else of_mass | {0.25: "half edges used as edges", 4.0: "edges used as half edges"},
        neutral=None if is_far else 1.0,
    )


def _attitude_rate() -> Iterator[Hypothesis]:
    """Yield a wrong factor between the angular velocity and the rate of the attitude.

    Results differ if the program stores L, which then turns in the body at the wrong rate, too.
    """
    for (name, text, factor), (stored, keeps_momentum) in product(
        (
            ("quaternion-rate-doubled", "attitude rotated twice as fast: q' = w q without the factor 1/2", 2.0),
            ("quaternion-rate-halved", "attitude rotated half as fast: q' = w q / 4", 0.5),
            ("quaternion-rate-reversed", "attitude rotated the other way: q' = -w q / 2", -1.0),
        ),
        (("", False), (" (angular momentum stored)", True)),
    ):
        yield Hypothesis(
            name,
            "turning",
            text + stored,
            lambda program, _, factor=factor, stored=MOMENTUM if keeps_momentum else IN_BODY: program.but(
                attitude_rate_factor=factor, scheme=program.scheme._replace(stored=stored)
            ),
        )


def _frames(context: Context) -> Iterator[Hypothesis]:
    """Yield that the attitude is rotated by w in the wrong frame; results differ if the program stores w or L."""
    world = "attitude rotated with Q w~, but w is in world axes: use w~ Q"
    body = "attitude rotated with w~ Q, but w is in body axes: use Q w~"
    variants = [(world, MIXED_WORLD, MOMENTUM), (body, MIXED_BODY, IN_BODY)]
    if np.ptp(context.program.moments) > 0:
        variants.append((f"{world} (w by Euler's equations)", MIXED_WORLD, IN_WORLD))
    for text, frame_mixup, stored in variants:
        yield Hypothesis(
            "angular-velocity-in-wrong-frame",
            "frame",
            text,
            lambda program, _, frame_mixup=frame_mixup, stored=stored: program.but(
                frame_mixup=frame_mixup, scheme=program.scheme._replace(stored=stored)
            ),
        )


def _unequal_moments(context: Context) -> Iterator[Hypothesis]:
    program, moments = context.program, context.program.moments
    yield Hypothesis(
        "spherical-inertia",
        "inertia",
        "inertia of a sphere: three equal moments",
        lambda program, _: program.but(moments=np.full(3, program.moments.mean())),
        unlikely=UNUSUAL,
    )
    orders = [order for order in permutations(range(3)) if (moments[list(order)] != moments).any()]
    yield Hypothesis(
        "inertia-axes-permuted",
        "inertia",
        "moments of inertia permuted: x y z have those of {}",
        lambda program, number: program.but(moments=program.moments[list(orders[int(number)])]),
        choice(len(orders)),
        tuple(" ".join("xyz"[axis] for axis in order) for order in orders),
    )
    for axis, name in enumerate("xyz"):
        yield Hypothesis(
            f"wrong-moment-of-inertia-{name}",
            "inertia",
            f"moment of inertia about the body's {name} {{}} times its value",
            lambda program, factor, axis=axis: program.but(moments=program.moments * factor ** np.eye(3)[axis]),
            MOMENTS,
            named_values={0.5: "half", 2.0: "double"},
            neutral=1.0,
        )
    if (edges := context.scene.body.size) is not None:
        own = context.scene.body.mass / 6 * np.square(edges)
        yield Hypothesis(
            "inertia-of-own-edges",
            "inertia",
            "each moment of inertia from the edge along its axis: m/12 (2 s^2) instead of from the two others",
            lambda program, _: program.but(moments=own * (program.moments / moments)),
        )
    for name, text, tensor in (
        (
            "inertia-never-rotated",
            "inertia tensor never rotated with the body: Euler's equations in world axes",
            NEVER_TURNED,
        ),
        ("inertia-frozen-at-start", "inertia tensor in world axes constant from the start on", FROZEN),
        ("inertia-rotated-inversely", "inertia tensor rotated inversely: R^T I R", TURNED_BACK),
    ):
        yield Hypothesis(
            name,
            "inertia axes",
            text,
            lambda program, _, tensor=tensor: program.but(tensor=tensor, inverse_tensor=tensor, impulse_tensor=tensor),
        )
    yield from _gyroscopic_tensors(program)
    if program.impulses:
        for name, text, tensor in (
            ("impulse-inertia-not-rotated", "not rotated with the body", NEVER_TURNED),
            ("impulse-inertia-frozen-at-start", "as at the start", FROZEN),
            ("impulse-inertia-rotated-inversely", "rotated inversely, R^T I R,", TURNED_BACK),
        ):
            yield Hypothesis(
                name,
                "inertia axes",
                f"inertia tensor {text} for an impulse",
                lambda program, _, tensor=tensor: program.but(impulse_tensor=tensor),
            )
    yield Hypothesis(
        "inertia-inverted",
        "inertia",
        "inertia used as its inverse",
        lambda program, _: program.but(moments=1.0 / program.moments),
    )
    yield gyroscopic_term_missing()
    yield Hypothesis(
        "gyroscopic-term-reversed",
        "gyroscopic",
        "gyroscopic term has the wrong sign",
        lambda program, _: program.but(gyroscopic=-1.0),
    )


def _gyroscopic_tensors(program: ProgramModel) -> Iterator[Hypothesis]:
    """Yield other tensors in Euler's equations alone, and different ones in the torque and in what it is divided by."""
    of_both = (
        ("gyroscopic-inertia-not-rotated", "never rotated with the body", NEVER_TURNED),
        ("gyroscopic-inertia-frozen-at-start", "as at the start", FROZEN),
        ("gyroscopic-inertia-rotated-inversely", "rotated inversely, R^T I R,", TURNED_BACK),
    )
    for name, text, tensor in of_both if program.impulses else ():
        yield Hypothesis(
            name,
            "inertia axes",
            f"inertia tensor {text} in the gyroscopic term, w' = -I^-1 (w x I w), but not for an impulse",
            lambda program, _, tensor=tensor: program.but(tensor=tensor, inverse_tensor=tensor),
        )
    for name, text, tensor, inverse in (
        ("momentum-inertia-not-rotated", "L = I w with the tensor in body axes, w in world axes", NEVER_TURNED, TURNED),
        (
            "gyroscopic-torque-divided-in-wrong-axes",
            "gyroscopic torque in world axes divided by the tensor in body axes",
            TURNED,
            NEVER_TURNED,
        ),
        (
            "gyroscopic-rate-in-body-axes",
            "gyroscopic rate I^-1 (L x w) in body axes added to w in world axes",
            TURNED,
            RESPONSE_UNTURNED,
        ),
        (
            "gyroscopic-torque-not-divided",
            "gyroscopic torque not divided by the inertia: w' = -w x L",
            TURNED,
            UNDIVIDED,
        ),
        (
            "gyroscopic-torque-multiplied",
            "gyroscopic torque multiplied by the inertia instead of divided: w' = -I (w x L)",
            TURNED,
            MULTIPLIED,
        ),
    ):
        yield Hypothesis(
            name,
            "inertia axes",
            text,
            lambda program, _, tensor=tensor, inverse=inverse: program.but(tensor=tensor, inverse_tensor=inverse),
        )


def gyroscopic_term_missing() -> Hypothesis:
    """Return that the gyroscopic term is missing."""
    return Hypothesis(
        GYROSCOPIC_TERM_MISSING,
        "gyroscopic",
        "gyroscopic term missing: the angular velocity stays constant",
        lambda program, _: program.but(gyroscopic=0.0),
    )


def _start_spin(program: ProgramModel) -> Iterator[Hypothesis]:
    if (_in_body(program, 0.0).start != program.start).any():
        yield Hypothesis("start-spin-in-body-axes", "spin", "start angular velocity taken in body axes", _in_body)
    for name, text, factor in (
        ("start-spin-read-as-degrees", "start angular velocity in rad/s read as degrees/s", DEGREE),
        (
            "start-spin-converted-to-degrees",
            "start angular velocity converted to degrees/s: 57 times too fast",
            1 / DEGREE,
        ),
    ):
        yield Hypothesis(name, "spin", text, lambda program, _, factor=factor: _spun(program, factor))


def _in_body(program: ProgramModel, _: float) -> ProgramModel:
    start = program.start.copy()
    start[10:13] = rotation_matrix(quaternion_product(start[3:7], program.body.file_axes)) @ start[10:13]
    return program.but(start=start)


def _spun(program: ProgramModel, factor: float) -> ProgramModel:
    start = program.start.copy()
    start[10:13] *= factor
    return program.but(start=start)
