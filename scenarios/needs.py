"""What a scene needs of an engine, read off its numbers: what it has not got, nobody need pay for.

Where the numbers do not settle a question, because only a flight can tell, the answer is that the scene needs it.
"""

from weakref import WeakKeyDictionary

import numpy as np

from tumble.scenarios.forces import LAWS, acting, can_turn
from tumble.scenarios.frames import Array
from tumble.scenarios.impulse import RayMissed, jump
from tumble.scenarios.scene import Body, Impulse, Scene

# The force laws an engine must be able to express exactly; a file in compare/engines lists those it can.
FORCES = tuple(law.name for law in LAWS)
# Of scenes that there are, which never change.
_known: WeakKeyDictionary[Scene, tuple[str, ...]] = WeakKeyDictionary()


def needs(scene: Scene) -> tuple[str, ...]:
    """Return the features that an engine needs to simulate a scene.

    Parameters
    ----------
    scene

    Returns
    -------
    features
        in this order: the FORCES; rotation, if the body ever rotates; gyroscopic, if it ever rotates about an axis
        that is not principal, or may; later impulses; throws, if there is more than one
    """
    found = _known.get(scene)
    if found is None:
        found = _known[scene] = _needs(scene)
    return found


def _needs(scene: Scene) -> tuple[str, ...]:
    with np.errstate(all="ignore"):  # what overflows is not zero, and so it is needed
        spins = _spins(scene)
        precesses = bool(np.ptp(scene.body.moments)) if spins is None else _precesses(spins, scene.body)
    acts = acting(scene)
    has = {
        **{law.name: law in acts for law in LAWS},
        "rotation": spins is None or bool(spins[:, 10:13].any()),
        "gyroscopic": precesses,
        "later impulses": any(impulse.time > 0 for impulse in scene.impulses),
        "throws": len(scene.start) > 1,
    }
    return tuple(need for need, needed in has.items() if needed)


def _spins(scene: Scene) -> Array | None:
    """Return states with every spin about its body's axes that the flight has, (N, 13), or None where it must tell.

    Angular drag and blows at the centre leave a spin about the axis it has; a body that does not spin has at every
    blow the attitude of the start, and where it is then is known as long as only gravity pulls.
    """
    if can_turn(scene):
        return None
    states, now = scene.start, 0.0
    for impulse in scene.impulses:
        if impulse.time > now:
            states, now = _fallen(states, impulse.time - now, scene.gravity), impulse.time
            followed = impulse.point_body is not None or scene.is_free
            if not _at_centre(impulse) and (states[:, 10:13].any() or not followed):
                return None
        try:
            states = jump(impulse, states, scene.body)
        except RayMissed:
            return None
    return states


def _at_centre(impulse: Impulse) -> bool:
    return impulse.point_body is not None and not impulse.point_body.any()


def _fallen(states: Array, t: float, gravity: Array | None) -> Array:
    """Return the states t [s] later, (N, 13), of bodies that do not spin and that nothing but gravity pulls at."""
    pull = np.zeros(3) if gravity is None else gravity
    fallen = states.copy()
    fallen[:, 0:3] += t * states[:, 7:10] + t * t / 2 * pull
    fallen[:, 7:10] += t * pull
    return fallen


def _precesses(states: Array, body: Body) -> bool:
    """Return whether any of the angular velocities is off the principal axes, where L x w is not zero."""
    w_body = _in_body_axes(states[:, 3:7], states[:, 10:13]) != 0
    differ = np.roll(body.moments, -1) != np.roll(body.moments, -2)
    # (L x w)_1 = (B - C) w2 w3, and so on round; as yes and no, for a small product may vanish.
    return bool((differ & np.roll(w_body, -1, axis=1) & np.roll(w_body, -2, axis=1)).any())


def _in_body_axes(q: Array, w_world: Array) -> Array:
    """Return R^T w, (N, 3), times |q|^2, so that nothing is rounded where the quaternion stands along its axes."""
    scalar, axis = q[:, :1], q[:, 1:]
    along = np.einsum("ij,ij->i", axis, w_world)[:, None]
    length = np.einsum("ij,ij->i", axis, axis)[:, None]
    return (scalar * scalar - length) * w_world + 2 * along * axis - 2 * scalar * np.cross(axis, w_world)
