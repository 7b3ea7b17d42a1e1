"""What a scene needs of an engine, read off its numbers."""

import numpy as np

from scenarios.impulse import jump
from scenarios.scene import Scene

# The force laws an engine must be able to express exactly; a file in compare/engines lists those it can.
FORCES = ("gravity", "tether", "drag", "floor")


def needs(scene: Scene) -> tuple[str, ...]:
    """Return what the scene has, in this order: the FORCES, rotation, gyroscopic, later impulses, throws.

    rotation: the body ever turns; gyroscopic: it turns and its moments differ; throws: more than one.
    """
    rotates = _rotates(scene)
    has = {
        "gravity": scene.gravity is not None,
        "tether": bool(scene.tethers),
        "drag": scene.drag is not None,
        "floor": scene.floor is not None,
        "rotation": rotates,
        "gyroscopic": rotates and np.ptp(scene.body.moments) > 0,
        "later impulses": any(impulse.time > 0 for impulse in scene.impulses),
        "throws": len(scene.start) > 1,
    }
    return tuple(need for need, needed in has.items() if needed)


def _rotates(scene: Scene) -> bool:
    """Return whether the body ever turns: it spins at the start, or something off its centre can pull or strike it."""
    if scene.start[:, 10:13].any() or scene.tethers or scene.floor is not None:
        return True
    for impulse in scene.impulses:
        # Where a later blow lands depends on the flight, except on a spot of a body that has not turned.
        if impulse.time > 0 and impulse.point_body is None:
            return True
        if jump(impulse, scene.start, scene.body)[:, 10:13].any():
            return True
    return False
