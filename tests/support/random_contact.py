"""Scene files above a plane, drawn at random, on which the contact truth's bound is tried."""

import numpy as np

FAMILIES = (
    "ball dropped",
    "ball that slips",
    "ball on an incline",
    "box that slides",
    "box on an incline",
    "cube thrown",
    "box thrown",
    "box thrown without friction",
    "oblique tensor thrown",
    "box that sticks",
    "box that tips",
    "block that rocks",
    "top",
    "disc that rolls",
    "disc thrown",
)


def numbers(values):
    return "[" + ", ".join(repr(float(value)) for value in np.ravel(values)) + "]"


def drawn(family, seed):
    """The text of a scene of that family."""
    if family in FAMILIES[10:13]:
        return pinned(family, seed)
    if family in FAMILIES[13:]:
        return disc(family, seed)
    random = np.random.default_rng((FAMILIES.index(family), seed))
    unit = 10.0 ** random.uniform(-3, 1)
    mass = 10.0 ** random.uniform(-2, 1)
    pull = 9.81 * 10.0 ** random.uniform(-0.5, 0.5)
    level = family in ("ball dropped", "ball that slips") and random.random() < 0.5
    normal = np.array((0.0, 1.0, 0.0)) if level else random.normal(size=3)
    if family == "box that slides" and random.random() < 0.5:
        normal = np.array((0.0, 1.0, 0.0))
    n = normal / np.linalg.norm(normal)
    along = np.cross(n, random.normal(size=3))
    along /= np.linalg.norm(along)
    across = np.cross(n, along)
    point = random.normal(size=3) * unit
    inclined = "incline" in family or (family == "ball dropped" and random.random() < 0.3)
    slope = random.uniform(0.05, 0.9) if inclined else 0.0
    gravity = pull * (np.sin(slope) * along - np.cos(slope) * n)
    thrown = "thrown" in family or "sticks" in family
    if thrown:
        gravity = pull * (along * random.uniform(-0.3, 0.3) - n)
    speed = np.sqrt(pull * unit)
    on_plane = not thrown and family != "ball dropped"
    e = 0.0 if random.random() < 0.15 else 1.0 if random.random() < 0.1 else random.uniform(0.05, 0.95)
    mu = 0.0 if "without" in family or random.random() < 0.1 else random.uniform(0.05, 1.2)
    mu = random.uniform(3, 8) if "sticks" in family else mu
    if family == "ball dropped":
        e = min(e, 0.7) if e < 1 else e
    lines = [f'title = "{family}"', "step = 0.001", f"gravity = {numbers(gravity)}"]
    body = ["[body]", f"mass = {mass!r}"]
    if "ball" in family:
        radius = unit * random.uniform(0.2, 1)
        body += ['shape = "sphere"', f"radius = {radius!r}"]
        height = radius if on_plane else radius + unit * random.uniform(0.2, 2)
        body += ["orientation = " + numbers(random.normal(size=4))]
        spin = random.normal(size=3) * speed / radius
        v = speed * (random.normal() * along + random.normal() * across) * 0.7
        if not on_plane:
            v = v + speed * random.normal() * 0.5 * n
        elif random.random() < 0.15:
            v, spin = 0 * v, 0 * spin
    elif on_plane:
        size = unit * random.uniform(0.2, 1, 3)
        axis = int(random.integers(3))
        q = laying(axis, n, along)
        size[axis] *= 0.3
        height = size[axis] / 2
        mu = min(mu, 0.9 * min(np.delete(size, axis)) / size[axis])
        v = speed * (random.normal() * along + random.normal() * across)
        if "incline" in family and random.random() < 0.4:
            v = 0 * v
        spin = 0 * v
        body += ['shape = "box"', "size = " + numbers(size), "orientation = " + numbers(q)]
    else:
        if "oblique" in family:
            turn, _ = np.linalg.qr(random.normal(size=(3, 3)))
            tensor = mass * unit**2 * 0.1 * turn @ np.diag(random.uniform(0.6, 1.1, 3)) @ turn.T
            body += ['shape = "rigid"', "inertia = [" + ", ".join(map(numbers, (tensor + tensor.T) / 2)) + "]"]
            points = random.normal(size=(6, 3)) * unit * 0.4
            body += ["points = [" + ", ".join(map(numbers, points)) + "]"]
            reach = np.linalg.norm(points, axis=1).max()
        else:
            size = unit * (np.full(3, random.uniform(0.2, 1)) if "cube" in family else random.uniform(0.2, 1, 3))
            body += ['shape = "box"', "size = " + numbers(size)]
            reach = np.linalg.norm(size) / 2
        body += ["orientation = " + numbers(random.normal(size=4))]
        height = reach * 1.01 + unit * random.uniform(0, 0.5)
        v = speed * (random.normal(size=3) * 0.7 - n)
        spin = random.normal(size=3) * speed / unit * 2
    position = point + height * n + unit * (random.normal() * along + random.normal() * across)
    body += ["position = " + numbers(position), "velocity = " + numbers(v), "angular_velocity = " + numbers(spin)]
    duration = float(np.sqrt(unit / pull) * random.uniform(1.5, 3.5))
    lines += [f"duration = {duration!r}", "samples = 5"]
    if thrown and random.random() < 0.3:
        time = duration * random.uniform(0.05, 0.6)
        body += ["[[impulse]]", f"time = {time!r}", "value = " + numbers(random.normal(size=3) * mass * speed * 0.5)]
        body += ["point_body = " + numbers(random.normal(size=3) * unit * 0.1)]
    plane = ["[plane]", "point = " + numbers(point), "normal = " + numbers(normal)]
    plane += [f"restitution = {e!r}", f"friction = {float(mu)!r}"]
    return "\n".join([*lines, *body, *plane]) + "\n"


def laying(axis, normal, along):
    """The quaternion that turns a body's axis onto the plane's normal, in doubles."""
    columns = np.empty((3, 3))
    columns[:, axis] = normal
    columns[:, (axis + 1) % 3] = along
    columns[:, (axis + 2) % 3] = np.cross(normal, along)
    trace = np.trace(columns)
    four = np.array([1 + trace, *(1 - trace + 2 * np.diag(columns))])
    largest = int(four.argmax())
    w, x, y, z = (
        columns[2, 1] - columns[1, 2], columns[0, 2] - columns[2, 0], columns[1, 0] - columns[0, 1], 0.0,
    )  # fmt: skip
    if largest == 0:
        return np.array((four[0], w, x, y))
    q = np.empty(4)
    q[1:] = columns[largest - 1] + columns[:, largest - 1]
    q[largest] = four[largest]
    q[0] = (w, x, y)[largest - 1]
    del z
    return q


def pinned(family, seed):
    """The text of a scene of a body that an edge or its tip stays on the plane of."""
    random = np.random.default_rng((FAMILIES.index(family), seed))
    unit, mass = 10.0 ** random.uniform(-2, 0.5), 10.0 ** random.uniform(-2, 1)
    pull = 9.81 * 10.0 ** random.uniform(-0.5, 0.5)
    time = np.sqrt(unit / pull)
    level = random.random() < 0.5
    n = np.array((0.0, 1.0, 0.0)) if level else unit_vector(random.normal(size=3))
    along = np.array((0.0, 0.0, 1.0)) if level else unit_vector(np.cross(n, random.normal(size=3)))
    across = np.cross(along, n)
    point = random.normal(size=3) * unit
    body = ["[body]", f"mass = {mass!r}"]
    if family == "top":
        transverse = mass * unit**2 * random.uniform(0.01, 0.05)
        own = transverse * random.uniform(0.3, 1.9)
        height, tilt = unit * random.uniform(0.1, 0.4), random.uniform(0.15, 0.9)
        rim = [(height * np.cos(a), 0.4 * height, height * np.sin(a)) for a in (0, 2, 4)]
        axis = np.cos(tilt) * n + np.sin(tilt) * across
        spin = random.uniform(10, 40) / time * axis * random.choice((-1, 1)) + random.normal(size=3) / time
        q = laying(1, axis, along)
        position, velocity = point + height * axis, np.cross(spin, height * axis)
        body += ['shape = "rigid"', f"points = [{numbers((0.0, -height, 0.0))}, {', '.join(map(numbers, rim))}]"]
        body += ["inertia = [" + ", ".join(map(numbers, np.diag((transverse, own, transverse)))) + "]"]
        mu, e, length = random.uniform(0.5, 2), random.random(), 2.0
    else:
        width, tall, deep = (
            unit * random.uniform(0.2, 0.5),
            unit * random.uniform(0.8, 1.2),
            unit * random.uniform(0.2, 1),
        )
        lean = np.arctan(width / tall)
        angle = lean * random.uniform(0.2, 0.9) if "rocks" in family else lean + random.uniform(0.02, 0.5)
        # The lower edge at a point: up the block's side and along its foot.
        up, foot = np.cos(angle) * n + np.sin(angle) * across, np.cos(angle) * across - np.sin(angle) * n
        arm = tall / 2 * up - width / 2 * foot
        rate = random.normal() * 0.2 / time if random.random() < 0.5 and "tips" in family else 0.0
        spin = -abs(rate) * along
        q = laying(2, along, -foot)
        columns = np.array((-foot, np.cross(along, -foot), along))
        assert abs(columns[1] @ up) > 0.999
        position, velocity = point + arm, np.cross(spin, arm)
        body += ['shape = "box"', "size = " + numbers((width, tall, deep))]
        mu, e, length = random.uniform(0.6, 1.5), 0.0, 3.0
    body += ["orientation = " + numbers(q), "position = " + numbers(position)]
    body += ["velocity = " + numbers(velocity), "angular_velocity = " + numbers(spin)]
    head = [f'title = "{family}"', "step = 0.001", f"duration = {float(time * length)!r}", "samples = 8"]
    head += ["gravity = " + numbers(-pull * n)]
    plane = ["[plane]", "point = " + numbers(point), "normal = " + numbers(n)]
    plane += [f"restitution = {float(e)!r}", f"friction = {float(mu)!r}"]
    return "\n".join([*head, *body, *plane]) + "\n"


def disc(family, seed):
    """The text of a scene of a disc that rolls on its rim, some of them in a steady circle, or comes down on it."""
    random = np.random.default_rng((FAMILIES.index(family), seed))
    unit, mass = 10.0 ** random.uniform(-2, 0.5), 10.0 ** random.uniform(-2, 1)
    pull = 9.81 * 10.0 ** random.uniform(-0.5, 0.5)
    rate = np.sqrt(pull / unit)
    n = np.array((0.0, 1.0, 0.0)) if random.random() < 0.5 else unit_vector(random.normal(size=3))
    along = unit_vector(np.cross(n, random.normal(size=3)))
    beside = np.cross(n, along)
    thickness = 0.0 if random.random() < 0.3 else unit * random.uniform(0.01, 0.4)
    point = random.normal(size=3) * unit
    tilt = random.uniform(0.3, 1.5)
    axis, up = np.cos(tilt) * n - np.sin(tilt) * beside, np.sin(tilt) * n + np.cos(tilt) * beside
    # A turn about the normal, and the spin by which it is a steady circle; most of them nearly, or far from it.
    q, f = random.uniform(0.5, 4) * rate * random.choice((-1, 1)) * np.array((np.sin(tilt), np.cos(tilt)))
    c, own, across = -thickness / 2, unit**2 / 2, (3 * unit**2 + thickness**2) / 12
    needed = f * q * (-across - c * c) + unit * q * q * c + pull * (unit * np.cos(tilt) + c * np.sin(tilt))
    steady = np.array((0.0, q, needed / (unit * (c * f - unit * q) - own * q)))
    spin = steady + (random.choice((0.1, 0.6)) * rate * random.normal(size=3) if random.random() < 0.8 else 0.0)
    lever = -unit * up - thickness / 2 * axis
    w = np.array((along, up, axis)).T @ spin
    body = ["[body]", 'shape = "disc"', f"mass = {mass!r}", f"radius = {unit!r}", f"thickness = {float(thickness)!r}"]
    position, v, e = point - lever, -np.cross(w, lever), random.random()
    slope = random.uniform(-0.4, 0.4, 2) if random.random() < 0.4 else np.zeros(2)
    if "thrown" in family:
        position, v = position + unit * random.uniform(0.05, 0.6) * n, unit * rate * random.normal(size=3)
        e = random.uniform(0.2, 0.95)
    mu = random.uniform(0.5, 3) if "rolls" in family else random.uniform(0, 1.2)
    body += ["position = " + numbers(position), "orientation = " + numbers(laying(2, axis, along))]
    body += ["velocity = " + numbers(v), "angular_velocity = " + numbers(w)]
    length = random.uniform(1, 4) / rate
    head = [f'title = "{family}"', "step = 0.001", f"duration = {float(length)!r}", "samples = 6"]
    head += ["gravity = " + numbers(pull * (slope[0] * along + slope[1] * beside - n))]
    plane = ["[plane]", "point = " + numbers(point), "normal = " + numbers(n)]
    plane += [f"restitution = {float(e)!r}", f"friction = {float(mu)!r}"]
    return "\n".join([*head, *body, *plane]) + "\n"


def unit_vector(vector):
    return vector / np.linalg.norm(vector)
