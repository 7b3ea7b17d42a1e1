"""Scene files drawn at random, free and forced, on which the truth's bound is tried."""

import numpy as np

FAMILIES = (
    "box",
    "oblique tensor",
    "needle, oblique tensor",
    "box, struck",
    "tether",
    "tether with a rest length",
    "stiff tether",
    "overdamped tether",
    "drag",
    "floor",
)


def drawn(family, seed):
    """The text of a scene of that family."""
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
    if "oblique" in family:
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
    if family == "box, struck" or "needle" in family:
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
