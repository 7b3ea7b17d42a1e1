"""The laws of compare.engines, put to an engine: what `tumble engines --check` and the tests of engines ask.

Each throws the same triaxial box three times, once near its middle axis, once near its third, once near none: a cube
cannot show a wrong gyroscopic term.  A rounding is one of the engine's precision.
"""

import math
from collections.abc import Callable, Iterable, Iterator
from itertools import pairwise
from types import ModuleType

import numpy as np

from compare.engines import EULER, LAWS
from compare.run.free_body import MISREADINGS, moved, to_world
from compare.run.message import frame
from compare.run.timer import PARTS, prepare
from scenarios.frames import Array, quaternion_product, turned_by
from scenarios.mass import BOX_FACES, box_corners
from scenarios.published import table_4_1
from scenarios.scene import Body, Scene, frozen_array

SIZE = (0.4, 0.15, 0.1)
MASS = 2.4
MOMENTS = MASS / 12 * np.array([0.15**2 + 0.1**2, 0.4**2 + 0.1**2, 0.4**2 + 0.15**2])
GRAVITY = (0.3, -9.81, 0.1)

# Position, attitude (of unit length below), velocity, angular velocity.
THROWS = np.array(
    [
        [0.3, -1.2, 0.7, 0.8, 0.2, -0.4, 0.4, 0.5, 3.0, -1.0, 0.2, 3.1, 0.4],
        [-7.0, 0.0, 0.1, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 2.0, 0.1, 0.2, -2.0],
        [0.0, 40.0, 2.0, -0.1, 0.7, 0.7, -0.1, -3.0, 1.0, 0.3, 1.5, 1.2, 1.0],
    ]
)
THROWS[:, 3:7] /= np.linalg.norm(THROWS[:, 3:7], axis=1, keepdims=True)

# Numbers of which six digits say too little for single precision, too: half a unit of the sixth is left over.
ALL_DIGITS = 1 + np.arange(39).reshape(3, 13) * 0.01371 + 4.9e-6 / np.sqrt(2)
DIGITS = {"double": 17, "single": 9}

# A spin about each principal axis [rad/s], and the step of it [s]; its time is 1 s.
SPINS, SPIN_STEP = np.array([2.3, -1.9, 3.1]), 1 / 256
# A tumbling flight's time [s] and its numbers of steps; an order is read from errors below the largest [rad], where
# higher orders are not seen, and so many times what rounding leaves.
TUMBLE_S, HALVED, LARGEST, CLEAR = 1.0, [2**k for k in range(1, 11)], 0.1, 100.0
# An order is within this of what is stated; an error that falls at all falls as the step.
ORDER_WITHIN, LEAST_ORDER = 0.3, 0.7
# What a method that chooses its own steps is asked to keep to, and how near one comes that takes none.
TOLERANCES, WITHOUT_STEPS = (1e-3, 1e-5, 1e-7), 1e-6
# A mistake explains a motion if it leaves this much of its error.
EXPLAINED = 0.05

# A power of two changes no bit of a ratio.
LIGHTER = 2.0**-20


class Broken(Exception):
    """A law that does not hold; the message says how."""


def scene(
    start: Array = THROWS,
    gravity: tuple[float, float, float] | None = None,
    mass: float = MASS,
    moments: Array | tuple[float, float, float] = tuple(MOMENTS),
) -> Scene:
    """Return a scene with no impulse; its times are those of Table 4.1, for the hand calculation flies no others."""
    times = frozen_array(table_4_1().physics_times)
    body = Body("box", mass, frozen_array(moments), frozen_array(box_corners(np.array(SIZE))), BOX_FACES)
    field = None if gravity is None else frozen_array(gravity)
    return Scene("triaxial", "Triaxial box", "", times[-1], times, 0.001, body, frozen_array(start), field)


def step(engine: ModuleType, world: object, *steps: tuple[int, float]) -> None:
    """Make the steps (n, dt)."""
    for n, dt in steps:
        prepare(engine, world, dt)
        engine.advance(world, n, dt)


def flown(
    engine: ModuleType, method: str, states: Array, *steps: tuple[int, float], gravity=None, weight: float = 1.0
) -> Array:
    """Return the states after the steps (n, dt), in a world of its own; weight: that many times the mass."""
    world = engine.build(scene(states, gravity, weight * MASS, weight * MOMENTS), method)
    engine.write(world, states)
    step(engine, world, *steps)
    return np.array(engine.read(world))


def rounding(engine: ModuleType) -> float:
    """Return the spacing of the engine's numbers at one."""
    return float(np.finfo(np.float32 if engine.ABOUT.get("precision") == "single" else np.float64).eps)


def by_other_roundings(engine: ModuleType, method: str) -> float:
    """Return how far a flight of 50 steps may be off where a term that is nothing rounds another way."""
    plain, _, tolerance = method.partition("@")
    # One's own steps may be other ones.
    adaptive = plain in getattr(engine, "ADAPTIVE", ())
    return 100 * float(tolerance or 1e-9) if adaptive else 450 * rounding(engine)


def with_signs_of(reference: Array, states: Array) -> Array:
    """Return the states with q or -q, which are one attitude, whichever is nearer to the reference's."""
    alike = states.copy()
    alike[:, 3:7] *= np.where(np.sum(states[:, 3:7] * reference[:, 3:7], axis=1, keepdims=True) < 0, -1.0, 1.0)
    return alike


def demand(states: Array, expected: Array, within: Array | float, what: str) -> None:
    """Raise Broken where states are not those expected, to `within`; 0 is bit by bit."""
    if states.shape != expected.shape:
        raise Broken(f"{what}: shape {states.shape}, not {expected.shape}")
    off = np.abs(states - expected)
    wrong = ~(off <= within)
    if wrong.any():
        throw, column = np.unravel_index(int(np.argmax(np.where(np.isnan(off), np.inf, off * wrong))), off.shape)
        part = PARTS[column] if off.shape[1] == len(PARTS) else f"component {column}"
        raise Broken(
            f"{what}: {part} of throw {throw} is {states[throw, column]:.17g}, not {expected[throw, column]:.17g}"
        )


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
    at_once = flown(engine, method, THROWS, (11, 0.1 / 11), (28, 0.003))
    in_parts = flown(engine, method, THROWS, (3, 0.1 / 11), (8, 0.1 / 11), (1, 0.003), (27, 0.003))
    demand(in_parts, at_once, 0.0, "3 + 8 and 1 + 27 steps instead of 11 and 28")


def forgets(engine: ModuleType, method: str) -> None:
    """A flight after write is that of a new world."""
    fresh = flown(engine, method, THROWS, (50, 0.01))
    world = engine.build(scene(), method)
    engine.write(world, THROWS[::-1].copy())
    step(engine, world, (37, 0.07))
    engine.write(world, THROWS)
    step(engine, world, (50, 0.01))
    demand(np.array(engine.read(world)), fresh, 0.0, "after another flight")


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


def spins_steadily(engine: ModuleType, method: str) -> None:
    """A spin about a principal axis goes on, and the attitude turns about it."""
    start = THROWS.copy()
    start[:, 10:13] = to_world(start[:, 3:7], np.diag(SPINS))
    states = flown(engine, method, start, (round(1 / SPIN_STEP), SPIN_STEP))
    half = start[:, 10:13] / 2
    turn = np.hstack((np.cos(np.abs(SPINS) / 2)[:, np.newaxis], np.sinc(SPINS / 2 / np.pi)[:, np.newaxis] * half))
    expected = quaternion_product(turn, start[:, 3:7])
    # A method of order one is off by a step's turn of what it turns, once by its spin and once by its attitude.
    within = 2 * np.abs(SPINS) * SPIN_STEP * np.abs(SPINS) + by_other_roundings(engine, method)
    off = turned_apart(states, expected)
    spun = np.linalg.norm(states[:, 10:13] - start[:, 10:13], axis=1)
    for axis in range(3):
        if not off[axis] <= within[axis]:
            raise Broken(
                f"1 s of {SPINS[axis]:g} rad/s about principal axis {axis} ends {off[axis]:.2g} rad away from where "
                f"that leads{misread(states, start, 1.0)}"
            )
        if not spun[axis] <= within[axis]:
            raise Broken(
                f"{SPINS[axis]:g} rad/s about principal axis {axis} alone have become "
                f"{np.round(states[axis, 10:13], 4).tolist()} rad/s after 1 s, and were "
                f"{np.round(start[axis, 10:13], 4).tolist()}{misread(states, start, 1.0)}"
            )


def turned_apart(states: Array, expected: Array) -> Array:
    """Return by how much attitudes of states and quaternions differ [rad], (N,); inf of what is no attitude."""
    q = states[:, 3:7] / np.linalg.norm(states[:, 3:7], axis=1, keepdims=True)
    angles = np.linalg.norm(turned_by(expected, q), axis=1)
    return np.where(np.isfinite(angles), angles, np.inf)


def misread(states: Array, start: Array, time: float) -> str:
    """Return the mistake that leads where an engine's free bodies are after a time [s], '' where none of them does."""
    right = turned_apart(states, moved(start[:, 3:7], start[:, 10:13], MOMENTS, time)[0]).max()
    for mistake in MISREADINGS:
        led, _ = mistake.moved(start[:, 3:7], start[:, 10:13], MOMENTS, time)
        if turned_apart(states, led).max() < EXPLAINED * right:
            return f": {mistake.words}"
    return ""


def comes_nearer_with_the_step(engine: ModuleType, method: str) -> None:
    """Half the step, smaller error: the motion of a free body, to the order that is stated."""
    plain, _, _ = method.partition("@")
    if getattr(engine, "GYROSCOPIC", {}).get(method) == "none":
        raise NotImplementedError("it states that it leaves the gyroscopic torque out")
    expected, _ = moved(THROWS[:, 3:7], THROWS[:, 10:13], MOMENTS, TUMBLE_S)

    def error(asked: str, n: int) -> tuple[float, Array]:
        states = flown(engine, asked, THROWS, (n, TUMBLE_S / n))
        return float(turned_apart(states, expected).max()), states

    if plain in getattr(engine, "WHOLE", ()):
        demand_near(*error(method, 1), max(WITHOUT_STEPS, CLEAR * rounding(engine)), "in one step")
    elif plain in getattr(engine, "ADAPTIVE", ()):
        off = [error(f"{plain}@{tolerance:g}", 1) for tolerance in TOLERANCES]
        demand_near(*off[-1], max(off[0][0] / 10, CLEAR * TOLERANCES[-1]), f"at a tolerance of {TOLERANCES[-1]:g}")
    else:
        demand_order(lambda n: error(method, n), rounding(engine), stated_order(engine, method))


def demand_near(off: float, states: Array, within: float, how: str) -> None:
    """Raise Broken where a tumbling flight ends further from where it leads than that [rad]."""
    if not off <= within:
        raise Broken(
            f"{how} a tumbling brick is {off:.2g} rad off after {TUMBLE_S:g} s{misread(states, THROWS, TUMBLE_S)}"
        )


def demand_order(error: Callable[[int], tuple[float, Array]], eps: float, stated: float | None) -> None:
    """Raise Broken where errors [rad] of n steps do not fall with the step, or not to the order that is stated."""
    errors, states = [], THROWS
    for n in HALVED:
        off, states = error(n)
        errors.append(off)
        if off < CLEAR * eps * n:
            break
    n = HALVED[len(errors) - 1]
    slopes = [*orders(errors, eps)]
    if not slopes and errors[-1] < CLEAR * eps * n:
        return  # it has hardly an error to fall
    order = slopes[-1] if slopes else 0.0
    if order < LEAST_ORDER:
        raise Broken(
            f"half the step leaves the error of a tumbling brick as it is: {errors[-2]:.2g} rad with {n // 2} steps in "
            f"{TUMBLE_S:g} s, {errors[-1]:.2g} rad with {n}{misread(states, THROWS, TUMBLE_S)}"
        )
    if stated is not None and not abs(order - stated) <= ORDER_WITHIN:
        raise Broken(f"the error of a tumbling brick falls by order {order:.2f}, and {stated:g} is stated")


def orders(errors: list[float], eps: float) -> Iterator[float]:
    """Yield the orders by which errors of halved steps fall, from small errors that are clear of rounding."""
    for (coarse, fine), n in zip(pairwise(errors), HALVED[1:], strict=False):
        if coarse <= LARGEST and fine >= CLEAR * eps * n:
            yield math.log2(coarse / fine)


def stated_order(engine: ModuleType, method: str) -> float | None:
    """Return the order that an engine states of a method, also by its gyroscopic torque, None where it does not."""
    stated = getattr(engine, "ORDERS", {}).get(method)
    return stated if stated is not None else EULER.get(getattr(engine, "GYROSCOPIC", {}).get(method, ""))


def flies_light_as_heavy(engine: ModuleType, method: str) -> None:
    """A millionth of the mass and of the moments is flown the same way: ratios alone matter."""
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
    together = flown(engine, method, THROWS, (100, 0.01))
    for number, start in enumerate(THROWS):
        alone = flown(engine, method, start[np.newaxis].copy(), (100, 0.01))
        demand(together[number : number + 1], alone, 0.0, f"throw {number} beside the others")


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


Law = Callable[[ModuleType, str], None]

ASKED: dict[str, Law] = {
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
}


def laws_for(features: Iterable[str], optional: Iterable[str], exempt: Iterable[str]) -> list[str]:
    """Return the laws that bind an engine with those FEATURES, OPTIONAL and EXEMPT."""
    free = {*exempt, *(() if "gravity" in features else ("gravity",)), *(() if tuple(optional) else ("optional",))}
    return [law for law in LAWS if law not in free]


def law_broken(engine: ModuleType, law: str, method: str) -> str:
    """Return how a law does not hold for a method, '' where it does.  Raises what the engine raises."""
    try:
        ASKED[law](engine, method)
    except Broken as broken:
        return str(broken)
    return ""
