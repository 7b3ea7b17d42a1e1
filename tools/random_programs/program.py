"""A program, its file of one scene, and what is true of it: its scheme, its mistakes, and what of them can be seen."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np

from tools.random_programs import dialect, drawn_scenes, measurement, scheme
from tools.random_programs.dialect import VERTICES, Dialect
from tools.random_programs.mistakes import KINDS, PER_STEP, Params
from tools.random_programs.reference import reference
from tools.random_programs.scene import Scene
from tools.random_programs.scheme import SPLIT, Reading, Scheme
from tools.random_programs.simulation import BlownUp, Rows, Simulation

# An effect is as large as in the row in which it is third largest: one row can be a slip.
ROW = 3
# Rounding in single precision is seen once, and could have been larger; every number is rounded at least once.
SINGLE, EPSILON = 3.0, 2.0**-24
# A step is seen by one that is so much shorter.
FINER = 8
# Numbers are doubles in the end: of the body and its distance.
DOUBLE = 1e-15


@dataclass(frozen=True)
class Limits:
    """How many times the noise of its file an effect is, at least: to be seen at all, and to have a name to be found.

    same: a program whose file is nearer than this writes the same one; value: of an effect, what its values are off by.
    """

    seen: float
    significant: float
    same: float
    value: float


# Digits bound what they move; of measurements the root mean square counts, and rows together show less than each.
DIGITS, MEASUREMENT = Limits(3.0, 10.0, 10.0, 5.0), Limits(0.1, 3.0, 0.5, 1.0)


@dataclass(frozen=True)
class Planted:
    """One mistake of a program."""

    label: str
    params: Params = field(default_factory=dict)

    def __str__(self) -> str:
        values = ", ".join(f"{name} {_short(value)}" for name, value in self.params.items() if name != "seed")
        return f"{self.label} ({values})" if values else self.label


@dataclass(frozen=True)
class Program:
    """A scheme and the mistakes that are made upon it."""

    scheme: Scheme
    planted: tuple[Planted, ...] = ()

    def rows(self, scene: Scene, number: type | None = None) -> Rows:
        """Return what it writes of a scene, in its own precision unless another is given.  Raises BlownUp."""
        sim = Simulation(scene, self.scheme, number or (np.float32 if self.scheme.single else float))
        for planted in self.planted:
            KINDS[planted.label].plant(sim, **planted.params)
        return sim.rows()

    def with_scheme(self, **changes: object) -> "Program":
        """Return the program with another scheme."""
        return replace(self, scheme=replace(self.scheme, **changes))  # type: ignore[arg-type]


class Writes(Protocol):
    """Whatever writes rows of a scene."""

    def rows(self, scene: Scene, /) -> Rows:
        """Return them.  Raises BlownUp."""
        ...


@dataclass(frozen=True)
class Fact:
    """Something that is true of a program and not right; effect: over the noise of its file."""

    label: str
    params: Params
    effect: float
    mistake: bool = False

    def __str__(self) -> str:
        return f"{Planted(self.label, self.params)}: {self.effect:.3g}"


@dataclass(frozen=True)
class Case:
    """A program, the scene that it simulates and the file that it writes.

    noise: standard deviation of what a measurement adds, over the body's size; 0 where the rows are not measured.
    """

    number: int
    seed: int
    scene: Scene
    program: Program
    dialect: Dialect
    noise: float = 0.0

    @property
    def limits(self) -> Limits:
        """Which effects count in the file."""
        return MEASUREMENT if self.noise else DIGITS

    def text(self, rows: Rows) -> str:
        """Return the file of the program's rows, with the noise of their measurement."""
        if self.noise:
            random = np.random.default_rng((self.seed, self.number, 1))
            rows = measurement.measured(rows, self.scene, self.noise, self.dialect.kind == VERTICES, random)
        return self.dialect.text(rows)

    @property
    def random(self) -> np.random.Generator:
        """Numbers that belong to this case alone."""
        return np.random.default_rng((self.seed, self.number))


@dataclass(frozen=True)
class Truth:
    """What is true of a file: its rows, the noise of each [m], how far off it is over that, and why."""

    rows: Rows
    noise_m: np.ndarray
    error: float
    error_m: float
    facts: tuple[Fact, ...]
    limits: Limits = DIGITS

    @property
    def significant(self) -> tuple[Fact, ...]:
        """Facts that a reader of the file can be expected to find."""
        return tuple(fact for fact in self.facts if fact.effect >= self.limits.significant)


# --- what is true ---------------------------------------------------------------------------------------------------


def truth_of(case: Case) -> Truth:
    """Return what is true of a case.  Raises BlownUp."""
    rows = case.program.rows(case.scene)
    noise = noise_of(case, rows)
    right = reference(case.scene, rows.t)
    apart = distances(case, rows, right)
    error = effect(case, apart, noise)
    return Truth(rows, noise, error, float(apart.max()), tuple(_facts(case, rows, noise)), case.limits)


def noise_of(case: Case, rows: Rows) -> np.ndarray:
    """Return how far digits, precision and measurement may have moved each row's vertices [m], (n,)."""
    sizes = np.abs(rows.x).max(axis=1) + case.scene.reach
    noise = case.dialect.noise(rows, case.scene) + DOUBLE * sizes
    if case.program.scheme.single:
        double = case.program.rows(case.scene, float)
        moved = np.maximum.accumulate(distances(case, rows, double).max(axis=1))
        noise = noise + SINGLE * (moved + EPSILON * sizes)
    if case.noise:
        noise = noise + measurement.moved_m(case.scene, case.noise, case.dialect.kind == VERTICES)
    return noise


def distances(case: Case, one: Rows, other: Rows) -> np.ndarray:
    """Return how far apart the vertices of two files are in each row [m], as far as both go, (n, k)."""
    count = min(len(one.t), len(other.t))
    a, b = (case.dialect.seen(rows, case.scene)[:count] for rows in (one, other))
    return np.linalg.norm(a - b, axis=2)


def effect(case: Case, apart: np.ndarray, noise: np.ndarray) -> float:
    """Return how large distances are over noise: in the row in which they are third largest, or root mean square."""
    ratio = apart / noise[: len(apart), None]
    if case.noise:
        return float(np.sqrt(np.square(ratio).mean()))
    largest = np.sort(ratio.max(axis=1))
    return float(largest[-min(ROW, len(largest))])


def apart_from(case: Case, other: Writes, rows: Rows, noise: np.ndarray) -> float:
    """Return the distance of a file from another program's, over noise; inf if that program diverges."""
    try:
        return effect(case, distances(case, rows, other.rows(case.scene)), noise)
    except BlownUp:
        return float("inf")


def _facts(case: Case, rows: Rows, noise: np.ndarray) -> Iterator[Fact]:
    """Yield what is true of a program, each with what is different where it alone is right."""
    program = case.program
    smooth = replace(program, planted=tuple(p for p in program.planted if p.label not in PER_STEP))
    for label, params, neutral in scheme_parts(program.scheme):
        # A mistake that is made once a step would be made otherwise in shorter steps.
        if label == "step" and smooth is not program:
            try:
                clean = smooth.rows(case.scene)
            except BlownUp:
                continue
            size = apart_from(case, neutral(smooth), clean, noise)
        else:
            size = apart_from(case, neutral(program), rows, noise)
        yield Fact(label, params, size)
    for number, planted in enumerate(program.planted):
        without = replace(program, planted=program.planted[:number] + program.planted[number + 1 :])
        yield Fact(planted.label, planted.params, apart_from(case, without, rows, noise), True)


Neutral = Callable[[Program], Program]


def scheme_parts(own: Scheme) -> Iterator[tuple[str, Params, Neutral]]:
    """Yield each part of a scheme that is not right: its label, its numbers, and what makes it right."""
    damping, reading = own.damping, own.reading
    if own.method == SPLIT and own.gyroscopic == "none":
        yield "gyroscopic term missing", {}, lambda p: p.with_scheme(gyroscopic="order 4")
    for label, rate in (("linear damping", damping.linear), ("angular damping", damping.angular)):
        if rate:
            kind = label.split()[0]
            params: Params = {"rate": rate, "where": damping.where, "how": damping.how}
            yield label, params, lambda p, kind=kind: p.with_scheme(damping=replace(p.scheme.damping, **{kind: 0.0}))
    if reading.late:
        time = reading.late * own.dt
        yield (
            "rows late",
            {"time": time, "tick": own.dt},
            lambda p: p.with_scheme(reading=Reading(0, p.scheme.reading.between)),
        )
    if reading.between:
        params = {"how": reading.between, "tick": own.dt, "late": reading.late}
        yield "rows between ticks", params, lambda p: p.with_scheme(reading=Reading(p.scheme.reading.late, "smooth"))
    if own.idle:
        yield "gravity idle", {"time": own.idle * own.dt}, lambda p: p.with_scheme(idle=0)
    if own.asleep:
        yield "asleep at first", {"time": own.asleep * own.dt}, lambda p: p.with_scheme(asleep=0)
    if own.velocity != "world":
        yield "velocity in body axes", {"how": own.velocity}, lambda p: p.with_scheme(velocity="world")
    if own.recovers:
        yield "spin of the difference of attitudes", {}, lambda p: p.with_scheme(recovers=False)
    if own.normalises != 1:
        yield "normalised", {"every": own.normalises}, lambda p: p.with_scheme(normalises=1)
    if own.centre > 1 and own.moves == "new":
        yield "centre in substeps", {"substeps": own.centre}, lambda p: p.with_scheme(centre=1)
    if own.method == SPLIT and own.moves in ("old", "parabola"):
        yield "another step of x", {"moves": own.moves}, lambda p: p.with_scheme(moves="new")
    params = {"step": own.step, "method": own.method, "stages": own.stages}
    if own.method == SPLIT:
        # A program that keeps the angular momentum takes no gyroscopic term.
        kept = own.keeps == "momentum" and own.gyroscopic != "none"
        gyroscopic = "momentum" if kept else own.gyroscopic
        params |= {"gyroscopic": gyroscopic, "turning": own.turning, "moves": own.moves}
    yield "step", params, _finer


def _finer(program: Program) -> Program:
    own = program.scheme
    return program.with_scheme(
        substeps=FINER * own.substeps,
        normalises=FINER * own.normalises if own.normalises > 1 else own.normalises,
    )


# --- how cases are drawn --------------------------------------------------------------------------------------------

CATALOGUE = (
    "brick-tumble", "die-straight", "die-vertex", "drag-stiff", "dzhanibekov", "nesc-brick", "spin-fast", "table-4-1",
    "two-hits", "yardstick",
)  # fmt: skip
FROM_CATALOGUE = 0.35
# Of programs: right, engines without a mistake, one mistake, two; upon a scheme that is as good as right.
NONE, ENGINE, TWO, FINE = 0.08, 0.22, 0.16, 0.45
TRIED = 60


def drawn(number: int, seed: int, catalogue: dict[str, Scene]) -> tuple[Case, Truth]:
    """Return a case of a seed, and what is true of it."""
    case = Case(number, seed, next(iter(catalogue.values())), Program(Scheme(1.0, 1.0)), Dialect())
    random = case.random
    while True:
        scene = _scene(random, catalogue)
        try:
            program = _program(random, scene)
        except NotHere:
            continue
        written = dialect.drawn(random, scene)
        noise = measurement.drawn(random)
        if noise:  # poses and vertices are what is measured
            written = replace(written, velocities=False)
        case = replace(case, scene=scene, program=program, dialect=written, noise=noise)
        try:
            return case, truth_of(case)
        except BlownUp:
            continue


class NotHere(Exception):
    """No scheme or mistake can be had in this scene."""


def _scene(random: np.random.Generator, catalogue: dict[str, Scene]) -> Scene:
    if random.random() >= FROM_CATALOGUE:
        return drawn_scenes.drawn(random)
    scene = catalogue[str(random.choice(list(catalogue)))]
    longest = float(random.choice((2.0, 5.0, 10.0)))
    return replace(scene, duration=min(scene.duration, longest))


def _program(random: np.random.Generator, scene: Scene) -> Program:
    kind = random.random()
    if kind < NONE:
        return Program(_scheme(random, scene, fine=True))
    if kind < NONE + ENGINE:
        return Program(_scheme(random, scene, fine=False))
    own = _scheme(random, scene, fine=bool(random.random() < FINE))
    first = _mistake(random, scene, own, set())
    if random.random() < TWO / (1 - NONE - ENGINE):
        second = _mistake(random, scene, own, {KINDS[first.label].part})
        # In the order of a program: impulses, motion and rotation before output.
        order = list(KINDS)
        return Program(own, tuple(sorted((first, second), key=lambda planted: order.index(planted.label))))
    return Program(own, (first,))


def _scheme(random: np.random.Generator, scene: Scene, fine: bool) -> Scheme:
    own = (scheme.fine if fine else scheme.drawn)(random, scene.duration)
    if own is None:
        raise NotHere
    return own


def _mistake(random: np.random.Generator, scene: Scene, own: Scheme, taken: set[str]) -> Planted:
    """Return a mistake that can be made; of all kinds as often, where they can."""
    for _ in range(TRIED):
        kind = list(KINDS.values())[int(random.integers(len(KINDS)))]
        if kind.part not in taken and kind.where(scene, own):
            return Planted(kind.label, kind.drawn(random, scene, own))
    raise NotHere


def _short(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
