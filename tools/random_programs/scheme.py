"""The scheme of a program, a point of a product, and how it is drawn."""

from dataclasses import dataclass

import numpy as np

from tools.random_programs.gyroscopic import SCHEMES
from tools.random_programs.turning import TURNINGS

# Runge-Kutta methods of the whole state: stages and weights.
TABLEAUS: dict[str, tuple[tuple[tuple[float, ...], ...], tuple[float, ...]]] = {
    "explicit Euler": (((),), (1.0,)),
    "midpoint": (((), (0.5,)), (0.0, 1.0)),
    "Heun": (((), (1.0,)), (0.5, 0.5)),
    "Ralston": (((), (2 / 3,)), (0.25, 0.75)),
    "order 3": (((), (0.5,), (-1.0, 2.0)), (1 / 6, 2 / 3, 1 / 6)),
    "order 3, Shu and Osher": (((), (1.0,), (0.25, 0.25)), (1 / 6, 1 / 6, 2 / 3)),
    "order 4": (((), (0.5,), (0.0, 0.5), (0.0, 0.0, 1.0)), (1 / 6, 1 / 3, 1 / 3, 1 / 6)),
    "order 4, three eighths": (((), (1 / 3,), (-1 / 3, 1.0), (1.0, -1.0, 1.0)), (1 / 8, 3 / 8, 3 / 8, 1 / 8)),
}
SPLIT, VERLET = "split", "Verlet"
# The quaternion q of a stage is not of length 1: R is of q/|q|, but q' of q; both are of q/|q|; both are of q, R by the
# formula for unit quaternions, with the inverse of R I R^T or with R I^-1 R^T.  The methods that are drawn with them.
UNIT_IN_R, NORMALISED, RAW, RAW_INVERSE = "unit in R", "normalised", "raw", "raw, R I^-1 R^T"
STAGED = ("order 4", "midpoint", "Heun")


@dataclass(frozen=True)
class Damping:
    """Rates [1/s] of v and w; where in the step: before the forces, between them and the move, after the move; how."""

    linear: float = 0.0
    angular: float = 0.0
    where: str = "between"  # before, after
    how: str = "1 - c dt"  # exp, 1/(1 + c dt)

    def factor(self, rate: float, dt: float) -> float:
        """Return what a velocity is multiplied by in a step [s]."""
        by = rate * dt
        if self.how == "exp":
            return float(np.exp(-by))
        return 1 - by if self.how == "1 - c dt" else 1 / (1 + by)


@dataclass(frozen=True)
class Reading:
    """How rows are read from ticks: each as it is, a tick late or early, held or interpolated between ticks.

    late: ticks; between: "" where each row is a tick, else held, straight (the quaternion as well), arcs, ahead (by the
    velocities of the last tick), or smooth, which is not one that programs have: what a tick costs is seen by it.
    """

    late: int = 0
    between: str = ""


@dataclass(frozen=True)
class Scheme:
    """What a program does in a step, and how its rows are read.

    dt: from tick to tick [s], of so many substeps; every: ticks from row to row where rows are ticks; spacing: of rows
    [s]; method: split steps of an engine, velocity Verlet, or a Runge-Kutta method of the whole state; keeps: w in
    world or body axes, or the angular momentum; moves: x by the new velocity, the old one, or a parabola, and q by the
    new w, or the old one ("old, all" with x, "old turn" without); normalises: q every so many steps, 0 never; centre:
    parts of a step in which v and x are stepped; idle: ticks without gravity; asleep: ticks in which nothing moves;
    velocity: of the centre, in world or body axes, and then along a screw or not; recovers: w is taken from the
    difference of attitudes at a step's end; stages: of a Runge-Kutta method, the quaternions in them.
    """

    dt: float
    spacing: float
    method: str = SPLIT
    gyroscopic: str = "rescaled"
    turning: str = "exponential"
    damping: Damping = Damping()
    reading: Reading = Reading()
    keeps: str = "world"
    moves: str = "new"
    substeps: int = 1
    centre: int = 1
    normalises: int = 1
    idle: int = 0
    asleep: int = 0
    velocity: str = "world"
    recovers: bool = False
    stages: str = UNIT_IN_R
    single: bool = False

    @property
    def step(self) -> float:
        """The length of a substep [s]."""
        return self.dt / self.substeps

    @property
    def every(self) -> int:
        """Ticks from row to row; 0 where rows lie between ticks."""
        return 0 if self.reading.between else round(self.spacing / self.dt)


TICK_RATES = (50, 60, 100, 120)
RATES = (30, 50, 60, 60, 72, 90, 100, 120, 120, 144, 200, 240, 250, 500)
ROW_RATES = (24, 25, 30, 40, 50, 60, 75, 90, 100, 120, 144, 240)
DAMPING_RATES = (0.01, 0.02, 0.05, 0.05, 0.1, 0.1, 0.2, 0.3, 0.5, 1.0)
# A drawn program takes no more steps than this, and its file has no more rows and no fewer.
MOST_STEPS, MOST_ROWS, FEWEST_ROWS = 5000, 1000, 20
FINE_RATES = (500, 1000, 2000)
TRIED = 100


def drawn(random: np.random.Generator, duration: float) -> Scheme | None:
    """Return a scheme of an engine, of a game or of a student; None where none that was drawn fits the duration."""
    for _ in range(TRIED):
        scheme = _drawn(random)
        if _fits(scheme, duration):
            return scheme
    return None


def _fits(scheme: Scheme, duration: float) -> bool:
    rows = duration / scheme.spacing
    return duration / scheme.step <= MOST_STEPS and FEWEST_ROWS <= rows <= MOST_ROWS


def fine(random: np.random.Generator, duration: float) -> Scheme | None:
    """Return a scheme whose own error few digits show: order 4, small steps; None where none fits the duration."""
    for _ in range(TRIED):
        rate = int(random.choice(FINE_RATES))
        every = int(random.choice((5, 10, 20, 25, 50)))
        keeps = str(random.choice(("world", "body", "momentum")))
        scheme = Scheme(1 / rate, every / rate, "order 4", keeps=keeps, single=bool(random.random() < 0.1))
        if _fits(scheme, duration):
            return scheme
    return None


def _drawn(random: np.random.Generator) -> Scheme:
    choose = random.choice
    dt = 1 / int(choose(RATES))
    single = bool(random.random() < 0.4)
    reading, spacing = _reading(random, dt)
    if reading.between:
        dt = 1 / int(choose(TICK_RATES))
    if random.random() < 0.22:
        method = str(choose((VERLET, *TABLEAUS)))
        keeps = str(choose(("world", "body", "momentum")))
        normalises = int(choose((1, 1, 1, 0, 10))) if method == "explicit Euler" else 1
        is_leapfrog = method == VERLET and keeps == "momentum"
        return Scheme(
            dt,
            spacing,
            method,
            turning=str(choose(("exponential", "first order"))) if is_leapfrog else "exponential",
            reading=reading,
            keeps=keeps,
            normalises=normalises,
            stages=_stages(random, method, keeps),
            single=single,
        )
    damping = Damping()
    if random.random() < 0.45:
        linear = float(choose(DAMPING_RATES)) if random.random() < 0.6 else 0.0
        angular = float(choose(DAMPING_RATES)) if random.random() < 0.8 or not linear else 0.0
        where = str(choose(("before", "between", "between", "after")))
        damping = Damping(linear, angular, where, str(choose(("1 - c dt", "1 - c dt", "exp", "1/(1 + c dt)"))))
    names = list(SCHEMES)
    weights = np.array([6.0 if name in ("none", "explicit", "implicit", "rescaled") else 1.0 for name in names])
    turnings = list(TURNINGS)
    heavy = np.array([10.0 if name in ("exponential", "first order") else 1.0 for name in turnings])
    turning = str(choose(turnings, p=heavy / heavy.sum()))
    rare = random.random()
    return Scheme(
        dt,
        spacing,
        SPLIT,
        str(choose(names, p=weights / weights.sum())),
        turning,
        damping,
        reading,
        keeps=str(choose(("world", "world", "body", "momentum"))),
        moves=str(choose(("new", "old", "old, all", "parabola"), p=(0.79, 0.07, 0.07, 0.07))),
        substeps=int(choose((1, 1, 1, 1, 2, 4, 8))),
        centre=4 if rare < 0.05 else 1,
        normalises=int(choose((1, 1, 1, 1, 1, 1, 0, 20))) if turning == "first order" else 1,
        idle=int(choose((1, 1, 2))) if 0.05 < rare < 0.13 else 0,
        asleep=int(choose((1, 2, 5))) if 0.13 < rare < 0.17 else 0,
        velocity=str(choose(("body", "screw"))) if 0.17 < rare < 0.25 else "world",
        recovers=bool(0.25 < rare < 0.29),
        single=single,
    )


def _stages(random: np.random.Generator, method: str, keeps: str) -> str:
    """Return what becomes of the quaternions of a method's stages."""
    if method not in STAGED or random.random() < 0.5:
        return UNIT_IN_R
    return NORMALISED if keeps == "body" else str(random.choice((NORMALISED, RAW, RAW_INVERSE)))


def _reading(random: np.random.Generator, dt: float) -> tuple[Reading, float]:
    """Return how rows are read, and how far they are apart [s]."""
    kind = random.random()
    if kind < 0.2:
        between = str(random.choice(("held", "straight", "arcs", "ahead")))
        late = 1 if between != "ahead" and random.random() < 0.5 else 0
        return Reading(late, between), 1 / int(random.choice(ROW_RATES))
    late = int(random.choice((1, 1, 1, 2, -1))) if kind < 0.35 else 0
    return Reading(late), int(random.choice((1, 1, 1, 1, 2, 4, 5, 10))) * dt
