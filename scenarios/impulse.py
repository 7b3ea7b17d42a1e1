"""An impulse is a jump of the state: v += J/m, w += I^-1 ((r - x) x J), and nothing else changes."""

import numpy as np

from tumble.scenarios.frames import Array, rotation_matrix
from tumble.scenarios.ray import first_hit, first_on_disc, first_on_sphere
from tumble.scenarios.refusal import UserError
from tumble.scenarios.scene import Body, Impulse


class RayMissed(UserError):
    """The ray of an impulse does not meet the body's surface from outside."""


def strike_point(impulse: Impulse, state: Array, body: Body) -> Array:
    """Return the point at which an impulse acts.

    Parameters
    ----------
    impulse
    state : (13,)
        of one throw
    body

    Returns
    -------
    point : (3,), m
        world axes

    Raises
    ------
    RayMissed
        The impulse's ray does not hit the body from outside.
    """
    if impulse.point_world is not None:
        return impulse.point_world
    axes = rotation_matrix(state[3:7])
    if impulse.point_body is not None:
        return state[0:3] + axes @ impulse.point_body
    assert impulse.ray is not None
    # The ray is carried into body axes, where the surface stands still.
    origin = axes.T @ (impulse.ray.origin - state[0:3])
    direction = axes.T @ impulse.ray.direction
    if body.radius is not None:
        hit = first_on_sphere(origin, direction, body.radius)
    elif body.disc is not None:
        hit = first_on_disc(origin, direction, body.disc.radius, body.disc.thickness)
    else:
        found = first_hit(origin, direction, body.points, body.faces)
        hit = None if found is None else (found.distance, found.from_inside)
    if hit is None:
        raise RayMissed("the ray misses the body")
    distance, from_inside = hit
    if from_inside:
        raise RayMissed("the ray starts inside the body")
    return impulse.ray.origin + distance * impulse.ray.direction


def jump(impulse: Impulse, states: Array, body: Body) -> Array:
    """Return the states just after an impulse.

    Parameters
    ----------
    impulse
    states : (N, 13)
        just before it
    body

    Returns
    -------
    states : (N, 13)

    Raises
    ------
    RayMissed
        The impulse's ray does not hit the body from outside.

    Notes
    -----
    Source: CE1051A report, section 3.1; Goldstein, "Classical Mechanics" (1980), section 1-2.
    """
    after = states.copy()
    for state in after:
        lever = strike_point(impulse, state, body) - state[0:3]
        axes = rotation_matrix(state[3:7])
        state[7:10] += impulse.value / body.mass
        state[10:13] += axes @ ((axes.T @ np.cross(lever, impulse.value)) / body.moments)
    return after
