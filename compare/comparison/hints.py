"""What in a scene to look at where its truth is lost: what makes a motion that no program can follow."""

from collections.abc import Iterator

import numpy as np

from tumble.scenarios.frames import vertices
from tumble.scenarios.scene import Scene

# A tether that starts stretched by more than this share of the body pulls hard from the first instant on.
STRETCHED = 0.1
# Radians of the stiffest spring in the flight beyond which the last digits of the inputs are likely lost.
MANY_RADIANS = 1e5


def hints(scene: Scene) -> Iterator[str]:
    """Yield questions about the scene, the likeliest mistake first."""
    size = scene.body.reach
    for number, tether in enumerate(scene.tethers):
        point = vertices(scene.start[:1], tether.point_body[None])[0, 0]
        stretch = float(np.linalg.norm(point - tether.anchor)) - tether.rest_length
        if abs(stretch) > STRETCHED * size:
            how = "stretched" if stretch > 0 else "compressed"
            question = "is a rest_length missing?" if not tether.rest_length else "is its rest_length meant?"
            yield f"tether {number} starts {how} by {abs(stretch):.3g} m: {question}"
        turns = float(np.sqrt(tether.stiffness / scene.body.mass)) * scene.duration
        if turns > MANY_RADIANS:
            yield (
                f"tether {number} swings through {turns:.1g} radians in {scene.duration:g} s: are its stiffness of "
                f"{tether.stiffness:g} N/m and the duration meant?"
            )
    if scene.floor is not None:
        heights = vertices(scene.start[:1], scene.body.points)[0] @ scene.floor.normal - scene.floor.height
        if heights.min() < -STRETCHED * size:
            yield f"the body starts {-heights.min():.3g} m deep in the floor: is its height meant?"
        elif scene.gravity is not None:
            yield "a body that bounces on its corners is soon chaotic: is a shorter duration enough?"
