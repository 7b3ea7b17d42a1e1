"""A second formulation of the truth, to 60 digits: it reads the scene file itself and shares nothing with Tumble.

Taylor series of x, v, the quaternion and the angular velocity in body axes, with the tensor as the file gives it.
Source of the equations: Goldstein, "Classical Mechanics" (1980), eqs. 4-86, 5-39; of the steps: Jorba & Zou (2005).
"""

import tomllib
from itertools import product
from operator import mul
from pathlib import Path

import gmpy2
from gmpy2 import mpfr, mpq

BITS, ORDER = 260, 56
# What the last terms of a step may be.
TOLERANCE = mpfr(10) ** -62
# Points at which a vertex's height is looked at in a step for a passage through the floor.
LOOKS = 24
# The time between two places or attitudes whose difference is a derivative [s].
NUDGE = mpfr(10) ** -20


class Body:
    """A body along its file's axes: mass, points from the centre of mass, tensor and its inverse, all rational."""

    def __init__(self, table):
        self.mass = mpq(table["mass"])
        if table["shape"] == "box":
            a, b, c = (mpq(edge) for edge in table["size"])
            self.points = [[x * a / 2, y * b / 2, z * c / 2] for x, y, z in product((-1, 1), repeat=3)]
            squares = (b * b + c * c, a * a + c * c, a * a + b * b)
            self.tensor = [[self.mass * squares[i] / 12 if i == j else mpq(0) for j in range(3)] for i in range(3)]
        else:
            given = table["inertia"]
            self.points = [[mpq(number) for number in point] for point in table["points"]]
            self.tensor = [[(mpq(given[i][j]) + mpq(given[j][i])) / 2 for j in range(3)] for i in range(3)]
        t = self.tensor
        cofactors = [cross(t[(i + 1) % 3], t[(i + 2) % 3]) for i in range(3)]
        whole = sum(t[0][i] * cofactors[0][i] for i in range(3))
        self.inverse = [[cofactors[j][i] / whole for j in range(3)] for i in range(3)]


def cross(a, b):
    """a x b, of any numbers."""
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def unit(vector):
    """A vector of length 1, to BITS."""
    vector = [mpq(number) for number in vector]
    length = gmpy2.sqrt(mpfr(sum(number * number for number in vector)))
    return [number / length for number in vector]


def axes_of(q):
    """The rotation matrix of a unit quaternion."""
    w, x, y, z = q
    return [
        [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
    ]


def times(matrix, vector):
    """A matrix times a vector, of any numbers."""
    return [sum((a * b for a, b in zip(row[1:], vector[1:], strict=True)), row[0] * vector[0]) for row in matrix]


class Series(list):
    """Coefficients of a power series so far; sums and products with numbers and with one another, term by term."""

    def at(self, s):
        """Its value, by Horner's rule."""
        total = mpfr(0)
        for coefficient in reversed(self):
            total = total * s + coefficient
        return total


class Motion:
    """The series of one step, grown order by order."""

    def __init__(self, body, document, pressing, state):
        self.body, self.document, self.pressing = body, document, pressing
        self.state = [Series([number]) for number in state]
        self.products = {}
        self.heights = []
        for k in range(ORDER):
            rates = self.rates(k)
            for series, rate in zip(self.state, rates, strict=True):
                series.append(rate / (k + 1))

    def times(self, name, a, b, k):
        """The k-th coefficient of a product of two series, kept under a name."""
        kept = self.products.setdefault(name, Series())
        kept.append(sum(map(mul, a[: k + 1], b[k::-1]), mpfr(0)))
        return kept[k]

    def rates(self, k):
        """The k-th coefficients of the state's rates."""
        x, v, q, w = self.state[0:3], self.state[3:6], self.state[6:10], self.state[10:13]
        pairs = [
            [self.times(("qq", min(i, j), max(i, j)), q[i], q[j], k) if i <= j else None for j in range(4)]
            for i in range(4)
        ]
        s = lambda i, j: pairs[min(i, j)][max(i, j)]  # noqa: E731
        matrix = [
            [s(0, 0) + s(1, 1) - s(2, 2) - s(3, 3), 2 * (s(1, 2) - s(0, 3)), 2 * (s(1, 3) + s(0, 2))],
            [2 * (s(1, 2) + s(0, 3)), s(0, 0) - s(1, 1) + s(2, 2) - s(3, 3), 2 * (s(2, 3) - s(0, 1))],
            [2 * (s(1, 3) - s(0, 2)), 2 * (s(2, 3) + s(0, 1)), s(0, 0) - s(1, 1) - s(2, 2) + s(3, 3)],
        ]
        for i, j in product(range(3), repeat=2):
            self.products.setdefault(("R", i, j), Series()).append(matrix[i][j])
        R = [[self.products["R", i, j] for j in range(3)] for i in range(3)]
        now = lambda vector: [series[k] for series in vector]  # noqa: E731
        force, torque = [mpfr(0)] * 3, [mpfr(0)] * 3
        doc = self.document
        for number, tether in enumerate(doc.get("tether", [])):
            p = self.body.points[tether["vertex"]]
            lever, rate = times(matrix, p), self.point_rate(("t", number), p, R, v, w, k)
            anchor = [mpq(c) if k == 0 else 0 for c in tether["anchor"]]
            d = [a + b - c for a, b, c in zip(now(x), lever, anchor, strict=True)]
            stiffness, damping, rest = (mpq(tether.get(key, 0)) for key in ("stiffness", "damping", "rest_length"))
            if rest:
                pull = self.along(("t", number), d, rate, stiffness, damping, rest, k)
            else:
                pull = [-stiffness * a - damping * b for a, b in zip(d, rate, strict=True)]
            own = self.body_torque(("t", number), p, pull, R, k)
            force, torque = ([a + b for a, b in zip(*pair, strict=True)] for pair in ((force, pull), (torque, own)))
        if "drag" in doc:
            linear, angular = (mpq(doc["drag"].get(key, 0)) for key in ("linear", "angular"))
            force = [f - linear * u for f, u in zip(force, now(v), strict=True)]
            torque = [m - angular * u for m, u in zip(torque, now(w), strict=True)]
        if "floor" in doc:
            force, torque = self.on_floor(force, torque, x, v, w, matrix, R, k)
        spin = times(self.body.tensor, now(w))
        L = [self.products.setdefault(("L", i), Series()) for i in range(3)]
        for series, number in zip(L, spin, strict=True):
            series.append(number)
        gyro = [
            self.times(("g", i, 0), L[(i + 1) % 3], w[(i + 2) % 3], k)
            - self.times(("g", i, 1), L[(i + 2) % 3], w[(i + 1) % 3], k)
            for i in range(3)
        ]
        turn = times(self.body.inverse, [m + g for m, g in zip(torque, gyro, strict=True)])
        t = {(i, j): self.times(("qw", i, j), q[i], w[j], k) / 2 for i in range(4) for j in range(3)}
        gravity = [mpq(g) if k == 0 else 0 for g in doc.get("gravity", (0, 0, 0))]
        return [
            *now(v),
            *(f / self.body.mass + g for f, g in zip(force, gravity, strict=True)),
            -(t[1, 0] + t[2, 1] + t[3, 2]),
            t[0, 0] + t[2, 2] - t[3, 1],
            t[0, 1] + t[3, 0] - t[1, 2],
            t[0, 2] + t[1, 1] - t[2, 0],
            *turn,
        ]

    def point_rate(self, name, p, R, v, w, k):
        """v + R (w x p)."""
        crossed = cross([series[k] for series in w], p)
        kept = [self.products.setdefault((name, "wp", i), Series()) for i in range(3)]
        for series, number in zip(kept, crossed, strict=True):
            series.append(number)
        return [v[i][k] + sum(self.times((name, "Rwp", i, j), R[i][j], kept[j], k) for j in range(3)) for i in range(3)]

    def body_torque(self, name, p, pull, R, k):
        """p x R^T F."""
        kept = [self.products.setdefault((name, "F", i), Series()) for i in range(3)]
        for series, number in zip(kept, pull, strict=True):
            series.append(number)
        return cross(p, [sum(self.times((name, "RF", i, j), R[j][i], kept[j], k) for j in range(3)) for i in range(3)])

    def along(self, name, d, rate, stiffness, damping, rest, k):
        """-(k (|d| - l0) + c d'.u) u = -(k - k l0/|d| + c d.d'/|d|^2) d, with 1/|d| as a series of its own."""
        line = [self.products.setdefault((name, "d", i), Series()) for i in range(3)]
        speed = [self.products.setdefault((name, "d'", i), Series()) for i in range(3)]
        for series, number in zip((*line, *speed), (*d, *rate), strict=True):
            series.append(number)
        square = self.products.setdefault((name, "dd"), Series())
        square.append(sum(self.times((name, "dd", i), line[i], line[i], k) for i in range(3)))
        inverse = self.products.setdefault((name, "1/d"), Series())
        if k == 0:
            inverse.append(1 / gmpy2.sqrt(square[0]))
        else:
            # u = s^(-1/2):  k s_0 u_k = sum over j of (-(j)/2 - (k - j)) s_j u_(k-j).
            terms = ((-mpq(j, 2) - (k - j)) * square[j] * inverse[k - j] for j in range(1, k + 1))
            inverse.append(sum(terms, mpfr(0)) / (k * square[0]))
        closing = self.products.setdefault((name, "dd'"), Series())
        closing.append(sum(self.times((name, "dd'", i), line[i], speed[i], k) for i in range(3)))
        once = self.products.setdefault((name, "c"), Series())
        once.append(self.times((name, "cu"), closing, inverse, k))
        twice = self.times((name, "cuu"), once, inverse, k)
        factor = self.products.setdefault((name, "f"), Series())
        factor.append((stiffness if k == 0 else 0) - stiffness * rest * inverse[k] + damping * twice)
        return [-self.times((name, "fd", i), factor, line[i], k) for i in range(3)]

    def on_floor(self, force, torque, x, v, w, matrix, R, k):
        """The thrusts -k y - c y' of the vertices that press, along the normal."""
        floor = self.document["floor"]
        normal = unit(floor.get("normal", (0, 1, 0)))
        height, stiffness, damping = (mpq(floor.get(key, 0)) for key in ("height", "stiffness", "damping"))
        for vertex, p in enumerate(self.body.points):
            rate = self.point_rate(("v", vertex), p, R, v, w, k)
            place = [series[k] + a for series, a in zip(x, times(matrix, p), strict=True)]
            y = sum(n * a for n, a in zip(normal, place, strict=True)) - (height if k == 0 else 0)
            thrust = -stiffness * y - damping * sum(n * a for n, a in zip(normal, rate, strict=True))
            for name, number in (("y", y), ("N", thrust)):
                self.products.setdefault((name, vertex), Series()).append(number)
            if self.pressing[vertex] == 1:
                pull = [n * thrust for n in normal]
                own = self.body_torque(("v", vertex), p, pull, R, k)
                force, torque = ([a + b for a, b in zip(*pair, strict=True)] for pair in ((force, pull), (torque, own)))
        return force, torque

    def length(self):
        """How long a step may be [s]."""
        longest = mpfr(10) ** 9
        for series in self.state:
            for power in (ORDER - 1, ORDER):
                if series[power]:
                    longest = min(longest, (TOLERANCE / abs(series[power])) ** (mpfr(1) / power))
        return longest

    def switch(self, h):
        """The first instant in (0, h] at which a vertex leaves its state, which, and for what; or None."""
        first = None
        for vertex, mode in enumerate(self.pressing):
            y, thrust = (self.products[name, vertex] for name in ("y", "N"))
            watched = [(y, 1, 1)] if mode == 0 else [(y, -1, 0), (thrust, 1 if mode == 1 else -1, 3 - mode)]
            for series, sign, then in watched:
                at = first_fall(series, sign, h)
                if at is not None and (first is None or at < first[0]):
                    first = at, vertex, then
        return first


def first_fall(series, sign, h):
    """The first instant in (0, h] after which sign * series < 0, by looking often and halving, or None."""
    before = mpfr(0)
    for look in range(1, LOOKS + 1):
        t = h * look / LOOKS
        if sign * series.at(t) < 0:
            low, high = before, t
            if look == 1 and sign * series.at(t / 2**40) < 0:
                return mpfr(0) if sign * series[1] < 0 else None
            while high - low > t * mpfr(10) ** -70:
                middle = (low + high) / 2
                low, high = (low, middle) if sign * series.at(middle) < 0 else (middle, high)
            return high
        before = t
    return None


def vertices(path, times_s):
    """Where the corners are at the instants [s], blows of an instant included: (R, n, 3) rational-looking mpfr."""
    with gmpy2.context(precision=BITS):
        document = tomllib.loads(Path(path).read_text(encoding="utf-8"))
        body = Body(document["body"])
        rows = []
        for state, _ in _states(document, body, [mpq(float(time)) for time in times_s]):
            R = axes_of(state[6:10])
            rows.append([[a + b for a, b in zip(state[0:3], times(R, p), strict=True)] for p in body.points])
        return rows


def sensor_readings(path, sensor, times_s):
    """Specific force, angular velocity and field direction that a sensor of the file reads: (R, 3, 3).

    By differences of places and attitudes NUDGE apart, of which the second is right to NUDGE^2: no formula for the
    acceleration of a point of a turning body is used.
    """
    with gmpy2.context(precision=BITS):
        document = tomllib.loads(Path(path).read_text(encoding="utf-8"))
        body, table = Body(document["body"]), document["sensor"][sensor]
        p = [mpq(number) for number in table.get("point", (0, 0, 0))]
        mounted = axes_of(unit(table.get("orientation", (1, 0, 0, 0))))
        field = unit(table["field"]) if "field" in table else [mpfr(0)] * 3
        gravity = [mpq(number) for number in document.get("gravity", (0, 0, 0))]
        rows = []
        for state, pressing in _states(document, body, [mpq(float(time)) for time in times_s]):
            motion = Motion(body, document, pressing, state)
            before, here, after = (_pose(motion, p, h) for h in (-NUDGE, mpfr(0), NUDGE))
            a = [
                (x - 2 * y + z) / NUDGE**2 for x, y, z in zip(*(pose[0] for pose in (before, here, after)), strict=True)
            ]
            felt = [x - g for x, g in zip(a, gravity, strict=True)]
            R = here[1]
            rate = [
                [(y - x) / (2 * NUDGE) for x, y in zip(*pair, strict=True)]
                for pair in zip(before[1], after[1], strict=True)
            ]
            # R^T R' is the cross product with w.
            w = [sum(R[k][i] * rate[k][j] for k in range(3)) for i, j in ((2, 1), (0, 2), (1, 0))]
            own = [[sum(R[k][i] * vector[k] for k in range(3)) for i in range(3)] for vector in (felt, field)]
            rows.append([[sum(mounted[k][i] * v[k] for k in range(3)) for i in range(3)] for v in (own[0], w, own[1])])
        return rows


def _pose(motion, p, h):
    """Where a point of the body is h [s] on, and the axes."""
    state = [series.at(h) for series in motion.state]
    R = axes_of(state[6:10])
    return [a + b for a, b in zip(state[0:3], times(R, p), strict=True)], R


def _states(document, body, instants):
    """The states at the instants, blows included, each with how the vertices stand to the floor."""
    table = document["body"]
    q = unit(table.get("orientation", (1, 0, 0, 0)))
    R = axes_of(q)
    w_world = [mpq(number) for number in table.get("angular_velocity", (0, 0, 0))]
    w = [sum(R[j][i] * w_world[j] for j in range(3)) for i in range(3)]
    place = [mpfr(mpq(number)) for key in ("position", "velocity") for number in table.get(key, (0, 0, 0))]
    state = [*place, *q, *w]
    blows = sorted(document.get("impulse", []), key=lambda blow: blow.get("time", 0))
    now = mpq(0)
    stops = sorted({*instants, *(mpq(blow.get("time", 0)) for blow in blows)})
    pressing = standing(document, body, state)
    for stop in stops:
        while now < stop:
            motion = Motion(body, document, pressing, state)
            h = min(motion.length(), mpfr(stop - now))
            switch = motion.switch(h) if "floor" in document else None
            if switch is not None:
                h, vertex, then = switch
                pressing[vertex] = then
            state = [series.at(h) for series in motion.state]
            now = stop if switch is None and h == mpfr(stop - now) else now + mpq(h)
        for blow in blows:
            if mpq(blow.get("time", 0)) == stop:
                state = struck(body, blow, state)
                pressing = standing(document, body, state)
        if stop in instants:
            yield state, list(pressing)


def standing(document, body, state):
    """0, 1 or 2 for every vertex: above the floor, pressed, below it but leaving too fast to be pressed."""
    if "floor" not in document:
        return []
    motion = Motion.__new__(Motion)
    motion.body, motion.document, motion.pressing, motion.products = body, document, [0] * len(body.points), {}
    motion.state = [Series([number]) for number in state]
    motion.rates(0)
    modes = []
    for vertex in range(len(body.points)):
        y, thrust = (motion.products[name, vertex][0] for name in ("y", "N"))
        modes.append(0 if y >= 0 else 1 if thrust > 0 else 2)
    return modes


def struck(body, blow, state):
    """The state after a blow: v += J/m, w += I^-1 R^T (r x J)."""
    R = axes_of(state[6:10])
    if "value" in blow:
        J = [mpq(number) for number in blow["value"]]
    else:
        J = [mpq(blow["magnitude"]) * number for number in unit(blow["direction"])]
    if "point" in blow:
        lever = [mpq(a) - b for a, b in zip(blow["point"], state[0:3], strict=True)]
    else:
        p = body.points[blow["vertex"]] if "vertex" in blow else [mpq(number) for number in blow["point_body"]]
        lever = times(R, p)
    torque = cross(lever, J)
    turn = times(body.inverse, [sum(R[j][i] * torque[j] for j in range(3)) for i in range(3)])
    v = [a + b / body.mass for a, b in zip(state[3:6], J, strict=True)]
    return [*state[0:3], *v, *state[6:10], *(a + b for a, b in zip(state[10:13], turn, strict=True))]


def worst(path, true, reached=None):
    """Of a truth's rows within its horizon: how far a corner is off [m] over the bound, and how far, at the worst.

    reached: how many of the rows are looked at, if not all.
    """
    rows = vertices(path, true.times[: true.known][:reached])
    with gmpy2.context(precision=BITS):
        ratio, most = 0.0, 0.0
        for row, exact in enumerate(rows):
            for corner, told in zip(exact, true.vertices[row, 0], strict=True):
                off = float(gmpy2.sqrt(sum((a - mpfr(float(b))) ** 2 for a, b in zip(corner, told, strict=True))))
                ratio, most = max(ratio, off / float(true.bound[row, 0])), max(most, off)
        return ratio, most
