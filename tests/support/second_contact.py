"""A second formulation of the truth above a plane, to 60 digits: it reads the scene file itself.

It shares no line with Tumble.  Everything is integrated: Newton's and Euler's equations by Taylor series in time (as in
`second_truth`), with the contact force of the law as a force; impacts by Taylor series of the point's velocity in the
impulse, in Cartesian components; contacts are found by looking often and halving.
"""

import tomllib
from operator import mul
from pathlib import Path

import gmpy2
from gmpy2 import mpfr, mpq
from second_truth import BITS, Body, Motion, axes_of, cross, struck, times, unit

ORDER = 44
TINY = mpfr(10) ** -34
LOOKS = 48
# What counts as touching and as no speed along the normal at the start: what rounding may have made of it.
ROUNDED = mpfr(2) ** -46
# Of the weight: the friction that is left where a slip begins; rounding of that instant changes it.
SLIPS = 1e-12


class Sphere:
    """A uniform ball along its own axes."""

    def __init__(self, table):
        self.mass, self.radius = mpq(table["mass"]), mpq(table["radius"])
        r = self.radius
        self.points = [[mpq(0)] * 3]
        for axis in range(3):
            for sign in (-1, 1):
                self.points.append([sign * r if axis == i else mpq(0) for i in range(3)])
        moment = self.mass * r * r * 2 / 5
        self.tensor = [[moment if i == j else mpq(0) for j in range(3)] for i in range(3)]
        self.inverse = [[1 / moment if i == j else mpq(0) for j in range(3)] for i in range(3)]


class Disc:
    """A uniform disc about its z axis, with eight points on each rim."""

    def __init__(self, table):
        self.mass, self.radius, self.half = mpq(table["mass"]), mpq(table["radius"]), mpq(table.get("thickness", 0)) / 2
        self.sides = (-1, 1) if self.half else (1,)
        self.points = [[mpq(0)] * 3]
        for side in self.sides:
            for eighth in range(8):
                angle = eighth * gmpy2.const_pi() / 4
                x, y = (self.radius * c for c in (gmpy2.cos(angle), gmpy2.sin(angle)))
                self.points.append([x, y, side * self.half])
        across = self.mass * (self.radius**2 / 4 + self.half**2 / 3)
        moments = (across, across, self.mass * self.radius**2 / 2)
        self.tensor = [[moments[i] if i == j else mpq(0) for j in range(3)] for i in range(3)]
        self.inverse = [[1 / moments[i] if i == j else mpq(0) for j in range(3)] for i in range(3)]

    def lowest(self, axis, n):
        """From the centre to the lowest point of each rim, world axes."""
        below = plus([c * dot(axis, n) for c in axis], n, -1)
        below = [c * self.radius / size(below) for c in below]
        return [plus(below, axis, side * self.half) for side in self.sides]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b, strict=True))


def plus(a, b, factor=1):
    return [x + factor * y for x, y in zip(a, b, strict=True)]


def size(a):
    return gmpy2.sqrt(dot(a, a))


class World:
    """What a scene file says of body, plane and gravity."""

    def __init__(self, document):
        self.document = {key: value for key, value in document.items() if key != "plane"}
        table, plane = document["body"], document["plane"]
        self.ball, self.disc = (table["shape"] == shape for shape in ("sphere", "disc"))
        self.body = Sphere(table) if self.ball else Disc(table) if self.disc else Body(table)
        self.n = [mpfr(c) for c in unit(plane.get("normal", (0, 1, 0)))]
        self.o = [mpq(c) for c in plane.get("point", (0, 0, 0))]
        self.e, self.mu = mpq(plane["restitution"]), mpq(plane["friction"])
        self.g = [mpq(c) for c in document.get("gravity", (0, 0, 0))]
        self.gn = dot(self.g, self.n)
        self.gt = plus(self.g, self.n, -self.gn)
        self.reach = max(size(p) for p in self.body.points)

    def arms(self, state):
        """Where the points that can touch are from the centre, world axes."""
        if self.ball:
            return [[-self.body.radius * c for c in self.n]]
        R = axes_of(state[6:10])
        if self.disc:
            return self.body.lowest([row[2] for row in R], self.n)
        return [times(R, p) for p in self.body.points]

    def heights(self, state):
        base = dot(self.n, plus(state[0:3], self.o, -1))
        return [base + dot(self.n, arm) for arm in self.arms(state)]

    def spin(self, state):
        return times(axes_of(state[6:10]), state[10:13])

    def rate(self, state, arm):
        return plus(state[3:6], cross(self.spin(state), arm))

    def bears(self, pull):
        """What friction can hold more than it needs to, over the weight; pull: the plane's force over the mass."""
        press = dot(pull, self.n)
        return (self.mu * press - size(plus(pull, self.n, -press))) / size(self.g)

    def with_spin(self, state, w):
        R = axes_of(state[6:10])
        return [*state[0:10], *(sum(R[j][i] * w[j] for j in range(3)) for i in range(3))]

    def inverse(self, state):
        """The inverse inertia along world axes."""
        R = axes_of(state[6:10])
        half = [[sum(R[i][k] * self.body.inverse[k][j] for k in range(3)) for j in range(3)] for i in range(3)]
        return [[sum(half[i][k] * R[j][k] for k in range(3)) for j in range(3)] for i in range(3)]


def impact(world, state, arm):
    """The state after an impact of one point, by steps in the impulse along the normal."""
    inverse, m = world.inverse(state), world.body.mass
    n = world.n
    first = cross(n, min(([1, 0, 0], [0, 1, 0], [0, 0, 1]), key=lambda axis: abs(dot(axis, n))))
    first = [c / size(first) for c in first]
    frame = [n, first, cross(n, first)]

    def gained(J):
        """The velocity that an impulse gives the point."""
        return plus([c / m for c in J], cross(times(inverse, cross(arm, J)), arm))

    K = [[dot(frame[i], gained(frame[j])) for j in range(3)] for i in range(3)]
    u = [dot(axis, world.rate(state, arm)) for axis in frame]
    J = [mpfr(0)] * 3
    target = -world.e * u[0]
    for _ in range(3000):
        if u[0] >= target:
            break
        slip = gmpy2.sqrt(u[1] ** 2 + u[2] ** 2)
        if not world.mu:
            J = plus(J, [(target - u[0]) / K[0][0], 0, 0])
            break
        if slip <= TINY * abs(target - u[0]):
            J, u, done = from_rest(world, K, u, J, target)
            if done:
                break
            continue
        J, u = slide_on(world, K, u, J, slip, target)
    total = [sum(J[i] * frame[i][c] for i in range(3)) for c in range(3)]
    v = plus(state[3:6], [c / m for c in total])
    w = plus(world.spin(state), times(inverse, cross(arm, total)))
    return world.with_spin([*state[0:3], *v, *state[6:13]], w)


def from_rest(world, K, u, J, target):
    """Stick to the end, or begin to slip where friction cannot hold."""
    a, b, d = K[1][1], K[1][2], K[2][2]
    k1, k2 = K[1][0], K[2][0]
    whole = a * d - b * b
    hold = [-(d * k1 - b * k2) / whole, -(a * k2 - b * k1) / whole]
    if hold[0] ** 2 + hold[1] ** 2 <= world.mu**2:
        climb = K[0][0] + K[0][1] * hold[0] + K[0][2] * hold[1]
        P = (target - u[0]) / climb
        return plus(J, [P, P * hold[0], P * hold[1]]), u, True
    # The direction c with k - mu K c = rate c: halve for the rate.
    low, high = mpfr(0), 10 * (abs(k1) + abs(k2))

    def direction(rate):
        A, D, B = world.mu * a + rate, world.mu * d + rate, world.mu * b
        return [(D * k1 - B * k2) / (A * D - B * B), (A * k2 - B * k1) / (A * D - B * B)]

    for _ in range(BITS):
        middle = (low + high) / 2
        low, high = (middle, high) if size(direction(middle)) > 1 else (low, middle)
    c = direction(high)
    climb = K[0][0] - world.mu * (K[0][1] * c[0] + K[0][2] * c[1])
    P = (target - u[0]) / climb
    return plus(J, [P, -world.mu * P * c[0], -world.mu * P * c[1]]), u, True


def slide_on(world, K, u, J, slip, target):
    """One Taylor step of u' = K (1, -mu s/|s|) in the impulse along the normal."""
    U = [[c] for c in u]
    unit_slip = [[], []]
    square, halves, inverse = [], [], []
    F, mu = [[J[1]], [J[2]]], mpfr(world.mu)
    for k in range(ORDER):
        square.append(sum(map(mul, U[1], U[1][::-1])) + sum(map(mul, U[2], U[2][::-1])))
        halves.append(square[k] * k / 2)
        if k == 0:
            inverse.append(1 / gmpy2.sqrt(square[0]))
        else:
            # As in `second_truth`: k s_0 u_k = sum over j of (j / 2 - k) s_j u_(k-j).
            terms = sum(map(mul, halves[1:], inverse[::-1])) - k * sum(map(mul, square[1:], inverse[::-1]))
            inverse.append(terms / (k * square[0]))
        for i in (0, 1):
            unit_slip[i].append(sum(map(mul, U[i + 1], inverse[::-1])))
        push = [1 if k == 0 else 0, -mu * unit_slip[0][k], -mu * unit_slip[1][k]]
        for i in range(3):
            U[i].append(sum(map(mul, K[i], push)) / (k + 1))
        for i in (0, 1):
            F[i].append(push[i + 1] / (k + 1))
    h = step_length([*U, *F], mpfr(10) ** -44 * max(slip, abs(target) + abs(u[0])))
    fastest = abs(U[1][1]) + abs(U[2][1])
    h = min(h, slip / (4 * fastest)) if fastest else h
    at = first_rise(U[0], target, h)
    h = h if at is None else at
    return [J[0] + h, value(F[0], h), value(F[1], h)], [value(series, h) for series in U]


def value(series, h):
    total = mpfr(0)
    for c in reversed(series):
        total = total * h + c
    return total


def step_length(all_series, tolerance):
    longest = mpfr(10) ** 9
    for series in all_series:
        for power in (len(series) - 2, len(series) - 1):
            if series[power]:
                longest = min(longest, (tolerance / abs(series[power])) ** (mpfr(1) / power))
    return longest


def first_rise(series, target, h):
    """The first argument at which a series that begins below a target is at it, by looking often and halving."""
    if series[0] + h * value([abs(c) for c in series[1:]], h) < target:
        return None
    before = mpfr(0)
    for look in range(1, LOOKS + 1):
        t = h * look / LOOKS
        if value(series, t) >= target:
            low, high = before, t
            for _ in range(BITS):
                middle = (low + high) / 2
                low, high = (low, middle) if value(series, middle) >= target else (middle, high)
            return high
        before = t
    return None


class Pushed:
    """One Taylor step of a body on the plane that a force along it acts on: sliding friction, or what keeps it rolling.

    Of a ball the force also turns it; a body on its face does not turn.  State: x, v, q, w as world axes.
    """

    def __init__(self, world, state, w, mode):
        m, n = world.body.mass, world.n
        arm = [-world.body.radius * c for c in n] if world.ball else [mpq(0)] * 3
        moment = world.body.tensor[0][0]
        X, V, W = ([[c] for c in part] for part in (state[0:3], state[3:6], w))
        Q = [[c] for c in state[6:10]]
        slip, square, inverse = [[], [], []], [], []
        held = (
            [-c * m / (1 + m * world.body.radius**2 / moment) for c in world.gt]
            if world.ball
            else [-m * c for c in world.gt]
        )
        for k in range(ORDER):
            now = [series[k] for series in V]
            u = plus(now, cross([series[k] for series in W], arm)) if world.ball else now
            along = dot(u, n)
            for i in range(3):
                slip[i].append(u[i] - along * n[i])
            if mode == "slips":
                square.append(sum(slip[i][j] * slip[i][k - j] for i in range(3) for j in range(k + 1)))
                if k == 0:
                    inverse.append(1 / gmpy2.sqrt(square[0]))
                else:
                    terms = ((-mpq(j, 2) - (k - j)) * square[j] * inverse[k - j] for j in range(1, k + 1))
                    inverse.append(sum(terms, mpfr(0)) / (k * square[0]))
                hold = world.mu * m * world.gn
                force = [hold * sum(slip[i][j] * inverse[k - j] for j in range(k + 1)) for i in range(3)]
            elif mode == "holds":
                force = [c if k == 0 else mpq(0) for c in held]
            else:
                force = [mode[i] if k == 0 else mpq(0) for i in range(3)]
            torque = cross(arm, force) if world.ball else [0, 0, 0]
            spinning = [
                -sum(W[i][j] * Q[i + 1][k - j] for i in range(3) for j in range(k + 1)),
                *(
                    sum(
                        W[i][j] * Q[0][k - j]
                        + W[(i + 1) % 3][j] * Q[(i + 2) % 3 + 1][k - j]
                        - W[(i + 2) % 3][j] * Q[(i + 1) % 3 + 1][k - j]
                        for j in range(k + 1)
                    )
                    for i in range(3)
                ),
            ]
            for i in range(3):
                X[i].append(V[i][k] / (k + 1))
                V[i].append((force[i] / m + (world.gt[i] if k == 0 else 0)) / (k + 1))
                W[i].append(torque[i] / moment / (k + 1))
            for i in range(4):
                Q[i].append(spinning[i] / 2 / (k + 1))
        self.series = [*X, *V, *Q, *W]
        self.slip = size([series[0] for series in slip])
        self.rate = size([series[1] for series in slip]) if len(slip[0]) > 1 else mpfr(0)

    def at(self, h):
        return [value(series, h) for series in self.series]


class Hinged:
    """One Taylor step of Euler's equations about a point of the body that stays: R' = R [w], I w' = I w x w + r x g."""

    def __init__(self, world, state, hinge, gravity):
        m, I = world.body.mass, world.body.tensor  # noqa: E741
        self.hinge = hinge
        square = dot(hinge, hinge)
        about = [[I[i][j] + m * ((square if i == j else 0) - hinge[i] * hinge[j]) for j in range(3)] for i in range(3)]
        cofactors = [cross(about[(i + 1) % 3], about[(i + 2) % 3]) for i in range(3)]
        whole = dot(about[0], cofactors[0])
        inverse = [[cofactors[j][i] / whole for j in range(3)] for i in range(3)]
        W, Q = ([[c] for c in part] for part in (state[10:13], state[6:10]))
        R = [[[] for _ in range(3)] for _ in range(3)]
        L = [[], [], []]
        for k in range(ORDER):
            pairs = {(i, j): sum(Q[i][a] * Q[j][k - a] for a in range(k + 1)) for i in range(4) for j in range(i, 4)}
            s = lambda i, j: pairs[min(i, j), max(i, j)]  # noqa: B023, E731
            matrix = [
                [s(0, 0) + s(1, 1) - s(2, 2) - s(3, 3), 2 * (s(1, 2) - s(0, 3)), 2 * (s(1, 3) + s(0, 2))],
                [2 * (s(1, 2) + s(0, 3)), s(0, 0) - s(1, 1) + s(2, 2) - s(3, 3), 2 * (s(2, 3) - s(0, 1))],
                [2 * (s(1, 3) - s(0, 2)), 2 * (s(2, 3) + s(0, 1)), s(0, 0) - s(1, 1) - s(2, 2) + s(3, 3)],
            ]
            for i in range(3):
                for j in range(3):
                    R[i][j].append(matrix[i][j])
            now = [series[k] for series in W]
            for i in range(3):
                L[i].append(dot(about[i], now))
            down = [sum(R[j][i][k] * gravity[j] for j in range(3)) for i in range(3)]
            torque = cross([-c * m for c in hinge], down)
            swirl = [
                sum(
                    L[(i + 1) % 3][a] * W[(i + 2) % 3][k - a] - L[(i + 2) % 3][a] * W[(i + 1) % 3][k - a]
                    for a in range(k + 1)
                )
                for i in range(3)
            ]
            rate = times(inverse, plus(torque, swirl))
            turned = lambda i, j: sum(Q[i][a] * W[j][k - a] for a in range(k + 1))  # noqa: B023, E731
            spins = [
                -(turned(1, 0) + turned(2, 1) + turned(3, 2)),
                turned(0, 0) + turned(2, 2) - turned(3, 1),
                turned(0, 1) + turned(3, 0) - turned(1, 2),
                turned(0, 2) + turned(1, 1) - turned(2, 0),
            ]
            for i in range(3):
                W[i].append(rate[i] / (k + 1))
            for i in range(4):
                Q[i].append(spins[i] / 2 / (k + 1))
        self.series = [*W, *Q]

        goes, gains = (cross([series[k] for series in W], [-c for c in hinge]) for k in (0, 1))
        swung = plus(gains, cross([series[0] for series in W], goes))
        self.bears = world.bears(plus(times(axes_of(state[6:10]), swung), world.g, -1))

    def at(self, h, place):
        """The state with the hinge at a place."""
        w, q = ([value(series, h) for series in part] for part in (self.series[:3], self.series[3:]))
        R = axes_of(q)
        arm = times(R, [-c for c in self.hinge])
        return [*plus(place, arm), *cross(times(R, w), arm), *q, *w]


class Rolled:
    """A disc on the lowest point of one rim, without slip: Newton's and Euler's equations with the force unknown.

    y: the centre, the quaternion and the spin, world axes.  A step is Gragg's, extrapolated (Bulirsch and Stoer).
    """

    def __init__(self, world, side):
        self.world, self.side = world, side

    def lever(self, axis, axis_rate):
        """From the centre to the lowest point, and how fast that changes."""
        n, body = self.world.n, self.world.body
        below = plus([c * dot(axis, n) for c in axis], n, -1)
        changes = plus([c * dot(axis, n) for c in axis_rate], axis, dot(axis_rate, n))
        length = size(below)
        d = [c / length for c in below]
        turns = [(c - b * dot(d, changes)) / length for c, b in zip(changes, d, strict=True)]
        offset = self.side * body.half
        return (
            plus([c * body.radius for c in d], axis, offset),
            plus([c * body.radius for c in turns], axis_rate, offset),
        )

    def motion(self, y):
        """The rate of y, and of the centre's velocity."""
        world, m = self.world, self.world.body.mass
        q, w = y[3:7], y[7:10]
        length = size(q)
        R = axes_of([c / length for c in q])
        moments = [world.body.tensor[i][i] for i in range(3)]

        def spun(u):
            """The angular momentum of a spin."""
            own = times(zip(*R, strict=True), u)
            return times(R, [moment * c for moment, c in zip(moments, own, strict=True)])

        axis = [row[2] for row in R]
        r, r_rate = self.lever(axis, cross(w, axis))
        # I w' + w x I w = r x m (v' - g), v' = -w' x r - w x r'.
        known = plus(cross(w, spun(w)), cross(r, plus(cross(w, r_rate), world.g)), m)
        columns = []
        for i in range(3):
            unit_rate = [mpfr(int(i == j)) for j in range(3)]
            columns.append(plus(spun(unit_rate), cross(r, cross(unit_rate, r)), m))
        whole = dot(columns[0], cross(columns[1], columns[2]))
        rate = [-dot(known, cross(columns[(i + 1) % 3], columns[(i + 2) % 3])) / whole for i in range(3)]
        v = [-c for c in cross(w, r)]
        gained = plus(cross(rate, r), cross(w, r_rate))
        return [*v, *(c / 2 for c in product([mpfr(0), *w], q)), *rate], [-c for c in gained]

    def slope(self, y):
        return self.motion(y)[0]

    def bears(self, y):
        return self.world.bears(plus(self.motion(y)[1], self.world.g, -1))

    def step(self, y, h):
        table, last = [], None
        for row in range(1, 40):
            n = 2 * row
            before, now = y, plus(y, self.slope(y), h / n)
            for _ in range(n - 1):
                before, now = now, plus(before, self.slope(now), 2 * h / n)
            new = [[(a + b + h / n * c) / 2 for a, b, c in zip(before, now, self.slope(now), strict=True)]]
            for column in range(1, row):
                factor = mpfr(row * row) / (row - column) ** 2 - 1
                new.append([a + (a - b) / factor for a, b in zip(new[-1], table[column - 1], strict=True)])
            if last and max(abs(a - b) for a, b in zip(new[-1], last, strict=True)) < mpfr(10) ** -30 * size(y):
                return new[-1]
            table, last = new, new[-1]
        raise RuntimeError("no step")


class Course:
    """The whole motion, phase by phase."""

    def __init__(self, world, document):
        self.world, table = world, document["body"]
        q = unit(table.get("orientation", (1, 0, 0, 0)))
        R = axes_of(q)
        w = [mpq(number) for number in table.get("angular_velocity", (0, 0, 0))]
        own = [sum(R[j][i] * w[j] for j in range(3)) for i in range(3)]
        place = [mpfr(mpq(number)) for key in ("position", "velocity") for number in table.get(key, (0, 0, 0))]
        self.state = [*place, *q, *own]
        self.blows = sorted(document.get("impulse", []), key=lambda blow: blow.get("time", 0))
        self.now = mpq(0)
        self.fresh, self.fastest, self.bears = True, gmpy2.sqrt(size(world.g) * world.reach), None

    def rows(self, instants):
        world, rows = self.world, []
        for instant in instants:
            while self.blows and mpq(self.blows[0].get("time", 0)) <= instant:
                blow = self.blows.pop(0)
                self.go(mpq(blow.get("time", 0)))
                self.state = struck(world.body, blow, self.state)
                self.fresh = True
            self.go(instant)
            R = axes_of(self.state[6:10])
            rows.append([plus(self.state[0:3], times(R, p)) for p in world.body.points])
        return rows

    def go(self, end):
        """Go on to an instant, events of that instant included."""
        for _ in range(20000):
            mode = self.mode()
            if mode == "done" or (self.now >= end and mode != "impact"):
                return
            getattr(self, mode)(end)
        raise RuntimeError("no end")

    def mode(self):
        """What happens next."""
        world, state = self.world, self.state
        heights, arms = world.heights(state), world.arms(state)
        far = max(abs(c) for c in (*state[0:3], *world.o))
        touching = [i for i, h in enumerate(heights) if h <= ROUNDED * (world.reach + far)]
        speeds = {i: dot(world.n, world.rate(state, arms[i])) for i in touching}
        still = self.still(state)
        meets = [i for i in touching if speeds[i] < -still]
        self.rests = [i for i in touching if abs(speeds[i]) <= still]
        if len(meets) > 1 and len(self.rests) > 1:
            self.rests = meets
            return "rock"
        if meets:
            assert len(meets) == 1, [float(speeds[i]) for i in touching]
            self.point = meets[0]
            return "impact"
        if self.rests and world.disc:
            return "rolls"
        if self.rests and world.gn < 0:
            pinned = not world.ball and not self.spans(self.rests)
            return "pinned" if pinned or self.tips() else "on_plane"
        return "fly"

    def rolls(self, end):
        """One step of a disc that rolls."""
        world, state, (rim,) = self.world, self.state, self.rests
        x = plus(state[0:3], world.n, -world.heights(state)[rim])
        rolled, w = Rolled(world, world.body.sides[rim]), world.spin(state)
        n, axis = world.n, [row[2] for row in axes_of(state[6:10])]
        fastest = size(w) / size(cross(axis, n)) + gmpy2.sqrt(size(world.g) / world.reach)
        h = min(mpfr(end - self.now), 1 / fastest)
        self.hold(rolled.bears([*x, *state[6:10], *w]))
        y = rolled.step([*x, *state[6:10], *w], h)
        length = size(y[3:7])
        q = [c / length for c in y[3:7]]
        arm = world.arms([*y[0:3], *state[3:6], *q, *state[10:13]])[rim]
        v = [-c for c in cross(y[7:10], arm)]
        self.state = world.with_spin([*y[0:3], *v, *q, *state[10:13]], y[7:10])
        self.now, self.fresh = end if h == mpfr(end - self.now) else self.now + mpq(h), False

    def hold(self, bears):
        """Fail where friction cannot hold a contact that stays; bears: how much more it can, over the weight."""
        self.bears = bears
        assert bears > -ROUNDED, f"friction does not hold at {float(self.now)} s: {float(bears)}"

    def slips(self, instant):
        """Fail where a contact that stays does not begin to slip at an instant."""
        self.go(instant)
        getattr(self, self.mode())(instant + mpq(1, 10**9))
        assert abs(self.bears) < SLIPS, f"no slip at {float(instant)} s: {float(self.bears)}"

    def still(self, state):
        """The speed that counts as none."""
        speed = size(state[3:6]) + size(self.world.spin(state)) * self.world.reach
        self.fastest = max(self.fastest, speed)
        return ROUNDED * speed if self.fresh else mpfr(10) ** -24 * self.fastest

    def impact(self, end):
        self.state = impact(self.world, self.state, self.world.arms(self.state)[self.point])
        self.fresh = False

    def spans(self, points):
        """Whether some of the points are not on a line."""
        p = [self.world.body.points[i] for i in points]
        sides = [cross(plus(p[1], p[0], -1), plus(c, p[0], -1)) for c in p[2:]] if len(p) > 2 else []
        return any(size(side) > ROUNDED * self.world.reach**2 for side in sides)

    def tips(self):
        """Whether a body at rest on its face tips over an edge of it, which is then what rests."""
        world, state = self.world, self.state
        steep = size(world.gt)
        if world.ball or size(state[3:6]) or size(state[10:13]) or steep > world.mu * -world.gn:
            return False
        arms = world.arms(state)
        down = [c / steep for c in world.gt] if steep else world.n
        furthest = max(dot(arms[i], down) for i in self.rests)
        height = -dot(arms[self.rests[0]], world.n)
        if steep * height <= -world.gn * furthest:
            return False
        self.rests = [i for i in self.rests if dot(arms[i], down) > furthest - ROUNDED * world.reach]
        return True

    def hinge(self):
        """The point about which the body turns, from its centre, along the file's axes."""
        points = [self.world.body.points[i] for i in self.rests]
        middle = [sum(p[i] for p in points) / len(points) for i in range(3)]
        if len(points) == 1:
            return middle
        line = plus(points[1], points[0], -1)
        return plus(middle, line, -dot(middle, line) / dot(line, line))

    def rock(self, end):
        """The impulse that stops the new hinge: three equations, written out and solved."""
        world, state = self.world, self.state
        arm = times(axes_of(state[6:10]), self.hinge())
        inverse, m = world.inverse(state), world.body.mass
        columns = []
        for i in range(3):
            J = [mpfr(int(i == j)) for j in range(3)]
            columns.append(plus([c / m for c in J], cross(times(inverse, cross(arm, J)), arm)))
        u = world.rate(state, arm)
        whole = dot(columns[0], cross(columns[1], columns[2]))
        J = [-dot(u, cross(columns[(i + 1) % 3], columns[(i + 2) % 3])) / whole for i in range(3)]
        w = plus(world.spin(state), times(inverse, cross(arm, J)))
        v = plus(state[3:6], [c / m for c in J])
        self.state = world.with_spin([*state[0:3], *v, *state[6:13]], w)
        self.fresh = False

    def pinned(self, end):
        """One Taylor step of a body that turns about a hinge on the plane, or less, to the landing of another point."""
        world = self.world
        hinge, rests = self.hinge(), list(self.rests)
        if self.fresh and len(rests) > 1:
            self.level(rests)
        R = axes_of(self.state[6:10])
        place = plus(self.state[0:3], times(R, hinge))
        place = plus(place, world.n, -dot(world.n, plus(place, world.o, -1)))
        motion = Hinged(world, self.state, hinge, self.across(rests))
        self.hold(motion.bears)
        h = min(step_length(motion.series, mpfr(10) ** -48), mpfr(end - self.now))
        others = [i for i in range(len(world.body.points)) if i not in rests]
        before = mpfr(0)
        for look in range(1, LOOKS + 1):
            t = h * look / LOOKS
            if self.low(motion, place, t, others) < 0:
                low, high = before, t
                for _ in range(BITS):
                    middle = (low + high) / 2
                    low, high = (low, middle) if self.low(motion, place, middle, others) < 0 else (middle, high)
                h = high
                break
            before = t
        arrived = h == mpfr(end - self.now)
        self.state, self.fresh = motion.at(h, place), False
        self.now = end if arrived else self.now + mpq(h)

    def across(self, points):
        """Gravity without what rounding has left of it along an edge."""
        g = self.world.g
        if len(points) == 1:
            return g
        a, b = (self.world.body.points[i] for i in points[:2])
        line = times(axes_of(self.state[6:10]), plus(b, a, -1))
        return plus(g, line, -dot(g, line) / dot(line, line))

    def level(self, points):
        """Turn the body by what rounding has left so that an edge is level, and it turns about the edge alone."""
        world, state = self.world, self.state
        a, b = (world.body.points[i] for i in points[:2])
        line = times(axes_of(state[6:10]), plus(b, a, -1))
        axis = cross(line, world.n)
        axis = [c / size(axis) for c in axis]
        half = gmpy2.asin(dot(line, world.n) / size(line)) / 2
        turn = [gmpy2.cos(half), *(-c * gmpy2.sin(half) for c in axis)]
        other = [gmpy2.cos(half), *(c * gmpy2.sin(half) for c in axis)]
        turned = [product(each, state[6:10]) for each in (turn, other)]
        best = min(turned, key=lambda q: abs(dot(times(axes_of(q), plus(b, a, -1)), world.n)))
        w = world.spin(state)
        line = [c / size(line) for c in plus(line, world.n, -dot(line, world.n))]
        self.state = world.with_spin([*state[0:6], *best, *state[10:13]], [c * dot(w, line) for c in line])

    def low(self, motion, place, t, others):
        """How high the lowest of the other points is that falls."""
        world, state = self.world, motion.at(t, place)
        heights, arms = world.heights(state), world.arms(state)
        falls = [i for i in others if dot(world.n, world.rate(state, arms[i])) < 0]
        return min((heights[i] for i in falls), default=mpfr(1))

    def fly(self, end):
        """One Taylor step of free flight, or less, to the first contact."""
        world = self.world
        motion = Motion(world.body, world.document, [], self.state)
        h = min(motion.length(), mpfr(end - self.now))
        before = mpfr(0)
        for look in range(LOOKS + 1):
            t = h * look / LOOKS
            state = [series.at(t) for series in motion.state]
            low = min(enumerate(world.heights(state)), key=lambda pair: pair[1])
            if look and low[1] < 0 and dot(world.n, world.rate(state, world.arms(state)[low[0]])) < 0:
                at = self.halved(motion, before, t)
                self.state, self.now, self.fresh = [series.at(at) for series in motion.state], self.now + mpq(at), False
                return
            before = t
        self.state = [series.at(h) for series in motion.state]
        self.now = end if h == mpfr(end - self.now) else self.now + mpq(h)

    def halved(self, motion, low, high):
        world = self.world
        for _ in range(BITS):
            middle = (low + high) / 2
            below = min(world.heights([series.at(middle) for series in motion.state])) < 0
            low, high = (low, middle) if below else (middle, high)
        return high

    def on_plane(self, end):
        """One Taylor step on the plane: slip, or no slip."""
        world = self.world
        state = self.laid()
        w = world.spin(state)
        arm = world.arms(state)[self.rests[0]]
        u = world.rate(state, arm)
        u = plus(u, world.n, -dot(u, world.n))
        still = self.still(state)
        self.fresh = False
        steep = size(world.gt)
        most = (
            world.mu
            * -world.gn
            * (1 + world.body.mass * world.body.radius**2 / world.body.tensor[0][0] if world.ball else 1)
        )
        if size(u) > still and world.mu:
            step = Pushed(world, state, w, "slips")
        elif not world.mu:
            step = Pushed(world, state, w, [mpq(0)] * 3)
        elif steep <= most:
            if world.ball:  # so that what rounding has left of the slip is none
                about = dot(w, world.n)
                w = plus([about * c for c in world.n], [c / world.body.radius for c in cross(world.n, state[3:6])])
            else:
                state = [*state[0:3], mpfr(0), mpfr(0), mpfr(0), *state[6:10], mpfr(0), mpfr(0), mpfr(0)]
                w = [mpfr(0)] * 3
            step = Pushed(world, state, w, "holds")
        else:
            push = world.mu * world.body.mass * world.gn / steep
            step = Pushed(world, state, w, [push * c for c in world.gt])
        h = min(step_length(step.series, mpfr(10) ** -48), mpfr(end - self.now))
        slipping = size(u) > still and bool(world.mu)
        if slipping:
            h = min(h, step.slip / (4 * step.rate))
        after = step.at(h)
        self.now = end if h == mpfr(end - self.now) else self.now + mpq(h)
        self.state = world.with_spin(after[:10] + [mpfr(0)] * 3, after[10:13])

    def laid(self):
        """The state with what touches on the plane, without velocity along the normal."""
        world, state = self.world, self.state
        n = world.n
        if not world.ball and len(self.rests) > 2:
            R = axes_of(state[6:10])
            p = world.body.points
            a, b, c = (p[i] for i in self.rests[:3])
            out = cross(plus(b, a, -1), plus(c, a, -1))
            out = times(R, [x / size(out) for x in out])
            out = out if dot(out, n) < 0 else [-x for x in out]
            axis = cross(out, [-x for x in n])
            # Half the angle between the face and the plane, by the sine alone: it is small.
            sine = size(axis)
            if sine:
                half = gmpy2.asin(sine) / 2
                turn = [gmpy2.cos(half), *(x / sine * gmpy2.sin(half) for x in axis)]
                state = [*state[0:6], *product(turn, state[6:10]), *state[10:13]]
                state = world.with_spin(state, world.spin(self.state))
        low = world.heights(state)
        mean = sum(low[i] for i in self.rests) / len(self.rests)
        v = plus(state[3:6], n, -dot(state[3:6], n))
        if not world.ball:
            w = world.spin(state)
            state = world.with_spin(state, [dot(w, n) * c for c in n] if not world.mu else [mpfr(0)] * 3)
        return [*plus(state[0:3], n, -mean), *v, *state[6:13]]


def product(p, q):
    """Hamilton's product."""
    a, b, c, d = p
    w, x, y, z = q
    return [
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x,
        a * z + b * y - c * x + d * w,
    ]


def worst(path, true, reached=None):
    """Of a truth's rows within its horizon: how far a point is off [m] over the bound, and how far, at the worst.

    Fails where a truth ends because a point begins to slip, and friction holds it then.
    """
    instants = true.times[: true.known][:reached]
    with gmpy2.context(precision=BITS):
        document = tomllib.loads(Path(path).read_text(encoding="utf-8"))
        course = Course(World(document), document)
        rows = course.rows([mpq(float(time)) for time in instants])
        ratio, most = 0.0, 0.0
        for row, exact in enumerate(rows):
            for point, told in zip(exact, true.vertices[row, 0], strict=True):
                off = float(size(plus(point, [mpfr(float(c)) for c in told], -1)))
                ratio, most = max(ratio, off / float(true.bound[row, 0])), max(most, off)
        record = true.contacts[0]
        if reached is None and "begins to slip" in record.why:
            course.slips(mpq(record.ended_s))
        return ratio, most
