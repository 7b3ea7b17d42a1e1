"""The checks of the engine contract: what `tumble engines --check` and the tests of engines run."""

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from types import ModuleType

import numpy as np

from tumble.compare.engines import CHECKS, CONTACT_CHECKS
from tumble.compare.run.contestant import MethodName
from tumble.compare.run.engines.brick import (
    GRAVITY,
    LANDING,
    THROWS,
    Broken,
    by_other_roundings,
    demand,
    flown,
    flown_in,
    over_plane,
    rounding,
    scene,
    step,
    with_signs_of,
)
from tumble.compare.run.engines.contact_checks import (
    adds_no_energy,
    has_no_direction,
    holds_below_the_critical_angle,
    keeps_mirror_images,
    rebounds_by_the_pairs_restitution,
    slides_by_the_pairs_friction,
    stays_above,
)
from tumble.compare.run.engines.motion_checks import comes_nearer_with_the_step, spins_steadily
from tumble.compare.run.engines.registry import EngineInfo
from tumble.compare.run.engines.sensor_checks import reads_what_a_body_feels
from tumble.compare.run.process.message import frame
from tumble.scenarios.scene import Scene, frozen_array

# Numbers of which six digits say too little for single precision, too: half a unit of the sixth is left over.
ALL_DIGITS = 1 + np.arange(39).reshape(3, 13) * 0.01371 + 4.9e-6 / np.sqrt(2)
DIGITS = {"double": 17, "single": 9}

# A power of two changes no bit of a ratio.
LIGHTER = 2.0**-20


def reads_what_was_written(engine: ModuleType, method: str) -> None:
    """read(write(s)) = s."""
    states = with_signs_of(THROWS, flown(engine, method, THROWS))
    # Turning w into body axes and back, or normalising q, costs a few roundings of numbers up to 40.
    eps = rounding(engine)
    demand(states, THROWS, 16 * eps + 8 * eps * np.abs(THROWS), "read after write")


def digits_are_all_there(engine: ModuleType, method: str) -> None:
    """Numbers with all their digits are read as they were written."""
    start = ALL_DIGITS.copy()
    start[:, 3:7] /= np.linalg.norm(start[:, 3:7], axis=1, keepdims=True)
    states = with_signs_of(start, flown(engine, method, start))
    eps = rounding(engine)
    needed = DIGITS["single" if eps > 1e-10 else "double"]
    found = min(needed, *(same_digits(a, b) for a, b in zip(states.flat, start.flat, strict=True)))
    demand(
        states, start, 16 * eps + 8 * eps * np.abs(start), f"{found} digits of a number came back, {needed} are needed"
    )


def same_digits(a: float, b: float) -> int:
    """Return to how many significant digits a number b has become a."""
    if not math.isfinite(a) or a == b:
        return 17 if a == b else 0
    return max(0, math.floor(math.floor(math.log10(abs(b))) + 1 - math.log10(2 * abs(a - b))))


def steps_add_up(engine: ModuleType, method: str) -> None:
    """advance(a) then advance(b) = advance(a + b)."""
    for question, where in settings(engine, method):
        at_once = flown_in(engine, method, question, (11, 0.1 / 11), (28, 0.003))
        in_parts = flown_in(engine, method, question, (3, 0.1 / 11), (8, 0.1 / 11), (1, 0.003), (27, 0.003))
        demand(in_parts, at_once, 0.0, f"3 + 8 and 1 + 27 steps instead of 11 and 28{where}")


def settings(engine: ModuleType, method: str) -> list[tuple[Scene, str]]:
    """Return the free brick and, for a method that has planes, the brick that comes down on one, each with words."""
    over = over_plane(LANDING)
    try:
        if "plane" in getattr(engine, "FEATURES", ()):
            engine.build(over, method)
            return [(scene(), ""), (over, ", on a plane")]
    except NotImplementedError:
        pass
    return [(scene(), "")]


def forgets(engine: ModuleType, method: str) -> None:
    """A flight after write is that of a new world."""
    for question, where in settings(engine, method):
        fresh = flown_in(engine, method, question, (50, 0.01))
        world = engine.build(question, method)
        if question.plane is None:
            engine.write(world, question.start[::-1].copy())
            step(engine, world, (37, 0.07))
        else:  # what is kept of a contact is kept near its place
            engine.write(world, question.start.copy())
            step(engine, world, (7, 0.01))
        engine.write(world, question.start.copy())
        step(engine, world, (50, 0.01))
        demand(np.array(engine.read(world)), fresh, 0.0, f"after another flight{where}")


def goes_straight(engine: ModuleType, method: str) -> None:
    """With no force and no spin x + v t."""
    start = THROWS.copy()
    start[:, 10:13] = 0.0
    states = flown(engine, method, start, (150, 0.01), (50, 0.02))
    expected = start.copy()
    expected[:, 0:3] += 2.5 * start[:, 7:10]
    # One rounding a step of the largest number in hand.  It leaves room for MuJoCo's angular velocity too, where the
    # rounding of v x m v over the moment of inertia makes 2e-13 rad/s of nothing.
    within = 200 * rounding(engine) * float(np.abs(expected).max())
    demand(with_signs_of(start, states), expected, within, "after 2.5 s with no force and no spin")


def falls_by_gravity(engine: ModuleType, method: str) -> None:
    """With gravity v + g t, and x to the order of the method."""
    states = flown(engine, method, THROWS, (100, 0.01), gravity=GRAVITY)
    pull = np.broadcast_to(GRAVITY, (3, 3))
    eps = rounding(engine)
    fallen = THROWS[:, 0:3] + THROWS[:, 7:10] + pull / 2
    # One rounding a step of the largest number in hand: who keeps velocities about the origin has w x there too.
    within = 100 * eps * float(np.abs(fallen).max())
    demand(states[:, 7:10], THROWS[:, 7:10] + pull, within, "v after 1 s of gravity")
    # A method of order one is off by g t dt / 2, and so is x by 1 % of what gravity gives.
    demand(states[:, 0:3], fallen, 0.0101 * abs(pull) / 2 + within, "x after 1 s of gravity")


def flies_light_as_heavy(engine: ModuleType, method: str) -> None:
    """A body of a millionth of the mass and of the moments moves the same way: only ratios matter."""
    heavy, light = (flown(engine, method, THROWS, (50, 0.01), weight=weight) for weight in (1.0, LIGHTER))
    demand(light, heavy, by_other_roundings(engine, method), "with a millionth of the mass")


def leaves_the_scene_alone(engine: ModuleType, method: str) -> None:
    """The scene is not altered."""
    question = scene()
    before = spelled(question)
    world = engine.build(question, method)
    engine.write(world, question.start)
    step(engine, world, (5, 0.01))
    engine.read(world)
    if spelled(question) != before:
        raise Broken("the scene is another after a flight")


def spelled(question: Scene) -> bytes:
    """Return all that a scene says, every bit of it."""
    return b"".join(frame(question))


def throws_are_apart(engine: ModuleType, method: str) -> None:
    """A throw flies as it would alone."""
    for question, where in settings(engine, method):
        together = flown_in(engine, method, question, (100, 0.01))
        for number, start in enumerate(question.start):
            alone = flown_in(engine, method, replace(question, start=frozen_array([start])), (100, 0.01))
            demand(together[number : number + 1], alone, 0.0, f"throw {number} beside the others{where}")


def optional_is_optional(engine: ModuleType, method: str) -> None:
    """What OPTIONAL keeps changes no motion."""
    bare = flown(engine, method, THROWS, (50, 0.01))
    off = by_other_roundings(engine, method)
    for keep in [*((name,) for name in engine.OPTIONAL), engine.OPTIONAL]:
        try:
            world = engine.build(scene(), method, keep)
        except NotImplementedError:
            continue
        engine.write(world, THROWS)
        step(engine, world, (50, 0.01))
        demand(np.array(engine.read(world)), bare, off, f"with {', '.join(keep)}")


class KnownFailure(NotImplementedError):
    """A check that a method fails as its engine states."""


Check = Callable[[ModuleType, str], None]

FUNCTIONS: dict[str, Check] = {
    "read after write": reads_what_was_written,
    "digits": digits_are_all_there,
    "steps add up": steps_add_up,
    "write forgets": forgets,
    "throws are apart": throws_are_apart,
    "straight": goes_straight,
    "gravity": falls_by_gravity,
    "turns": spins_steadily,
    "converges": comes_nearer_with_the_step,
    "light": flies_light_as_heavy,
    "the scene": leaves_the_scene_alone,
    "optional": optional_is_optional,
    "sensors": reads_what_a_body_feels,
    "friction": slides_by_the_pairs_friction,
    "restitution": rebounds_by_the_pairs_restitution,
    "stays above": stays_above,
    "adds no energy": adds_no_energy,
    "holds": holds_below_the_critical_angle,
    "any direction": has_no_direction,
    "mirror images": keeps_mirror_images,
}


def checks_for(info: EngineInfo) -> list[str]:
    """Return the checks that apply to an engine."""
    lacks = {"gravity": "gravity" not in info.features, "optional": not info.optional, "sensors": not info.senses}
    without = {*info.exempt, *(check for check, lacking in lacks.items() if lacking)}
    has_contact = {"gravity", "plane"} <= info.features
    return [check for check in (*CHECKS, *(CONTACT_CHECKS if has_contact else ())) if check not in without]


def check_failure(engine: ModuleType, check: str, method: str) -> str:
    """Return why a check fails for a method, '' if it passes.

    Raises KnownFailure where the engine states that it fails it, and what the engine raises.
    """
    known = known_failure(getattr(engine, "KNOWN_FAILURES", {}), check, method)
    try:
        FUNCTIONS[check](engine, method)
    except Broken as broken:
        if known:
            raise KnownFailure(f"{known}: {broken}") from None
        return str(broken)
    return f"it passes, and is stated to fail: {known}" if known else ""


def known_failure(stated: Mapping[str, Mapping[str, str]], check: str, method: str) -> str:
    """Return why a method is stated to fail a check, '' where it is not."""
    of_methods = stated.get(check, {})
    return of_methods.get(str(MethodName.parse(method).without_tolerance), of_methods.get("*", ""))
