"""Mistakes with gravity, and damping, limits and floors that the scene does not have."""

from collections.abc import Iterator
from itertools import product

import numpy as np

from tumble.compare.grade.hypotheses.engine_schemes import DAMPING_PLACES
from tumble.compare.grade.hypotheses.hypothesis import STEPS, Context, Hypothesis, choice, grid
from tumble.compare.grade.hypotheses.names import (
    FLOOR_AT_ZERO,
    GRAVITY_DELAYED,
    GRAVITY_SIZE,
    PYBULLET_DAMPING,
    SPIN_CAP,
)
from tumble.compare.grade.model.kernel.dynamics import (
    AS_FORCE,
    BEFORE_FORCES,
    CAP_BEFORE,
    CAP_FORCED,
    CAP_MOVED,
    FLOOR_AFTER,
    FLOOR_BEFORE,
)
from tumble.compare.grade.model.program_model import ProgramModel
from tumble.scenarios.scene import Scene

STANDARD = 9.81  # m/s2
SIZES = {9.8: "9.8 m/s2", 9.80665: "9.80665 m/s2", 10.0: "10 m/s2"}
AXES = ("+x", "-x", "+y", "-y", "+z", "-z")
DIRECTIONS = tuple(sign * axis for axis in np.eye(3) for sign in (1.0, -1.0))
# Default rates of engines [1/s].
RATES = {0.01: "", 0.04: "", 0.05: "", 0.1: "", 0.5: "", 1.0: ""}
BULLET = 0.04
# Powers of e by which a body slows down in a run at the largest rate that is fitted, which its first eighth shows; and
# by which it gets faster.
MOST_DAMPED, MOST_GROWN = 40.0, 4.0
# Weight that damping costs beside drag of the scene.
LESS_LIKELY = 8.0
# Weight that damping along one axis alone costs, and a limit of each component.
UNLIKELY = 15.0
# That of a limit, which is rarer than a wrong start or a wrong size: where it holds from the first row to the last, it
# is as good as one of these.
SELDOM = 5.0
# That of other laws of drag than damping in proportion, which is what engines have.
RARER = 2.0
# Coefficients of Dynamics.damping that it sets.
BULLET_KINDS = (0, 1, 2, 3)
# Where a program in steps limits velocities, and a height; the first is what a continuous run does.
CAP_PLACES = {
    CAP_FORCED: "",
    CAP_MOVED: ", after a step has moved the body",
    CAP_BEFORE: ", before the forces of a step",
}
FLOOR_PLACES = {FLOOR_AFTER: "", FLOOR_BEFORE: ", after the row is written"}
# Shares of the velocity that a bounce leaves.
BOUNCES = (0.1, 0.3, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)
# Default limits of engines [rad/s, m/s].
SPIN_CAPS = {7.0: "Unity's", 47.12: "Rapier's and Jolt's at 60 Hz", 100.0: "PhysX's"}
SPEED_CAPS = {100.0: "", 400.0: "", 500.0: "Jolt's"}
# Lowest limit of a speed, over the largest one of a right program.
SLOWEST = 1e-3


def forces(context: Context) -> Iterator[Hypothesis]:
    """Yield mistakes with forces."""
    yield from _gravity(context)
    yield from _damping(context)
    yield from _drag(context)
    yield from _other_drag(context)
    yield from _brakes(context)
    yield from _caps(context)
    yield from _floors(context)


def _gravity(context: Context) -> Iterator[Hypothesis]:
    gravity = context.program.gravity
    size = float(np.linalg.norm(gravity))
    if context.has_centre:
        yield Hypothesis(
            "constant-acceleration",
            "gravity",
            "an acceleration of ({}) m/s2 that the scene does not have",
            lambda program, more: program.but(gravity=program.gravity + np.array(more)),
            ((0.0, 0.0, 0.0),),
            unit="m/s2",
            scale=size or STANDARD,
            vague=True,
        )
    if not size:
        yield Hypothesis(
            "gravity-added",
            "gravity",
            f"gravity of {STANDARD} m/s2 along {{}}, which the scene does not have",
            lambda program, number: program.but(gravity=STANDARD * DIRECTIONS[int(number)]),
            choice(len(AXES)),
            AXES,
        )
        return
    for name, text, factor in (
        ("gravity-missing", "gravity missing", 0.0),
        ("gravity-doubled", "gravity applied twice", 2.0),
        ("gravity-reversed", "gravity reversed", -1.0),
    ):
        yield Hypothesis(name, "gravity", text, lambda program, _, factor=factor: program.but(gravity=factor * gravity))
    others = [number for number, direction in enumerate(DIRECTIONS) if abs(direction @ gravity) < 0.9 * size]
    yield Hypothesis(
        "gravity-along-wrong-axis",
        "gravity",
        "gravity along {}",
        lambda program, number: program.but(gravity=size * DIRECTIONS[others[int(number)]]),
        choice(len(others)),
        tuple(AXES[number] for number in others),
    )
    yield Hypothesis(
        GRAVITY_SIZE,
        "gravity",
        "gravity {} times its value",
        lambda program, factor: program.but(gravity=factor * gravity),
        (*grid(1e-3, 0.25, 6), *grid(0.5, 1.6, 9), 2.5, 5.0, 20.0),
        named_values={other / size: name for other, name in SIZES.items() if other != size},
        neutral=1.0,
    )
    yield Hypothesis(
        "gravity-in-body-axes",
        "gravity",
        "gravity in body axes: it rotates with the body",
        lambda program, _: program.but(gravity_in_body=True),
    )
    yield _gravity_delayed(context)


def _gravity_delayed(context: Context) -> Hypothesis:
    """Return that gravity starts to act with a delay, for example after an engine's first step."""
    longest = 0.5 * context.duration
    named_values = {context.spacing_s: "one row"} | STEPS
    named_values = {instant: name for instant, name in named_values.items() if instant < longest}
    return Hypothesis(
        GRAVITY_DELAYED,
        "gravity start",
        "gravity acts from t = {} s on",
        lambda program, instant: program.but(gravity_from=instant),
        tuple(sorted({*grid(min(0.002, 1e-2 * longest), longest, 9), *named_values})),
        named_values=named_values,
        unit="s",
        at_ticks=True,
    )


def damping_rates(duration: float, most: float = MOST_DAMPED) -> tuple[float, ...]:
    """Return rates [1/s] with which a run of `duration` seconds slows down by up to `most` powers of e."""
    return grid(1e-3 / duration, most / duration, 11)


def is_dragged(scene: Scene, kind: str) -> bool:
    """Return whether the scene has linear or angular drag itself."""
    return scene.drag is not None and bool(getattr(scene.drag, kind, False))


def beside_drag(scene: Scene, kind: str) -> str:
    """Return what the text of damping ends with if the scene has drag of that kind itself."""
    return ", in addition to the scene's drag" if is_dragged(scene, kind) else ""


def _damping(context: Context) -> Iterator[Hypothesis]:
    """Yield damping as a force; `scheme_hypotheses` has it at other places of a step.

    As a force it may be the same as another coefficient of the scene's drag, which is likelier.
    """
    for kind, what, place in (("linear", "velocity", 0), ("angular", "angular velocity", 2)):
        yield Hypothesis(
            f"{kind}-damping",
            f"{kind} damping",
            f"{kind} damping: {what} decays at {{}} /s{beside_drag(context.scene, kind)}",
            lambda program, rate, place=place: damped(program, {place: rate}, AS_FORCE),
            damping_rates(context.duration),
            named_values=RATES,
            unit="1/s",
            neutral=0.0,
            unlikely=LESS_LIKELY if is_dragged(context.scene, kind) else 0.0,
        )
        if is_dragged(context.scene, kind):
            continue  # less drag
        yield Hypothesis(
            f"{kind}-damping-reversed",
            f"{kind} damping",
            f"{kind} damping with the wrong sign: {what} grows at {{}} /s",
            lambda program, rate, place=place: damped(program, {place: -rate}, AS_FORCE),
            damping_rates(context.duration, MOST_GROWN),
            named_values=RATES,
            unit="1/s",
            neutral=0.0,
        )
    yield Hypothesis(
        PYBULLET_DAMPING,
        "linear damping",
        f"PyBullet's default damping: a = -{BULLET} (1 + |v|) v, and the same for w",
        lambda program, _: damped(program, dict.fromkeys(BULLET_KINDS, BULLET), AS_FORCE),
    )


def damped(program: ProgramModel, rates: dict[int, float], damping_place: int) -> ProgramModel:
    """Return the program with some coefficients of `Dynamics.damping`, applied at a place of the step."""
    d0, d1, d2, d3, d4 = (rates.get(place, rate) for place, rate in enumerate(program.damping))
    return program.but(damping=(d0, d1, d2, d3, d4), damping_place=damping_place)


def _drag(context: Context) -> Iterator[Hypothesis]:
    """Yield drag with the square of a speed, and a drag torque that is divided by the inertia."""
    rates, moment = grid(1e-3 / context.duration, 10 / context.duration, 11), float(context.program.moments.mean())
    for name, part, text, place, unit, scale in (
        ("quadratic-drag", "linear damping", "quadratic drag: a = -{} /m |v| v", 1, "1/m", 1.0),
        ("quadratic-angular-drag", "angular damping", "quadratic angular drag: alpha = -{} |w| w", 3, "1", 1.0),
        ("drag-torque", "angular damping", "drag torque of -{} N m s times w", 4, "N m s", moment),
    ):
        is_equal = float(np.ptp(context.program.moments)) == 0
        if name == "drag-torque" and (is_equal or is_dragged(context.scene, "angular")):
            continue  # of equal moments it is angular damping, and beside the scene's angular drag more of it
        yield Hypothesis(
            name,
            part,
            text,
            lambda program, rate, place=place: damped(program, {place: rate}, program.damping_place),
            tuple(scale * rate for rate in rates),
            unit=unit,
            neutral=0.0,
            unlikely=RARER,
        )


def _other_drag(context: Context) -> Iterator[Hypothesis]:
    """Yield drag by another power of the speed, or of each component by itself."""
    fast, fast_spin = (float(speeds.max()) for speeds in context.speeds)
    rates = np.array(grid(1e-3 / context.duration, 4 / context.duration, 9))
    for number, (name, part, text, unit, size) in enumerate(
        (
            ("dry-friction", "linear damping", "dry friction: a = -{} m/s2 v/|v|", "m/s2", fast),
            ("cubic-drag", "linear damping", "cubic drag: a = -{} s/m2 |v|^2 v", "s/m2", fast and 1 / fast**2),
            (
                "quadratic-drag-by-component",
                "linear damping",
                "quadratic drag of each component by itself: ax = -{} /m |vx| vx, and so for y and z",
                "1/m",
                fast and 1 / fast,
            ),
            ("dry-angular-friction", "angular damping", "dry friction: alpha = -{} rad/s2 w/|w|", "rad/s2", fast_spin),
        )
    ):
        # Friction is often a function that is called in each step.
        for place, where in DAMPING_PLACES.items() if size else ():
            if place == AS_FORCE or (place != BEFORE_FORCES and name.startswith("dry")):
                yield Hypothesis(
                    name,
                    part,
                    text if place == AS_FORCE else f"{text}, {where}",
                    lambda program, rate, number=number, place=place: _dragged(program, number, rate, place),
                    tuple((size * rates).tolist()),
                    unit=unit,
                    neutral=0.0,
                    details=() if place == AS_FORCE else (("damping-place", where),),
                    unlikely=RARER,
                    needs_steps=place != AS_FORCE,
                )


def _dragged(program: ProgramModel, number: int, rate: float, place: int) -> ProgramModel:
    c0, c1, c2, c3 = (rate if other == number else old for other, old in enumerate(program.drag))
    return program.but(drag=(c0, c1, c2, c3), damping_place=place if place != AS_FORCE else program.damping_place)


def _brakes(context: Context) -> Iterator[Hypothesis]:
    """Yield damping along one axis only."""
    rates = damping_rates(context.duration)
    for kind, what, axes in (
        (0, "linear-damping-along-{}", "velocity along {} decays at {{}} /s"),
        (1, "angular-damping-about-body-{}", "angular velocity about the body's {} decays at {{}} /s"),
        (2, "angular-damping-about-world-{}", "angular velocity about the world's {} decays at {{}} /s"),
    ):
        for number, axis in enumerate("xyz"):
            yield Hypothesis(
                what.format(axis),
                what.format(axis),
                axes.format(axis),
                lambda program, rate, kind=kind, number=number: _braked(program, kind, number, rate),
                rates,
                named_values=RATES,
                unit="1/s",
                neutral=0.0,
                unlikely=UNLIKELY,
                vague=True,
            )


def _braked(program: ProgramModel, kind: int, axis: int, rate: float) -> ProgramModel:
    axis_damping = [list(brake) for brake in program.axis_damping]
    axis_damping[kind][axis] = rate
    of_v, of_body, of_world = ((x, y, z) for x, y, z in axis_damping)
    return program.but(axis_damping=(of_v, of_body, of_world))


def _caps(context: Context) -> Iterator[Hypothesis]:
    """Yield limits of the speeds that are reached, of their size or of each component.

    A program in steps limits them after the forces, before these, or after it has moved the body.
    """
    for (name, what, place, named_values), (each, of, field) in product(
        (
            (SPIN_CAP, "angular velocity", 1, SPIN_CAPS),
            ("speed-cap", "velocity", 0, SPEED_CAPS),
        ),
        (("", "", "caps"), ("-of-components", "each component of the ", "component_caps")),
    ):
        fastest = float(context.speeds[place].max())
        for cap_place, where in CAP_PLACES.items() if fastest > 0 else ():
            yield Hypothesis(
                name + each,
                name.replace("-", " "),
                f"{of}{what} limited to {{}} {'rad/s' if place else 'm/s'}{where}",
                lambda program, cap, place=place, field=field, cap_place=cap_place: program.but(
                    **{field: _with_cap(getattr(program, field), place, cap)}, cap_place=cap_place
                ),
                tuple(np.geomspace(SLOWEST, 1.0, 24) * fastest),
                named_values={cap: name for cap, name in named_values.items() if cap < fastest},
                unit="rad/s" if place else "m/s",
                unlikely=UNLIKELY if each else SELDOM,
                needs_steps=bool(where),
                limits=("spin" if place else "velocity") + (" component" if each else ""),
            )


def _with_cap(caps: tuple[float, float], place: int, cap: float) -> tuple[float, float]:
    return (caps[0], cap) if place else (cap, caps[1])


def _floors(context: Context) -> Iterator[Hypothesis]:
    """Yield that the centre is at no negative height, if it would be."""
    if (up := context.up_from_below) is None:
        return
    for floor_place, where in FLOOR_PLACES.items():
        for name, text, shares in (
            (FLOOR_AT_ZERO, "the centre stopped by a floor at height 0, which the scene does not have", ()),
            ("bounce-at-zero", "the centre bounces at height 0: {} times the velocity, reversed", BOUNCES),
        ):
            yield Hypothesis(
                name,
                "floor at zero",
                text + where,
                lambda program, share, floor_place=floor_place: program.but(
                    up=tuple(up.tolist()), bounce=share, floor_place=floor_place
                ),
                shares,
                unit="1" if shares else "",
                needs_steps=bool(where),
            )
