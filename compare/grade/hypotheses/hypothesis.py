"""A hypothesis: a mistake, how it changes the model of a correct program, the value that is fitted, and its text."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Protocol

import numpy as np

from tumble.compare.grade.model.kernel.stepping import MOST_STEPS
from tumble.compare.grade.model.program_model import FINE, ProgramModel
from tumble.compare.grade.read.digits import vector_text
from tumble.scenarios.frames import Array
from tumble.scenarios.scene import Scene

# Usual steps of programs [s].
STEPS = {
    1 / 30: "1/30 s", 0.02: "1/50 s", 1 / 60: "1/60 s", 0.01: "1/100 s", 1 / 120: "1/120 s",
    0.005: "1/200 s", 1 / 240: "1/240 s", 0.002: "1/500 s", 0.001: "1/1000 s",
    0.0005: "1/2000 s",
}  # fmt: skip
# Instants at which the largest speeds are sought.
PROBES = 64
# Relative tolerance for treating two step sizes as equal.
NEAR = 1e-4
# Numbers of rows that a tick may last.
TICKS = (2, 3, 4, 5, 8, 10)
# Steps in a row interval: most programs log every step, but a log can be sparse.
MOST_A_ROW = 400
PARTS = {
    1: "one step a row", 2: "two steps a row", 3: "three steps a row", 4: "four steps a row", 5: "five steps a row",
    8: "eight steps a row", 10: "ten steps a row", 20: "20 steps a row",
}  # fmt: skip


# A value of a mistake: a number, or several that are fitted together.
Value = float | tuple[float, ...]


class Change(Protocol):
    """Returns the model of a program with the mistake; value: fitted or chosen, 0 if there is none."""

    def __call__(self, program: ProgramModel, value: Any, /) -> ProgramModel: ...  # noqa: D102


@dataclass(frozen=True, eq=False)
class Context:
    """What hypotheses know of the scene and the file.

    program: model of a correct program; kind: what the file has, pose, matrix or vertices; rows: their number;
    duration: up to the last row [s]; turn_s: shortest time in which the body rotates by a radian [s]; spacing_s: of
    most rows; first: x [m] and q of the row at t = 0, (7,), if there is one; has_centre: the file has the position;
    offset: constant offset of the position, body axes [m], (3,), if there is one; fineness: largest rotation in a
    continuous step that is as good as exact [rad].
    """

    scene: Scene
    program: ProgramModel
    kind: str
    rows: int
    duration: float
    turn_s: float
    spacing_s: float
    first: Array | None = None
    has_centre: bool = True
    offset: Array | None = None
    fineness: float = FINE

    @cached_property
    def probes(self) -> Array:
        """Rows of a correct program at PROBES instants, (PROBES, 22), as `ProgramModel.simulate` has them."""
        return self.program.simulate(np.linspace(0.0, self.duration, PROBES))

    @property
    def speeds(self) -> tuple[Array, Array]:
        """The velocity of the centre [m/s] and the angular velocity [rad/s] at these instants, (PROBES,)."""
        v, w = (np.linalg.norm(self.probes[:, columns], axis=1) for columns in (slice(12, 15), slice(15, 18)))
        return v, w

    @property
    def up_from_below(self) -> Array | None:
        """The direction against gravity, (3,); None if the centre is at no negative height, or the file has none."""
        gravity = self.program.gravity
        size = float(np.linalg.norm(gravity))
        if not size or not self.has_centre:
            return None
        up = -gravity / size
        return up if (self.probes[:, 0:3] @ up).min() < 0.0 else None

    @cached_property
    def ticks(self) -> dict[float, str]:
        """Steps that are longer than a row interval: usual ones, and multiples of the interval."""
        rows = {number * self.spacing_s: f"{number} rows" for number in TICKS}
        return {step: name for step, name in STEPS.items() if step > self.spacing_s * (1 + NEAR)} | rows

    @cached_property
    def parts(self) -> list[float]:
        """Steps that divide the row interval [s]: the interval, parts of it, and usual steps.

        Steps that are too short to be simulated are left out.
        """
        steps = self.steps
        counts = {step: self.spacing_s / step for step in steps if self.duration <= MOST_STEPS * step}
        return [
            step
            for step, count in counts.items()
            if steps[step] in PARTS.values() or (count <= MOST_A_ROW and abs(count - round(count)) < NEAR * count)
        ]

    @cached_property
    def steps(self) -> dict[float, str]:
        """Parts of the row interval, then usual steps [s]."""
        spacing = next((step for step in STEPS if abs(step - self.spacing_s) < NEAR * step), self.spacing_s)
        parts = {spacing / part: name for part, name in PARTS.items()}
        return parts | {step: name for step, name in STEPS.items() if all(abs(step - h) > NEAR * h for h in parts)}


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """A mistake.

    name: for tables; variants of a mistake share it.  part: of the program, which has at most one mistake a part.
    text: for people, with a place for the value.  change: makes the mistake.  values: tried first; () if there is no
    value.  choices: names of the values; no others are possible.  named_values: values with a name, which cost little.
    only_named: no other values are possible.  unit: of the value.  details: further parameters for tables.  from_data:
    numbers that were taken from the file itself; value: these numbers, for tables.  scale: if the value is several
    numbers, which begin at 0, what they are compared with. at_ticks: a time that takes effect at a tick of a program in
    steps.  neutral: the value that changes nothing, if a small deviation from it has an effect in proportion.
    unlikely: weight that it costs to assume it, beyond others. vague: it explains a part of almost any error; measured:
    rows show its value, whatever else is wrong.
    needs_steps: without steps it is the same as another one.  limits: which of `measure.speeds.SPEEDS`.
    """

    name: str
    part: str
    text: str
    change: Change
    values: tuple[Any, ...] = ()
    choices: tuple[str, ...] = ()
    named_values: dict[float, str] = field(default_factory=dict)
    only_named: bool = False
    unit: str = ""
    details: tuple[tuple[str, str], ...] = ()
    from_data: int = 0
    value: tuple[float, ...] = ()
    scale: float = 0.0
    at_ticks: bool = False
    neutral: float | None = None
    unlikely: float = 0.0
    vague: bool = False
    measured: bool = False
    needs_steps: bool = False
    limits: str = ""

    @cached_property
    def dimension(self) -> int:
        """How many numbers its value is, if it is fitted."""
        return len(self.values[0]) if self.scale else 1  # type: ignore[arg-type]

    @cached_property
    def fitted(self) -> bool:
        """Whether it has a value that may be any between the first ones."""
        return bool(self.values) and not self.choices and not self.only_named

    @cached_property
    def bounds(self) -> tuple[float, float]:
        """The smallest and the largest value, apart from named ones."""
        values = self.values if self.neutral is None else (*self.values, self.neutral)
        return min(values), max(values)

    def text_with(self, value: Any) -> str:
        """Return the text with a value."""
        if self.scale:
            return self.text.format(vector_text(value))
        if self.choices:
            return self.text.format(self.choices[int(value)])
        named = f" ({self.named_values[value]})" if self.named_values.get(value) else ""
        return self.text.format(figures(value)) + named


def figures(value: float) -> str:
    """Return a number in four significant digits, or as many as distinguish it from 1."""
    from_one = abs(value - 1)
    enough = 4 if from_one == 0 or from_one > 1e-2 else 3 - int(np.floor(np.log10(from_one)))
    return f"{value:.{min(enough, 12)}g}"


def grid(low: float, high: float, count: int) -> tuple[float, ...]:
    """Return a geometric sequence from low > 0 to high."""
    return tuple(np.geomspace(low, high, count).tolist())


def choice(count: int) -> tuple[float, ...]:
    """Return the values of a choice among this many."""
    return tuple(float(number) for number in range(count))
