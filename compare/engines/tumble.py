"""Our own solver, all its methods."""

from importlib.metadata import version

import numpy as np

from solver.body import Body
from solver.flight import Flight
from solver.registry import METHODS as REGISTRY
from solver.registry import find

METHODS = tuple(REGISTRY)
# Of these NAME@TOLERANCE is a method too, e.g. adaptive@1e-9; the plain name means its default.
ADAPTIVE = tuple(name for name, method in REGISTRY.items() if method.tolerance is not None)
# These take a flight of any length in one step.
WHOLE = tuple(name for name, method in REGISTRY.items() if method.order is None and method.tolerance is None)
ON_REQUEST = ("auto",)
FEATURES = {"gravity"}
ABOUT = {
    "version": version("tumble"),
    "precision": "double",
    "switched_off": [
        "nothing: gravity, and the gyroscopic term of unequal moments, are there only where a scene has them"
    ],
}

# A die whose squared lengths and angles are off by a tenth is not the scene's body any more.
LARGEST_STRAIN = 0.1


class AutoFlight(Flight):
    """A flight by the method that `auto` takes: all that this engine can fly is free, and that has a closed form."""


def build(scene, method):
    """Return a flight that is compiled already: no step is timed that waits for a compiler."""
    kind, name = (AutoFlight, "exact") if method in ON_REQUEST else (Flight, method)
    least = find(name).least_throws
    if len(scene.start) < least:
        raise NotImplementedError(f"{name} is for {least} throws or more")
    a, b, c = scene.body.moments.tolist()
    flight = kind(Body(scene.body.mass, (a, b, c)), name, scene.gravity)
    flight.advance(0, scene.step)
    return flight


def write(flight, states):
    """Start from these states, (N, 13)."""
    flight.write(states)


def advance(flight, n, dt):
    """Take n steps of dt [s]."""
    flight.advance(n, dt)


def read(flight):
    """Return the states, (N, 13)."""
    return flight.read()


def vertices(flight, points):
    """Return the points [m], (N, n, 3), of the body as the method has deformed it."""
    return flight.vertices(points)


@np.errstate(all="ignore")
def remark(flight):
    """Say what `auto` took; the other methods are what they are called."""
    took = "took exact: a free flight has a closed form, and nothing is cheaper at any error"
    return took if isinstance(flight, AutoFlight) else ""


@np.errstate(over="ignore", invalid="ignore")
def audit(flight):
    """Return what a state does not show: a step beyond the stable one, a matrix that is no rotation any more."""
    findings = []
    turn = np.max(np.linalg.norm(flight.read()[:, 10:13], axis=1)) * flight.dt
    if turn > flight.method.stable_turn:
        findings.append(f"beyond its stability limit: |w| dt = {turn:.3g} > {flight.method.stable_turn:.3g}")
    matrices = flight.matrices()
    strain = np.max(np.abs(np.swapaxes(matrices, 1, 2) @ matrices - np.eye(3)))
    if strain > LARGEST_STRAIN:
        findings.append(f"the matrix is no rotation any more: |R^T R - 1| = {strain:.3g}")
    return findings
