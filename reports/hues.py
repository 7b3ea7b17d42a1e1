"""One colour for each engine, the same on the page, in the lab and in every picture."""

from collections.abc import Iterable

from tumble.compare.engines import BY_HAND
from tumble.compare.run.contestant import Contestant

# Okabe and Ito (2008), darkened so that a line or a name in them is read on light paper; the page's --hue-1 to --hue-6.
LIGHT = ("#0072b2", "#a63d7c", "#c25100", "#007a5a", "#7a5b00", "#4f4fb5")
# The place of an engine: its colour is that number modulo the colours; engines that share one have another fill.
# The first six are those that most pages show together.
PLACES = (
    "tumble", "heyoka", "mujoco", "pybullet", "scipy", "drake",
    "physx", "rapier", "jolt", "ode", "dart", "newton",
    "ammo", "cannon", "rapier-js", "box3d", "havok",
)  # fmt: skip


def places(engines: Iterable[str]) -> dict[str, int]:
    """Return the place of each engine.

    An engine without a place in PLACES takes, in the order given, the first place whose colour is free, and if none is
    left the places after those.  The hand calculation has no place.

    Parameters
    ----------
    engines : ENGINE or ENGINE@RELEASE of each; duplicates are ignored

    Returns
    -------
    place by engine, as given
    """
    named = [engine for engine in dict.fromkeys(engines) if engine != BY_HAND]
    found = {engine: PLACES.index(name) for engine in named if (name := Contestant.of(engine).engine) in PLACES}
    taken = {place % len(LIGHT) for place in found.values()}
    free = [place for place in range(len(LIGHT)) if place not in taken]
    later = len(PLACES)
    for engine in named:
        if engine not in found:
            found[engine] = free.pop(0) if free else later
            later += not free
    return {engine: found[engine] for engine in named}


def rgb(place: int) -> tuple[int, int, int]:
    """Return the colour of a place on light paper.

    Parameters
    ----------
    place : place of an engine, from `places`

    Returns
    -------
    red, green and blue, each 0 to 255
    """
    code = LIGHT[place % len(LIGHT)]
    red, green, blue = (int(code[at : at + 2], 16) for at in (1, 3, 5))
    return red, green, blue
