"""Schemes of engines as mistakes: hypotheses that the search knows, with the engine's values."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from tumble.compare.grade.hypotheses.engine_schemes import (
    DAMPING_FORMS,
    DAMPING_PLACES,
    GYROSCOPIC,
    ROTATION,
    Damping,
    SteppedScheme,
)
from tumble.compare.grade.hypotheses.explanation import Mistake, Mistakes
from tumble.compare.grade.hypotheses.hypothesis import NEAR, Context, Hypothesis
from tumble.compare.grade.hypotheses.mistakes.forces import BULLET_KINDS, RATES, beside_drag, damped, damping_rates
from tumble.compare.grade.hypotheses.mistakes.rotation import gyroscopic_term_missing
from tumble.compare.grade.hypotheses.mistakes.steps import velocity_in_body_axes
from tumble.compare.grade.hypotheses.names import (
    CLOCK_RATE,
    EXPLICIT_EULER,
    GRAVITY_DELAYED,
    IMPULSE_OVER_ONE_STEP,
    LOG_LAG,
    NEVER_NORMALISED,
    PYBULLET_DAMPING,
    SPIN_CAP,
    SYMPLECTIC_EULER,
)
from tumble.compare.grade.model.kernel.dynamics import (
    AS_FORCE,
    CAP_WHEN_SET,
    IN_BODY,
    IN_WORLD,
    IN_WORLD_AXES,
    MOMENTUM,
    Scheme,
)
from tumble.compare.grade.model.kernel.reading import SLERP
from tumble.compare.grade.model.program_model import Clock, ImpulseApplication, ProgramModel

# Parts of steps that engines and textbooks have, and the weight that it costs to assume another one.
USUAL = frozenset(
    {"", "none", "explicit", "implicit", "rescaled", "momentum", "midpoint", "backward", "exponential", "first order"}
)
UNUSUAL, LIKELY = 4.0, 1.0
# Parts of steps that rotate the body about another axis than the stored angular velocity: it matters whether its
# components in world axes or in body axes stay then.  Rotations of the matrix are those of programs with world axes.
TURNED_ASIDE = frozenset({"midpoint", "gram-schmidt", "axis by axis"})
OF_THE_MATRIX = frozenset({"gram-schmidt", "axis by axis"})


@dataclass(frozen=True)
class Step:
    """A step of Euler's methods: w is stepped first, and rotates the attitude; if explicit, the old w does.

    gyroscopic, rotation: keys of `engine_schemes.GYROSCOPIC` and `ROTATION`, "" for a detail without an effect;
    substeps: that move the centre; normalise_every: steps, 0 for never; other_axes: the angular velocity is not stored
    in the axes that are usual with the rotation, world axes with a matrix and otherwise body axes; steps_a_tick: steps
    from one instant to the next at which events happen; is_unit_used: q is normalised where it rotates a lever.
    """

    gyroscopic: str
    rotation: str
    substeps: int = 1
    normalise_every: int = 1
    other_axes: bool = False
    steps_a_tick: int = 1
    explicit: bool = False
    is_unit_used: bool = False

    @property
    def stored(self) -> int:
        """What is stored of the rotation: a constant of the kernel."""
        if self.gyroscopic == "momentum":
            return MOMENTUM
        return IN_WORLD if (self.rotation in OF_THE_MATRIX) != self.other_axes else IN_BODY


class SchemeHypotheses:
    """Converts schemes to mistakes; equal parts of schemes give identical hypotheses."""

    def __init__(self, context: Context) -> None:
        self._context, self._made = context, dict[tuple, Hypothesis]()
        self._steps: dict[Hypothesis, Step] = {}
        self._equal = float(np.ptp(context.program.moments)) == 0.0

    def mistakes(self, stepped: SteppedScheme, fitted: bool = False) -> Mistakes:
        """Return the differences of a scheme from a correct program; fitted: its damping rates are to be fitted."""
        scheme, found = stepped.scheme, []
        if stepped.impulse_as_force:
            found.append(Mistake(self._of(_impulse_as_force, ()), stepped.step))
        if scheme.idle_steps:
            found.append(Mistake(self._of(_gravity_delayed, (scheme.idle_steps,)), stepped.step))
        if (cap := scheme.cap(stepped.step)) and cap * self._context.turn_s < 1:
            found.append(Mistake(self._of(_spin_cap, ()), cap))
        duration = self._context.duration if fitted else 0.0
        found += [
            Mistake(self._of(_damping, (*key, duration, beside_drag(self._context.scene, key[0]))), rate)
            for key, rate in _dampings(scheme.damping)
        ]
        if scheme.gyroscopic == "none" and not self._equal:
            found.append(Mistake(self._of(gyroscopic_term_missing, ())))
        normalise_every = 0 if scheme.unnormalised else 1
        step = self.step(Step(scheme.gyroscopic, scheme.rotation, scheme.position_substeps, normalise_every))
        found.append(Mistake(step, stepped.step))
        if scheme.velocity_axes != IN_WORLD_AXES:
            found.append(Mistake(self._of(velocity_in_body_axes, (scheme.velocity_axes,))))
        spacing = self._context.spacing_s
        if scheme.step and not scheme.interpolated and abs(scheme.step - spacing) > NEAR * spacing:
            found.append(Mistake(self._of(_own_step, ()), scheme.step / spacing))
        ticks = scheme.late + stepped.late
        if scheme.interpolated:
            found.append(Mistake(self._of(_interpolated, (ticks,)), stepped.step))
        elif ticks:
            late = abs(ticks * (stepped.step if scheme.step else spacing))
            found.append(Mistake(self._of(_late, (1 if ticks > 0 else -1,)), late))
        return tuple(found)

    def gyroscopic_term_missing(self) -> Mistake:
        """Return that the gyroscopic term is missing."""
        return Mistake(self._of(gyroscopic_term_missing, ()))

    def damping(self, kind: str, place: int, form: int) -> Hypothesis:
        """Return linear or angular damping at a place in the step, whose rate is fitted."""
        where = beside_drag(self._context.scene, kind)
        return self._of(_damping, (kind, place, form, self._context.duration, where))

    def late(self, ticks: int) -> Mistake:
        """Return rows that are late by so many row intervals; early, if the number is negative."""
        return Mistake(self._of(_late, (1 if ticks > 0 else -1,)), abs(ticks * self._context.spacing_s))

    def step(self, step: Step) -> Hypothesis:
        """Return the hypothesis of a step."""
        if self._equal or step.gyroscopic == "none":
            step = replace(step, gyroscopic="")
        hypothesis = self._of(_step, (step, tuple(self._context.steps.items())))
        self._steps[hypothesis] = step
        return hypothesis

    def of_step(self, hypothesis: Hypothesis) -> Step | None:
        """Return the step of a hypothesis that `step` has returned."""
        return self._steps.get(hypothesis)

    def _of(self, make: Callable[..., Hypothesis], key: tuple) -> Hypothesis:
        found = self._made.get((make, key))
        if found is None:
            found = self._made[make, key] = make(*key)
        return found


def _step(own: Step, steps: tuple[tuple[float, str], ...]) -> Hypothesis:
    spin, term = GYROSCOPIC[own.gyroscopic or "explicit"]
    attitude, update = ROTATION[own.rotation or "exponential"]
    more = [term if own.gyroscopic else "", update if own.rotation else ""]
    levers = " but where an impulse acts" if own.is_unit_used else ""
    more.append("" if own.normalise_every else f"never normalised{levers}")
    more.append(f"position moved in {own.substeps} substeps" if own.substeps > 1 else "")
    is_told = own.other_axes or (own.explicit and own.stored != MOMENTUM)
    axes = ("world" if own.stored == IN_WORLD else "body") if is_told else ""
    more.append(f"angular velocity stored in {axes} axes" if axes else "")
    more.append(
        f"{own.steps_a_tick} steps from one impulse that is possible to the next" if own.steps_a_tick > 1 else ""
    )
    # v changes by a dt / n in each of n substeps, after which x moves.
    position_weight = 0.0 if own.explicit else (own.substeps + 1) / (2 * own.substeps)
    title = "explicit" if own.explicit else "symplectic"
    name = EXPLICIT_EULER if own.explicit else SYMPLECTIC_EULER

    def change(program: ProgramModel, step: float) -> ProgramModel:
        old = program.scheme
        return program.but(
            scheme=Scheme(
                step,
                attitude,
                spin,
                not own.explicit,
                position_weight,
                own.normalise_every,
                old.idle_steps,
                velocity_axes=old.velocity_axes,
                stored=own.stored,
                recovers=old.recovers,
                is_unit_used=own.is_unit_used,
            ),
            tick=own.steps_a_tick * step,
        )

    return Hypothesis(
        name if own.normalise_every or not own.explicit else NEVER_NORMALISED,
        "steps",
        ", ".join((f"{title} Euler with a step of {{}} s", *filter(None, more))),
        change,
        named_values=dict(steps),
        unit="s",
        details=(
            ("gyroscopic", own.gyroscopic),
            ("rotation", own.rotation),
            ("substeps", str(own.substeps) if own.substeps > 1 else ""),
            ("normalised", "" if own.normalise_every else "never"),
            ("stored", axes),
            ("ticks", str(own.steps_a_tick) if own.steps_a_tick > 1 else ""),
        ),
        unlikely=UNUSUAL * ((own.gyroscopic not in USUAL) + (own.rotation not in USUAL) + own.other_axes)
        + LIKELY * ((own.steps_a_tick > 1) + (own.substeps > 1)),
    )


def _dampings(damping: Damping) -> Iterator[tuple[tuple, float]]:
    """Yield the key and the rate [1/s] of each damping of a scheme."""
    how = damping.place, damping.form
    if damping.quadratic:
        yield ("PyBullet", *how), damping.linear
        return
    if damping.linear:
        yield ("linear", *how), damping.linear
    if damping.angular:
        yield ("angular", *how), damping.angular


def _damping(kind: str, place: int, form: int, duration: float, beside: str) -> Hypothesis:
    """Return damping as in engines; duration: of the run to which its rate is fitted [s], 0 if it is not.

    beside: what its text ends with.
    """
    where = beside if place == AS_FORCE else f", {DAMPING_FORMS[form]} {DAMPING_PLACES[place]}{beside}"
    details = (("damping-form", DAMPING_FORMS[form]), ("damping-place", DAMPING_PLACES[place]))
    kinds = {"linear": (0,), "angular": (2,), "PyBullet": BULLET_KINDS}[kind]

    def change(program: ProgramModel, rate: float) -> ProgramModel:
        return damped(program, dict.fromkeys(kinds, rate), place).but(damping_form=form)

    if kind == "PyBullet":
        text = "PyBullet's default damping: a = -{} (1 + |v|) v, and the same for w"
        return Hypothesis(PYBULLET_DAMPING, "linear damping", text, change, unit="1/s", details=details)
    what = "velocity" if kind == "linear" else "angular velocity"
    text = f"{kind} damping: {what} decays at {{}} /s{where}"
    found = Hypothesis(f"{kind}-damping", f"{kind} damping", text, change, unit="1/s", details=details)
    if not duration:
        return found
    return replace(found, values=damping_rates(duration), named_values=RATES, neutral=0.0)


def _impulse_as_force() -> Hypothesis:
    return Hypothesis(
        IMPULSE_OVER_ONE_STEP,
        "impulse",
        "impulse applied as a force over a first step of {} s",
        lambda program, step: program.but(application=ImpulseApplication(lasts=step)),
        unit="s",
    )


def _spin_cap() -> Hypothesis:
    return Hypothesis(
        SPIN_CAP,
        "spin cap",
        "angular velocity limited to {} rad/s",
        lambda program, cap: program.but(caps=(program.caps[0], cap), cap_place=CAP_WHEN_SET),
        unit="rad/s",
    )


def _gravity_delayed(steps: int) -> Hypothesis:
    return Hypothesis(
        GRAVITY_DELAYED,
        "gravity start",
        "gravity acts from the second step on, after {} s",
        lambda program, _: program.but(scheme=program.scheme._replace(idle_steps=steps)),
        unit="s",
    )


def _late(sign: int) -> Hypothesis:
    return Hypothesis(
        LOG_LAG,
        "clock offset",
        f"rows logged {{}} s {'late' if sign > 0 else 'early'}",
        lambda program, late: program.but(clock=program.clock._replace(offset=-sign * late)),
        unit="s",
    )


def _own_step() -> Hypothesis:
    return Hypothesis(
        CLOCK_RATE,
        "clock rate",
        "each row is one step of the engine, which is {} times as long as the row interval",
        lambda program, rate: program.but(clock=program.clock._replace(rate=rate)),
    )


def _interpolated(ticks: int) -> Hypothesis:
    return Hypothesis(
        LOG_LAG,
        "clock offset",
        "rows logged {} s late, and interpolated between two steps",
        lambda program, tick: program.but(clock=Clock(tick=tick, lag=float(ticks), interpolation=SLERP)),
        unit="s",
    )
