"""What to check in a scene whose reference solution ends early: causes of unpredictable motion."""

from collections.abc import Iterator

import numpy as np

from tumble.scenarios.frames import vertices
from tumble.scenarios.scene import Scene

# A tether that starts stretched by more than this share of the body is suspicious.
STRETCHED = 0.1
# Radians of the stiffest spring over the run beyond which the last digits of the inputs are likely lost.
MANY_RADIANS = 1e5


def hints(scene: Scene) -> Iterator[str]:
    """Yield questions about a scene whose motion is unpredictable.

    Parameters
    ----------
    scene : the scene

    Returns
    -------
    one sentence for each, the likeliest mistake first
    """
    size = scene.body.reach
    for number, tether in enumerate(scene.tethers):
        point = vertices(scene.start[:1], tether.point_body[None])[0, 0]
        stretch = float(np.linalg.norm(point - tether.anchor)) - tether.rest_length
        if abs(stretch) > STRETCHED * size:
            how = "stretched" if stretch > 0 else "compressed"
            question = "is a rest_length missing?" if not tether.rest_length else "is its rest_length correct?"
            yield f"tether {number} starts {how} by {abs(stretch):.3g} m: {question}"
        turns = float(np.sqrt(tether.stiffness / scene.body.mass)) * scene.duration
        if turns > MANY_RADIANS:
            yield (
                f"tether {number} swings through {turns:.1g} radians in {scene.duration:g} s: are its stiffness of "
                f"{tether.stiffness:g} N/m and the duration correct?"
            )
    if scene.floor is not None:
        heights = vertices(scene.start[:1], scene.body.points)[0] @ scene.floor.normal - scene.floor.height
        if heights.min() < -STRETCHED * size:
            yield f"the body starts {-heights.min():.3g} m deep in the floor: is its height correct?"
        elif scene.gravity is not None:
            yield "a body bouncing on its vertices soon becomes chaotic: is a shorter duration enough?"
