"""What must hold of any free flight, on random scenes: the laws do not know where the world's axes point.

Every tolerance is a rounding's, a million times below what the engines' own errors at these steps are.
"""

from dataclasses import replace
from itertools import permutations, product

import numpy as np
from hypothesis import Phase, assume, given, settings
from hypothesis import strategies as st

from tumble.compare.judge.errors import Run
from tumble.compare.run.engines.registry import load
from tumble.compare.run.flight import Trajectory, simulate
from tumble.scenarios.frames import Array, quaternion_product, rotation_matrix
from tumble.scenarios.mass import BOX_FACES, box_corners
from tumble.scenarios.scene import Body, Impulse, Scene, frozen_array
from tumble.scenarios.truth import Truth, truth
from tumble.solver.registry import METHODS

DT = 2.0**-6
TIMES = (0.25, 0.5, 1.0)
STRUCK_AT = 0.375
# Lengths of a few metres, turned, shifted and added up over 64 steps, have roundings of 1e-14; spins of 4 rad/s over
# one second stretch them by no more than e^4.
ROUNDING = 1e-11
# One method of each way of stepping, and both engines in both of theirs; all are of an order that leaves errors.
CONTESTANTS = {
    "tumble": ("rk4", "splitting", "symplectic-euler"),
    "mujoco": ("euler", "rk4", "implicit"),
    "pybullet": ("multibody", "rigidbody"),
}
PAIRS = [(engine, method) for engine, methods in CONTESTANTS.items() for method in methods]
REVERSIBLE = [name for name, method in METHODS.items() if method.reversible and method.least_throws == 1]
KEEPING = [name for name, method in METHODS.items() if method.keeps_momentum and method.least_throws == 1]


def random(examples: int):
    # A failure is shown as it was found: to shrink one would compute hundreds of truths.
    return settings(max_examples=examples, derandomize=True, deadline=None, phases=(Phase.generate,))


def number(low: float, high: float) -> st.SearchStrategy[float]:
    """Numbers of 16 binary places: scenes that a person could have written, and that print short when they fail."""
    return st.integers(round(low * 2**16), round(high * 2**16)).map(lambda whole: whole / 2**16)


def vector(largest: float) -> st.SearchStrategy[Array]:
    return st.tuples(*[number(-largest, largest)] * 3).map(np.array)


def unit(numbers: tuple[float, ...]) -> Array:
    return np.array(numbers) / np.linalg.norm(numbers)


quaternions = st.tuples(*[number(-1, 1)] * 4).filter(lambda q: np.linalg.norm(q) > 0.1).map(unit)
sizes = st.tuples(*[number(0.1, 1.0)] * 3)


def box(size: tuple[float, float, float], mass: float) -> Body:
    squares = np.array(size) ** 2
    moments = mass / 12 * (squares.sum() - squares)
    return Body("box", mass, frozen_array(moments), frozen_array(box_corners(np.array(size))), BOX_FACES)


@st.composite
def scenes(draw, gravity: bool = True, blow: bool = True) -> Scene:
    """A box of any shape, thrown with up to 4 rad/s about each axis, struck once more on the way."""
    body = box(draw(sizes), draw(number(0.5, 4.0)))
    start = np.concatenate([draw(vector(2.0)), draw(quaternions), draw(vector(3.0)), draw(vector(4.0))])
    # A blow that changes the spin by no more than about what it is.
    strength = body.moments.min() / np.abs(body.points).max()
    struck = Impulse(
        STRUCK_AT, frozen_array(strength * draw(vector(1.0))), point_body=body.points[draw(st.integers(0, 7))]
    )
    return Scene(
        "random", "", "", TIMES[-1], frozen_array(TIMES), DT, body, frozen_array(start[None]),
        frozen_array(draw(vector(10.0))) if gravity else None,
        (struck,) if blow else (),
    )  # fmt: skip


def flight(engine: str, scene: Scene, method: str, dt: float = DT) -> Trajectory:
    return simulate(load(engine), scene, method, dt)


def errors(engine: str, scene: Scene, method: str, true: Truth) -> Array:
    """Return the vertex errors at the samples [m], (S, n, 3)."""
    return Run(scene, engine, method, DT, flight(engine, scene, method), true).errors[:, 0]


def turned(scene: Scene, q: Array, shift: Array) -> Scene:
    """Return the same throw in a world that is turned by q, then shifted."""
    axes = rotation_matrix(q)
    x, attitude, v, w = np.split(scene.start[0], (3, 7, 10))
    start = np.concatenate([axes @ x + shift, quaternion_product(q, attitude), axes @ v, axes @ w])
    return replace(
        scene,
        start=frozen_array(start[None]),
        gravity=frozen_array(axes @ scene.gravity),
        impulses=tuple(replace(blow, value=frozen_array(axes @ blow.value)) for blow in scene.impulses),
    )


@random(12)
@given(scene=scenes(), q=quaternions, shift=vector(5.0))
def test_the_worlds_axes_do_not_matter(scene, q, shift):
    other, axes = turned(scene, q, shift), rotation_matrix(q)
    true, true_other = truth(scene), truth(other)
    expected = true.vertices @ axes.T + shift
    assert np.abs(true_other.vertices - expected).max() < ROUNDING
    for engine, method in PAIRS:
        here, there = errors(engine, scene, method, true), errors(engine, other, method, true_other)
        assert np.abs(there - here @ axes.T).max() < ROUNDING, f"{engine}:{method}"
    # It would show: the same throw under a gravity that was not turned with the rest ends elsewhere.
    away = np.linalg.norm(axes @ scene.gravity - scene.gravity)
    if away > 0.1:
        astray = truth(replace(other, gravity=scene.gravity)).vertices[-1] - expected[-1]
        assert np.linalg.norm(astray, axis=-1).min() > away / 2 - ROUNDING


def axis_swaps() -> list[Array]:
    """The 24 ways to name a box's axes that keep them right-handed: columns are the new axes in the old, (3, 3)."""
    swaps = [
        np.eye(3)[:, list(order)] * signs
        for order in permutations(range(3))
        for signs in product((1.0, -1.0), repeat=3)
    ]
    return [swap for swap in swaps if np.linalg.det(swap) > 0]


def quaternion(matrix: Array) -> Array:
    """Return the quaternion of one of these: its numbers are -1, 0 or 1 before it is made a unit."""
    candidates = [unit(numbers) for numbers in product((-1.0, 0.0, 1.0), repeat=4) if any(numbers)]
    return min(candidates, key=lambda q: np.abs(rotation_matrix(q) - matrix).max())


@random(12)
@given(scene=scenes(), swap=st.sampled_from(axis_swaps()))
def test_the_names_of_a_boxs_axes_do_not_matter(scene, swap):
    size = 2 * np.abs(scene.body.points).max(axis=0)
    body = box(tuple(np.abs(swap.T) @ size), scene.body.mass)
    start = scene.start.copy()
    start[0, 3:7] = quaternion_product(start[0, 3:7], quaternion(swap))
    (blow,) = scene.impulses
    blow = replace(blow, point_body=frozen_array(swap.T @ blow.point_body))
    other = replace(scene, body=body, start=frozen_array(start), impulses=(blow,))
    # Vertex k of the box by its new names is vertex same[k] by its old ones.
    same = [int(np.argmin(np.linalg.norm(scene.body.points - swap @ point, axis=1))) for point in body.points]
    assert sorted(same) == list(range(8))
    true, true_other = truth(scene), truth(other)
    assert np.abs(true_other.vertices - true.vertices[:, :, same]).max() < ROUNDING
    for engine, method in PAIRS:
        if method != "splitting":  # it turns about one axis after the other, so that their names are part of the method
            here, there = errors(engine, scene, method, true), errors(engine, other, method, true_other)
            assert np.abs(there - here[:, same]).max() < ROUNDING, f"{engine}:{method}"


@random(12)
@given(scene=scenes(gravity=False, blow=False))
def test_momenta_are_kept(scene):
    true = truth(scene)
    for engine, method in PAIRS:
        _, momentum, _ = Run(scene, engine, method, DT, flight(engine, scene, method), true).drifts
        assert momentum < ROUNDING, f"{engine}:{method}"
    for method in KEEPING:
        _, _, angular = Run(scene, "tumble", method, DT, flight("tumble", scene, method), true).drifts
        assert angular < ROUNDING, method


@random(20)
@given(scene=scenes(blow=False))
def test_a_reversible_flight_comes_back(scene):
    for method in REVERSIBLE:
        there = flight("tumble", scene, method)
        end = there.states[-1].copy()
        end[:, 7:13] *= -1.0
        back = flight("tumble", replace(scene, start=frozen_array(end)), method)
        assert np.abs(back.vertices[-1] - there.vertices[0]).max() < ROUNDING, method


def test_a_method_that_is_not_reversible_does_not_come_back():
    """The negative control: at this step explicit Euler is centimetres away."""
    start = np.array([[0.0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1.0, 3.0, 2.0]])
    scene = Scene("s", "", "", 1.0, frozen_array(TIMES), DT, box((0.4, 0.3, 0.1), 1.0), frozen_array(start))
    there = flight("tumble", scene, "quaternion-euler")
    end = there.states[-1].copy()
    end[:, 7:13] *= -1.0
    back = flight("tumble", replace(scene, start=frozen_array(end)), "quaternion-euler")
    assert np.abs(back.vertices[-1] - there.vertices[0]).max() > 1e-3


@random(15)
@given(scene=scenes())
def test_rk4_at_small_steps_finds_the_truth(scene):
    """By two steps that halve: a fifteenth of their difference is the error of the finer one (Richardson 1911)."""
    coarse, fine = (flight("tumble", scene, "rk4", DT / part).vertices for part in (4, 8))
    left = (coarse - fine) / 15
    size = np.abs(left).max()
    assert np.abs(fine - left - truth(scene).vertices).max() < 0.2 * size + ROUNDING
    assert size < 1e-6, "not a small step any more"


@random(20)
@given(scene=scenes(blow=False), half=st.sampled_from(TIMES[:-1]))
def test_a_flight_in_two_is_the_flight(scene, half):
    row = 1 + TIMES.index(half)
    rest = replace(scene, duration=TIMES[-1] - half, times=frozen_array([TIMES[-1] - half]))
    true = truth(scene)
    again = truth(replace(rest, start=frozen_array(true.states[row])))
    assert np.abs(again.vertices[-1] - true.vertices[-1]).max() < ROUNDING
    for engine, method in [*PAIRS, *(("tumble", method) for method in REVERSIBLE)]:
        whole = flight(engine, scene, method)
        parted = flight(engine, replace(rest, start=frozen_array(whole.states[row])), method)
        assert np.abs(parted.vertices[-1] - whole.vertices[-1]).max() < ROUNDING, f"{engine}:{method}"


@random(10)
@given(scene=scenes())
def test_the_random_scenes_are_not_moot(scene):
    """Else the rest could pass on nothing: the body turns, is struck, and first-order methods are visibly off."""
    assume(np.abs(scene.start[0, 10:13]).max() > 0.5)
    true = truth(scene)
    assert np.linalg.norm(true.states[-1, 0, 10:13] - scene.start[0, 10:13]) > 0
    assert np.abs(errors("mujoco", scene, "euler", true)).max() > 1e-6


def test_there_are_methods_to_try():
    assert {"splitting", "splitting8", "implicit-midpoint", "exact"} <= set(REVERSIBLE)
    assert {"symplectic-euler", "splitting"} <= set(KEEPING)
    assert len(axis_swaps()) == 24
    assert max(np.abs(rotation_matrix(quaternion(swap)) - swap).max() for swap in axis_swaps()) < 1e-15
