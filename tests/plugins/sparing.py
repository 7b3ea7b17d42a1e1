"""An engine with OPTIONAL: ballast only costs time; a breeze, which no scene has, moves the body; digits are a state's.

`careless` leaves out digits that a motion has use for; `fragile` is not built with a breeze, `brittle` with anything.
"""

import mine

METHODS = ("careful", "windy", "careless", "fragile", "brittle")
FEATURES = {"gravity"}
OPTIONAL = ("ballast", "breeze", "digits", "gravity")
ABOUT = {"version": "1", "precision": "double", "switched_off": ["ballast", "breeze"]}
BALLAST = 3  # flights made for nothing
BREEZE = 1e-3  # m/s2


class World(mine.World):
    def __init__(self, scene, method, keep):
        super().__init__(scene)
        self.ballast = BALLAST if "ballast" in keep else 0
        self.rounds = method == "careless" and "digits" not in keep
        if method == "windy" and "breeze" in keep:
            self.gravity = self.gravity + BREEZE


def build(scene, method, keep=frozenset()):
    if (method == "fragile" and "breeze" in keep) or (method == "brittle" and keep):
        raise NotImplementedError("it would break")
    return World(scene, method, keep)


def write(world, states):
    world.states = states.round() if world.rounds else states.copy()


def advance(world, n, dt):
    start = world.states.copy()
    for _ in range(world.ballast):
        mine.advance(world, n, dt)
        world.states[:] = start
    mine.advance(world, n, dt)


def read(world):
    return mine.read(world)
