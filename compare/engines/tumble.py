"""Our own solver, all its methods."""

from importlib.metadata import version
from typing import Any, NamedTuple

import numpy as np

from tumble.compare.engines.parts.soft_law import SPRING, SoftLaw
from tumble.solver.body import Body
from tumble.solver.collocation.newton import FURTHEST_TURN
from tumble.solver.contact.compliant import softness_of
from tumble.solver.contact.flight import ContactFlight, Plane
from tumble.solver.contact.methods import CONTACT_METHODS
from tumble.solver.flight import Flight
from tumble.solver.forces import LAWS, only_gravity
from tumble.solver.quaternion import to_matrix
from tumble.solver.registry import METHODS as REGISTRY
from tumble.solver.registry import find
from tumble.solver.scene_forces import WITHOUT_STRENGTH, forces_of
from tumble.solver.stiffness import fastest

METHODS = tuple(REGISTRY)
# Of these NAME@TOLERANCE is a method too, e.g. adaptive@1e-9; the plain name means its default.
ADAPTIVE = {name: method.tolerance for name, method in REGISTRY.items() if method.tolerance is not None}
# These take a flight of any length in one step.
FREE_WHOLE = tuple(name for name, method in REGISTRY.items() if method.order is None and method.tolerance is None)
WHOLE = (*FREE_WHOLE, *(name for name, method in CONTACT_METHODS.items() if method.dense))
# These alone know a plane; without one they take part only when asked for, and run the free flight.
CONTACT = tuple(CONTACT_METHODS)
ON_REQUEST = ("auto",)
SHOWN = ("rk4", "exact", "adaptive", "symplectic-euler", "quaternion-euler", "matrix-euler")
# events takes 20 s to compile, and compliant has another law.
LANDING = ("moreau",)
# Every law of the solver, by the name that a scene has it under: the key of one of its kind; and contact's.
FEATURES = {*(law.removesuffix("s") for law in LAWS), "plane"}
# Most take less; what a solver of equations or many stages take.
SLOW_NS = {"magnus6": 90.0, "taylor8": 80.0, "taylor12": 140.0, "splitting8": 800.0, "gauss6": 3500.0, "radau5": 3500.0}
STEP_NS = dict.fromkeys((*METHODS, *ON_REQUEST), 50.0) | SLOW_NS
PACKAGES = ("tumble",)
IMPORTS = ("numba",)
SCHEMES = {
    "rk4": "rk4",
    "symplectic-euler": "semi-implicit-euler",
    "gauss6": "a-stable",
    "radau5": "a-stable",
}
WHOLE_TURN = dict.fromkeys(("gauss6", "radau5"), FURTHEST_TURN)
ORDERS = {name: float(method.order) for name, method in REGISTRY.items() if method.order is not None}
GYROSCOPIC = {name: "keeps-momentum" for name, method in REGISTRY.items() if method.keeps_momentum}
KNOWN_FAILURES = {"holds": {"compliant": "its friction is viscous below v_s, so it creeps: its own law"}}
OPTIONAL = (*(law.removesuffix("s") for law in WITHOUT_STRENGTH), "rotation", "gyroscopic", "translation")
ABOUT = {
    "version": version("tumble"),
    "precision": "double",
    "switched_off": [
        "nothing: forces, rotation and the gyroscopic term of unequal moments are there only where a scene has them",
        "steps of the translation where only gravity acts: it is taken in closed form, which the engines step",
    ],
}

# Specific force is that of the equations of motion in the state, without gravity.
SENSE = "derivatives"

# A die whose squared lengths and angles are off by a tenth is not the scene's body any more.
LARGEST_STRAIN = 0.1


class World(NamedTuple):
    """A flight of a body in a scene, and what `auto` took for it and why."""

    flight: Flight | ContactFlight
    body: Body
    scene: Any
    took: str = ""


def build(scene, method, keep=frozenset()):
    """Return a flight; keep: of OPTIONAL, what is computed although the scene has not got it."""
    a, b, c = scene.body.moments.tolist()
    body = Body(scene.body.mass, (a, b, c))
    if method in CONTACT:
        return World(contact_flight(scene, body, method, keep), body, scene)
    if scene.plane is not None:
        raise NotImplementedError(f"{method} has no plane: of Tumble's methods {', '.join(CONTACT)} do")
    forces = forces_of(scene, keep)
    name, took = choice(body, forces, scene) if method in ON_REQUEST else (method, "")
    if "gyroscopic" in keep and name in FREE_WHOLE:
        raise NotImplementedError(f"{name} is a closed form, not a sum of terms")
    least = find(name).least_throws
    if len(scene.start) < least:
        raise NotImplementedError(f"{name} is for {least} throws or more")
    return World(Flight(body, name, forces, keep), body, scene, took)


def contact_flight(scene, body, method, keep):
    """Return a flight above the scene's plane, or a free one where it has none."""
    others = [law for law in LAWS if law != "gravity" and getattr(scene, law)]
    if others or keep:
        lacking = [*(law.removesuffix("s") for law in others), *(f"way to keep {name}" for name in sorted(keep))]
        raise NotImplementedError(f"{method} has no {' or '.join(lacking)}")
    plane = scene.plane and Plane(
        scene.plane.point,
        scene.plane.normal,
        scene.plane.restitution,
        scene.plane.friction,
        scene.body.points,
        scene.body.radius or 0.0,
        scene.body.disc and (scene.body.disc.radius, scene.body.disc.thickness),
    )
    return ContactFlight(body, method, scene.gravity, plane)


# A step of radau5 takes as long as adaptive's steps do while the fastest mode turns, or decays, by so much.
STIFF = 45.0
# More radians of a flight than that no steps should follow.
ENDLESS = 1e6


def choice(body, forces, scene):
    """Return the method that `auto` takes, and why."""
    if only_gravity(forces):
        return "exact", "took exact: a free flight has a closed form, and nothing is cheaper at any error"
    frequency, decay = fastest(body, forces)
    stiffness = f"w dt = {max(frequency, decay) * scene.step:.3g} in the stiffest mode at the scene's step"
    if decay > 2.0 * frequency and decay * scene.step > STIFF:
        return "radau5", f"took radau5: overdamped with {stiffness}, which it need not follow"
    if frequency * scene.duration > ENDLESS:
        return "gauss6", f"took gauss6: {stiffness}, {frequency * scene.duration:.2g} rad in all: it keeps the energy"
    return "adaptive", f"took adaptive: {stiffness}, which its own steps follow"


def write(world, states):
    """Start from these states, (N, 13), compiled for them: no step is timed that waits for a compiler."""
    world.flight.write(states)
    world.flight.compile()


def advance(world, n, dt):
    """Take n steps of dt [s]."""
    world.flight.advance(n, dt)


def read(world):
    """Return the states, (N, 13)."""
    return world.flight.read()


def sense(world):
    """Return specific force [m/s2] and angular velocity [rad/s] of every sensor in its axes, (N, S, 6)."""
    # Compiled by itself: a scene without sensors does not load it.
    from tumble.solver.sensors import readings

    if world.scene.plane is not None:
        raise NotImplementedError("no method of Tumble has sensors above a plane")
    forces, sensors, body = forces_of(world.scene)._replace(gravity=None), world.scene.sensors, world.body
    points = np.array([sensor.point_body for sensor in sensors])
    axes = np.array([np.swapaxes(to_matrix(sensor.orientation), -1, -2) for sensor in sensors])
    return readings(read(world), body.inverse_moments, body.gyroscopic, forces, points, axes)


def vertices(world, points):
    """Return the points [m], (N, n, 3), of the body as the method has deformed it; None of a method that cannot."""
    return world.flight.vertices(points) if deforms(world.flight) else None


def deforms(flight):
    """Whether the method of a flight may keep a matrix that is no rotation."""
    return not (isinstance(flight, ContactFlight) or flight.method.rigid)


def soft_law(world):
    """Return the spring and damper of `compliant`, and its friction."""
    flight = world.flight
    if not isinstance(flight, ContactFlight) or flight.method is not CONTACT_METHODS["compliant"]:
        return None
    softness = softness_of(flight.ground)
    return SoftLaw(SPRING, softness.stiffness, softness.damping, slow=softness.slow)


def remark(world):
    """Say what `auto` took, or that an impact gained energy; the other methods are what they are called."""
    return world.flight.remark if isinstance(world.flight, ContactFlight) else world.took


@np.errstate(over="ignore", invalid="ignore")
def audit(world):
    """Return what a state does not show: steps not found or beyond the stable one, a matrix that is no rotation."""
    flight, findings = world.flight, []
    if isinstance(flight, ContactFlight):
        return [("other", text) for text in flight.findings]
    if flight.unsolved:
        findings.append(("unsolved", f"Newton did not converge in {flight.unsolved} steps"))
    turn, stable = np.max(np.linalg.norm(flight.read()[:, 10:13], axis=1)) * flight.dt, flight.method.stable_turn
    if stable is not None and turn > stable:
        findings.append(("unstable", f"beyond its stability limit: |w| dt = {turn:.3g} > {stable:.3g}"))
    if not deforms(flight):
        return findings
    matrices = flight.matrices()
    strain = np.max(np.abs(np.swapaxes(matrices, 1, 2) @ matrices - np.eye(3)))
    if strain > LARGEST_STRAIN:
        findings.append(("deformed", f"the matrix is no rotation any more: |R^T R - 1| = {strain:.3g}"))
    return findings
