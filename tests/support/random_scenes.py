"""Scene files drawn at random, free and forced, on which the truth's bound is tried."""

import numpy as np

FAMILIES = (
    "box",
    "oblique tensor",
    "needle, oblique tensor",
    "box, impulse",
    "tether",
    "tether with a rest length",
    "stiff tether",
    "overdamped tether",
    "drag",
    "floor",
    "moments 8e-15 apart",
    "tether of 1e6 to 1e9 N/m",
    "damper that holds, tether to 1e12 N/m",
    "several forces and impulses, any unit",
)
# Those that take the second formulation longest are drawn less often.
COSTLY = FAMILIES[9:]
# What dies out in nanoseconds and goes on for a second: so many of the samples the second formulation can reach.
REACHED = {"damper that holds, tether to 1e12 N/m": 2}


def rotated(q, point):
    """A point turned by a quaternion of any length, in doubles."""
    w, axis = q[0], np.array(q[1:])
    return point + 2 * np.cross(axis, np.cross(axis, point) + w * point) / (w * w + axis @ axis)


def drawn(family, seed):
    """The text of a scene of that family."""
    if family in FAMILIES[11:]:
        return drawn_with_forces(family, seed)
    random = np.random.default_rng((FAMILIES.index(family), seed))
    numbers = lambda *values: "[" + ", ".join(repr(float(value)) for value in np.ravel(values)) + "]"  # noqa: E731
    normal = lambda count, scale: random.normal(size=count) * scale  # noqa: E731
    mass = 10.0 ** random.uniform(-1, 1)
    stiff = family in ("stiff tether", "overdamped tether")
    lines = [f'title = "{family}"', "step = 0.001"]
    lines += [f"duration = {0.02 if stiff else 1.0}", "samples = 4"]
    if random.random() < 0.5 or family == "floor":
        lines.append("gravity = " + numbers(0.0, -9.81, 0.0))
    lines += ["[body]", f"mass = {mass!r}"]
    if "apart" in family:
        moments = mass * 0.1 * np.array((0.7, 1.0, 1.0 + 8e-15))[random.permutation(3)]
        lines += ['shape = "rigid"', "inertia = [" + ", ".join(map(numbers, np.diag(moments))) + "]"]
        lines += ["points = [" + ", ".join(numbers(normal(3, 0.5)) for _ in range(5)) + "]"]
    elif "oblique" in family:
        turn, _ = np.linalg.qr(random.normal(size=(3, 3)))
        moments = np.array((1e-6, 1.0, 1.0 + 1e-7)) if "needle" in family else random.uniform(0.6, 1.1, 3)
        tensor = mass * 0.1 * turn @ np.diag(moments) @ turn.T
        lines += ['shape = "rigid"', "inertia = [" + ", ".join(map(numbers, (tensor + tensor.T) / 2)) + "]"]
        lines += ["points = [" + ", ".join(numbers(normal(3, 0.5)) for _ in range(5)) + "]"]
    else:
        lines += ['shape = "box"', "size = " + numbers(random.uniform(0.2, 1.5, 3))]
    height = 1.6 if family == "floor" else 0.0
    lines += [
        "position = " + numbers(np.add(normal(3, 0.3), (0, height, 0))),
        "orientation = " + numbers(normal(4, 1.0)),
        "velocity = " + numbers(normal(3, 1.0)),
        "angular_velocity = " + numbers(normal(3, 0.02 if "needle" in family else 2.0)),
    ]
    if family == "box, impulse" or "needle" in family:
        strength, time = 3e-4 * mass if "needle" in family else mass, random.uniform(0.1, 0.6)
        lines += ["[[impulse]]", f"time = {time!r}", f"magnitude = {strength!r}"]
        lines += ["direction = " + numbers(normal(3, 1.0)), "point_body = " + numbers(normal(3, 0.02))]
    if "tether" in family:
        stiffness = mass * 10.0 ** (random.uniform(3, 6) if stiff else random.uniform(0.5, 2))
        share = 20.0 if family == "overdamped tether" else 0.1 * random.random()
        lines += ["[[tether]]", f"vertex = {random.integers(8)}", "anchor = " + numbers(normal(3, 0.5))]
        lines += [f"stiffness = {stiffness!r}", f"damping = {2 * share * np.sqrt(stiffness * mass)!r}"]
        lines += [f"rest_length = {random.uniform(0.2, 1)!r}"] if "rest" in family else []
    if family == "drag":
        lines += ["[drag]", f"linear = {mass * random.random()!r}", f"angular = {0.1 * mass * random.random()!r}"]
    if family == "floor":
        lines += ["[floor]", f"stiffness = {mass * 3000.0!r}", f"damping = {mass * 10 * random.random()!r}"]
        lines += ["height = 0.0", "normal = " + numbers(np.add(normal(3, 0.1), (0, 1, 0)))]
    return "\n".join(lines).replace("np.float64(", "").replace(")", "") + "\n"


def drawn_with_forces(family, seed):
    """The text of a scene of tethers as stiff as can be, or of several forces and blows; lengths in any unit."""
    random = np.random.default_rng((FAMILIES.index(family), seed))
    numbers = lambda values: "[" + ", ".join(repr(float(value)) for value in values) + "]"  # noqa: E731
    several, held = "several" in family, "holds" in family
    unit = 10.0 ** random.uniform(-5, 5) if several else 1.0
    mass = 10.0 ** random.uniform(-1, 1)
    size, q = random.uniform(0.2, 1.5, 3) * unit, random.normal(size=4)
    # Unit to rounding.
    q /= np.linalg.norm(q)
    place = random.normal(size=3) * 0.3 * unit
    lines = [f'title = "{family}"', "step = 0.001", "gravity = " + numbers((0.0, -9.81 * unit, 0.0))]
    body = ["[body]", 'shape = "box"', f"mass = {mass!r}", "size = " + numbers(size)]
    body += ["position = " + numbers(place), "orientation = " + numbers(q)]
    body += [
        "velocity = " + numbers(random.normal(size=3) * unit),
        "angular_velocity = " + numbers(random.normal(size=3)),
    ]
    end = 1.0
    for _ in range(2 if several else 1):
        stiffness = mass * 10.0 ** random.uniform(0.5, 2) if several else 10.0 ** random.uniform(6, 12 if held else 9)
        rate, share = np.sqrt(stiffness / mass), random.uniform(20, 60) if held else 0.1 * random.random()
        vertex, line = random.integers(8), random.normal(size=3)
        corner = place + rotated(
            q, size / 2 * ((vertex >> 2 & 1) * 2 - 1, (vertex >> 1 & 1) * 2 - 1, (vertex & 1) * 2 - 1)
        )
        rest = random.choice((0.0, random.uniform(0.1, 1) * unit))
        stretch = random.uniform(-0.2, 0.5) * unit if several else 10.0 ** random.uniform(-5, -2)
        anchor = corner + (rest + stretch) * line / np.linalg.norm(line)
        body += ["[[tether]]", f"vertex = {vertex}", "anchor = " + numbers(anchor), f"rest_length = {float(rest)!r}"]
        body += [f"stiffness = {float(stiffness)!r}", f"damping = {float(2 * share * rate * mass)!r}"]
        end = 1.0 if several else 40 / rate
    if several:
        body += ["[drag]", f"linear = {mass * random.random()!r}"]
        body += [f"angular = {0.1 * mass * unit * unit * random.random()!r}"]
        for time in np.sort(random.uniform(0.1, 0.9, 2)).tolist():
            body += ["[[impulse]]", f"time = {time!r}", "value = " + numbers(random.normal(size=3) * mass * unit)]
            body += [f"vertex = {random.integers(8)}"]
    # What is held dies out within about 1 / (4 share rate).
    times = [2 / (share * rate), 5 / (share * rate), 1.0] if held else [end / 4, end / 2, end]
    lines += [f"duration = {float(times[-1])!r}", "times = " + numbers(times)]
    return "\n".join(lines + body) + "\n"
