"""Mistakes of students' programs, planted in the program of `programs.py`: each is named upon a scheme or several."""

from dataclasses import replace

import numpy as np
import pytest
from planted import Spoilt, capped, one, pulled
from programs import Simulation, cross, matrix, multiply, read, write

from tools.heldout import SCENES
from tumble.compare.grade.grade import grade
from tumble.compare.grade.verdicts import EXPLAINED_WHOLLY
from tumble.scenarios.read import read_scene

# Steps too fine to be seen; and those of a short program, four a row.
FINE, FOUR_A_ROW = {"dt": 0.001, "every": 25}, {"dt": 1 / 240, "every": 4}
SYMPLECTIC = FOUR_A_ROW | {"method": "symplectic"}
EULER, RUNGE_KUTTA = "symplectic-euler", "runge-kutta-4"
EYE = np.eye(3)


def after(change):
    """Return a program that changes what a step has left."""
    return {"after": change}


def before(change):
    """Return a program that changes what a step begins with."""

    def euler(self, dt):
        change(self)
        Spoilt.euler(self, dt)

    def rk4(self, dt):
        change(self)
        Spoilt.rk4(self, dt)

    return {"euler": euler, "rk4": rk4}


def height(bounce):
    """Return what keeps the centre's height from becoming negative; bounce: share of the velocity that is left."""

    def change(self):
        if self.x[1] < 0:
            self.x[1], self.v[1] = 0, -bounce * self.v[1]

    return change


def clipped(name, most):
    """Return what limits each component of a velocity."""
    return lambda self: setattr(self, name, np.clip(getattr(self, name), -most, most))


def equations(of_momentum=None, of_torque=None, divided=None):
    """Return Euler's equations with other axes of the tensor in L, and of the one that the torque is divided by."""

    def angular(self, R, w, torque):
        axes, others = R if of_momentum is None else of_momentum, R if of_torque is None else of_torque
        twist = torque - cross(w, axes @ self.inertia @ axes.T @ w)
        return divided(self, R, twist) if divided else others @ self.inverse @ others.T @ twist

    return {"angular": angular}


def hit(change):
    """Return another effect of an impulse on w; change: of the simulation, the impulse and its point in body axes."""

    def struck(self, J, p):
        self.v, self.w = self.v + J / self.mass, self.w + change(self, J, p)

    return {"hit": struck}


def never_normalised():
    """Return a quaternion that is never normalised but for the matrix."""

    def rotate(self, dt, w):
        self.q = self.q + multiply(dt / 2 * np.array([0, *w]), self.q)
        self.R = matrix(self.q / np.sqrt(self.q @ self.q))

    return {"rotate": rotate}


def moved_twice(self, dt):
    """Take a step with x += v dt + a dt^2 and the new v."""
    old = self.v
    Spoilt.euler(self, dt)
    self.x = self.x + dt * (self.v - old)


def sets(self, J, p):
    """Set the velocities by an impulse."""
    self.v, self.w = 0 * self.v, 0 * self.w
    Spoilt.hit(self, J, p)


def turns_back(self, *state):
    """Return the slope of a state whose attitude is rotated the other way."""
    v, q, a, alpha = Simulation.slope(self, *state)
    return v, -q, a, alpha


def in_body(self, x, R, v, w):
    """Return gravity in body axes."""
    return R @ (self.mass * self.gravity), np.zeros(3)


def uncorrected(self, x, R, v, w):
    """Return what makes v rotate with the body."""
    return self.mass * (self.gravity + cross(w, v)), np.zeros(3)


DRY, DRY_SPIN = 0.4, 0.3

# What a program is, how it steps, and the names that it must be given with the first one's value.
CASES = {
    # --- caps and floors
    "cap at the end of a step": (capped("w", 5.3), SYMPLECTIC, {"spin-cap": 5.3, EULER: 1 / 240}),
    "cap at the begin of a step": (
        before(capped("w", 5.3)["after"]),
        SYMPLECTIC,
        {"spin-cap": 5.3, EULER: 1 / 240},
    ),
    "cap of the speed at the end": (capped("v", 6.0), SYMPLECTIC, {"speed-cap": 6.0, EULER: 1 / 240}),
    "cap of each component": (after(clipped("w", 4.0)), SYMPLECTIC, {"spin-cap-of-components": 4.0, EULER: 1 / 240}),
    "cap in a classical step": (capped("w", 5.3), FOUR_A_ROW, {"spin-cap": 5.3, RUNGE_KUTTA: 1 / 240}),
    "floor": (after(height(0.0)), SYMPLECTIC, {"floor-at-zero": None, EULER: 1 / 240}),
    "floor, fine steps": (after(height(0.0)), FINE, {"floor-at-zero": None}),
    "floor after the row": (before(height(0.0)), SYMPLECTIC, {"floor-at-zero": None, EULER: 1 / 240}),
    "height alone": (after(height(-1.0)), FINE, {"floor-at-zero": None}),
    "bounce": (after(height(0.6)), SYMPLECTIC, {"bounce-at-zero": 0.6, EULER: 1 / 240}),
    # --- rotation
    "gyroscopic tensor not rotated": (
        equations(EYE, EYE), SYMPLECTIC, {"gyroscopic-inertia-not-rotated": None, EULER: 1 / 240}
    ),
    "gyroscopic tensor not rotated, fine steps": (equations(EYE, EYE), FINE, {"gyroscopic-inertia-not-rotated": None}),
    "L by the tensor in body axes": (equations(EYE), FINE, {"momentum-inertia-not-rotated": None}),
    "torque over the tensor in body axes": (
        equations(None, EYE), FINE, {"gyroscopic-torque-divided-in-wrong-axes": None}
    ),
    "torque not divided": (
        equations(divided=lambda s, R, twist: twist), FINE, {"gyroscopic-torque-not-divided": None}
    ),
    "torque multiplied": (
        equations(divided=lambda s, R, twist: R @ s.inertia @ R.T @ twist), FINE, {"gyroscopic-torque-multiplied": None}
    ),
    "attitude rotated back": ({"slope": turns_back}, FINE, {"quaternion-rate-reversed": None}),
    "never normalised": (never_normalised(), SYMPLECTIC, {EULER: 1 / 240}),
    # --- impulses
    "impulse of a torque in mixed axes": (
        hit(lambda s, J, p: s.R @ s.inverse @ cross(p, J)), FINE, {"impulse-torque-of-mixed-axes": None}
    ),
    "impulse of a spin in body axes": (
        hit(lambda s, J, p: s.inverse @ s.R.T @ cross(s.R @ p, J)), FINE, {"impulse-spin-in-body-axes": None}
    ),
    "impulse not divided": (hit(lambda s, J, p: cross(s.R @ p, J)), FINE, {"impulse-not-divided-by-inertia": None}),
    "impulse multiplied": (
        hit(lambda s, J, p: s.R @ s.inertia @ s.R.T @ cross(s.R @ p, J)), FINE, {"impulse-multiplied-by-inertia": None}
    ),
    "impulse over the mass": (hit(lambda s, J, p: cross(s.R @ p, J) / s.mass), FINE, {"impulse-divided-by-mass": None}),
    "impulse over the mean moment": (
        hit(lambda s, J, p: 3 * cross(s.R @ p, J) / np.trace(s.inertia)), FINE, {"impulse-of-spherical-inertia": None}
    ),
    "impulse rotated back": (
        {"hit": lambda s, J, p: Spoilt.hit(s, s.R.T @ J, p)}, FINE, {"impulse-rotated-to-body-axes": None}
    ),
    "impulse sets": ({"hit": sets}, FINE, {"impulse-sets-velocity": None}),
    "component of an impulse reversed": (
        one(2, lambda s, J, p: Spoilt.hit(s, J * (-1, 1, 1), p)), FINE, {"impulse-component-reversed": None}
    ),
    # --- forces
    "gravity in body axes": ({"forces": in_body}, FINE, {"gravity-in-body-axes": None}),
    "velocity in body axes": (
        {"forces": uncorrected}, FINE, {"velocity-in-body-axes-without-correction": None}
    ),
    "drag with the wrong sign": (pulled(lambda s, v: 0.2 * v), FINE, {"linear-damping-reversed": 0.2}),
    "dry friction": (pulled(lambda s, v: -DRY * v / np.sqrt(v @ v)), FINE, {"dry-friction": DRY}),
    "cubic drag": (pulled(lambda s, v: -0.004 * (v @ v) * v), FINE, {"cubic-drag": 0.004}),
    "drag by component": (pulled(lambda s, v: -0.05 * np.abs(v) * v), FINE, {"quadratic-drag-by-component": 0.05}),
    "dry friction of the spin": (
        {"angular": lambda s, R, w, torque: Simulation.angular(s, R, w, torque) - DRY_SPIN * w / np.sqrt(w @ w)},
        FINE,
        {"dry-angular-friction": DRY_SPIN},
    ),
    # --- steps
    "x by twice the acceleration": (
        {"euler": moved_twice}, SYMPLECTIC, {"wrong-position-update": None, EULER: 1 / 240}
    ),
    "damping after a step of Runge-Kutta": (
        after(lambda s: setattr(s, "v", 0.998 * s.v)), FOUR_A_ROW, {"linear-damping": 0.48, RUNGE_KUTTA: 1 / 240}
    ),
}  # fmt: skip


def named(tmp_path, rows, throw):
    """Return the mistakes that the file of some rows is explained by: their values by name."""
    file = write(tmp_path / "student.csv", rows, throw.vertices, form="{:.9g}".format)
    found = grade(tmp_path / file, read_scene(str(SCENES["struck"])), {}, search_s=10.0)
    best = found.diagnosis.best.mistakes
    assert found.verdict == EXPLAINED_WHOLLY, [mistake.text for mistake in best]
    return {mistake.hypothesis.name: mistake.value for mistake in best}


@pytest.mark.parametrize("case_name", CASES)
def test_a_mistake_of_a_students_program_is_named(tmp_path, case_name):
    methods, program, expected = CASES[case_name]
    throw = read(SCENES["struck"])
    values = named(tmp_path, type("Student", (Spoilt,), methods)(throw, **program).rows(), throw)
    assert values.keys() == expected.keys()
    for name, value in expected.items():
        assert value is None or values[name] == pytest.approx(value, rel=1e-3)


def test_a_clock_that_is_wrong_but_for_impulses_is_named(tmp_path):
    """A step of 0.96/240 s that is logged as one of 1/240 s: impulses act at their rows."""
    throw, rate = read(SCENES["struck"]), 0.96
    early = replace(throw, impulses=[impulse | {"time": rate * impulse["time"]} for impulse in throw.impulses])
    flight = Spoilt(early, dt=0.001 * rate, every=25).rows()
    values = named(tmp_path, [(t / rate, *rest) for t, *rest in flight], throw)
    assert values == {"clock-rate": pytest.approx(rate)}


@pytest.mark.parametrize("again", [False, True])
def test_impulses_that_are_all_late_or_act_again_are_named(tmp_path, again):
    throw, late = read(SCENES["struck"]), 0.0125
    moved = [impulse | {"time": impulse["time"] + late} for impulse in throw.impulses]
    impulses = sorted([*throw.impulses, *moved] if again else moved, key=lambda impulse: impulse["time"])
    flight = Spoilt(replace(throw, impulses=impulses), dt=0.00125, every=20).rows()
    name = "impulses-repeated" if again else "impulses-late"
    assert named(tmp_path, flight, throw) == {name: pytest.approx(late)}


@pytest.mark.parametrize("stops", [False, True])
def test_a_height_that_is_only_written_as_0_is_told_from_a_floor(tmp_path, stops):
    """An impulse upwards, below height 0, tells them apart: where the height is only written the body begins lower."""
    upwards = "".join(f"\n[[impulse]]\ntime = 1.6\nvalue = [0.0, 20.0, 0.0]\nvertex = {i}\n" for i in (0, 7))
    scene = tmp_path / "hit-upwards.toml"
    scene.write_text(SCENES["struck"].read_text() + upwards)
    throw = read(scene)
    if stops:
        rows = type("Student", (Spoilt,), after(height(0.0)))(throw, **FINE).rows()
    else:
        rows = [(t, np.maximum(x, (-np.inf, 0, -np.inf)), *rest) for t, x, *rest in Spoilt(throw, **FINE).rows()]
    file = write(tmp_path / "student.csv", rows, throw.vertices, form="{:.9g}".format)
    found = grade(tmp_path / file, read_scene(str(scene)), {}, search_s=10.0)
    assert found.verdict == EXPLAINED_WHOLLY
    (best,) = found.diagnosis.best.mistakes
    assert best.hypothesis.name == "floor-at-zero"
    assert ("written as 0" in best.text) is not stops
