"""For engines without a scene's force laws: the force is told once a step and held over it, as scripts do."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tumble.scenarios.scene import Scene
    from tumble.scenarios.wrench import Wrench


def held_wrench(scene: "Scene", method: str) -> "Wrench | None":
    """Return what gives the wrench of a step, None of a scene in which only gravity and a plane act.

    Raises NotImplementedError for a method that is not told of forces.
    """
    if scene.is_unforced:
        return None
    kind, _, manner = method.partition("+")
    if not manner:
        raise NotImplementedError(f"{kind} has none of these laws itself; {kind}+held is given their force once a step")
    from tumble.scenarios.wrench import wrench  # it may bring a compiler, which a free flight has no use for

    return wrench(scene)
